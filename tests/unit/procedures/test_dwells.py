"""Dwells of a recording: which samples belong to each, which are dropped, which end the test."""

import dataclasses
import re
from typing import Any

import numpy as np
import pytest

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.dwells import DwellRecord, dwell_records, noise_of
from gyrotest.procedures.outlier_rule import OutlierRule
from gyrotest.procedures.rails import rail_of
from gyrotest.procedures.step_table import steps_figure
from gyrotest.records.recording import Gap, SampleFlag, Samples
from gyrotest.units import Quantity
from tests.unit.procedures.turntable import (
    Unit,
    plan_of,
    samples_of_turns,
    table_case,
    table_context,
)

PLAN = plan_of(table_case())
STILL = Unit(bias_dps=0.0, earth_dps=0.0)


def records_of(
    samples: Samples, rule: OutlierRule | None = None, **changes: Any
) -> tuple[DwellRecord, ...]:
    may_saturate = changes.pop("may_saturate", False)
    context = table_context(PLAN, **changes)
    return dwell_records(samples, context, rule=rule, may_saturate=may_saturate)


def changed(samples: Samples, rows: slice | list[int], volts: float) -> Samples:
    values = samples.values.copy()
    values[rows, 0] = volts
    return dataclasses.replace(samples, values=values)


def refusal(samples: Samples, **changes: Any) -> str:
    with pytest.raises(InsufficientDataError) as caught:
        records_of(samples, **changes)
    return str(caught.value)


def test_each_dwell_has_its_own_samples_less_the_nominal_output_at_rest() -> None:
    records = records_of(samples_of_turns(STILL, PLAN))
    assert [one.rate_dps for one in records[:4]] == [0.0, 10.0, -10.0, 20.0]
    assert [one.kept for one in records] == [100] * 12
    assert [one.mean for one in records] == pytest.approx(
        [0.05 * one.rate_dps for one in records], abs=2e-3
    )
    assert records[1].mean_rate_dps == pytest.approx(10.0, abs=0.05)
    assert records[1].middle_s == pytest.approx(10.0 + 3.0 + 5.0)
    assert records[1].begin_s == pytest.approx(13.0)


def test_outliers_are_dropped_and_counted() -> None:
    record = records_of(changed(samples_of_turns(STILL, PLAN), [150], 9.0))[1]
    assert (record.dropped, record.kept) == (1, 99)
    assert record.mean == pytest.approx(0.5, abs=2e-3)


def test_more_than_one_in_a_hundred_is_an_error_that_names_step_and_rule() -> None:
    samples = changed(samples_of_turns(STILL, PLAN), [150, 160], 9.0)
    message = refusal(samples)
    assert "step 'turn 1' at 10 °/s: 2 of 100 samples are not within 7.5 median" in message
    narrow = OutlierRule(window=Quantity(0.001, "%"))
    with pytest.raises(InsufficientDataError, match=re.escape("within 0.0001 °/s of the rate")):
        records_of(samples_of_turns(STILL, PLAN), narrow)


@pytest.mark.parametrize("window", [Quantity(10.0, "%"), Quantity(1.0, "deg/s")])
def test_a_stated_window_is_about_the_rate(window: Quantity) -> None:
    samples = changed(samples_of_turns(STILL, PLAN), [150], 2.5 + 0.05 * 11.2)
    records = records_of(samples, OutlierRule(window=window))
    assert [one.dropped for one in records[:3]] == [0, 1, 0]


def test_a_dwell_has_the_samples_of_its_positions_where_some_are_missing() -> None:
    whole = samples_of_turns(STILL, PLAN)
    keep = np.delete(np.arange(1200), np.arange(120, 130))
    values = np.asfortranarray(whole.values[keep])
    by_index = dataclasses.replace(whole, values=values, flags=whole.flags[keep], index=keep)
    by_gap = dataclasses.replace(by_index, index=None)
    gaps = (Gap(after=119, missing=10, reason="io"),)
    for records in (records_of(by_index), records_of(by_gap, gaps=gaps)):
        assert [one.missing for one in records[:4]] == [0, 10, 0, 0]
        assert [one.mean for one in records] == pytest.approx(
            [0.05 * one.rate_dps for one in records], abs=2e-3
        )
        assert records[1].middle_s > 18.0


def test_a_dwell_that_lost_half_of_its_samples_is_refused() -> None:
    whole = samples_of_turns(STILL, PLAN)
    keep = np.delete(np.arange(1200), np.arange(120, 180))
    part = dataclasses.replace(whole, values=whole.values[keep], flags=whole.flags[keep], index=keep)
    assert "step 'turn 1' at 10 °/s: 40 of 100 samples are there" in refusal(part)


def test_overloads_name_step_rate_count_and_full_scale() -> None:
    message = refusal(samples_of_turns(dataclasses.replace(STILL, saturation=3.5), PLAN))
    assert "step 'turn 9' at 80 °/s: 100 of 100 samples are overloads" in message
    assert "full scale is 100 deg/s" in message


def test_samples_at_a_rail_are_found_without_a_flag() -> None:
    samples = samples_of_turns(STILL, PLAN)
    clipped = dataclasses.replace(samples, values=np.clip(samples.values, -10.0, 2.5 + 4.0))
    message = refusal(clipped)
    assert re.search(
        r"step 'turn 9' at 80 °/s: \d+ of 100 samples read 6.5 V: the output stands", message
    )


@pytest.mark.parametrize("limit_v", [3.0, 4.0])
def test_a_rail_behind_the_meters_noise_is_found(limit_v: float) -> None:
    samples = samples_of_turns(STILL, PLAN)
    noise = np.random.default_rng(7).normal(0.0, 3e-6, samples.values.shape)
    clipped = np.minimum(samples.values, 2.5 + limit_v) + noise
    message = refusal(dataclasses.replace(samples, values=clipped))
    turn = {3.0: "step 'turn 7' at 60 °/s", 4.0: "step 'turn 9' at 80 °/s"}[limit_v]
    assert message.startswith(turn)
    assert "the output stands at its limit" in message


def test_a_gyro_quieter_than_the_meter_is_no_gyro_at_its_limit() -> None:
    quiet = dataclasses.replace(STILL, noise={"angle_random_walk": 1e-6})
    samples = samples_of_turns(quiet, PLAN)
    noise = np.random.default_rng(8).normal(0.0, 3e-6, samples.values.shape)
    records = records_of(dataclasses.replace(samples, values=samples.values + noise))
    assert [one.dropped for one in records] == [0] * 12


def test_where_it_may_saturate_overloads_do_not_count_and_rails_are_told() -> None:
    samples = samples_of_turns(dataclasses.replace(STILL, saturation=4.0), PLAN)
    records = records_of(samples, may_saturate=True)
    assert records[9].saturated
    assert 0 < records[9].overloaded < 100
    assert records[9].kept == 100 - records[9].overloaded
    assert not any(one.saturated for one in records[:9])


@pytest.mark.parametrize("flag", [SampleFlag.FAULT, SampleFlag.START_UP, SampleFlag.NOT_A_NUMBER])
def test_other_flags_are_refused_by_name(flag: SampleFlag) -> None:
    samples = samples_of_turns(STILL, PLAN)
    samples.flags[250] = flag
    spoken = str(flag.name).lower().replace("_", " ")
    assert (
        f"step 'turn 2' at −10 °/s: 1 of 100 samples are bad, the first of them sample 250 ({spoken})"
        in (refusal(samples))
    )


def test_a_recording_without_dwells_is_refused() -> None:
    assert "no dwells" in refusal(samples_of_turns(STILL, PLAN), dwells=())


def test_the_noise_of_all_dwells_tells_how_uncertain_a_mean_is() -> None:
    unit = dataclasses.replace(STILL, noise={"angle_random_walk": 0.01})
    noise = noise_of(records_of(samples_of_turns(unit, PLAN)))
    found = noise.of_mean(10.0)
    assert np.sqrt(found.value) / 0.05 == pytest.approx(0.01 / np.sqrt(10.0), rel=0.4)
    assert found.degrees_of_freedom > 5.0


class TestRails:
    """Saturation by the values alone."""

    random = np.random.default_rng(1)

    def test_noise_has_none_fine_or_coarse(self) -> None:
        noise = self.random.normal(0.0, 1.0, 2000)
        for values in (noise, np.rint(noise), np.rint(noise / 2.0), np.rint(noise + 0.5)):
            assert not rail_of(values).any()

    @pytest.mark.parametrize("step", [1e-6, 0.2, 0.5])
    def test_what_is_cut_off_piles_up(self, step: float) -> None:
        noise = np.rint(self.random.normal(0.0, 1.0, 2000) / step) * step
        for values in (np.minimum(noise, step), np.maximum(noise, -step)):
            assert 700 < rail_of(values).sum() < 1300

    def test_a_constant_is_at_its_limit_or_stuck(self) -> None:
        assert rail_of(np.full(10, 4.0)).all()
        assert rail_of(np.empty(0)).size == 0


def test_a_step_of_the_fewest_samples_may_lose_some_of_them() -> None:
    plan = plan_of(table_case(duration=Quantity(1.6, "s")))
    samples = samples_of_turns(STILL, plan)
    values = samples.values.copy()
    values[20, 0] += 1.0
    kept = np.ones(values.shape[0], dtype=bool)
    kept[[33, 36, 40, 41, 47]] = False
    short = dataclasses.replace(
        samples, values=values[kept], flags=samples.flags[kept], index=np.flatnonzero(kept)
    )
    records = dwell_records(short, table_context(plan))
    assert [one.kept for one in records[:4]] == [16, 15, 11, 16]
    assert 0.0 < noise_of(records).of_mean(records[2].duration_s).value < (0.05 * 0.01) ** 2


def test_a_mean_is_told_to_the_digits_that_its_noise_leaves() -> None:
    records = records_of(samples_of_turns(Unit(bias_dps=0.0, noise={"angle_random_walk": 0.02}), PLAN))
    assert records[0].output.std() / np.sqrt(100.0) == pytest.approx(3e-4, rel=0.2)
    table = steps_figure(records).table
    assert table is not None
    assert table.note == "mean output less the nominal one at rest, 2.5 V"
    told = [row[3].text.replace("−", "-") for row in table.rows[:2]]
    assert told == [f"{one.mean:.5f} V" for one in records[:2]]
