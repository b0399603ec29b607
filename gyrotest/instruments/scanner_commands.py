"""The commands that set a scanner's channels up, in the words of each of its two generations."""

from collections.abc import Iterator
from dataclasses import dataclass

from gyrotest.instruments.scanner_settings import PROBES, BesideChannel, Keysight34970ASettings
from gyrotest.instruments.scpi import Setting
from gyrotest.instruments.voltage import on_off

SHORTEST_READING_S = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Scan:
    """The channels of a scan: gyro outputs, and what is recorded beside them."""

    settings: Keysight34970ASettings
    outputs: tuple[str, ...]
    auxiliary: tuple[str, ...]

    @property
    def columns(self) -> tuple[str, ...]:
        """All channels: outputs, then auxiliaries."""
        return (*self.outputs, *self.auxiliary)

    @property
    def scanned(self) -> tuple[int, ...]:
        """The scan list: the instrument scans in the order of the numbers, whatever it is told."""
        return tuple(sorted(int(one) for one in self.columns))

    @property
    def places(self) -> list[int]:
        """Where each column stands in a sweep."""
        return [self.scanned.index(int(one)) for one in self.columns]

    @property
    def written(self) -> str:
        """The scan list as it is sent and read back."""
        return f"(@{','.join(map(str, self.scanned))})"

    def nplc(self, channel: str) -> float:
        """A channel's integration time in power-line cycles."""
        own = self.settings.at(channel).nplc if channel in self.auxiliary else None
        return self.settings.nplc if own is None else own

    def least_sweep_s(self, cycle_s: float) -> float:
        """What a sweep takes at least: the readings, without relays and settling."""
        readings = 2 if self.settings.autozero else 1
        return sum(readings * max(self.nplc(one) * cycle_s, SHORTEST_READING_S) for one in self.columns)

    def channel_settings(self, *, newer: bool) -> Iterator[Setting]:
        """Each channel's function, range and integration time; `newer`: a DAQ970A or DAQ973A."""
        for channel in self.outputs:
            yield from self._voltage(channel, self.settings.range.to("V"), newer=newer)
        for channel in self.auxiliary:
            beside = self.settings.at(channel)
            if beside.is_temperature:
                yield from self._temperature(channel, beside)
            else:
                volts = (beside.range or self.settings.range).to("V")
                yield from self._voltage(channel, volts, newer=newer)

    def _voltage(self, channel: str, volts: float, *, newer: bool) -> Iterator[Setting]:
        where, settings, nplc = f"(@{channel})", self.settings, self.nplc(channel)
        zeroed, impedance = (
            ("VOLT:DC:ZERO:AUTO", "VOLT:DC:IMP:AUTO") if newer else ("ZERO:AUTO", "INP:IMP:AUTO")
        )
        # CONF first: it resets the channel.
        yield Setting(f"CONF:VOLT:DC {volts:g},{where}", f"VOLT:DC:RANG? {where}", volts)
        yield Setting(f"VOLT:DC:NPLC {nplc:g},{where}", f"VOLT:DC:NPLC? {where}", nplc)
        for header, on in ((zeroed, settings.autozero), (impedance, settings.high_impedance)):
            yield Setting(f"{header} {on_off(on=on)},{where}", f"{header}? {where}", float(on))

    def _temperature(self, channel: str, beside: BesideChannel) -> Iterator[Setting]:
        where, probe, nplc = f"(@{channel})", PROBES[beside.function], self.nplc(channel)
        yield Setting(
            f"CONF:TEMP {probe},{beside.probe_type},{where}", f"TEMP:TRAN:TYPE? {where}", probe
        )
        yield Setting(f"UNIT:TEMP C,{where}", f"UNIT:TEMP? {where}", "C")
        yield Setting(f"TEMP:NPLC {nplc:g},{where}", f"TEMP:NPLC? {where}", nplc)

    def list_settings(self) -> tuple[Setting, ...]:
        """The scan list and the form of the readings, after the channels: each CONF has undone them."""
        return (
            Setting(f"ROUT:SCAN {self.written}"),
            Setting("FORM:READ:TIME ON", "FORM:READ:TIME?", 1.0),
            Setting("FORM:READ:TIME:TYPE REL", "FORM:READ:TIME:TYPE?", "REL"),
            Setting("FORM:READ:CHAN ON", "FORM:READ:CHAN?", 1.0),
            Setting("FORM:READ:UNIT OFF", "FORM:READ:UNIT?", 0.0),
            Setting("FORM:READ:ALAR OFF", "FORM:READ:ALAR?", 0.0),
        )
