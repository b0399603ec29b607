"""A place on the simulated bench: one meter and the unit that it reads."""

from dataclasses import dataclass

from gyrotest.ports import Clock
from gyrotest.simulation.converter import Converter, MeterErrors
from gyrotest.simulation.faults import Faults
from gyrotest.simulation.gyro import GyroOutput, GyroParameters, RailedOutput, Signal, SteadyOutput, Unit
from gyrotest.simulation.meter import Meter
from gyrotest.simulation.noise import RateNoise
from gyrotest.simulation.personalities import MODELS, command_table
from gyrotest.simulation.scenarios import Misbehaviour, Scenario
from gyrotest.simulation.settings import MeterParameters
from gyrotest.simulation.streams import Normals, generator

_RAIL_V = 15.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Occasion:
    """Which record of which unit is next: what the random streams depend on."""

    serial_number: str
    case: str
    power_cycle: int
    repeat: int
    elapsed_s: float
    duration_s: float


class Workplace:
    """One meter of the bench and the unit that it reads."""

    def __init__(
        self,
        name: str,
        meter: Meter,
        gyro: GyroParameters,
        errors: MeterParameters,
        *,
        seed: int,
        scenario: Scenario,
        clock: Clock,
    ) -> None:
        self.meter = meter
        self._name = name
        self._gyro = gyro
        self._errors = errors
        self._seed = seed
        self._scenario = scenario
        self._clock = clock
        self._unit: Unit | None = None
        self._elapsed_s = 0.0
        self._drawn_errors: MeterErrors | None = None

    def begin(self, occasion: Occasion) -> None:
        """Put a unit on the meter's input and restart the random streams for its next record."""
        now_s = self._clock.now_s()
        unit = self._draw_unit(occasion, now_s)
        errors = self._draw_errors(occasion.serial_number)
        stream = (occasion.serial_number, occasion.case, occasion.power_cycle, occasion.repeat)
        noise = RateNoise(
            self._gyro.noise,
            Normals(generator(self._seed, "gyro noise", *stream)),
            since_power_on_s=occasion.elapsed_s,
            start_s=now_s,
        )
        faults = Faults(self._scenario.strikes, start_s=now_s, duration_s=occasion.duration_s)
        normals = Normals(generator(self._seed, "meter noise", self._name, *stream))
        signal = self._signal(unit, noise, now_s, occasion.duration_s)
        self._unit, self._drawn_errors, self._elapsed_s = unit, errors, occasion.elapsed_s
        self.meter.connect(Converter(signal, errors, normals, faults))

    def _draw_unit(self, occasion: Occasion, now_s: float) -> Unit:
        gyro, serial = self._gyro, occasion.serial_number
        spread = generator(self._seed, "scale factor", serial).uniform(-1.0, 1.0)
        turn_on = generator(self._seed, "turn-on bias", serial, occasion.power_cycle).standard_normal()
        factor = gyro.scale_factor_v_per_dps * (1.0 + gyro.scale_factor_error * spread)
        return Unit(
            parameters=gyro,
            scale_factor_v_per_dps=-factor if self._scenario.inverted else factor,
            turn_on_bias_dps=gyro.turn_on_bias_dps * turn_on,
            power_on_s=now_s - occasion.elapsed_s,
        )

    def _draw_errors(self, serial_number: str) -> MeterErrors:
        stream = generator(self._seed, "meter errors", serial_number, self._name)
        return MeterErrors(
            gain=self._errors.gain_error * stream.uniform(-1.0, 1.0),
            offset_of_range=self._errors.offset_error_of_range * stream.uniform(-1.0, 1.0),
            noise_v=self._errors.noise_v,
        )

    def _signal(self, unit: Unit, noise: RateNoise, now_s: float, duration_s: float) -> Signal:
        if self._scenario.dead_output:
            return SteadyOutput(self._gyro.zero_rate_v)
        signal: Signal = GyroOutput(unit, noise)
        for strike in self._scenario.strikes:
            if strike.misbehaviour is Misbehaviour.RAIL:
                from_s, to_s = now_s + strike.at * duration_s, now_s + strike.until * duration_s
                signal = RailedOutput(signal, from_s=from_s, to_s=to_s, rail_v=_RAIL_V)
        return signal

    def truth(self, duration_s: float) -> dict[str, float]:
        """The true figures of the unit and the meter for the record begun last; empty before the first."""
        unit, errors = self._unit, self._drawn_errors
        if unit is None or errors is None:
            return {}
        drift = unit.drift_dps(unit.power_on_s + self._elapsed_s, duration_s)
        noise = self._gyro.noise
        return {
            "turn_on_bias_dps": unit.turn_on_bias_dps,
            "mean_drift_dps": drift,
            "bias_dps": unit.turn_on_bias_dps + drift,
            "input_rate_dps": self._gyro.input_rate_dps,
            "angle_random_walk_dps_sqrt_s": noise.angle_random_walk_dps_sqrt_s,
            "bias_instability_coefficient_dps": noise.bias_instability_dps,
            "rate_random_walk_dps_per_sqrt_s": noise.rate_random_walk_dps_per_sqrt_s,
            "bandwidth_hz": noise.bandwidth_hz,
            "scale_factor_v_per_dps": unit.scale_factor_v_per_dps,
            "zero_rate_v": self._gyro.zero_rate_v,
            "meter_gain_error": errors.gain,
            "meter_offset_of_range": errors.offset_of_range,
            "meter_noise_v": errors.noise_v,
        }


def new_meter(
    model: str,
    *,
    serial_number: str,
    line_frequency_hz: float,
    clock: Clock,
    live: bool,
    hurried: bool = False,
) -> Meter:
    """A meter with nothing connected."""
    idle = Converter(
        SteadyOutput(0.0),
        MeterErrors(gain=0.0, offset_of_range=0.0, noise_v=0.0),
        Normals(generator(0, "nothing connected")),
        Faults((), start_s=0.0, duration_s=0.0),
    )
    return Meter(
        MODELS[model],
        command_table(model),
        serial_number=serial_number,
        line_frequency_hz=line_frequency_hz,
        clock=clock,
        converter=idle,
        live=live,
        hurried=hurried,
    )
