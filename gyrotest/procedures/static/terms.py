"""The five noise terms of the fitted model: their names, units and slopes, and how they are had as spreads."""

import math
from dataclasses import dataclass

from gyrotest.analysis.allan import FLAT
from gyrotest.analysis.noise_model import NoiseModel, NoiseTerm
from gyrotest.procedures.rest.spread import Spread
from gyrotest.units import Dimension, conversion_factor


@dataclass(frozen=True, slots=True, kw_only=True)
class Term:
    """A term of the noise model, reported in `unit`.

    A coefficient c, in the model's unit, gives the Allan deviation `at_1_s`·c·τ^`slope` (IEEE 952).
    """

    letter: str
    name: str
    label: str
    dimension: Dimension
    unit: str
    at_1_s: float
    slope: float

    @property
    def per_core(self) -> float:
        """Units of report in one of the model's (°, °/√s, °/s, °/s/√s, °/s²)."""
        return conversion_factor(self.dimension.value, self.unit)

    def of(self, model: NoiseModel) -> NoiseTerm:
        """Return the term of a model."""
        found: NoiseTerm = getattr(model, self.name)
        return found

    def spread(self, model: NoiseModel) -> Spread:
        """Return the fitted coefficient in the unit of report, or its upper limit where it is not resolved."""
        term = self.of(model)
        if not term.resolved:
            return Spread.bound(term.upper_95 * self.per_core)
        spread = Spread(value=term.value, lower=term.lower_95, upper=term.upper_95)
        return spread.times(self.per_core)


QUANTIZATION = Term(
    letter="Q",
    name="quantization_noise",
    label="Quantization noise",
    dimension=Dimension.ANGLE,
    unit="arcsec",
    at_1_s=math.sqrt(3.0),
    slope=-1.0,
)
ANGLE_WALK = Term(
    letter="N",
    name="angle_random_walk",
    label="Angle random walk",
    dimension=Dimension.ANGLE_RANDOM_WALK,
    unit="deg/sqrt(h)",
    at_1_s=1.0,
    slope=-0.5,
)
BIAS_INSTABILITY = Term(
    letter="B",
    name="bias_instability_coefficient",
    label="Bias instability coefficient",
    dimension=Dimension.RATE,
    unit="deg/h",
    at_1_s=FLAT,
    slope=0.0,
)
RATE_WALK = Term(
    letter="K",
    name="rate_random_walk",
    label="Rate random walk",
    dimension=Dimension.RATE_RANDOM_WALK,
    unit="deg/h/sqrt(h)",
    at_1_s=1.0 / math.sqrt(3.0),
    slope=0.5,
)
RAMP = Term(
    letter="R",
    name="rate_ramp",
    label="Rate ramp",
    dimension=Dimension.RATE_RAMP,
    unit="deg/h/h",
    at_1_s=1.0 / math.sqrt(2.0),
    slope=1.0,
)
TERMS = (QUANTIZATION, ANGLE_WALK, BIAS_INSTABILITY, RATE_WALK, RAMP)
