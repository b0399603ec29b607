"""What frequency responses are called, by whichever method they were measured."""

from collections.abc import Iterable, Iterator

from gyrotest.procedures.scaling import SCALE_FACTORS
from gyrotest.procedures.wording import plain
from gyrotest.records.result import Measurand
from gyrotest.records.spec import Output, OutputKind
from gyrotest.units import Dimension

SENSITIVITY_UNITS = {
    OutputKind.VOLTAGE: "mV/(deg/s)",
    OutputKind.RATE: "",
    OutputKind.COUNT: "count/(deg/s)",
}
"""The unit in which the sensitivity of an output is reported."""

FLATNESS = "flatness"
BANDWIDTH = "bandwidth_3db"
PHASE_90 = "phase_90_frequency"

BAND_LABELS = {
    FLATNESS: "Flatness of the sensitivity",
    BANDWIDTH: "Bandwidth, \N{MINUS SIGN}3 dB",
    PHASE_90: "Frequency of \N{MINUS SIGN}90° phase",
}
"""The labels of what the whole band gives."""

AGAINST_THE_SIGN = (
    "The output moves against the sign of the nominal scale factor; phases are less half a turn. Either the unit"
    " is inverted, or the encoder counts the other way: see 'encoder.reversed', and which signal is 'sine'."
)
"""What is to be said of a response that is the other way round."""

_OFF_LEVEL = 0.3
_DIGITS = 9


def level_remarks(moved_dps: float, asked_dps: float) -> Iterator[str]:
    """Tell of a table that moved far from the level asked for, both rms, °/s.

    A table's own response makes a part of the band larger or smaller; lines that are stated wrongly, all of it.
    """
    if abs(moved_dps / asked_dps - 1.0) > _OFF_LEVEL:
        yield (
            f"In the band the table moved with {plain(moved_dps, 3)} °/s rms, and was asked for"
            f" {plain(asked_dps, 4)} °/s; the encoder's rate is used. Are the lines of its grating stated rightly?"
        )


def frequency_key(frequency_hz: float) -> str:
    """Return a frequency as it stands in names: `20Hz`, `12.5Hz`."""
    return f"{plain(frequency_hz, _DIGITS)}Hz"


def sensitivity_name(frequency_hz: float) -> str:
    """Return the name of the sensitivity at a frequency: `sensitivity_20Hz`."""
    return f"sensitivity_{frequency_key(frequency_hz)}"


def phase_name(frequency_hz: float) -> str:
    """Return the name of the phase at a frequency: `phase_20Hz`."""
    return f"phase_{frequency_key(frequency_hz)}"


def sensitivity_label(frequency_hz: float) -> str:
    """Return the label of the sensitivity at a frequency."""
    return f"Sensitivity, {plain(frequency_hz, _DIGITS)} Hz"


def phase_label(frequency_hz: float) -> str:
    """Return the label of the phase at a frequency."""
    return f"Phase, {plain(frequency_hz, _DIGITS)} Hz"


def response_measurands(frequencies_hz: Iterable[float], output: Output) -> Iterator[Measurand]:
    """Give sensitivity and phase at each frequency, and what the whole band gives."""
    slope, unit = SCALE_FACTORS[output.kind], SENSITIVITY_UNITS[output.kind]
    asked = tuple(frequencies_hz)
    for one in asked:
        yield _measurand(sensitivity_name(one), sensitivity_label(one), slope, unit)
    for one in asked:
        yield _measurand(phase_name(one), phase_label(one), Dimension.ANGLE, "deg")
    yield _measurand(FLATNESS, BAND_LABELS[FLATNESS], Dimension.NUMBER, "%")
    yield _measurand(BANDWIDTH, BAND_LABELS[BANDWIDTH], Dimension.FREQUENCY, "Hz")
    yield _measurand(PHASE_90, BAND_LABELS[PHASE_90], Dimension.FREQUENCY, "Hz")


def _measurand(name: str, label: str, dimension: Dimension, unit: str) -> Measurand:
    return Measurand(name=name, label=label, dimension=dimension, unit=unit)
