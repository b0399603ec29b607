"""Readings a second through the 34401A driver, against a bare pyvisa loop on the same simulated meter."""

import statistics
import sys
import time
from contextlib import closing

from gyrotest.instruments.agilent34401a import Agilent34401A, Agilent34401ASettings
from gyrotest.instruments.transport.visa import resource_manager
from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Instrument, Simulation, Slot, Station
from gyrotest.simulation.bench import SimulatedBench
from gyrotest.units import Quantity

_ROUNDS = 7
_READINGS = 4000
# One reading of a power-line cycle fits, so that the driver, too, asks once for each reading.
_INTERVAL_S = 0.05
_SETTINGS = Agilent34401ASettings(nplc=1.0, autozero=False)


def main() -> None:
    """Print the rates and their ratio, both ways in turn on a fresh connection each."""
    with SimulatedBench(_station(), _spec()) as bench:
        bench.begin(
            slot="a",
            serial_number="1234",
            case="rate",
            power_cycle=1,
            repeat=1,
            elapsed_s=0,
            duration_s=1e6,
        )
        rates = [(_through_driver(bench), _bare(bench)) for _ in range(_ROUNDS)]
    driver, bare = (statistics.median(each) for each in zip(*rates, strict=True))
    ratio = statistics.median(ours / theirs for ours, theirs in rates)
    sys.stdout.write(
        f"readings through the driver: {driver:.0f}/s, bare pyvisa: {bare:.0f}/s,"
        f" ratio {ratio:.2f} (at least 0.70)\n"
    )


def _through_driver(bench: SimulatedBench) -> float:
    source = Agilent34401A(bench.address("meter"), _SETTINGS, clock=bench.clock, line_frequency_hz=50.0)
    with closing(source):
        source.open()
        if source.configure(_INTERVAL_S).readings != 1:
            raise RuntimeError("more than one reading fits into the interval: no fair comparison")
        start_s = time.perf_counter()
        source.start(0, _READINGS)
        while source.fetch() is not None:
            pass
        return _READINGS / (time.perf_counter() - start_s)


def _bare(bench: SimulatedBench) -> float:
    meter = resource_manager().open_resource(
        bench.address("meter"), read_termination="\n", write_termination="\n"
    )
    with closing(meter):
        for command in ("*RST", "CONF:VOLT:DC 10", "VOLT:DC:NPLC 1", "ZERO:AUTO OFF", "TRIG:DEL 0"):
            meter.write(command)
        meter.query("*OPC?")
        start_s = time.perf_counter()
        for _ in range(_READINGS):
            float(meter.query("READ?"))
        return _READINGS / (time.perf_counter() - start_s)


def _station() -> Station:
    return Station(
        name="rate",
        instruments={"meter": Instrument(driver="agilent34401a", resource="simulated:tcp")},
        slots={"a": Slot(source="meter")},
        simulation=Simulation(),
    )


def _spec() -> Spec:
    return Spec(
        model="SIM50",
        cases={},
        output=Output(
            kind=OutputKind.VOLTAGE,
            scale_factor=Quantity(50.0, "mV/(deg/s)"),
            zero_rate=Quantity(2.5, "V"),
        ),
    )


if __name__ == "__main__":
    main()
