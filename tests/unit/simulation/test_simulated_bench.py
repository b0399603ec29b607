"""The simulated bench: units drawn by name, truth, scenarios, complaints about the station."""

import math
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.errors import StationError
from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Accuracy, Instrument, Simulation, Slot, Station
from gyrotest.simulation.bench import SimulatedBench
from gyrotest.simulation.converter import OVERLOAD_V
from gyrotest.simulation.dialogue import LineDialogue
from gyrotest.simulation.meter import Meter
from gyrotest.simulation.meter_peer import MeterPeer
from gyrotest.simulation.meter_state import Interface
from gyrotest.units import Quantity

OUTPUT = Output(
    kind=OutputKind.VOLTAGE,
    scale_factor=Quantity(50.0, "mV/(deg/s)"),
    zero_rate=Quantity(2.5, "V"),
    bandwidth=Quantity(50.0, "Hz"),
)
SPEC = Spec(model="SIM50", output=OUTPUT, cases={})
QUIET = {
    "angle_random_walk": "0 deg/sqrt(h)",
    "bias_instability_coefficient": "0 deg/h",
    "rate_random_walk": "0 deg/h/sqrt(h)",
}


def station(
    *,
    gyro: Mapping[str, Any] | None = None,
    meter: Mapping[str, Any] | None = None,
    scenario: str = "nominal",
    accuracy: Accuracy | None = None,
) -> Station:
    return Station(
        name="simulated",
        instruments={
            "meter": Instrument(driver="agilent34401a", resource="simulated", accuracy=accuracy)
        },
        slots={"a": Slot(source="meter")},
        simulation=Simulation(
            scenario=scenario, gyro=gyro or {}, instruments={"meter": meter} if meter is not None else {}
        ),
    )


def spec_of(output: Output) -> Spec:
    return replace(SPEC, output=output)


def begin(
    bench: SimulatedBench,
    *,
    serial: str = "1234",
    repeat: int = 1,
    power_cycle: int = 0,
    case: str = "c",
    elapsed_s: float = 600.0,
) -> None:
    bench.begin(
        slot="a",
        serial_number=serial,
        case=case,
        power_cycle=power_cycle,
        repeat=repeat,
        elapsed_s=elapsed_s,
        duration_s=400.0,
    )


def meter_of(bench: SimulatedBench) -> Meter:
    peer = bench._peers["meter"]
    assert isinstance(peer, MeterPeer)
    return peer.meter


def record(bench: SimulatedBench, count: int = 1000) -> NDArray[np.float64]:
    """Readings as a client gets them, 0.4 s each, without the wire."""
    dialogue = LineDialogue(meter_of(bench), Interface.SOCKET)
    list(dialogue.receive(b"CONF:VOLT:DC 10,1E-5\nTRIG:DEL 0\n"))
    list(dialogue.receive(b"SAMP:COUN %d\n" % count))
    said = b""
    for ready_s, part in dialogue.receive(b"READ?\n"):
        bench.clock.sleep_until(ready_s)
        said += part
    return np.array([float(one) for one in said.split(b",")])


def test_a_record_depends_on_its_name_and_not_on_those_before() -> None:
    with SimulatedBench(station(), SPEC) as bench:
        begin(bench, repeat=1)
        first = record(bench)
        begin(bench, repeat=2)
        second = record(bench)
    with SimulatedBench(station(), SPEC) as bench:
        begin(bench, repeat=2)
        alone = record(bench)
    assert alone == pytest.approx(second, abs=2e-6)
    assert np.abs(first - second).max() > 1e-4


@pytest.mark.parametrize(
    "change", [{"serial": "1235"}, {"case": "d"}, {"power_cycle": 1}, {"repeat": 2}]
)
def test_every_part_of_the_name_gives_other_noise(change: dict[str, Any]) -> None:
    with SimulatedBench(station(), SPEC) as bench:
        begin(bench)
        first = record(bench, 100)
        begin(bench, **change)
        assert np.abs(np.diff(record(bench, 100)) - np.diff(first)).max() > 1e-4


def test_the_seed_gives_other_units() -> None:
    biases = []
    for seed in (1, 2, 3):
        with SimulatedBench(station(), SPEC, seed=seed) as bench:
            begin(bench)
            biases.append(bench.truth("a", duration_s=400.0)["turn_on_bias_dps"])
    assert len(set(biases)) == 3


def test_turn_on_bias_changes_with_power_cycle_and_scale_factor_with_the_unit_only() -> None:
    with SimulatedBench(station(), SPEC) as bench:
        begin(bench, repeat=1)
        first = bench.truth("a", duration_s=400.0)
        begin(bench, repeat=2, case="d")
        same_power = bench.truth("a", duration_s=400.0)
        begin(bench, repeat=2, power_cycle=1)
        cycled = bench.truth("a", duration_s=400.0)
        begin(bench, serial="77")
        other = bench.truth("a", duration_s=400.0)
    assert first["turn_on_bias_dps"] == same_power["turn_on_bias_dps"] != cycled["turn_on_bias_dps"]
    assert first["scale_factor_v_per_dps"] == cycled["scale_factor_v_per_dps"]
    assert first["meter_gain_error"] == cycled["meter_gain_error"]
    assert first["scale_factor_v_per_dps"] != other["scale_factor_v_per_dps"]
    assert first["meter_gain_error"] != other["meter_gain_error"]


def test_units_are_spread_as_the_station_says() -> None:
    with SimulatedBench(station(gyro={"turn_on_bias": "0.2 deg/s"}), SPEC) as bench:
        truths = []
        for serial in range(600):
            begin(bench, serial=str(serial))
            truths.append(bench.truth("a", duration_s=400.0))
    biases = np.array([truth["turn_on_bias_dps"] for truth in truths])
    factors = np.array([truth["scale_factor_v_per_dps"] for truth in truths]) / 0.05 - 1.0
    assert biases.std() == pytest.approx(0.2, rel=0.1)
    assert abs(biases.mean()) < 0.03
    assert 0.0049 < np.abs(factors).max() <= 0.005
    assert factors.std() == pytest.approx(0.005 / math.sqrt(3.0), rel=0.1)


def test_a_quiet_unit_reads_what_the_truth_says() -> None:
    gyro = {
        **QUIET,
        "input_rate": "-2 deg/s",
        "warm_up_drift": "1 deg/s",
        "warm_up_time_constant": "100 s",
    }
    with SimulatedBench(station(gyro=gyro, meter={"noise": "0 V"}), SPEC) as bench:
        begin(bench, elapsed_s=50.0)
        values = record(bench)
        truth = bench.truth("a", duration_s=400.0)
    rate = truth["bias_dps"] + truth["input_rate_dps"]
    volts = truth["scale_factor_v_per_dps"] * rate + truth["zero_rate_v"]
    volts = volts * (1.0 + truth["meter_gain_error"]) + truth["meter_offset_of_range"] * 10.0
    # The autozero half of each reading is not integrated, which matters little to so slow a drift.
    assert values.mean() == pytest.approx(volts, abs=2e-4 * 0.05 * 4)
    expected = math.exp(-0.5) * 100.0 / 400.0 * (1.0 - math.exp(-4.0))
    assert truth["mean_drift_dps"] == pytest.approx(expected)
    assert truth["bias_dps"] == truth["turn_on_bias_dps"] + truth["mean_drift_dps"]


def test_the_meters_errors_stay_within_the_stations_accuracy() -> None:
    stated = Accuracy(
        of_reading=Quantity(100.0, "ppm"), of_range=Quantity(20.0, "ppm"), noise=Quantity(5.0, "uV")
    )
    with SimulatedBench(station(accuracy=stated), SPEC) as bench:
        truths = []
        for serial in range(200):
            begin(bench, serial=str(serial))
            truths.append(bench.truth("a", duration_s=1.0))
    assert 90e-6 < max(abs(truth["meter_gain_error"]) for truth in truths) <= 100e-6
    assert 18e-6 < max(abs(truth["meter_offset_of_range"]) for truth in truths) <= 20e-6
    assert [truth["meter_noise_v"] for truth in truths] == pytest.approx([5e-6] * 200)


def played(scenario: str) -> NDArray[np.float64]:
    with SimulatedBench(station(), SPEC, scenario=scenario) as bench:
        begin(bench)
        return record(bench)


def test_a_dead_output_gives_only_the_meters_noise() -> None:
    values = played("dead-output")
    assert values.mean() == pytest.approx(2.5, abs=2e-4)
    assert 2e-6 < values.std() < 5e-6


def test_an_inverted_unit_turns_its_departure_from_zero_rate_round() -> None:
    departure = played("nominal") - 2.5
    assert played("inverted") - 2.5 == pytest.approx(-departure, abs=5e-4)


def test_a_unit_out_of_limits_has_several_times_the_noise() -> None:
    assert np.diff(played("out-of-limits")).std() > 3.0 * np.diff(played("nominal")).std()


def test_an_overload_strikes_in_the_middle_of_a_record_and_ends() -> None:
    overloaded = np.abs(played("overload")) >= OVERLOAD_V
    assert list(np.flatnonzero(overloaded)) == list(range(400, 420))


def test_a_stuck_meter_repeats_a_reading_from_half_of_the_record_on() -> None:
    values = played("stuck-reading")
    assert len(set(values[500:])) == 1
    assert len(set(values[:500])) > 400


def test_an_instrument_without_a_record_has_no_truth() -> None:
    with SimulatedBench(station(), SPEC) as bench:
        assert bench.truth("a", duration_s=1.0) == {}
        assert bench.truth("nowhere", duration_s=1.0) == {}


@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        ({"gyro": {"angle_random_walk": "0.5 deg/h"}}, "simulation.gyro.angle_random_walk: "),
        ({"gyro": {"angle_random_walk": 0.5}}, "simulation.gyro.angle_random_walk: "),
        ({"gyro": {"turn_on_bais": "1 deg/s"}}, "did you mean 'turn_on_bias'"),
        ({"gyro": {"bandwidth": "0 Hz"}}, "simulation.gyro.bandwidth: '0 Hz' must be more than zero"),
        ({"gyro": {"turn_on_bias": "-1 deg/s"}}, "must be zero or more"),
        (
            {"meter": {"model": "3458A"}},
            "simulation.instruments.meter.model: '3458A' cannot be simulated",
        ),
        ({"meter": {"noise": "1 deg/s"}}, "simulation.instruments.meter.noise: "),
        ({"scenario": "nominel"}, "simulation.scenario: 'nominel' is no scenario"),
    ],
)
def test_a_complaint_names_the_key(given: dict[str, Any], complaint: str) -> None:
    with pytest.raises(StationError) as refused:
        SimulatedBench(station(**given), SPEC)
    assert complaint in str(refused.value)


def test_all_complaints_about_the_gyro_come_at_once() -> None:
    gyro = {"bandwidth": "1 s", "turn_on_bias": "1 V", "unknown": 1}
    with pytest.raises(StationError) as refused:
        SimulatedBench(station(gyro=gyro), SPEC)
    assert len(refused.value.faults) == 3


def test_an_entry_for_no_instrument_is_refused() -> None:
    made = replace(station(), simulation=Simulation(instruments={"metre": {}}))
    with pytest.raises(StationError, match="did you mean 'meter'"):
        SimulatedBench(made, SPEC)


@pytest.mark.parametrize("resource", ["simulated:gpib", "simulated:"])
def test_an_unknown_way_to_a_simulated_instrument_is_refused(resource: str) -> None:
    made = replace(
        station(), instruments={"meter": Instrument(driver="agilent34401a", resource=resource)}
    )
    with pytest.raises(StationError, match=r"instruments\.meter\.resource: 'simulated:"):
        SimulatedBench(made, SPEC)


def test_an_output_that_is_no_voltage_is_refused() -> None:
    with pytest.raises(StationError, match="voltage output"):
        SimulatedBench(station(), spec_of(Output(kind=OutputKind.RATE)))


def test_a_station_without_a_simulation_section_is_nominal() -> None:
    with SimulatedBench(replace(station(), simulation=None), SPEC) as bench:
        begin(bench)
        assert record(bench, 10).mean() == pytest.approx(2.5, abs=0.1)


def test_real_time_is_the_real_clock() -> None:
    with SimulatedBench(station(), SPEC, real_time=True) as bench:
        before_s = bench.clock.now_s()
        bench.clock.sleep_until(before_s + 0.01)
        assert bench.clock.now_s() >= before_s + 0.01


def test_a_gyro_that_puts_out_rates_is_sent_to_another_station() -> None:
    with pytest.raises(
        StationError, match=r"output\.kind is 'rate'; name another station by --gyro-sta.*replay"
    ):
        SimulatedBench(station(), spec_of(Output(kind=OutputKind.RATE)))


def test_a_voltage_without_its_scale_factor_is_refused() -> None:
    with pytest.raises(StationError, match=r"the spec has no 'output\.scale_factor'"):
        SimulatedBench(station(), spec_of(Output(kind=OutputKind.VOLTAGE)))


def test_every_start_with_a_simulated_station_is_spared_what_only_its_motion_needs() -> None:
    program = (
        "import sys\n"
        "from gyrotest.simulation.complaints import simulation_faults\n"
        "from gyrotest.specification.lookup import shipped_specs\n"
        "from gyrotest.specification.station import load_station\n"
        "station = load_station(shipped_specs() / 'stations' / 'simulated.yaml').station\n"
        "assert not simulation_faults(station)\n"
        "print({'scipy.signal', 'scipy.linalg', 'scipy.stats'} & set(sys.modules))"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout == "set()\n"
