"""What turns, vibrates and heats the units of a bench: opened on first use, at rest when the bench is left."""

from typing import TYPE_CHECKING

from gyrotest.acquisition.stimulation import Rotates, Stimulation, Vibrates
from gyrotest.errors import RefusedError
from gyrotest.ports import Clock, Playback, Source
from gyrotest.records.plan import Plan, Turning
from gyrotest.records.station import Motion, Slot, Station
from gyrotest.runner.drivers import Drivers

if TYPE_CHECKING:
    from gyrotest.acquisition.rotating import StageDrive
    from gyrotest.acquisition.soaking import ChamberDrive
    from gyrotest.acquisition.turning import TableDrive
    from gyrotest.acquisition.vibrating import VibrationTable


class Stimuli:
    """The tables, stages, vibration tables and chambers that a run has used so far."""

    def __init__(self, station: Station, clock: Clock, drivers: Drivers) -> None:
        self._station, self._clock, self._drivers = station, clock, drivers
        self._tables: dict[str, TableDrive] = {}
        self._stages: dict[str, StageDrive] = {}
        self._vibrations: dict[str, VibrationTable] = {}
        self._chambers: dict[str, ChamberDrive] = {}

    def of(
        self, slot: str, plan: Plan, *, source: Source, by_hand: Vibrates | None = None
    ) -> Stimulation:
        """What a plan needs of a slot's tables and chamber, opened; raises `InstrumentError`.

        `by_hand` is the vibration where the slot has nothing that drives it.
        """
        place = self._station.slots[slot]
        turns_freely = any(isinstance(step.stimulus, Turning) for step in plan.steps)
        return Stimulation(
            table=self._table(place) if turns_freely else None,
            stage=self._stage(place, source) if plan.rotates else None,
            chamber=self._chamber(place) if plan.soaks else None,
            vibration=self._vibration(place, source, by_hand) if plan.vibrates else None,
            interval_s=plan.interval_s,
        )

    def put_down(self, slot: str) -> None:
        """After a fault: what moves a slot's unit at rest and disconnected; its next use opens it anew."""
        place = self._station.slots[slot]
        table = self._tables.get(place.table or "")
        if table is not None:
            table.put_down()
        vibration = self._vibrations.get(place.vibration or "")
        if vibration is not None:
            vibration.put_down()

    def make_safe(self, slot: str) -> str:
        """Have a slot's table at rest and switched off, so that somebody may touch it; what is so, in words.

        Raises `InstrumentError` where it does not rest.
        """
        name = self._station.slots[slot].table
        if name is None:
            return ""
        if name not in self._tables:
            return f"'{name}' has not been switched on; "
        self._tables[name].switch_off()
        return f"'{name}' is at rest and switched off; "

    def rest(self) -> None:
        """Have everything that moves at rest; never raises."""
        for table in self._tables.values():
            table.rest()
        for vibration in self._vibrations.values():
            vibration.rest()
        self._tables, self._stages, self._vibrations, self._chambers = {}, {}, {}, {}

    def _table(self, place: Slot) -> "TableDrive | None":
        name = place.table
        if name is None:
            return None
        if name not in self._tables:
            self._tables[name] = self._opened_table(name)
        self._tables[name].take_up()
        return self._tables[name]

    def _opened_table(self, name: str) -> "TableDrive":
        """A table, opened; one with a level shaft is a stage as well."""
        from gyrotest.acquisition.rotating import StageDrive
        from gyrotest.acquisition.turning import TableDrive

        motion = self._motion(name)
        table = self._drivers.table(name, motion)
        self._drivers.keep(name, table)
        who = self._drivers.address(name)
        if self._station.instruments[name].shaft is None:
            return TableDrive(table, clock=self._clock, motion=motion, name=who)
        self._stages[name] = StageDrive(table, clock=self._clock, motion=motion, name=who)
        return self._stages[name].turning

    def _motion(self, name: str) -> Motion:
        motion = self._station.instruments[name].motion
        if motion is None:
            raise RefusedError(f"instrument '{name}': no 'motion' says how fast and how far it may turn")
        return motion

    def _stage(self, place: Slot, source: Source) -> Rotates | None:
        from gyrotest.acquisition.rotating import RotationRecorded

        if isinstance(source, Playback):
            return RotationRecorded()
        self._table(place)
        return self._stages.get(place.table or "")

    def _vibration(self, place: Slot, source: Source, by_hand: Vibrates | None) -> Vibrates | None:
        from gyrotest.acquisition.vibrating import VibrationRecorded, VibrationTable

        name = place.vibration
        if isinstance(source, Playback):
            return VibrationRecorded()
        if name is None:
            return by_hand
        if name not in self._vibrations:
            drive = self._drivers.vibration(name)
            self._drivers.keep(name, drive)
            self._vibrations[name] = VibrationTable(drive, clock=self._clock)
        self._vibrations[name].take_up()
        return self._vibrations[name]

    def _chamber(self, place: Slot) -> "ChamberDrive | None":
        name = place.chamber
        if name is None:
            return None
        from gyrotest.acquisition.soaking import ChamberDrive

        if name not in self._chambers:
            chamber = self._drivers.chamber(name)
            self._drivers.keep(name, chamber)
            self._chambers[name] = ChamberDrive(
                chamber, clock=self._clock, name=self._drivers.address(name)
            )
        return self._chambers[name]
