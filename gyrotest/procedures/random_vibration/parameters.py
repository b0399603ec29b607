"""What a random-vibration case may be told."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, ClassVar

from gyrotest.analysis.cross_spectra import PERIODS
from gyrotest.procedures.vibration_channels import CUT_OFF
from gyrotest.records.described import Described, EarlierCase
from gyrotest.records.plan import Excitation, Vibrating
from gyrotest.units import Dimension, OfDimension, Quantity

_LOW, _HIGH = Quantity(5.0, "Hz"), Quantity(100.0, "Hz")
_REST, _SETTLE = Quantity(60.0, "s"), Quantity(5.0, "s")
_AMPLITUDE_GOAL, _PHASE_GOAL = Quantity(1.0, "%"), Quantity(1.0, "deg")


class Window(StrEnum):
    """Tapers of segments; the later ones leak less, and tell lines apart less well."""

    HANN = "hann"
    BLACKMAN = "blackman"
    NUTTALL = "nuttall"


@dataclass(frozen=True, slots=True, kw_only=True)
class RandomVibrationParameters:
    """Parameters of a random-vibration case; its `duration` is that of each run."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    level: Annotated[
        Quantity,
        OfDimension(Dimension.RATE),
        Described("root mean square of the table's rate while it vibrates", "8 deg/s"),
    ]
    low: Annotated[
        Quantity,
        OfDimension(Dimension.FREQUENCY),
        Described("lowest frequency of the band", "5 Hz"),
    ] = _LOW
    high: Annotated[
        Quantity,
        OfDimension(Dimension.FREQUENCY),
        Described("highest frequency of the band", "100 Hz"),
    ] = _HIGH
    runs: Annotated[
        int,
        Described("how many runs, each as long as the case's `duration`; their spread is reported", "3"),
    ] = 3
    rest: Annotated[
        Quantity,
        OfDimension(Dimension.TIME),
        Described("length of the record at rest before, which tells the noise of both channels", "60 s"),
    ] = _REST
    settle: Annotated[
        Quantity,
        OfDimension(Dimension.TIME),
        Described("time for which the table has vibrated before the first sample of a run", "5 s"),
    ] = _SETTLE
    cutoff: Annotated[
        Quantity | None,
        OfDimension(Dimension.FREQUENCY),
        Described(
            "cut-off of the low-pass that both channels pass; 2.5 times `high` by default", "250 Hz"
        ),
    ] = None
    segment: Annotated[
        Quantity | None,
        OfDimension(Dimension.TIME),
        Described("length of a segment of the spectra; 20 periods of `low` by default", "4 s"),
    ] = None
    window: Annotated[
        Window,
        Described("how the segments are tapered", "hann"),
    ] = Window.HANN
    degree: Annotated[
        int,
        Described("degree of the polynomials through gain and phase over the band", "7"),
    ] = 7
    coherence_floor: Annotated[
        float,
        Described("frequencies of a lesser coherence are left out, and named", "0.8"),
    ] = 0.8
    frequencies: Annotated[
        tuple[Annotated[Quantity, OfDimension(Dimension.FREQUENCY)], ...],
        Described(
            "frequencies whose sensitivity and phase are reported one by one", "[5 Hz, 20 Hz, 100 Hz]"
        ),
    ] = ()
    reference_frequency: Annotated[
        Quantity | None,
        OfDimension(Dimension.FREQUENCY),
        Described(
            "frequency to whose sensitivity flatness and bandwidth refer; the lowest of the band by default",
            "10 Hz",
        ),
    ] = None
    flat_to: Annotated[
        Quantity | None,
        OfDimension(Dimension.FREQUENCY),
        Described("frequency up to which the flatness is reported; `high` by default", "20 Hz"),
    ] = None
    compare_with: Annotated[
        str | None,
        EarlierCase("sine_vibration"),
        Described(
            "an earlier case of procedure `sine_vibration`, with whose results those here are compared",
            "sine",
        ),
    ] = None
    amplitude_goal: Annotated[
        Quantity,
        OfDimension(Dimension.NUMBER),
        Described("how far the methods' sensitivities should agree; drawn where no limit is", "1 %"),
    ] = _AMPLITUDE_GOAL
    phase_goal: Annotated[
        Quantity,
        OfDimension(Dimension.ANGLE),
        Described("how far the methods' phases should agree; drawn where no limit is", "1 deg"),
    ] = _PHASE_GOAL

    @property
    def low_hz(self) -> float:
        """The lowest frequency of the band, Hz."""
        return self.low.to("Hz")

    @property
    def high_hz(self) -> float:
        """The highest frequency of the band, Hz."""
        return self.high.to("Hz")

    @property
    def cutoff_hz(self) -> float:
        """The cut-off of the low-pass, Hz (S4.2)."""
        return CUT_OFF * self.high_hz if self.cutoff is None else self.cutoff.to("Hz")

    @property
    def shortest_segment_s(self) -> float:
        """The length of 20 periods of the lowest frequency, s (S4.3)."""
        return PERIODS / self.low_hz

    @property
    def segment_s(self) -> float:
        """The length of a segment, s."""
        return self.shortest_segment_s if self.segment is None else self.segment.to("s")

    @property
    def reference_hz(self) -> float:
        """The frequency to which flatness and bandwidth refer, Hz."""
        return self.low_hz if self.reference_frequency is None else self.reference_frequency.to("Hz")

    @property
    def flat_to_hz(self) -> float:
        """The frequency up to which the flatness is reported, Hz."""
        return self.high_hz if self.flat_to is None else self.flat_to.to("Hz")

    @property
    def reported_hz(self) -> tuple[float, ...]:
        """The frequencies that are reported one by one, Hz."""
        return tuple(one.to("Hz") for one in self.frequencies)

    def vibrating(self, excitation: Excitation) -> Vibrating:
        """Return the table at rest, or in random motion."""
        if excitation is Excitation.NONE:
            return Vibrating(excitation=excitation, settle_s=self.settle.to("s"))
        return Vibrating(
            excitation=excitation,
            rms_dps=self.level.to("deg/s"),
            low_hz=self.low_hz,
            high_hz=self.high_hz,
            settle_s=self.settle.to("s"),
        )
