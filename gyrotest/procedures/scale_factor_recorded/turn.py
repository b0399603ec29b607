"""The procedure `scale_factor_turn`: the output's integral over a turn by a known angle (S3)."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrotest.analysis.turn import Parts, TurnIntegral, find_rests, turn_integral
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.case_plan import single_step_plan
from gyrotest.procedures.earth import earth_share, earth_words, of_earth
from gyrotest.procedures.meter import missing_of_meter
from gyrotest.procedures.scale_factor_recorded.clipping import refuse_clipped_turn
from gyrotest.procedures.scale_factor_recorded.outputs import Outputs, recorded_outputs
from gyrotest.procedures.scale_factor_recorded.results import (
    in_proportion,
    missing_of_gain,
    of_meter_at_zero,
    of_meter_gain,
    repeatability_result,
    scale_factor_measurands,
    scale_factor_result,
    sign_remarks,
)
from gyrotest.procedures.scale_factor_recorded.turn_figures import turn_figure
from gyrotest.procedures.scale_factor_recorded.turn_parameters import TurnParameters, turn_complaints
from gyrotest.procedures.uncertainty import budgeted_result, by_statistics, rectangular
from gyrotest.procedures.wording import plain, rate_text
from gyrotest.records.plan import Context, Plan, Reduction
from gyrotest.records.recording import Samples, Sampling
from gyrotest.records.result import Contribution, Measurand, Result
from gyrotest.records.spec import Case, Output
from gyrotest.units import Dimension

_MINUS = "\N{MINUS SIGN}"


class ScaleFactorTurn:
    """Scale factor and bias from one turn by a known angle between two rests."""

    parameters: type[Any] = TurnParameters

    def measurands(
        self, case: Case, parameters: TurnParameters, output: Output
    ) -> tuple[Measurand, ...]:
        """Return everything that a case with these parameters measures."""
        del parameters
        difference = Measurand(
            name="rest_difference",
            label="Output at rest, after less before",
            dimension=Dimension.RATE,
            unit="deg/h",
        )
        return (*scale_factor_measurands(case, output), difference)

    def complaints(
        self, case: Case, parameters: TurnParameters, output: Output
    ) -> Iterable[tuple[str, str]]:
        """Give what is wrong with a case beyond its types."""
        del output  # the scale factor is what is measured: none is needed
        return turn_complaints(case, parameters)

    def plan(self, case: Case, parameters: TurnParameters) -> Plan:
        """Return the acquisition of one repeat: a single step, in which somebody turns the gyro."""
        del parameters
        return single_step_plan(case)

    def reduce(self, samples: Samples, context: Context) -> Reduction:
        """Return results and figures of one acquisition; raises `InsufficientDataError`."""
        parameters: TurnParameters = context.parameters
        outputs = recorded_outputs(samples, context)
        try:
            parts = _parts(outputs, parameters)
            found = turn_integral(outputs.values, outputs.place, parts, interval_s=outputs.interval_s)
        except InsufficientDataError as error:
            raise InsufficientDataError(f"{context.case_name}: {error}") from error
        turned = _Turned(outputs=outputs, parts=parts, found=found, angle_deg=parameters.angle.to("deg"))
        _refuse_lifeless(turned, context)
        refuse_clipped_turn(outputs, parts, found.rest_level, context)
        scale_factor = _scale_factor(turned, parameters, context)
        return Reduction(
            results=(
                scale_factor,
                _bias(turned, samples.sampling, scale_factor, context),
                _difference(turned),
            ),
            figures=(turn_figure(outputs, parts, found, turned.slope, turned.angle_deg),),
            remarks=(
                *sign_remarks(turned.slope, context, against="the sign given to the turn"),
                *_told(turned, parameters, context),
            ),
        )

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Return the spread of the scale factor over the repeats; raises `InsufficientDataError`."""
        return Reduction(results=(repeatability_result(repeats, context),))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Turned:
    """A record with its turn integrated."""

    outputs: Outputs
    parts: Parts
    found: TurnIntegral
    angle_deg: float

    @property
    def slope(self) -> float:
        """The scale factor: ∫(U − U0)dt over the angle."""
        return self.found.integral / self.angle_deg

    @property
    def peak_dps(self) -> float:
        """The greatest rate of the turn."""
        turn = self.outputs.values[self.parts.begin : self.parts.end]
        return float(np.abs(turn - self.found.rest_level).max() / abs(self.slope))


def _parts(outputs: Outputs, parameters: TurnParameters) -> Parts:
    before, after = parameters.before, parameters.after
    if before is None or after is None:
        return find_rests(outputs.values)
    place = outputs.place - outputs.place[0]
    begin, rest = (round(one.to("s") / outputs.interval_s) for one in (before, after))
    end = int(place[-1]) + 1 - rest
    if begin >= end:
        raise InsufficientDataError(
            f"rests of {before} and {after} leave nothing of {plain((place[-1] + 1) * outputs.interval_s, 6)} s"
        )
    return Parts(begin=int(np.searchsorted(place, begin)), end=int(np.searchsorted(place, end)))


def _refuse_lifeless(turned: _Turned, context: Context) -> None:
    found = turned.found
    noise = float(np.hypot(found.noise, found.rest))
    if abs(found.integral) <= 3.0 * noise:
        raise InsufficientDataError(
            f"{context.case_name}: the output shows no turn: its integral is {plain(found.integral, 3)} ±"
            f" {plain(noise, 2)} {turned.outputs.unit}·s; is it the right axis, and was the gyro powered?"
        )


def _scale_factor(turned: _Turned, parameters: TurnParameters, context: Context) -> Result:
    found, slope, size = turned.found, turned.slope, abs(turned.angle_deg)
    budget = (
        by_statistics("noise in the turn", found.noise / size, found.noise_freedom),
        by_statistics("output at rest", found.rest / size, found.rest_freedom),
        *_of_drift(turned),
        *_of_angle(turned, parameters),
        *(
            ()
            if parameters.time_uncertainty is None
            else (
                in_proportion(
                    f"sampling rate, {parameters.time_uncertainty}", parameters.time_uncertainty, slope
                ),
            )
        ),
        *of_meter_gain(slope, context),
    )
    return scale_factor_result(
        slope,
        budget,
        turned.outputs,
        condition=f"turn by {plain(turned.angle_deg, 6)}° in {plain(found.lasts_s, 4)} s, at most"
        f" {rate_text(turned.peak_dps, 3)}".replace("-", _MINUS),
        not_included=(
            *(("angle of the turn",) if parameters.angle_uncertainty is None else ()),
            *(("sampling rate",) if parameters.time_uncertainty is None else ()),
            *missing_of_gain(context),
        ),
    )


def _of_drift(turned: _Turned) -> Iterator[Contribution]:
    drift = turned.found.drift
    if drift is not None:
        yield rectangular(
            "drift of the output at rest, half the difference", "", "", drift / abs(turned.angle_deg)
        )


def _of_angle(turned: _Turned, parameters: TurnParameters) -> Iterator[Contribution]:
    half = parameters.angle_uncertainty
    if half is not None:
        size = abs(turned.slope / turned.angle_deg)
        yield rectangular(
            "angle of the turn", f"{plain(half.to('deg'), 3)}°", plain(size, 3), size * half.to("deg")
        )


def _bias(turned: _Turned, sampling: Sampling, scale_factor: Result, context: Context) -> Result:
    """Return the output at rest as a rate, less the Earth's share."""
    found, slope = turned.found, turned.slope
    of_slope = (scale_factor.expanded_uncertainty or 0.0) / (scale_factor.coverage_factor or 1.0)
    share_dps = earth_share(context)
    level_dps = found.rest_level / slope
    budget = (
        by_statistics("noise at rest", found.rest_level_uncertainty / abs(slope), found.rest_freedom),
        by_statistics("scale factor, as found", abs(level_dps / slope) * of_slope),
        *of_meter_at_zero(turned.outputs, sampling, slope, context),
        of_earth(share_dps),
    )
    return budgeted_result(
        budget,
        name="bias",
        label="Bias",
        value=level_dps - (share_dps or 0.0),
        unit="deg/s",
        condition=f"between the rests; {earth_words(share_dps)}",
        not_included=tuple(
            dict.fromkeys((*scale_factor.not_included, *missing_of_meter(context, sampling)))
        ),
    )


def _difference(turned: _Turned) -> Result:
    difference = turned.found.difference
    return Result(
        name="rest_difference",
        label="Output at rest, after less before",
        value=None if difference is None else difference / turned.slope,
        unit="deg/s",
        condition="there is a rest at one end only" if difference is None else "",
    )


def _told(turned: _Turned, parameters: TurnParameters, context: Context) -> Iterator[str]:
    outputs, parts = turned.outputs, turned.parts
    how = "found in the record" if parameters.before is None else "as the case says"
    yield (
        f"At rest, {how}: {parts.begin} samples before the turn and {outputs.values.size - parts.end} after it;"
        f" {parts.end - parts.begin} of the turn."
    )
    if outputs.gaps:
        yield (
            f"The record has {outputs.gaps} gap{'s' * (outputs.gaps > 1)} with room for {outputs.missing}"
            " samples, none of them in the turn."
        )
    full_scale = context.output.full_scale
    if full_scale is not None and turned.peak_dps > full_scale.to("deg/s"):
        yield f"The turn was faster than full scale, {full_scale}: at most {rate_text(turned.peak_dps, 3)}."
