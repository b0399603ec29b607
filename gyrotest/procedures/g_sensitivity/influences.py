"""What makes the coefficients of a mounting wrong beside noise: each influence by its half-width."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.shaft_errors import (
    FittedShaft,
    azimuth_error,
    encoder_errors,
    gain_error,
    index_error,
    placement_error,
    tilt_error,
    timing_error,
)
from gyrotest.procedures.g_sensitivity.bench import Mounted
from gyrotest.procedures.g_sensitivity.known_scale import KnownScale
from gyrotest.procedures.scaling import Scaling
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.recording import Sampling
from gyrotest.records.result import Contribution
from gyrotest.records.spec import OutputKind

_Array = NDArray[np.float64]
_DEGREES = "°"
_ROOT_3 = math.sqrt(3.0)
_BEGIN_S = 0.5
"""How long after the end of its run-up the first sample of a turn may have been taken."""

PLACEMENT = "placement of the unit"


@dataclass(frozen=True, slots=True, kw_only=True)
class Influence:
    """An influence whose half-width is `half` of `unit`.

    `patterns` are what errors of that size do to the coefficients, each (k, p): whichever of them is the
    largest counts, the k patterns of one standing for the phases that the error may have. `single`: it is
    another error in each mounting; all others are the same in all.
    """

    source: str
    half: float
    unit: str
    patterns: tuple[_Array, ...]
    single: bool = False
    normal: bool = False

    @property
    def divisor(self) -> float:
        """What the half-width is over the standard uncertainty; of a normal one it is that itself."""
        return 1.0 if self.normal else _ROOT_3


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench:
    """What of a case's bench the influences depend on, beside its mountings."""

    context: Context
    scale: KnownScale
    scaling: Scaling | None = None
    sampling: Sampling | None = None
    counted: bool = False
    placement_deg: float = 0.0


def influences(fitted: FittedShaft, unit: Mounted, own: _Array, bench: Bench) -> tuple[Influence, ...]:
    """Return all influences on a mounting whose coefficients along the own axes are `own` (3,)."""
    return (
        *_of_shaft(fitted, unit, own),
        *_of_encoder(fitted, bench),
        *_of_gains(fitted, bench),
        _of_placement(fitted, unit, own, bench),
    )


def missing_influences(bench: Bench, *, turning: bool) -> Iterator[str]:
    """Give what could not be had."""
    context = bench.context
    if context.output.kind is OutputKind.VOLTAGE and context.accuracy is None:
        yield "accuracy of the meter"
    if bench.scale.relative is None:
        yield "uncertainty of the scale factor"
    if context.encoder is None or context.encoder.accuracy is None:
        yield "accuracy of the encoder"
    if turning and bench.sampling is not None and bench.sampling.skew_uncertainty_s is None:
        yield "skew of the channels"


def combined_lines(
    parts: Sequence[tuple[tuple[Influence, ...], _Array]], unit: str
) -> Iterator[Contribution]:
    """Give the lines of a budget of something linear in the coefficients of one or several mountings.

    `parts` are for each mounting its influences, the same ones in the same order, and the factors (p,) of
    its coefficients. Where an influence is common to the mountings its effects add with their signs.
    """
    for same in zip(*(found for found, _ in parts), strict=True):
        first = same[0]
        effects = [
            np.stack([np.linalg.norm(pattern @ factors) for pattern in one.patterns])
            if one.single
            else [pattern @ factors for pattern in one.patterns]
            for one, (_, factors) in zip(same, parts, strict=True)
        ]
        if first.single:
            half = float(np.sqrt(sum(float(np.max(one)) ** 2 for one in effects)))
        else:
            half = max(
                float(np.linalg.norm(sum(one[place] for one in effects)))
                for place in range(len(first.patterns))
            )
        if half > 0.0:
            yield Contribution(
                source=first.source,
                kind="B",
                distribution="normal" if first.normal else "rectangular",
                half_width=f"{plain(first.half, 3)}{'' if first.unit == _DEGREES else ' '}{first.unit}",
                sensitivity=f"{plain(half / first.half, 2)} {unit}/{first.unit}",
                standard_uncertainty=half / first.divisor,
            )


def _of_shaft(fitted: FittedShaft, unit: Mounted, own: _Array) -> Iterator[Influence]:
    shaft = unit.shaft
    azimuth, index, tilt = (
        one.to("deg")
        for one in (shaft.azimuth_uncertainty, shaft.index_uncertainty, shaft.tilt_uncertainty)
    )
    # Where x points north or south the Earth's rate hardly depends on it, and on one side more than on the other.
    sides = tuple(azimuth_error(fitted, side)[np.newaxis] for side in (azimuth, -azimuth))
    yield Influence(source="azimuth of the shaft", half=azimuth, unit=_DEGREES, patterns=sides)
    yield _simple("angle 0 of the stage", index, _DEGREES, index_error(fitted, index))
    # The largest of the coefficients stands for one that this mounting does not show.
    along = float(own[unit.along]) or float(np.abs(own).max())
    largest = abs(unit.pose.tilt_deg) + tilt
    yield _simple("tilt of the shaft", largest, _DEGREES, tilt_error(fitted, tilt, along))


def _of_encoder(fitted: FittedShaft, bench: Bench) -> Iterator[Influence]:
    encoder, sampling = bench.context.encoder, bench.sampling
    if encoder is not None and encoder.accuracy is not None:
        half = encoder.accuracy.to("deg")
        yield Influence(
            source="encoder", half=half, unit=_DEGREES, patterns=encoder_errors(fitted, half)
        )
    if not fitted.arcs.turns:
        return
    if sampling is not None and sampling.skew_uncertainty_s:
        skew_s = sampling.skew_uncertainty_s
        yield _simple("skew of the channels", skew_s, "s", timing_error(fitted, skew_s))
    if bench.counted:
        yield _simple("begin of each turn", _BEGIN_S, "s", timing_error(fitted, _BEGIN_S))


def _of_gains(fitted: FittedShaft, bench: Bench) -> Iterator[Influence]:
    scale, accuracy = bench.scale, bench.context.accuracy
    if scale.relative is not None:
        half = scale.relative * (1.0 if scale.measured else _ROOT_3)
        yield Influence(
            source=scale.source,
            half=100.0 * half,
            unit="%",
            patterns=(gain_error(fitted, half)[np.newaxis],),
            normal=scale.measured,
        )
    if accuracy is None:
        return
    zero_dps = 0.0 if bench.scaling is None else bench.scaling.zero / bench.scaling.scale_factor
    share = accuracy.of_reading.to("")
    if share > 0.0:
        yield _simple("meter, gain", 100.0 * share, "%", gain_error(fitted, share, zero_dps))
    if bench.scaling is not None and bench.sampling is not None and bench.sampling.range is not None:
        half = accuracy.of_range.to("") * bench.sampling.range * bench.scaling.to_canonical
        offset_dps = np.full(fitted.arcs.rate_dps.size, half / abs(bench.scaling.scale_factor))
        yield _simple("meter, of range", half, bench.scaling.unit, fitted.weights @ offset_dps)


def _of_placement(fitted: FittedShaft, unit: Mounted, own: _Array, bench: Bench) -> Influence:
    known = own.copy()
    if known[unit.along] == 0.0:
        known[unit.along] = np.abs(own).max()
    half = bench.placement_deg
    effect = placement_error(fitted, half, unit.axes, known, unit.sensitive)
    return Influence(
        source=PLACEMENT, half=half, unit=_DEGREES, patterns=(effect[np.newaxis],), single=True
    )


def _simple(source: str, half: float, unit: str, effect: _Array) -> Influence:
    return Influence(source=source, half=half, unit=unit, patterns=(effect[np.newaxis],))
