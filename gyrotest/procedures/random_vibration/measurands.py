"""What a random-vibration case measures."""

from gyrotest.procedures.random_vibration.parameters import RandomVibrationParameters
from gyrotest.procedures.vibration_names import response_measurands
from gyrotest.records.result import Measurand
from gyrotest.records.spec import Output
from gyrotest.units import Dimension

GROUP_DELAY = "group_delay"
AMPLITUDE_REPEATABILITY, PHASE_REPEATABILITY = "amplitude_repeatability", "phase_repeatability"
LEAST_COHERENCE = "coherence_minimum"
AMPLITUDE_AGREEMENT, PHASE_AGREEMENT = "amplitude_agreement", "phase_agreement"

LABELS = {
    GROUP_DELAY: "Group delay",
    AMPLITUDE_REPEATABILITY: "Repeatability of the sensitivity, 3σ",
    PHASE_REPEATABILITY: "Repeatability of the phase, 3σ",
    LEAST_COHERENCE: "Coherence, least",
    AMPLITUDE_AGREEMENT: "Agreement of the methods, sensitivity",
    PHASE_AGREEMENT: "Agreement of the methods, phase",
}

_KINDS = {
    GROUP_DELAY: (Dimension.TIME, "ms"),
    AMPLITUDE_REPEATABILITY: (Dimension.NUMBER, "%"),
    PHASE_REPEATABILITY: (Dimension.ANGLE, "deg"),
    LEAST_COHERENCE: (Dimension.NUMBER, "%"),
    AMPLITUDE_AGREEMENT: (Dimension.NUMBER, "%"),
    PHASE_AGREEMENT: (Dimension.ANGLE, "deg"),
}


def random_measurands(parameters: RandomVibrationParameters, output: Output) -> tuple[Measurand, ...]:
    """Return all that a random-vibration case may measure."""
    return (
        *response_measurands(parameters.reported_hz, output),
        *(
            Measurand(name=name, label=label, dimension=_KINDS[name][0], unit=_KINDS[name][1])
            for name, label in LABELS.items()
        ),
    )
