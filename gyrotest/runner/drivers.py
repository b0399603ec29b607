"""Drivers made and opened: each port's constructor, from a station's entry of an instrument."""

from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, Protocol

from gyrotest.ports import Chamber, Clock, PowerSupply, RateTable, Source, VibrationDrive
from gyrotest.records.recording import Identity
from gyrotest.records.run import InstrumentUse
from gyrotest.records.station import Motion, Station
from gyrotest.registry import INSTRUMENTS, load


class Openable(Protocol):
    """What all ports have in common."""

    def open(self) -> Identity:
        """Connect and ask who is there."""

    def close(self) -> None:
        """Leave it safe and disconnect."""


class Drivers:
    """Makes a station's drivers; `address` tells where an instrument is reached.

    `kept` are the instruments that stay open until `close`.
    """

    def __init__(self, station: Station, clock: Clock, address: Callable[[str], str]) -> None:
        self._station = station
        self._clock = clock
        self.address = address
        self.kept: dict[str, InstrumentUse] = {}
        self._safe = ExitStack()

    def source(self, name: str, resource: str) -> Source:
        """The driver of a source, not opened yet."""
        instrument = self._station.instruments[name]
        frequency = self._station.line_frequency
        made: Source = self._made(
            name,
            resource,
            line_frequency_hz=frequency.to("Hz") if frequency else None,
            accuracy=instrument.accuracy,
        )
        return made

    def table(self, name: str, motion: Motion) -> RateTable:
        """The driver of a rate table, not opened yet."""
        made: RateTable = self._made(name, self.address(name), motion=motion)
        return made

    def supply(self, name: str, output: int) -> PowerSupply:
        """The driver of a power supply's output, not opened yet."""
        made: PowerSupply = self._made(name, self.address(name), output=output)
        return made

    def chamber(self, name: str) -> Chamber:
        """The driver of a temperature chamber, not opened yet."""
        made: Chamber = self._made(name, self.address(name))
        return made

    def vibration(self, name: str) -> VibrationDrive:
        """The driver of what drives a vibration table, not opened yet."""
        made: VibrationDrive = self._made(name, self.address(name))
        return made

    def opened(self, name: str, resource: str, driver: Openable) -> InstrumentUse:
        """Open a driver; what then went wrong leaves nothing open. Raises `InstrumentError`."""
        try:
            identity = driver.open()
        except BaseException:
            driver.close()
            raise
        return InstrumentUse(
            name=name,
            driver=self._station.instruments[name].driver,
            resource=resource,
            identity=identity,
        )

    def keep(self, name: str, driver: Openable) -> None:
        """Open what is left safe by `close`; raises `InstrumentError`."""
        self.kept[name] = self.opened(name, self.address(name), driver)
        self._safe.callback(driver.close)

    def close(self) -> None:
        """Leave what was kept safe, the last one first; idempotent."""
        self._safe.close()

    def _made(self, name: str, resource: str, **beside: Any) -> Any:
        from gyrotest.specification.station import instrument_settings

        instrument = self._station.instruments[name]
        driver = load(INSTRUMENTS, instrument.driver)
        return driver(
            resource,
            instrument_settings(instrument, driver),
            clock=self._clock,
            io_timeout_s=instrument.io_timeout.to("s") if instrument.io_timeout else None,
            serial_number=instrument.serial_number,
            **beside,
        )
