"""One axis of a simulated unit in its place: what it makes of everything that acts on it."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.carriage import Carriage
from gyrotest.simulation.surroundings import REFERENCE_DEGC, Acting
from gyrotest.simulation.unit import Axis, Dice, GyroParameters, PowerOn, drift_dps, drifts_dps


class Element:
    """An axis without its noise: `U = SF·(R(ω) + B + noise) + U_z`, clipped where it saturates."""

    def __init__(self, axis: Axis, gyro: GyroParameters, carriage: Carriage, dice: Dice) -> None:
        self.axis = axis
        self.carriage = carriage
        self._gyro = gyro
        self._dice = dice
        self._turn_on: tuple[int, float] = (-1, 0.0)
        response = axis.response
        self.scale_factor = response.scale_factor
        self.zero_rate = response.zero_rate
        self.saturation_dps = response.saturation_dps
        # What gravity makes of the bias, while the axis turns.
        self._force = carriage.felt_dps(axis.g_sensitivity_dps_per_g)
        still = np.array(self._alive(gyro.input_rate_dps) + carriage.at_rest_dps)
        self._still_dps = float(response.felt_dps(still)) + self._force.at_rest

    def _alive(self, turning_dps: float) -> float:
        """What passes the dead zone, of a turning from rest."""
        return turning_dps if abs(turning_dps) >= self._gyro.dead_zone_dps else 0.0

    def turn_on_bias_dps(self, power_on: PowerOn) -> float:
        """The turn-on bias of a power-on."""
        if self._turn_on[0] != power_on.cycle:
            drawn = self._dice.turn_on(self.axis.name, power_on.cycle)
            self._turn_on = (power_on.cycle, self._gyro.turn_on_bias_dps * drawn)
        return self._turn_on[1]

    def still_rate_dps(self, power_on: PowerOn, start_s: float, aperture_s: float) -> float:
        """Mean of `R(ω) + B` over an aperture, where nothing but the Earth acts."""
        drift = drift_dps(self._gyro, start_s - power_on.on_s, aperture_s)
        return self._still_dps + self.turn_on_bias_dps(power_on) + drift

    def still_rates_dps(
        self, power_on: PowerOn, starts_s: NDArray[np.float64], aperture_s: float
    ) -> NDArray[np.float64]:
        """`still_rate_dps` over many apertures, (n,)."""
        drifts = drifts_dps(self._gyro, starts_s - power_on.on_s, aperture_s)
        return drifts + (self._still_dps + self.turn_on_bias_dps(power_on))

    def rates_dps(
        self, power_on: PowerOn, starts_s: NDArray[np.float64], acting: Acting
    ) -> NDArray[np.float64]:
        """Means of `R(ω) + B` over apertures, under whatever acts, (n,)."""
        gyro, carriage = self._gyro, self.carriage
        turning = np.full(starts_s.shape, gyro.input_rate_dps)
        earth: NDArray[np.float64] | float = carriage.at_rest_dps
        force: NDArray[np.float64] | float = self._force.at_rest
        if acting.from_deg is not None and acting.to_deg is not None:
            turned_deg = acting.to_deg - acting.from_deg
            turning += carriage.table_share * turned_deg / acting.aperture_s
            earth = carriage.earth_at_dps(acting.from_deg, acting.to_deg)
            force = self._force.mean(acting.from_deg, acting.to_deg)
        turning[np.abs(turning) < gyro.dead_zone_dps] = 0.0
        bias = self.turn_on_bias_dps(power_on) + drifts_dps(
            gyro, starts_s - power_on.on_s, acting.aperture_s
        )
        warmth = acting.temperature_degc - REFERENCE_DEGC
        bias += self.axis.temperature_sensitivity_dps_per_c * warmth + force
        return self.axis.response.felt_dps(turning + earth) + bias

    def scale_factors(self, acting: Acting) -> NDArray[np.float64]:
        """The scale factors at the temperatures, (n,)."""
        warmth = acting.temperature_degc - REFERENCE_DEGC
        return self.scale_factor * (1.0 + self.axis.scale_factor_sensitivity_per_c * warmth)

    def clipped(self, rates_dps: NDArray[np.float64]) -> NDArray[np.float64]:
        """Rates with their noise, held where the output saturates, (n,)."""
        return np.clip(rates_dps, -self.saturation_dps, self.saturation_dps)

    def truth(self, power_on: PowerOn, start_s: float, duration_s: float) -> dict[str, float]:
        """The true figures for a record that begins then."""
        gyro, response = self._gyro, self.axis.response
        bias = self.turn_on_bias_dps(power_on)
        drift = drift_dps(gyro, start_s - power_on.on_s, duration_s)
        found = {
            "turn_on_bias_dps": bias,
            "mean_drift_dps": drift,
            "bias_dps": bias + drift + (0.0 if self.carriage.staged else self._force.at_rest),
            "input_rate_dps": gyro.input_rate_dps,
            "earth_dps": self.carriage.at_rest_dps,
            "table_share": self.carriage.table_share,
            "angle_random_walk_dps_sqrt_s": gyro.noise.angle_random_walk_dps_sqrt_s,
            "bias_instability_coefficient_dps": gyro.noise.bias_instability_dps,
            "rate_random_walk_dps_per_sqrt_s": gyro.noise.rate_random_walk_dps_per_sqrt_s,
            "bandwidth_hz": self.axis.dynamics.bandwidth_hz,
            "damping": self.axis.dynamics.damping,
            "delay_s": self.axis.dynamics.delay_s,
            "scale_factor": response.scale_factor,
            "zero_rate": response.zero_rate,
            "full_scale_dps": response.full_scale_dps,
            "nonlinearity": response.nonlinearity,
            "asymmetry": response.asymmetry,
            "saturation_dps": response.saturation_dps,
            "dead_zone_dps": gyro.dead_zone_dps,
            "temperature_sensitivity_dps_per_c": self.axis.temperature_sensitivity_dps_per_c,
            "scale_factor_sensitivity_per_c": self.axis.scale_factor_sensitivity_per_c,
            "misalignment_deg": self.axis.misalignment_deg,
        }
        found |= {
            f"g_sensitivity_{own}_dps_per_g": value
            for own, value in self.axis.g_sensitivity_dps_per_g.items()
        }
        if gyro.voltage:
            found |= {
                "scale_factor_v_per_dps": response.scale_factor,
                "zero_rate_v": response.zero_rate,
            }
        return found
