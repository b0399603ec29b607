"""Conditions of a bench: sampling, power, table, chamber and the directions of the axes."""

import dataclasses
import re
from collections.abc import Callable
from typing import Any

import pytest

from gyrotest.certificate.conditions import conditions
from gyrotest.certificate.equipment import equipment
from gyrotest.certificate.statement import deviations
from gyrotest.records.recording import Auxiliary, Dwell, Sampling
from gyrotest.records.run import Attempt, RunRecord
from gyrotest.records.station import Encoder, Instrument, Shaft
from tests.unit.certificate import bench_records, records

FRAME = {"x": "z", "y": "-y", "z": "x"}
SHAFT = Shaft(
    azimuth=bench_records.quantity("30 deg"),
    azimuth_uncertainty=bench_records.quantity("0.5 deg"),
    tilt=bench_records.quantity("0.02 deg"),
)
Pages = Callable[[str], tuple[str, ...]]


def flat(text: str) -> str:
    return re.sub(r"\s+", " ", text)


def each(record: RunRecord, change: Callable[[Attempt], Attempt]) -> RunRecord:
    items = tuple(
        dataclasses.replace(item, attempts=tuple(change(one) for one in item.attempts))
        for item in record.items
    )
    return dataclasses.replace(record, items=items)


def sampled(record: RunRecord, sampling: Sampling) -> tuple[str, ...]:
    def change(attempt: Attempt) -> Attempt:
        recording = attempt.recording
        if recording is None:
            return attempt
        header = dataclasses.replace(recording.header, sampling=sampling)
        return dataclasses.replace(attempt, recording=dataclasses.replace(recording, header=header))

    return conditions(each(record, change))


def soaked(record: RunRecord) -> RunRecord:
    dwells = tuple(
        Dwell(
            name=f"{t} °C",
            first=0,
            samples=10,
            began_s=0.0,
            temperature_degc=t,
            measured_temperature_degc=t + 0.12,
        )
        for t in (25.0, -20.0, 60.0)
    )

    return with_dwells(record, dwells, chamber="chamber")


def with_dwells(record: RunRecord, dwells: tuple[Dwell, ...], **slot: Any) -> RunRecord:
    def change(attempt: Attempt) -> Attempt:
        if attempt.recording is None:
            return attempt
        return dataclasses.replace(
            attempt, recording=dataclasses.replace(attempt.recording, dwells=dwells)
        )

    station = dataclasses.replace(record.header.station, station=bench_records.station(**slot))
    header = dataclasses.replace(record.header, station=station)
    return each(dataclasses.replace(record, header=header), change)


def vibrated(rms_dps: float, **more: Any) -> Dwell:
    return Dwell(name="run", first=0, samples=10, began_s=0.0, vibration_dps=rms_dps, **more)


def test_samples_of_a_digital_gyro_are_its_own() -> None:
    told = conditions(bench_records.three_axes())
    assert told[0] == (
        "One sample of the axes x, y, z every 0.008 s, as the unit sends it, without gaps. "
        "Recorded beside it: temperature (in °C)."
    )


def test_averaged_samples_of_a_digital_gyro_tell_how_many() -> None:
    way = Sampling(interval_s=0.1, aperture_s=0.01, readings=10, unit="deg/s")
    told = sampled(bench_records.three_axes(), way)
    assert told[0] == "One sample every 0.1 s, the mean of 10 readings of the unit's own, without gaps."


def test_what_a_scanner_reads_later_is_told() -> None:
    way = Sampling(
        interval_s=1.0,
        aperture_s=0.02,
        channels=("101",),
        auxiliary=(Auxiliary(name="temperature", unit="V"),),
        offsets_s=(0.0, 0.2),
    )
    told = sampled(records.passing(), way)
    assert "integrated for 2 % of the time" in told[0]
    assert told[0].endswith(
        "Recorded beside it: temperature (in V). Sampled later than 101: temperature 0.2 s."
    )


def test_channels_of_one_clock_and_their_skews_are_told() -> None:
    way = Sampling(
        interval_s=1e-4,
        aperture_s=1e-4,
        channels=("gyro",),
        auxiliary=(Auxiliary(name="encoder_sine", unit="V"),),
        offsets_s=(0.0, 2e-5),
        synchronous=True,
        skew_uncertainty_s=1e-6,
        filter_hz=4000.0,
    )
    told = sampled(records.passing(), way)
    assert told[0] == (
        "gyro, encoder_sine sampled 10000 times a second by one clock; later than gyro and corrected for it:"
        " encoder_sine 20 µs; times between them known to within 1 µs. Analogue low-pass: 4000 Hz."
    )
    bare = dataclasses.replace(way, offsets_s=(), skew_uncertainty_s=None, filter_hz=None)
    told = sampled(records.passing(), bare)
    assert told[0].endswith(
        "by one clock; how well the times between them are known is not stated. Analogue low-pass: not stated."
    )


def test_what_measures_the_angle_and_how_a_shaft_lies_is_told() -> None:
    held = (Dwell(name="rest", first=0, samples=10, began_s=0.0, position_deg=90.0),)
    way = Sampling(
        interval_s=0.01,
        aperture_s=0.01,
        channels=("gyro",),
        auxiliary=(Auxiliary(name="encoder_angle", unit="deg"),),
        synchronous=True,
    )

    def told(encoder: Encoder) -> str:
        record = with_dwells(
            bench_records.rate_table(), held, table="stage", encoder=encoder, frame=FRAME
        )
        station = record.header.station.station
        stage = Instrument(driver="acutrol3000", resource="simulated", shaft=SHAFT)
        station = dataclasses.replace(station, instruments={**station.instruments, "stage": stage})
        document = dataclasses.replace(record.header.station, station=station)
        header = dataclasses.replace(record.header, station=document)
        return " ".join(sampled(dataclasses.replace(record, header=header), way))

    grating = told(
        Encoder(sine="ua", cosine="ub", lines=9000, accuracy=bench_records.quantity("2 arcsec"))
    )
    assert (
        "Angle measured by a grating of 9000 lines a turn (channels ua and ub); its error within a turn"
        in grating
    )
    assert "±2 arcsec at most." in grating
    assert (
        "Level shaft: azimuth of the stage's x axis at the angle 0 30° (±0.5° at most); tilt 0.02°"
        " (±0.05° at most); angle 0 within ±0.1°."
    ) in grating
    assert "Axes of the unit along those of the stage: x along z, y along −y, z along x." in grating
    assert "an encoder (channel a); its error within a turn is not stated." in told(Encoder(angle="a"))


def test_supply_and_power_cycles_are_told() -> None:
    told = " ".join(conditions(bench_records.rate_table()))
    assert "Powered with 5 V by 'supply': current limit 400 mA, over-voltage protection 5.5 V." in told
    assert "Power cycles before repeats 2 … 7 of bias_repeatability: off for 10 s." in told


def test_power_by_hand_is_told_as_manual(pages: Pages) -> None:
    text = flat(" ".join(pages("by_hand")))
    assert "Powered by hand: no power supply of the station was used." in text
    assert "Power cycles before repeats 2 … 7 of bias_repeatability: by hand (manual)." in text
    assert "bias_repeatability, repeats 2 … 7: power switched off and on by hand (manual)" in text


def test_a_replayed_record_says_nothing_of_power() -> None:
    told = conditions(dataclasses.replace(records.passing(), replayed=True))
    assert not any("owered" in text for text in told)


def test_table_its_limits_and_the_rates_are_told() -> None:
    told = conditions(bench_records.rate_table())
    assert "Rate table 'table' (acutrol3000): at most 200 °/s, 100 °/s², with a slip ring." in told
    rates = next(text for text in told if text.startswith("Rates asked for in scale_factor: "))
    assert "−80, −60, −40, −20, −10, 0, 10, 20, 40, 60, 80 °/s" in rates
    assert rates.endswith("; read back within 0.00040 °/s of that.")


@pytest.mark.parametrize(
    ("rates", "told"),
    [
        ((0.0, 40.0, -40.0), "−40, 0, 40 °/s;"),
        (
            (0.0, *(sign * float(n) for n in range(1, 12) for sign in (1, -1))),
            "0, ±1, ±2, ±3, ±4, ±5, ±6",
        ),
        (tuple(0.001 * n for n in range(40)), "0 … 0.039 °/s in 40 levels;"),
    ],
)
def test_many_rates_are_told_in_short(rates: tuple[float, ...], told: str) -> None:
    def change(attempt: Attempt) -> Attempt:
        if attempt.recording is None or not attempt.recording.dwells:
            return attempt
        recording = dataclasses.replace(attempt.recording, dwells=bench_records.dwells(rates))
        return dataclasses.replace(attempt, recording=recording)

    found = conditions(each(bench_records.rate_table(), change))
    assert any(text.startswith(f"Rates asked for in scale_factor: {told}") for text in found)


def test_a_table_that_did_not_turn_is_not_told() -> None:
    assert not any("Rate table" in text for text in conditions(bench_records.three_axes()))


def test_vibration_its_level_and_band_are_told() -> None:
    runs = (vibrated(0.0), vibrated(8.0, band_hz=(5.0, 100.0)), vibrated(8.0, band_hz=(5.0, 100.0)))
    told = conditions(with_dwells(bench_records.three_axes(), runs, vibration="supply"))
    assert "Vibration table, driven by 'supply' (scpi_supply)." in told
    (asked,) = (text for text in told if text.startswith("Vibration asked for"))
    assert asked.endswith(": 8 °/s root mean square, from 5 to 100 Hz, 2 times.")


def test_the_frequencies_of_sines_are_told() -> None:
    sines = (vibrated(0.0), vibrated(8.0, frequency_hz=5.0), vibrated(8.0, frequency_hz=12.5))
    told = conditions(with_dwells(bench_records.three_axes(), sines, vibration="supply"))
    assert any(text.endswith(": 8 °/s root mean square, sines of 5, 12.5 Hz.") for text in told)


def test_a_table_that_only_rests_is_no_vibration() -> None:
    told = conditions(with_dwells(bench_records.three_axes(), (vibrated(0.0),), vibration="supply"))
    assert not any("ibration" in text for text in told)


def test_chamber_and_temperatures_are_told() -> None:
    told = conditions(soaked(bench_records.three_axes()))
    assert "Temperature chamber 'chamber' (chamber)." in told
    assert "Temperatures asked for in noise: −20, 25, 60 °C; read back within 0.12 °C of that." in told


def test_a_direction_that_several_cases_share_is_told_once() -> None:
    record = bench_records.rate_table()
    spec = record.header.spec.spec
    cases = {
        name: dataclasses.replace(case, mountings={}, mounting=way)
        for (name, case), way in zip(
            spec.cases.items(), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)), strict=False
        )
    }
    changed = dataclasses.replace(
        record.header,
        spec=dataclasses.replace(record.header.spec, spec=dataclasses.replace(spec, cases=cases)),
    )
    told = conditions(dataclasses.replace(record, header=changed))
    first, second, *third = cases
    shared = ", ".join((first, *third))
    assert [one for one in told if one.startswith("Sensitive ax")] == [
        f"Sensitive axis in {shared}: up 1, north 0, east 0.",
        f"Sensitive axis in {second}: up 0, north 1, east 0.",
    ]


def test_direction_of_each_judged_axis_is_told() -> None:
    told = conditions(bench_records.three_axes())
    assert (
        "Sensitive axes in noise: x up 0, north 1, east 0; y up 0, north 0, east 1; "
        "z up 1, north 0, east 0." in told
    )
    told = conditions(bench_records.rate_table())
    assert "Sensitive axes in scale_factor: z up 1, north 0, east 0." in told
    assert "Judged in scale_factor: axis z of x, y, z." in told


def test_the_unit_itself_needs_no_calibration() -> None:
    record = bench_records.rate_table()
    unit = equipment(record)[0]
    assert unit.made_by == "Example TRIAX300, the unit under test"
    assert unit.certificate == "–"
    assert not any("'gyro'" in text for text in deviations(record))


def test_only_what_was_used_is_listed() -> None:
    def names(record: RunRecord) -> list[str]:
        return [one.name for one in equipment(record)]

    turned = bench_records.rate_table()
    assert names(turned) == ["gyro (stim300)", "table (acutrol3000)", "supply (scpi_supply)"]
    bare = each(turned, lambda one: dataclasses.replace(one, instruments=()))
    assert names(bare) == names(turned)
    still = each(bench_records.three_axes(), lambda one: dataclasses.replace(one, instruments=()))
    assert names(still) == ["gyro (stim300)"]
    assert "chamber (chamber)" in names(soaked(still))


def test_events_of_several_items_are_said_once() -> None:
    record = each(
        bench_records.rate_table(), lambda one: dataclasses.replace(one, events=("resynchronised",))
    )
    found = [text for text in deviations(record) if text.endswith("resynchronised")]
    assert len(found) == 1
    assert "scale_factor, repeat 1; bias_repeatability, repeats 1 … 7 and over the repeats" in found[0]


def test_recordings_tell_their_steps_and_exports_their_hashes(pages: Pages) -> None:
    text = flat(" ".join(pages("rate_table")))
    assert "90 000 of 90 000 samples in 24 steps, 0 missing" in text
    assert f"exports/compensation-{bench_records.SERIAL}.json exported for other programs" in text
    assert "ab" * 32 in text


def test_angles_that_a_stage_held_are_told_beside_the_rates_of_its_turns() -> None:
    at_rest = [
        Dwell(
            name="rest",
            first=0,
            samples=10,
            began_s=0.0,
            position_deg=deg,
            measured_position_deg=deg + 0.02,
        )
        for deg in (0.0, 90.0, 180.0)
    ]
    turn = Dwell(name="turn", first=0, samples=10, began_s=0.0, rate_dps=6.0, measured_rate_dps=6.001)
    told = conditions(with_dwells(bench_records.three_axes(), (*at_rest, turn)))
    assert any(one.startswith("Rate table 'table' (acutrol3000): at most 200 °/s") for one in told)
    assert any(one.endswith(": 6 °/s; read back within 0.0010 °/s of that.") for one in told)
    assert any(": 0, 90, 180 °; read back within 0.020 ° of that." in one for one in told)
