"""What is wrong with a g-sensitivity case, told before anything moves."""

from collections.abc import Iterator

import numpy as np

from gyrotest.analysis.mounting import AXES, own_axes, undetermined_axes
from gyrotest.procedures.case_plan import step_samples
from gyrotest.procedures.g_sensitivity.parameters import GSensitivityParameters, turn_samples
from gyrotest.procedures.scaling import nominal_complaints
from gyrotest.procedures.wording import plain
from gyrotest.records.spec import Case, Output
from gyrotest.units import Quantity

MOST_TURNS = 40
FEWEST_SAMPLES = 16
"""Samples of a record at rest, at least."""

_MOST_RUN_UP_DEG = 15.0
_MOST_STEP_DEG = 2.0
_FEWEST_MADS = 3.0
_QUARTER_DEG = 90.0
_SAME = 1e-9
_POSITIONS = "[0 deg, 90 deg, 180 deg, 270 deg]"


def g_sensitivity_complaints(
    case: Case, parameters: GSensitivityParameters, output: Output
) -> Iterator[tuple[str, str]]:
    """Give what is wrong with a case beyond its types: key and message."""
    yield from nominal_complaints(output)
    axes = case.axes or output.axes
    if len(axes) > 1:
        message = (
            f"names {len(axes)} axes, and each needs a mounting of its own; name one, e.g. [{axes[0]}]"
        )
        yield "axes", message
    elif axes and axes[0] in AXES and axes[0] != parameters.sensitive_axis.value:
        message = f"is '{parameters.sensitive_axis.value}', and the case's axis is '{axes[0]}'"
        yield "parameters.sensitive_axis", message
    samples = step_samples(case)
    if samples < FEWEST_SAMPLES:
        shortest = plain(FEWEST_SAMPLES * case.interval.to("s"), 3)
        yield "duration", f"{samples} samples at rest are too few; at least {shortest} s"
    yield from _value_complaints(parameters)
    if parameters.turning:
        yield from _turn_complaints(case, parameters)
    else:
        yield from _position_complaints(parameters)
    yield from _placement_complaints(case, parameters)


def _value_complaints(parameters: GSensitivityParameters) -> Iterator[tuple[str, str]]:
    not_less: tuple[tuple[str, Quantity], ...] = (
        ("settle", parameters.settle),
        ("placement_uncertainty", parameters.placement_uncertainty),
    )
    for name, value in not_less:
        if value.value < 0.0:
            yield f"parameters.{name}", f"'{value}' is less than zero"
    more = (
        ("rate", parameters.rate),
        ("tolerance", parameters.tolerance),
        ("run_up", parameters.run_up),
    )
    for name, value in more:
        if value.value <= 0.0:
            yield f"parameters.{name}", f"'{value}' is not more than zero"
    if not parameters.outlier_mads >= _FEWEST_MADS:
        message = (
            f"{parameters.outlier_mads:g} would drop samples of ordinary noise; at least 3, e.g. 7.5"
        )
        yield "parameters.outlier_mads", message


def _turn_complaints(case: Case, parameters: GSensitivityParameters) -> Iterator[tuple[str, str]]:
    if not 1 <= parameters.turns <= MOST_TURNS:
        yield "parameters.turns", f"{parameters.turns} is not from 1 to {MOST_TURNS}"
    if parameters.run_up.to("deg") > _MOST_RUN_UP_DEG:
        message = (
            f"'{parameters.run_up}' leaves too much of a turn out; at most {_MOST_RUN_UP_DEG:g} deg"
        )
        yield "parameters.run_up", message
        return
    if parameters.rate.value <= 0.0:
        return
    step_deg = parameters.rate_dps * case.interval.to("s")
    if step_deg > _MOST_STEP_DEG or turn_samples(case, parameters) < 2 * FEWEST_SAMPLES:
        message = (
            f"the shaft turns by {plain(step_deg, 3)}° from sample to sample at {parameters.rate}; at most"
            f" {_MOST_STEP_DEG:g}°: sample faster, or turn slower"
        )
        yield "interval", message


def _position_complaints(parameters: GSensitivityParameters) -> Iterator[tuple[str, str]]:
    angles = np.array([one.to("deg") for one in parameters.positions])
    for place, angle in enumerate(angles):
        if not 0.0 <= angle <= 360.0:
            message = (
                f"'{parameters.positions[place]}' is not within 0° to 360°, where the stage may turn"
            )
            yield f"parameters.positions[{place}]", message
    radians = np.radians(angles)
    design = np.column_stack((np.ones(angles.size), np.cos(radians), np.sin(radians)))
    sizes = np.linalg.svd(design, compute_uv=False)
    if angles.size < 3 or not sizes[-1] > 1e-3 * sizes[0]:
        message = (
            f"do not tell the bias and the coefficients of two axes apart; three angles at least, not all on one"
            f" side, e.g. {_POSITIONS}"
        )
        yield "parameters.positions", message


def _placement_complaints(case: Case, parameters: GSensitivityParameters) -> Iterator[tuple[str, str]]:
    if not parameters.placements:
        yield "parameters.placements", "names no placement; e.g. [0 deg, 90 deg]"
        return
    odd = [
        place
        for place, angle in enumerate(parameters.placements_deg)
        if abs(angle / _QUARTER_DEG - round(angle / _QUARTER_DEG)) > _SAME
    ]
    for place in odd:
        message = (
            f"'{parameters.placements[place]}' is no whole number of quarters of a turn: then an axis lies neither"
            " along the shaft nor across it"
        )
        yield f"parameters.placements[{place}]", message
    if odd or case.repeats < 2:
        if not odd and len(parameters.placements) > 1:
            message = (
                f"is 1, and there are {len(parameters.placements)} placements, one for each repeat; write"
                f" 'repeats: {len(parameters.placements)}', or a single placement"
            )
            yield "repeats", message
        return
    yield from _singular(case, parameters)


def _singular(case: Case, parameters: GSensitivityParameters) -> Iterator[tuple[str, str]]:
    """Complain of placements of which some coefficient stays unknown, however the station mounts the unit."""
    if case.repeats < len(parameters.placements):
        message = (
            f"is {case.repeats}, and there are {len(parameters.placements)} placements, one for each repeat; write"
            f" 'repeats: {len(parameters.placements)}'"
        )
        yield "repeats", message
        return
    angles = parameters.placements_deg
    lost = [
        undetermined_axes([own_axes(frame, parameters.sensitive_axis.value, one) for one in angles])
        for frame in _possible_frames(parameters.sensitive_axis.value)
    ]
    if all(lost):
        coefficients = " or ".join(f"g_sensitivity_{one}" for one in sorted({*sum(lost, ())}))
        message = (
            f"the same axis lies along the shaft in all of {_spoken(parameters.placements)}, and gravity never"
            f" turns along it: {coefficients} (the axis that the slot's 'frame' puts along the shaft) cannot be"
            " found; turn the unit by a quarter between, e.g. [0 deg, 90 deg]"
        )
        yield "parameters.placements", message


def _possible_frames(sensitive_axis: str) -> Iterator[dict[str, str]]:
    """Give mountings with the sensitive axis across the shaft: either other axis along it."""
    first, second = (one for one in AXES if one != sensitive_axis)
    if AXES.index(second) - AXES.index(first) == 2:
        first, second = second, first
    yield {sensitive_axis: "x", first: "y", second: "z"}
    yield {sensitive_axis: "z", first: "x", second: "y"}


def _spoken(placements: tuple[Quantity, ...]) -> str:
    return f"[{', '.join(str(one) for one in placements)}]"
