"""Replay: a recorded file stands in for an instrument."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np

from gyrotest.errors import InstrumentError, InstrumentIdentityError, RecordingError, UnitError
from gyrotest.instruments.replay_columns import PlayedColumns, played_columns, uniform
from gyrotest.instruments.replay_settings import ReplaySettings
from gyrotest.ports import Clock
from gyrotest.recordings.digest import sha256_of
from gyrotest.recordings.foreign import ForeignFile
from gyrotest.recordings.formats.detect import Format, detect
from gyrotest.recordings.reader import read_header
from gyrotest.recordings.regroup import Averages, Placed, consecutive
from gyrotest.recordings.stamps import described
from gyrotest.records.bench import DaqChannel
from gyrotest.records.recording import Block, Identity, Sampling
from gyrotest.records.station import Accuracy
from gyrotest.units import Quantity, same_dimension

# How far the case's interval may be from a whole number of the file's.
_INTERVALS_AGREE = 1e-3


class Replay:
    """Plays a file as fast as it is read, like a tape: an acquisition goes on where the last ended.

    What is wrong with the file's contents is a `RecordingError` out of `fetch`: no waiting and no
    second try will mend it.
    """

    settings: ClassVar[type] = ReplaySettings
    resource_is_path: ClassVar[bool] = True

    def __init__(
        self,
        resource: str,
        settings: ReplaySettings,
        *,
        clock: Clock,  # noqa: ARG002 - the constructor is the same for all instruments
        line_frequency_hz: float | None = None,  # noqa: ARG002 - as above
        accuracy: Accuracy | None = None,
        io_timeout_s: float | None = None,  # noqa: ARG002 - as above
        serial_number: str | None = None,
    ) -> None:
        self._path = Path(resource)
        self._settings = settings
        self._accuracy = accuracy
        self._serial_number = serial_number
        self._file: ForeignFile | None = None
        self._source_sampling: Sampling | None = None
        self._columns: PlayedColumns | None = None
        self._wanted: tuple[str, ...] = ()
        self._averages = Averages(1)
        self._size = 1
        self._runs: Iterator[Placed] = iter(())
        self._first = self._count = 0
        self._origin: tuple[int, float] | None = None
        self._played = self._given = self._flagged = 0
        self._absent: dict[str, int] = {}
        self._again = False

    def open(self) -> Identity:
        """Look at the file; its SHA-256 stands for the serial number."""
        try:
            self._load()
            digest = sha256_of(self._path)
        except (RecordingError, OSError) as error:
            raise InstrumentError(str(error)) from error
        identity = Identity(
            manufacturer="replay", model=self._path.name, serial_number=f"REPLAY-{digest[:8]}"
        )
        if self._serial_number not in (None, identity.serial_number):
            raise InstrumentIdentityError(
                f"{self._path}: is {identity.serial_number}, the station names {self._serial_number}"
            )
        return identity

    def channels(self) -> tuple[DaqChannel, ...]:
        """The columns that are played."""
        return self._opened_columns().as_channels()

    def select(self, outputs: tuple[str, ...], auxiliary: tuple[str, ...]) -> None:
        """Say which columns are wanted; all that the settings choose are played, in any case."""
        self._wanted = (*outputs, *auxiliary)

    def configure(self, interval_s: float) -> Sampling:
        """Take the file's own interval, or average a whole number of its samples."""
        sampling = self._sampling()
        size = round(interval_s / sampling.interval_s)
        if size < 1 or abs(interval_s / (size * sampling.interval_s) - 1.0) > _INTERVALS_AGREE:
            raise InstrumentError(
                f"{self._path}: has a sample every {sampling.interval_s:.9g} s, which the case's interval of "
                f"{interval_s:.9g} s is no whole multiple of; the shortest is {sampling.interval_s:.6g} s"
            )
        self._refuse_names()
        angles = self._opened_columns().angles
        if size > 1 and angles:
            raise InstrumentError(
                f"{self._path}: '{angles[0]}' is an angle, and the mean of {size} rows of it means nothing where"
                f" it passes 360°; set the case's interval to {sampling.interval_s:.9g} s"
            )
        self._size = size
        return replace(
            sampling,
            interval_s=size * sampling.interval_s,
            readings=size * sampling.readings,
            noise=None if sampling.noise is None else sampling.noise / math.sqrt(size),
        )

    def cue(self, position_s: float) -> None:
        """Wind to a position of the window; with `rewind` every acquisition begins at its start."""
        if not self._settings.rewind:
            self._played = round(position_s / self._sampling().interval_s)

    def start(self, first: int, count: int) -> None:
        """Begin at a sample; a first one of 0 is a new acquisition."""
        if first == 0:
            self._again = self._settings.rewind and self._played > 0
            self._played = 0 if self._settings.rewind else self._played
            self._origin = None
            self._given = self._flagged = 0
            self._absent = {one.name: 0 for one in self._sampling().auxiliary}
        self._first, self._count = first, count
        self._averages = Averages(self._size)
        self._runs = (
            run for part in self._averages.of(self._opened_file().samples()) for run in consecutive(part)
        )

    def fetch(self) -> Block | None:
        """Give the next consecutive samples; None at the end of the file or of what was asked for."""
        for run in self._runs:
            ahead = run.part(run.place * self._size >= self._played)
            if not len(ahead):
                continue
            if self._origin is None:
                self._origin = int(ahead.place[0]), float(ahead.time_s[0])
            position = ahead.place - self._origin[0]
            asked = ahead.part((position >= self._first) & (position < self._count))
            if len(asked):
                return self._block(asked, self._origin)
            if position[0] >= self._count:
                return None
        return None

    def recover(self) -> int:
        """Go on after the last sample that was given."""
        return self._first

    def remarks(self) -> tuple[str, ...]:
        """Tell which stretch of the file the acquisition got, and what is to be known of the file."""
        file = self._opened_file()
        begin = 0 if self._origin is None else self._origin[0] * self._size
        found = [f"{self._given} samples from positions {begin + 1} to {self._played} of the window"]
        if self._flagged:
            found.append(f"{self._flagged} samples are missing, infinite or not a number")
        found += [
            f"'{name}' is missing in {count} of them" for name, count in self._absent.items() if count
        ]
        if file.stamps is not None:
            found += described(file.stamps)
        if self._size > 1:
            found.append(f"each sample is the mean of {self._size} rows")
        if self._averages.incomplete:
            found.append(f"{self._averages.incomplete} means left out, for rows were missing in them")
        if self._again:
            found.append("played again from the start: the same samples as before")
        return tuple(f"{self._path.name}: {text}" for text in found)

    def close(self) -> None:
        """Let go of the file."""
        self._runs = iter(())

    def _block(self, samples: Placed, origin: tuple[int, float]) -> Block:
        self._played = (int(samples.place[-1]) + 1) * self._size
        first = int(samples.place[0]) - origin[0]
        self._first = first + len(samples)
        self._given += len(samples)
        outputs = len(self._sampling().channels)
        for at, name in enumerate(self._absent, start=outputs):
            self._absent[name] += int(np.count_nonzero(~np.isfinite(samples.values[:, at])))
        self._flagged += int(np.count_nonzero(samples.flags))
        return Block(
            first=first,
            time_s=samples.time_s - origin[1],
            values=samples.values,
            flags=samples.flags,
        )

    def _load(self) -> None:
        own = read_header(self._path).sampling if detect(self._path) is Format.OWN else None
        rate = self._settings.sample_rate
        interval_s = None if rate is None else 1.0 / rate.to("Hz")
        if own and interval_s is not None and abs(interval_s / own.interval_s - 1.0) > _INTERVALS_AGREE:
            raise RecordingError(
                f"{self._path}: is a recording with a sample every {own.interval_s:g} s; leave 'sample_rate' out"
            )
        try:
            columns = played_columns(self._settings, own)
        except UnitError as error:
            raise RecordingError(f"{self._path}: {error}") from error
        self._source_sampling, self._columns = own, columns
        self._file = ForeignFile(
            self._path,
            columns.selection,
            self._settings.window(),
            interval_s=own.interval_s if own else interval_s,
            factors=columns.factors,
            outputs=len(columns.channels),
            time_factor_s=self._settings.time_factor_s(),
        )

    def _sampling(self) -> Sampling:
        """How the file itself was sampled, in the unit that is given out."""
        file, own, columns = self._opened_file(), self._source_sampling, self._opened_columns()
        interval_s, settings = file.interval_s, self._settings
        factor = abs(columns.factors[0])
        noise = self._noise(columns.unit)
        if own is not None:
            noise = None if own.noise is None else own.noise * factor
        return Sampling(
            interval_s=own.interval_s if own else interval_s,
            aperture_s=own.aperture_s if own else interval_s,
            readings=own.readings if own else 1,
            unit=columns.unit,
            channels=columns.channels,
            auxiliary=columns.auxiliary,
            offsets_s=columns.offsets_s,
            noise=noise,
            range=None if own is None or own.range is None else own.range * factor,
            synchronous=columns.one_instant and uniform(file.stamps),
            skew_uncertainty_s=_stated(
                settings.skew_uncertainty, "s", own.skew_uncertainty_s if own else None
            ),
            filter_hz=_stated(settings.filter, "Hz", own.filter_hz if own else None),
        )

    def _refuse_names(self) -> None:
        """Refuse names that no column plays under, of the slot and of the settings."""
        complaint = self._opened_columns().complaint((*self._wanted, *self._settings.skew))
        if complaint is not None:
            raise InstrumentError(
                f"{self._path}: {complaint}; correct the slot or 'columns' and 'auxiliary'"
            )

    def _opened_columns(self) -> PlayedColumns:
        if self._columns is None:
            raise InstrumentError(f"{self._path}: the file is not opened yet")
        return self._columns

    def _noise(self, unit: str) -> float | None:
        noise = self._accuracy.noise if self._accuracy else None
        return noise.to(unit) if noise is not None and same_dimension(noise.unit, unit) else None

    def _opened_file(self) -> ForeignFile:
        if self._file is None:
            raise InstrumentError(f"{self._path}: the file is not opened yet")
        return self._file


def _stated(stated: Quantity | None, unit: str, recorded: float | None) -> float | None:
    """What the station states, or else what the recording says of itself."""
    return recorded if stated is None else stated.to(unit)
