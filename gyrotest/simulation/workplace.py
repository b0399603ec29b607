"""A slot of the simulated bench: the unit in it, and what stands on its wires."""

from gyrotest.ports import Clock
from gyrotest.simulation.faults import Faults
from gyrotest.simulation.gyro import GyroOutput, GyroParameters, RailedOutput, Signal, SteadyOutput, Unit
from gyrotest.simulation.noise import RateNoise
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Reading
from gyrotest.simulation.scenarios import Misbehaviour, Scenario
from gyrotest.simulation.streams import Normals, generator

_RAIL_V = 15.0


class Workplace:
    """A slot, and the unit in it."""

    def __init__(
        self, channel: str, gyro: GyroParameters, *, seed: int, scenario: Scenario, clock: Clock
    ) -> None:
        self._channel = channel
        self._gyro = gyro
        self._seed = seed
        self._scenario = scenario
        self._clock = clock
        self._unit: Unit | None = None
        self.occasion: Occasion | None = None

    def begin(self, occasion: Occasion, source: Reading) -> None:
        """Put a unit on the source's input and restart the random streams for its next record."""
        now_s = self._clock.now_s()
        unit = self._draw_unit(occasion, now_s)
        noise = RateNoise(
            self._gyro.noise,
            Normals(generator(self._seed, "gyro noise", *occasion.stream)),
            since_power_on_s=occasion.elapsed_s,
            start_s=now_s,
        )
        strikes = self._scenario.strikes if occasion.duration_s > 0.0 else ()
        faults = Faults(strikes, start_s=now_s, duration_s=occasion.duration_s)
        self._unit, self.occasion = unit, occasion
        signal = self._signal(unit, noise, now_s, occasion.duration_s)
        source.connect(occasion, {self._channel: signal}, faults)

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
        """The true figures of the unit for the record begun last; empty before the first."""
        unit, occasion = self._unit, self.occasion
        if unit is None or occasion is None:
            return {}
        drift = unit.drift_dps(unit.power_on_s + occasion.elapsed_s, duration_s)
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
        }
