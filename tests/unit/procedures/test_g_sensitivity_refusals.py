"""g-sensitivity: what is wrong with a case, and records from which no number may come."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.g_sensitivity import GSensitivity, GSensitivityParameters
from gyrotest.procedures.g_sensitivity.parameters import OwnAxis
from gyrotest.records.recording import SampleFlag
from gyrotest.records.spec import Case, Output, OutputKind
from gyrotest.records.station import Encoder
from gyrotest.units import Quantity

from .shaft_bench import OUTPUT, SHAFT, Bench, Recorded


def angles(*values: float) -> tuple[Quantity, ...]:
    return tuple(Quantity(one, "deg") for one in values)


def complaints(
    output: Output = OUTPUT, case: dict[str, Any] | None = None, **parameters: Any
) -> dict[str, str]:
    given = Case(
        procedure="g_sensitivity",
        **{
            "duration": Quantity(30.0, "s"),
            "interval": Quantity(10.0, "ms"),
            "repeats": 2,
            **(case or {}),
        },
    )
    return dict(GSensitivity().complaints(given, GSensitivityParameters(**parameters), output))


def test_the_case_of_the_documents_has_nothing_wrong() -> None:
    assert complaints() == {}
    assert complaints(positions=angles(0.0, 90.0, 180.0, 270.0)) == {}
    assert complaints(case={"repeats": 1}, placements=angles(90.0)) == {}
    assert complaints(case={"repeats": 4}) == {}


@pytest.mark.parametrize("same", [(0.0, 0.0), (0.0, 180.0), (90.0, 270.0)])
def test_mountings_that_are_the_same_leave_a_coefficient_unknown_and_it_is_named(
    same: tuple[float, ...],
) -> None:
    (key, message), *others = complaints(placements=angles(*same)).items()
    assert not others
    assert key == "parameters.placements"
    assert "g_sensitivity_y or g_sensitivity_z" in message
    assert "cannot be found" in message
    assert "[0 deg, 90 deg]" in message


@pytest.mark.parametrize(
    ("parameters", "key", "message"),
    [
        ({"placements": angles(0.0, 45.0)}, "parameters.placements[1]", "no whole number of quarters"),
        ({"placements": ()}, "parameters.placements", "names no placement"),
        ({"turns": 0}, "parameters.turns", "0 is not from 1 to 40"),
        ({"run_up": Quantity(40.0, "deg")}, "parameters.run_up", "at most 15 deg"),
        ({"run_up": Quantity(0.0, "deg")}, "parameters.run_up", "not more than zero"),
        ({"rate": Quantity(-6.0, "deg/s")}, "parameters.rate", "not more than zero"),
        ({"tolerance": Quantity(0.0, "deg/s")}, "parameters.tolerance", "not more than zero"),
        ({"settle": Quantity(-1.0, "s")}, "parameters.settle", "less than zero"),
        ({"outlier_mads": 1.0}, "parameters.outlier_mads", "ordinary noise"),
        ({"rate": Quantity(500.0, "deg/s")}, "interval", "turns by 5° from sample to sample"),
        ({"positions": angles(0.0, 180.0)}, "parameters.positions", "do not tell the bias"),
        ({"positions": angles(0.0, 90.0, 400.0)}, "parameters.positions[2]", "not within 0° to 360°"),
    ],
)
def test_what_is_wrong_with_the_parameters_is_said(
    parameters: dict[str, Any], key: str, message: str
) -> None:
    found = complaints(**parameters)
    assert list(found) == [key]
    assert message in found[key]


@pytest.mark.parametrize(
    ("case", "key", "message"),
    [
        ({"repeats": 1}, "repeats", "write 'repeats: 2'"),
        ({"duration": Quantity(50.0, "ms")}, "duration", "at least 0.16 s"),
    ],
)
def test_what_is_wrong_with_the_case_is_said(case: dict[str, Any], key: str, message: str) -> None:
    found = complaints(case=case)
    assert list(found) == [key]
    assert message in found[key]


def test_three_placements_in_two_repeats_are_too_many() -> None:
    assert "write 'repeats: 3'" in complaints(placements=angles(0.0, 90.0, 180.0))["repeats"]


def test_an_output_of_three_axes_names_the_one_that_is_mounted() -> None:
    three = replace(OUTPUT, axes=("x", "y", "z"))
    assert "name one, e.g. [x]" in complaints(three)["axes"]
    wrong = complaints(three, case={"axes": ("z",)})
    assert "the case's axis is 'z'" in wrong["parameters.sensitive_axis"]
    assert complaints(three, case={"axes": ("x",)}) == {}


def test_counts_without_a_scale_factor_are_no_rate() -> None:
    assert "output.scale_factor" in complaints(Output(kind=OutputKind.COUNT))["procedure"]


# Records


def refused(recorded: Recorded) -> str:
    with pytest.raises(InsufficientDataError) as found:
        recorded.reduced()
    return str(found.value)


def test_a_missing_latitude_or_azimuth_is_an_error() -> None:
    bench = Bench()
    assert "the latitude (the station's 'site.latitude') is not known" in refused(
        replace(bench, site=None).recorded(1)
    )
    nowhere = replace(bench, shaft=replace(SHAFT, azimuth=None))
    assert "'shaft.azimuth') is not known" in refused(nowhere.recorded(1))
    both = refused(replace(nowhere, site=None).recorded(1))
    assert "the latitude" in both
    assert "and the azimuth" in both
    assert "on no stage with a level shaft" in refused(replace(bench, shaft=None).recorded(1))


def test_a_sensitive_axis_along_the_shaft_is_refused() -> None:
    along = Bench(parameters=GSensitivityParameters(sensitive_axis=OwnAxis.Y))
    assert "the sensitive axis y lies along the shaft" in refused(along.recorded(1))


def test_channels_that_are_not_synchronous_are_refused_where_the_shaft_turns() -> None:
    assert "does not take output and angle by one clock" in refused(Bench(synchronous=False).recorded(1))
    standing = Bench(
        synchronous=False,
        parameters=GSensitivityParameters(positions=angles(0.0, 90.0, 180.0, 270.0)),
        rest_s=10.0,
    )
    assert standing.recorded(1).reduced().results


def test_a_range_short_of_a_turn_is_refused_with_the_missing_range() -> None:
    recorded = Bench().recorded(1)
    assert recorded.samples.index is not None
    angle = recorded.samples.values[:, 1]
    step = np.concatenate([np.full(one.samples, "forward" in one.name) for one in recorded.dwells])
    kept = ~(step & (angle > 245.0))
    short = recorded.of(
        values=recorded.samples.values[kept],
        flags=recorded.samples.flags[kept],
        index=recorded.samples.index[kept],
    )
    message = refused(short)
    assert "turning forward, there are too few samples at 240° … 270°, 270° … 300°" in message
    assert "short of a turn" in message


def starved(recorded: Recorded) -> Recorded:
    """The encoder updates once a second."""
    angle = recorded.samples.values[:, 1].copy()
    return recorded.column(1, np.repeat(angle[::20], 20)[: angle.size])


def clipped(recorded: Recorded) -> Recorded:
    flags = recorded.samples.flags.copy()
    flags[3000:3050] = SampleFlag.OVERLOAD
    return recorded.of(flags=flags)


def wrong_way(recorded: Recorded) -> Recorded:
    return recorded.column(1, (360.0 - recorded.samples.values[:, 1]) % 360.0)


def off_zero(recorded: Recorded) -> Recorded:
    return recorded.column(1, (recorded.samples.values[:, 1] + 90.0) % 360.0)


def no_number(recorded: Recorded) -> Recorded:
    angle = recorded.samples.values[:, 1].copy()
    angle[4000] = np.nan
    return recorded.column(1, angle)


def stuck(recorded: Recorded) -> Recorded:
    return recorded.column(0, np.full(recorded.samples.flags.size, 4.999))


def broken_off(recorded: Recorded) -> Recorded:
    return replace(recorded, dwells=recorded.dwells[:5])


def in_volts(recorded: Recorded) -> Recorded:
    sampling = recorded.samples.sampling
    (auxiliary,) = sampling.auxiliary
    return recorded.of(sampling=replace(sampling, auxiliary=(replace(auxiliary, unit="V"),)))


def without_encoder(recorded: Recorded) -> Recorded:
    sampling = replace(recorded.samples.sampling, auxiliary=(), offsets_s=(0.0,))
    return recorded.of(sampling=sampling, values=recorded.samples.values[:, :1])


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (starved, "starved of samples"),
        (clipped, "50 of 1166 samples are overloads"),
        (wrong_way, "the encoder turned at −6 °/s, the stage was asked for 6 °/s"),
        (off_zero, "the encoder reads 90° where the stage stands at 0°"),
        (no_number, "the encoder's angle is no number in 1 of 1166 samples"),
        (stuck, "the output stands at its limit, or is stuck"),
        (broken_off, "5 of 12 steps were carried out"),
        (in_volts, "comes in 'V', which is none of an angle"),
        (without_encoder, "no encoder is recorded beside the output"),
    ],
)
def test_a_spoiled_record_gives_a_clear_error_and_no_number(
    spoil: Callable[[Recorded], Recorded], message: str
) -> None:
    assert message in refused(spoil(Bench().recorded(1)))


def test_an_encoder_that_counts_the_other_way_is_turned_round_by_the_station() -> None:
    bench = Bench(encoder=Encoder(angle="angle", reversed=True))
    found = {one.name: one.value for one in wrong_way(bench.recorded(1)).reduced().results}
    assert found["mounted_g_sensitivity_z"] == pytest.approx(0.08, abs=1e-5)


def test_both_mountings_the_same_give_no_coefficient_but_its_name() -> None:
    bench = Bench(parameters=GSensitivityParameters(placements=angles(0.0, 180.0)))
    with pytest.raises(
        InsufficientDataError, match="g_sensitivity_y cannot be found: in all 2 mountings"
    ):
        bench.both()


def test_another_case_that_has_no_coefficients_cannot_be_compared_with() -> None:
    bench = Bench(parameters=GSensitivityParameters(compare_with="positions"))
    with pytest.raises(InsufficientDataError, match="judged before this case: none"):
        bench.both()


def test_a_case_without_a_scale_factor_gives_none() -> None:
    bench = Bench(parameters=GSensitivityParameters(scale_factor_from="table"))
    assert "case 'table' has no scale factor" in refused(bench.recorded(1))
