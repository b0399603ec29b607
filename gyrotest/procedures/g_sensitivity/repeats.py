"""The mountings of a case together: each one's results as numbers, and the model that they came from."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.g_sensitivity import Arcs, Term
from gyrotest.analysis.level_shaft import Circle
from gyrotest.analysis.mounting import AXES, undetermined_axes
from gyrotest.analysis.shaft_errors import FittedShaft
from gyrotest.analysis.shaft_samples import SECTOR_DEG
from gyrotest.analysis.wandering_fit import Spans
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.g_sensitivity.bench import Mounted, mounted
from gyrotest.procedures.g_sensitivity.influences import Bench, Influence, influences
from gyrotest.procedures.g_sensitivity.known_scale import KnownScale, known_scale, nominal_scale
from gyrotest.procedures.g_sensitivity.measurands import PER_G, mounted_name
from gyrotest.procedures.g_sensitivity.parameters import GSensitivityParameters
from gyrotest.procedures.scaling import output_scaling
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.records.spec import OutputKind
from gyrotest.units import conversion_factor

_Array = NDArray[np.float64]
_COEFFICIENTS = 3
_SAME = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Noise:
    """The standard uncertainty of a coefficient by noise alone, and its degrees of freedom (inf: many)."""

    standard: float
    freedom: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Mounting:
    """What one repeat measured: `values` and `noise` of the own axes across the shaft, by their places."""

    number: int
    unit: Mounted
    values: dict[int, float]
    noise: dict[int, Noise]
    results: dict[str, Result]

    def result(self, name: str) -> Result | None:
        """One of its results that has a value."""
        found = self.results.get(name)
        return found if found is not None and found.value is not None else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A coefficient from all mountings that show it: `weights` by their numbers, adding up to 1."""

    place: int
    value: float
    weights: dict[int, float]

    @property
    def axis(self) -> str:
        """The own axis's name."""
        return AXES[self.place]


@dataclass(frozen=True, slots=True, kw_only=True)
class Mountings:
    """All mountings, the coefficients that they come to, and what influences each of them."""

    mountings: tuple[Mounting, ...]
    estimates: tuple[Estimate, ...]
    influences: tuple[tuple[Influence, ...], ...]

    @property
    def own(self) -> _Array:
        """The coefficients along the own axes (3,), °/s per g."""
        return np.array([one.value for one in self.estimates])

    @property
    def not_included(self) -> tuple[str, ...]:
        """What could not be had in any of the mountings."""
        return tuple(
            dict.fromkeys(
                text
                for one in self.mountings
                for place in one.values
                for text in one.results[mounted_name(AXES[place])].not_included
            )
        )

    def factors(self, number: int, weights: dict[int, float]) -> _Array:
        """Return what a sum over a mounting's own coefficients, by their places, is of those of the fit (3,)."""
        axes = self.mountings[number].unit.axes
        factors = np.zeros(_COEFFICIENTS)
        for place, weight in weights.items():
            factors[Term.ALONG_X] += weight * axes[place, 0]
            factors[Term.ALONG_Z] += weight * axes[place, 2]
        return factors


def mountings_of(repeats: Sequence[tuple[Result, ...]], context: Context) -> Mountings:
    """Put the repeats together; raises `InsufficientDataError` naming a coefficient that none of them shows."""
    parameters: GSensitivityParameters = context.parameters
    found = tuple(
        _mounting(number, results, mounted(context, parameters.placement(number + 1)), context)
        for number, results in enumerate(repeats)
    )
    unknown = undetermined_axes([one.unit.axes for one in found])
    if unknown:
        names = ", ".join(f"g_sensitivity_{one}" for one in unknown)
        words = "; ".join(one.unit.words for one in found)
        raise InsufficientDataError(
            f"{context.case_name}: {names} cannot be found: in all {len(found)} mountings that axis lies along the"
            f" shaft ({words}); turn the unit about its sensitive axis by a quarter between:"
            " 'parameters.placements'"
        )
    _refuse_the_same(found, context)
    estimates = tuple(_estimate(place, found) for place in range(len(AXES)))
    own = np.array([one.value for one in estimates])
    bench = Bench(
        context=context,
        scale=_scale(parameters, context),
        counted=_counted(context) and parameters.turning,
        placement_deg=parameters.placement_uncertainty.to("deg"),
    )
    return Mountings(
        mountings=found,
        estimates=estimates,
        influences=tuple(
            influences(_even(one.unit, own, parameters), one.unit, own, bench) for one in found
        ),
    )


def _refuse_the_same(mountings: Sequence[Mounting], context: Context) -> None:
    """Refuse mountings that agree in the stage's own axes far below their noise: one record, taken twice."""
    for one, other in itertools.pairwise(mountings):
        apart = np.abs(_along_the_stage(one) - _along_the_stage(other)).max()
        if apart < _SAME * min(noise.standard for noise in (*one.noise.values(), *other.noise.values())):
            raise InsufficientDataError(
                f"{context.case_name}: repeats {one.number + 1} and {other.number + 1} hold the same samples: they"
                f" agree to a {round(1.0 / _SAME)}th of their noise; record each mounting by itself, and do not"
                " 'rewind' what is replayed"
            )


def _along_the_stage(mounting: Mounting) -> _Array:
    """Return the coefficients along the stage's axes (3,)."""
    return sum(
        (value * mounting.unit.axes[place] for place, value in mounting.values.items()),
        start=np.zeros(len(AXES)),
    )


def _mounting(number: int, results: tuple[Result, ...], unit: Mounted, context: Context) -> Mounting:
    by_name = {one.name: one for one in results}
    values: dict[int, float] = {}
    noise: dict[int, Noise] = {}
    for place in unit.across:
        found = by_name.get(mounted_name(AXES[place]))
        if found is None or found.value is None or not found.budget:
            raise InsufficientDataError(
                f"{context.case_name}: repeat {number + 1} has no {mounted_name(AXES[place])}, which its mounting"
                f" shows ({unit.words}); was it taken with another 'frame' or other 'placements'?"
            )
        factor = conversion_factor(found.unit, PER_G)
        values[place] = found.value * factor
        noise[place] = _noise(found, factor)
    return Mounting(number=number, unit=unit, values=values, noise=noise, results=by_name)


def _noise(found: Result, factor: float) -> Noise:
    (line,) = [one for one in found.budget if one.kind == "A"]
    freedom = line.degrees_of_freedom
    return Noise(
        standard=line.standard_uncertainty * factor, freedom=np.inf if freedom is None else freedom
    )


def _estimate(place: int, mountings: Sequence[Mounting]) -> Estimate:
    """Weigh the mountings by their noise: what they have in common does not tell them apart."""
    showing = [one for one in mountings if place in one.values]
    weights = np.array([one.noise[place].standard ** -2.0 for one in showing])
    weights /= weights.sum()
    value = float(weights @ np.array([one.values[place] for one in showing]))
    return Estimate(
        place=place,
        value=value,
        weights={one.number: float(weight) for one, weight in zip(showing, weights, strict=True)},
    )


def _even(unit: Mounted, own: _Array, parameters: GSensitivityParameters) -> FittedShaft:
    """Return the fit as it is to angles spread evenly as the case asks for, without what follows the turning."""
    if parameters.turning:
        count, run_up_deg = 12 * round(360.0 / SECTOR_DEG), parameters.run_up.to("deg")
        angles = run_up_deg + (360.0 - 2.0 * run_up_deg) * (np.arange(count) + 0.5) / count
        angles = np.concatenate((angles, angles[::-1]))
        rates = np.repeat((parameters.rate_dps, -parameters.rate_dps), count)
    else:
        angles = np.array([one.to("deg") for one in parameters.positions])
        rates = np.zeros(angles.size)
    arcs = Arcs(
        spans=Spans(begins_s=np.arange(angles.size, dtype=float), durations_s=np.ones(angles.size)),
        circle=Circle.of(angles),
        rate_dps=rates,
    )
    along_stage = own @ unit.axes
    coefficients = np.array([0.0, along_stage[0], along_stage[2]])
    if arcs.turns:
        coefficients = np.append(coefficients, 0.0)
    return FittedShaft.even(unit.model, arcs, coefficients)


def _scale(parameters: GSensitivityParameters, context: Context) -> KnownScale:
    if parameters.scale_factor_from is None:
        return nominal_scale(context)
    unit = {OutputKind.VOLTAGE: "V", OutputKind.RATE: "deg/s", OutputKind.COUNT: "count"}
    scaling = output_scaling(context.output, unit[context.output.kind])
    return known_scale(scaling, parameters.scale_factor_from, context)


def _counted(context: Context) -> bool:
    return context.encoder is not None and context.encoder.angle is None
