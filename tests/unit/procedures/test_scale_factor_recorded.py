"""Scale factors from recordings: results, what is told, what is refused, what a case may say."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.scale_factor_recorded import ScaleFactorReference, ScaleFactorTurn
from gyrotest.procedures.scale_factor_recorded.reference_parameters import (
    Outliers,
    ReferenceParameters,
)
from gyrotest.procedures.scale_factor_recorded.turn_parameters import TurnParameters
from gyrotest.records.plan import Context, Reduction
from gyrotest.records.recording import Auxiliary, SampleFlag, Samples, Sampling
from gyrotest.records.result import Contribution, Result
from gyrotest.records.spec import Case, Output, OutputKind
from gyrotest.records.station import Accuracy
from gyrotest.specification.checked import checked
from gyrotest.specification.spec import installed_procedure
from gyrotest.units import Quantity, conversion_factor

from .bench import SITE, quantity

KINDS = {
    OutputKind.VOLTAGE: ("V", "V*s/deg", 0.02),
    OutputKind.RATE: ("deg/s", "", 0.99),
    OutputKind.COUNT: ("count", "count*s/deg", 131.0),
}


def case(**changes: Any) -> Case:
    plain = Case(
        procedure="scale_factor_reference",
        duration=quantity(30.0, "s"),
        interval=quantity(10.0, "ms"),
        mounting=(1.0, 0.0, 0.0),
    )
    return dataclasses.replace(plain, **changes)


def context(parameters: Any, kind: OutputKind = OutputKind.RATE, **changes: Any) -> Context:
    plain = Context(
        case_name="table",
        case=case(),
        parameters=parameters,
        output=Output(kind=kind),
        datasheet={},
        accuracy=None,
        site=SITE,
    )
    return dataclasses.replace(plain, **changes)


def samples(columns: NDArray[np.float64], kind: OutputKind = OutputKind.RATE, **changes: Any) -> Samples:
    beside = columns.shape[1] > 1
    plain = Samples(
        sampling=Sampling(
            interval_s=0.01,
            aperture_s=0.01,
            unit=KINDS[kind][0],
            auxiliary=(Auxiliary(name="reference", unit="deg/s"),) if beside else (),
        ),
        values=columns,
        flags=np.zeros(len(columns), dtype=np.uint8),
    )
    return dataclasses.replace(plain, **changes)


def moving(
    slope: float, *, seed: int = 1, level_dps: float = 0.5, count: int = 3000
) -> NDArray[np.float64]:
    """Output and reference: a sine of 50 °/s, with 0.2 °/s of noise."""
    rng = np.random.default_rng(seed)
    reference = 50.0 * np.sin(np.arange(count) * 0.0157 + seed)
    return np.stack([slope * (reference + level_dps + 0.2 * rng.normal(size=count)), reference], axis=1)


def result(found: Reduction, name: str) -> Result:
    (one,) = [one for one in found.results if one.name == name]
    return one


def source(one: Result, begins: str) -> Contribution:
    (found,) = [line for line in one.budget if line.source.startswith(begins)]
    return found


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("kind", list(OutputKind))
def test_a_reference_gives_the_scale_factor_in_the_outputs_unit(kind, sign):
    _, unit, slope = KINDS[kind]
    setting = context(ReferenceParameters(reference_uncertainty=quantity(0.1, "%")), kind)
    found = ScaleFactorReference().reduce(samples(moving(sign * slope), kind), setting)
    scale_factor = result(found, "scale_factor")
    factor = conversion_factor(scale_factor.unit, unit)
    assert scale_factor.value * factor == pytest.approx(sign * slope, rel=1e-3)
    assert abs(scale_factor.value * factor - sign * slope) < scale_factor.expanded_uncertainty * factor
    reference = source(scale_factor, "reference, 0.1 %").standard_uncertainty * factor
    assert reference == pytest.approx(0.001 * slope / np.sqrt(3.0), rel=1e-3)
    measurands = ScaleFactorReference().measurands(setting.case, setting.parameters, setting.output)
    assert {one.name for one in measurands} == {one.name for one in found.results}
    assert all(conversion_factor(result(found, one.name).unit, one.unit) > 0.0 for one in measurands)
    told = " ".join(found.remarks)
    assert ("opposite to that of 'reference'" in told) == (sign < 0.0)
    assert result(found, "residual_rms").value == pytest.approx(0.2, rel=0.05)


def test_the_bias_is_the_level_of_the_line_less_the_earths_share():
    found = ScaleFactorReference().reduce(
        samples(moving(-0.9, level_dps=0.5)),
        context(
            ReferenceParameters(
                reference_offset=quantity(0.01, "deg/s"), reference_uncertainty=quantity(1.0, "%")
            )
        ),
    )
    bias = result(found, "bias")
    of_reference = source(bias, "reference, 1 %").standard_uncertainty
    assert of_reference == pytest.approx(0.01 * 0.5 / np.sqrt(3.0), rel=0.05)
    share = 15.041 / 3600.0 * np.sin(np.radians(48.0))
    assert abs(bias.value - (0.5 - share)) < bias.expanded_uncertainty
    assert bias.not_included == ()
    assert "Earth's share" in bias.condition


def test_the_nominal_zero_is_taken_off_and_a_sign_other_than_the_specs_is_told():
    columns = moving(0.02)
    columns[:, 0] += 2.5
    output = Output(
        kind=OutputKind.VOLTAGE,
        scale_factor=quantity(-20.0, "mV/(deg/s)"),
        zero_rate=quantity(2.5, "V"),
    )
    accuracy = Accuracy(of_reading=quantity(1.0, "%"), of_range=quantity(0.0, "%"))
    found = ScaleFactorReference().reduce(
        samples(columns, OutputKind.VOLTAGE),
        context(ReferenceParameters(), output=output, accuracy=accuracy),
    )
    assert result(found, "bias").value == pytest.approx(0.5, abs=0.05)
    assert any("scale factor of −20 mV/(°/s) has the other sign" in one for one in found.remarks)
    meter = source(result(found, "scale_factor"), "meter, 1 % of reading")
    assert meter.standard_uncertainty == pytest.approx(0.01 * 0.02 / np.sqrt(3.0), rel=1e-2)


@pytest.mark.parametrize("procedure", [ScaleFactorReference, ScaleFactorTurn])
def test_what_the_meter_makes_of_the_nominal_zero_is_in_the_bias(procedure):
    """A gain error g of the meter leaves the ratio of level and slope as it is, and moves 2.5 V by g·2.5 V."""
    columns = 2.5 + (moving(0.02) if procedure is ScaleFactorReference else a_turn(0.02))
    columns[:, 1:] -= 2.5
    output = Output(kind=OutputKind.VOLTAGE, zero_rate=quantity(2.5, "V"))
    accuracy = Accuracy(of_reading=quantity(0.01, "%"), of_range=quantity(20.0, "ppm"))
    parameters = ReferenceParameters() if procedure is ScaleFactorReference else turn_parameters()
    plain = samples(columns, OutputKind.VOLTAGE)
    ranged = dataclasses.replace(plain, sampling=dataclasses.replace(plain.sampling, range=10.0))
    bias = result(
        procedure().reduce(ranged, context(parameters, output=output, accuracy=accuracy)), "bias"
    )
    for begins, half_v in (("meter, 0.01 % of reading", 250e-6), ("meter, 20 ppm of range", 200e-6)):
        found = source(bias, begins).standard_uncertainty
        assert found == pytest.approx(half_v / 0.02 / np.sqrt(3.0), rel=0.01)
    unranged = result(
        procedure().reduce(plain, context(parameters, output=output, accuracy=accuracy)), "bias"
    )
    assert "accuracy of the meter's range (range not known)" in unranged.not_included


def test_what_is_not_known_is_named():
    found = ScaleFactorReference().reduce(
        samples(moving(0.02), OutputKind.VOLTAGE), context(ReferenceParameters(), OutputKind.VOLTAGE)
    )
    assert result(found, "scale_factor").not_included == (
        "accuracy of the reference",
        "accuracy of the meter",
    )
    assert result(found, "bias").not_included == (
        "offset of the reference at rest",
        "accuracy of the reference",
        "accuracy of the meter",
    )
    table = Accuracy(
        of_reading=quantity(0.02, "%"), of_range=quantity(0.0, "%"), of_setting=quantity(0.001, "deg/s")
    )
    known = ScaleFactorReference().reduce(
        samples(moving(1.0)), context(ReferenceParameters(), table=table)
    )
    assert result(known, "scale_factor").not_included == result(known, "bias").not_included == ()


def test_what_is_left_out_is_counted_and_gaps_do_not_matter():
    columns = moving(1.0)
    columns[0] = [500.0, 0.0]
    columns[7:10, 1] = np.nan
    slow = int(np.count_nonzero(np.abs(columns[1:, 1]) < 5.0))
    index = np.where(np.arange(3000) < 1000, np.arange(3000), np.arange(3000) + 70)
    found = ScaleFactorReference().reduce(
        samples(columns, index=index),
        context(ReferenceParameters(leave_out=1, low_speed=quantity(5.0, "deg/s"))),
    )
    assert result(found, "scale_factor").value == pytest.approx(1.0, abs=1e-3)
    told = " ".join(found.remarks)
    assert f"The line is fitted to {3000 - 4 - slow} of 3000 samples." in told
    assert "1 gap with room for 70 samples" in told
    assert "Left out: 1 sample at the begin" in told
    assert "3 samples without a value of the reference" in told
    assert f"{slow} samples with the reference slower than 5 deg/s" in told


def test_outliers_are_told_and_left_out_only_where_the_case_says_so():
    columns = moving(1.0)
    columns[100:110, 0] += 300.0
    kept = ScaleFactorReference().reduce(samples(columns), context(ReferenceParameters()))
    assert any(one.startswith("10 samples farther than 15") and "kept" in one for one in kept.remarks)
    chosen = ReferenceParameters(outliers=Outliers.LEAVE_OUT)
    dropped = ScaleFactorReference().reduce(samples(columns), context(chosen))
    assert any("10 samples" in one and "left out" in one for one in dropped.remarks)
    assert result(dropped, "residual_rms").value < result(kept, "residual_rms").value
    columns[200:240, 0] += 300.0
    with pytest.raises(InsufficientDataError, match="50 of 3000 samples are outliers, more than 1%"):
        ScaleFactorReference().reduce(samples(columns), context(chosen))


def test_recordings_without_a_line_are_refused():
    procedure, setting = ScaleFactorReference(), context(ReferenceParameters())
    columns = moving(1.0)
    with pytest.raises(InsufficientDataError, match=r"no 'encoder' is recorded .* but reference"):
        procedure.reduce(samples(columns), context(ReferenceParameters(reference="encoder")))
    with pytest.raises(InsufficientDataError, match="is recorded beside the output; name it in the"):
        procedure.reduce(samples(columns[:, :1]), setting)
    metres = Sampling(
        interval_s=0.01,
        aperture_s=0.01,
        unit="deg/s",
        auxiliary=(Auxiliary(name="reference", unit="m"),),
    )
    with pytest.raises(InsufficientDataError, match="is recorded in 'm', which is no rate"):
        procedure.reduce(samples(columns, sampling=metres), setting)
    with pytest.raises(InsufficientDataError, match="the spec's output is a count"):
        procedure.reduce(samples(columns), context(ReferenceParameters(), OutputKind.COUNT))
    flags = np.zeros(3000, dtype=np.uint8)
    flags[5] = SampleFlag.START_UP
    with pytest.raises(
        InsufficientDataError, match=r"1 of 3000 samples are bad, .* sample 5 \(start up\)"
    ):
        procedure.reduce(samples(columns, flags=flags), setting)
    for dead in (0.0, 0.2 * np.random.default_rng(1).normal(size=3000)):
        with pytest.raises(InsufficientDataError, match="does not follow the reference"):
            procedure.reduce(
                samples(np.stack([dead + 0.0 * columns[:, 1], columns[:, 1]], axis=1)), setting
            )


def test_an_output_that_stands_at_its_limit_while_the_reference_moves_is_refused():
    columns = moving(1.0)
    columns[:, 0] = np.clip(columns[:, 0], -30.0, 30.0)
    with pytest.raises(InsufficientDataError, match="the output stands at its limit"):
        ScaleFactorReference().reduce(samples(columns), context(ReferenceParameters()))
    coarse = moving(1.0)
    coarse[:, 0] = np.round(coarse[:, 0] / 2.0) * 2.0
    found = ScaleFactorReference().reduce(samples(coarse), context(ReferenceParameters()))
    assert result(found, "scale_factor").value == pytest.approx(1.0, abs=2e-3)


def a_turn(slope: float, *, seed: int = 1, angle_deg: float = 360.0) -> NDArray[np.float64]:
    rng = np.random.default_rng(seed)
    shape = 1.0 - np.cos(2.0 * np.pi * (np.arange(600) + 0.5) / 600)
    rate = np.zeros(1200)
    rate[300:900] = shape * angle_deg / (shape.sum() * 0.01)
    return slope * (rate + 0.5 + 0.2 * rng.normal(size=1200))[:, np.newaxis]


def turn_parameters(**changes: Any) -> TurnParameters:
    plain = TurnParameters(
        angle=quantity(360.0, "deg"),
        angle_uncertainty=quantity(6.0, "arcmin"),
        time_uncertainty=quantity(50.0, "ppm"),
    )
    return dataclasses.replace(plain, **changes)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("kind", list(OutputKind))
@pytest.mark.parametrize("rest", [None, Quantity(3.0, "s")])
def test_a_turn_gives_the_scale_factor_in_the_outputs_unit(kind, sign, rest):
    _, unit, slope = KINDS[kind]
    setting = context(turn_parameters(rest=rest), kind)
    found = ScaleFactorTurn().reduce(samples(a_turn(sign * slope), kind), setting)
    scale_factor = result(found, "scale_factor")
    factor = conversion_factor(scale_factor.unit, unit)
    assert scale_factor.value * factor == pytest.approx(sign * slope, rel=1e-3)
    assert abs(scale_factor.value * factor - sign * slope) < scale_factor.expanded_uncertainty * factor
    angle = source(scale_factor, "angle of the turn").standard_uncertainty * factor
    assert angle == pytest.approx(0.1 / 360.0 * slope / np.sqrt(3.0), rel=1e-3)
    measurands = ScaleFactorTurn().measurands(setting.case, setting.parameters, setting.output)
    assert {one.name for one in measurands} == {one.name for one in found.results}
    assert any("opposite to the sign given" in one for one in found.remarks) == (sign < 0.0)
    bias = result(found, "bias")
    share = 15.041 / 3600.0 * np.sin(np.radians(48.0))
    assert abs(bias.value - (0.5 - share)) < bias.expanded_uncertainty


def test_an_angle_the_other_way_round_has_the_other_sign():
    turned = samples(a_turn(1.0))
    forward, back = (
        result(
            ScaleFactorTurn().reduce(turned, context(turn_parameters(angle=quantity(angle, "deg")))),
            "scale_factor",
        ).value
        for angle in (360.0, -360.0)
    )
    assert forward == -back


def test_an_angle_and_a_sampling_rate_of_unknown_accuracy_are_named():
    setting = context(TurnParameters(angle=quantity(1.0, "turn")))
    found = ScaleFactorTurn().reduce(samples(a_turn(1.0)), setting)
    assert result(found, "scale_factor").not_included == ("angle of the turn", "sampling rate")
    assert result(found, "bias").not_included == ("angle of the turn", "sampling rate")


def test_a_rest_at_one_end_only_leaves_their_difference_open():
    parameters = turn_parameters(rest_before=quantity(3.0, "s"), rest_after=quantity(0.0, "s"))
    found = ScaleFactorTurn().reduce(samples(a_turn(1.0)[:900]), context(parameters))
    assert result(found, "scale_factor").value == pytest.approx(1.0, abs=2e-3)
    difference = result(found, "rest_difference")
    assert (difference.value, difference.condition) == (None, "there is a rest at one end only")


def test_turns_that_say_nothing_are_refused():
    procedure, setting = ScaleFactorTurn(), context(turn_parameters(rest=quantity(3.0, "s")))
    still = 0.2 * np.random.default_rng(3).normal(size=(1200, 1))
    with pytest.raises(InsufficientDataError, match="table: the output shows no turn"):
        procedure.reduce(samples(still), setting)
    with pytest.raises(InsufficientDataError, match="table: nothing turns"):
        procedure.reduce(samples(still), context(turn_parameters()))
    with pytest.raises(
        InsufficientDataError, match=r"from sample \d+ on all read .* stood at its limit"
    ):
        procedure.reduce(samples(np.minimum(a_turn(1.0), 70.0)), setting)
    with pytest.raises(InsufficientDataError, match="leave nothing of 12 s"):
        procedure.reduce(samples(a_turn(1.0)), context(turn_parameters(rest=quantity(6.0, "s"))))
    index = np.where(np.arange(1200) < 600, np.arange(1200), np.arange(1200) + 3)
    with pytest.raises(InsufficientDataError, match="3 samples of the turn are missing"):
        procedure.reduce(samples(a_turn(1.0), index=index), setting)


def test_a_turn_beyond_full_scale_is_told():
    output = Output(kind=OutputKind.RATE, full_scale=quantity(100.0, "deg/s"))
    found = ScaleFactorTurn().reduce(samples(a_turn(1.0)), context(turn_parameters(), output=output))
    assert any("faster than full scale, 100 deg/s: at most 12" in one for one in found.remarks)


@pytest.mark.parametrize("procedure", [ScaleFactorReference(), ScaleFactorTurn()])
def test_repeats_give_the_scale_factors_spread(procedure):
    once = [
        Result(name="scale_factor", label="Scale factor", value=value, unit="count/(deg/s)")
        for value in (-16.0, -16.016, -16.032)
    ]
    setting = context(None, OutputKind.COUNT, case=case(repeats=3))
    found = procedure.reduce_repeats(tuple((one,) for one in once), setting)
    spread = result(found, "scale_factor_repeatability")
    assert spread.value == pytest.approx(1e6 * 0.016 / 16.016)
    assert 0.0 < spread.lower_95 < spread.value < spread.upper_95
    with pytest.raises(InsufficientDataError, match="was a recorded file played again"):
        procedure.reduce_repeats(((once[0],),) * 3, setting)
    with pytest.raises(InsufficientDataError, match="2 of 3 repeats have a scale factor"):
        procedure.reduce_repeats(((once[0],), (), (once[1],)), setting)


@pytest.mark.parametrize(
    ("changes", "key", "told"),
    [
        ({"leave_out": 2990}, "parameters.leave_out", "3000 samples less 2990 are too few"),
        ({"leave_out": -1}, "parameters.leave_out", "too few"),
        ({"low_speed": quantity(-1.0, "deg/s")}, "parameters.low_speed", "less than zero"),
        (
            {"reference_uncertainty": quantity(100.0, "%")},
            "parameters.reference_uncertainty",
            "from 0 %",
        ),
        ({"outlier_mads": 1.0}, "parameters.outlier_mads", "make outliers of good samples"),
    ],
)
def test_parameters_of_a_reference_without_sense_are_refused_at_the_door(changes, key, told):
    found = list(
        ScaleFactorReference().complaints(
            case(), ReferenceParameters(**changes), Output(kind=OutputKind.COUNT)
        )
    )
    assert [one for one, _ in found] == [key]
    assert told in found[0][1]


@pytest.mark.parametrize(
    ("changes", "key", "told"),
    [
        ({"angle": quantity(0.0, "deg")}, "parameters.angle", "is no turn"),
        ({"angle_uncertainty": quantity(-1.0, "deg")}, "parameters.angle_uncertainty", "less than zero"),
        ({"rest": quantity(15.0, "s")}, "parameters.rest", "leaves nothing for the turn"),
        ({"rest": quantity(0.0, "s")}, "parameters.rest", "leaves no rest at either end"),
        ({"rest_after": quantity(1.0, "s")}, "parameters.rest_after", "given without 'rest_before'"),
    ],
)
def test_parameters_of_a_turn_without_sense_are_refused_at_the_door(changes, key, told):
    found = list(
        ScaleFactorTurn().complaints(case(), turn_parameters(**changes), Output(kind=OutputKind.COUNT))
    )
    assert [one for one, _ in found] == [key]
    assert told in found[0][1]


def test_both_are_one_step_that_nothing_of_the_bench_moves():
    for procedure, parameters in (
        (ScaleFactorReference(), ReferenceParameters()),
        (ScaleFactorTurn(), turn_parameters()),
    ):
        plan = procedure.plan(case(), parameters)
        assert (plan.samples, plan.turns, plan.soaks) == (3000, False, False)
        assert list(procedure.complaints(case(), parameters, Output(kind=OutputKind.COUNT))) == []


@pytest.mark.parametrize(
    "name",
    [
        "static",
        "bias_repeatability",
        "bias_temperature_sensitivity",
        "scale_factor",
        "bias_reversal",
        "scale_factor_reference",
        "scale_factor_turn",
    ],
)
def test_counts_without_a_scale_factor_are_refused_by_all_that_do_not_measure_it_from_a_recording(name):
    procedure = installed_procedure(name)
    parameters = turn_parameters() if name == "scale_factor_turn" else stand_in_for(procedure.parameters)
    found = procedure.complaints(case(), parameters, Output(kind=OutputKind.COUNT))
    is_needed = any("needs 'output.scale_factor'" in message for _, message in found)
    assert is_needed != name.endswith(("_reference", "_turn"))


def stand_in_for(parameters: type[Any]) -> Any:
    """Parameters with whatever is required."""
    return checked({}, parameters).record
