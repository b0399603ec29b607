"""Temperature sensitivity of the bias: records at rest at several temperatures of a chamber."""

from gyrotest.procedures.bias_temperature_sensitivity.parameters import TemperatureParameters
from gyrotest.procedures.bias_temperature_sensitivity.procedure import BiasTemperatureSensitivity

__all__ = ["BiasTemperatureSensitivity", "TemperatureParameters"]
