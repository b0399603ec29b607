"""The frames of STIM210 and STIM300 gyros: identifiers, layouts, checksums, scales.

Sources. STIM300: its datasheet TS1524 revision 31, tables 5-11 … 5-23 and section 7.5.2, and drivers
made for earlier revisions, which had an auxiliary input where the PPS is now. STIM210: a driver that
flies. Both send most significant bytes first; an identifier may be shared by both models with another
length and checksum behind it, so that the model cannot be told from a frame.
"""

from dataclasses import dataclass

from gyrotest.instruments.stim.crc import CRC_8, CRC_32_MPEG_2, Crc
from gyrotest.records.spec import OutputMode

# Counts of the internal clock, which the frame counter counts.
TICKS_PER_SECOND = 2000
COUNTER_MODULUS = 256

# One count of the output: deg/s, or the angle of one sample in degrees.
RATE_PER_COUNT_DPS = 2.0**-14
ANGLE_PER_COUNT_DEG = 2.0**-21
TEMPERATURE_PER_COUNT_K = 2.0**-8

LINE_END = b"\r\n"


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """A kind of frame: where in it things begin, in bytes from the identifier; None where it has none.

    `size` is without the checksum. `statuses` are the status bytes that concern the gyro.
    """

    name: str
    identifier: int
    size: int
    statuses: tuple[int, ...]
    rates: int = 1
    temperatures: int | None = None
    counter: int | None = None
    latency: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """A model of gyro: its frames and what it can be set to."""

    name: str
    frames: tuple[Frame, ...]
    crc: Crc
    range_dps: float = 400.0
    sample_rates_hz: tuple[int, ...] = (125, 250, 500, 1000, 2000)

    def frame(self, asked: str | int) -> Frame:
        """The kind by its name or identifier (a number, or `0x99`); raises `ValueError`."""
        text = str(asked).strip().lower()
        for one in self.frames:
            if asked == one.identifier or text in (one.name, f"0x{one.identifier:02x}"):
                return one
        known = ", ".join(f"{one.name} (0x{one.identifier:02X})" for one in self.frames)
        raise ValueError(f"frame {asked!r} is no kind of frame of the {self.name}: write one of {known}")

    def wire_size(self, frame: Frame, *, crlf: bool) -> int:
        """The bytes of a frame on the wire."""
        return frame.size + self.crc.size + (len(LINE_END) if crlf else 0)


def rate_per_count_dps(mode: OutputMode, period_s: float) -> float:
    """The rate, deg/s, that one count stands for: an increment is the angle turned in one sample."""
    if mode is OutputMode.INCREMENTAL_ANGLE:
        return ANGLE_PER_COUNT_DEG / period_s
    return RATE_PER_COUNT_DPS


_CLUSTER = 10  # three values of three bytes, and their status
_TEMPERATURES = 7  # three values of two bytes, and their status
_AUXILIARY = 4  # one value of three bytes, and its status
_TRAILER = 3  # the counter, and the latency of two bytes

_STIM300_IDENTIFIERS = {
    (): 0x90,
    ("acceleration",): 0x91,
    ("inclination",): 0x92,
    ("acceleration", "inclination"): 0x93,
    ("temperature",): 0x94,
    ("acceleration", "temperature"): 0xA5,
    ("inclination", "temperature"): 0xA6,
    ("acceleration", "inclination", "temperature"): 0xA7,
    ("auxiliary",): 0x98,
    ("acceleration", "auxiliary"): 0x99,
    ("inclination", "auxiliary"): 0x9A,
    ("acceleration", "inclination", "auxiliary"): 0x9B,
    ("temperature", "auxiliary"): 0x9C,
    ("acceleration", "temperature", "auxiliary"): 0xAD,
    ("inclination", "temperature", "auxiliary"): 0xAE,
    ("acceleration", "inclination", "temperature", "auxiliary"): 0xAF,
    ("pps",): 0xF0,
    ("acceleration", "pps"): 0xF1,
    ("inclination", "pps"): 0xF2,
    ("acceleration", "inclination", "pps"): 0xF3,
    ("temperature", "pps"): 0xF4,
    ("acceleration", "temperature", "pps"): 0xF5,
    ("inclination", "temperature", "pps"): 0xF6,
    ("acceleration", "inclination", "temperature", "pps"): 0xF7,
}


def _stim300_frame(parts: tuple[str, ...], identifier: int) -> Frame:
    """TS1524 table 5-20: clusters, then a temperature triple for each of them, PPS, counter, latency."""
    clusters = 1 + ("acceleration" in parts) + ("inclination" in parts)
    end = 1 + clusters * _CLUSTER
    temperatures = end if "temperature" in parts else None
    statuses = (_CLUSTER,) if temperatures is None else (_CLUSTER, end + _TEMPERATURES - 1)
    if temperatures is not None:
        end += clusters * _TEMPERATURES
    if "auxiliary" in parts or "pps" in parts:
        end += _AUXILIARY
    return Frame(
        name="_".join(("rate", *parts)),
        identifier=identifier,
        size=end + _TRAILER,
        statuses=statuses,
        temperatures=temperatures,
        counter=end,
        latency=end + 1,
    )


def _stim210_frame(name: str, identifier: int, *parts: str) -> Frame:
    """Rates, their status, and then what the kind adds, one after the other."""
    begins: dict[str, int] = {}
    end = 1 + _CLUSTER
    for part in parts:
        begins[part] = end
        end += {"reserve": 3, "temperature": 6, "counter": 1, "latency": 2}[part]
    return Frame(
        name=name,
        identifier=identifier,
        size=end,
        statuses=(_CLUSTER,),
        temperatures=begins.get("temperature"),
        counter=begins.get("counter"),
        latency=begins.get("latency"),
    )


STIM300 = Model(
    name="STIM300",
    crc=CRC_32_MPEG_2,
    frames=tuple(_stim300_frame(parts, number) for parts, number in _STIM300_IDENTIFIERS.items()),
)
STIM210 = Model(
    name="STIM210",
    crc=CRC_8,
    frames=(
        _stim210_frame("rate", 0x90),
        _stim210_frame("rate_extended", 0x92, "reserve"),
        _stim210_frame("rate_temperature", 0xA0, "temperature"),
        _stim210_frame("rate_counter", 0xA2, "counter"),
        _stim210_frame("rate_latency", 0xA4, "latency"),
        _stim210_frame("rate_counter_latency", 0xA5, "counter", "latency"),
        _stim210_frame("rate_temperature_counter", 0x99, "temperature", "counter"),
        _stim210_frame("rate_temperature_latency", 0xA6, "temperature", "latency"),
        _stim210_frame("rate_temperature_counter_latency", 0xA8, "temperature", "counter", "latency"),
    ),
)
MODELS = (STIM210, STIM300)
