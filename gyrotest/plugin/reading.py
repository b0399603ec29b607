"""An indication as the operator reads it, and how it becomes a rate."""

from gyrotest.errors import UnitError
from gyrotest.records.recording import Block, Sampling
from gyrotest.records.spec import Output, OutputKind
from gyrotest.units import conversion_factor


class Reading:
    """An indication as the operator reads it: in the source's unit and as a rate."""

    def __init__(self, output: Output) -> None:
        voltage = output.kind is OutputKind.VOLTAGE
        self._scale = output.scale_factor.to("V*s/deg") if voltage and output.scale_factor else None
        self._zero = output.zero_rate.to("V") if voltage and output.zero_rate else 0.0
        self._canonical = "V" if voltage else "deg/s"
        ratio = 1.0 if voltage or output.scale_factor is None else output.scale_factor.to("")
        self._scale_factor = self._scale if voltage else ratio

    def __call__(self, value: float, unit: str) -> str:
        """The text, `2.512345 V = +0.2469 °/s`."""
        if unit != "V" or self._scale is None:
            return f"{value:+.4f} {unit.replace('deg', '°')}"
        return f"{value:.6f} V = {(value - self._zero) / self._scale:+.4f} °/s"

    def all_of(self, block: Block, sampling: Sampling) -> str:
        """The last reading of every output of a block, by name where there are several."""
        last, names = block.values[-1], sampling.channels
        if len(names) == 1:
            return self(float(last[0]), sampling.unit)
        told = (f"{name} {self(float(last[place]), sampling.unit)}" for place, name in enumerate(names))
        return ", ".join(told)

    def dps_per(self, unit: str) -> float | None:
        """Return the difference in rate that one of a unit stands for; None where it is none."""
        if not self._scale_factor:
            return None
        try:
            return conversion_factor(unit, self._canonical) / self._scale_factor
        except UnitError:
            return None
