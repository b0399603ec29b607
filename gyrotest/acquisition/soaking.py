"""The temperature of a unit under test: a chamber brought to temperatures, soaked and watched."""

import math
from statistics import fmean

from gyrotest.errors import InstrumentError
from gyrotest.ports import Chamber, Clock
from gyrotest.records.plan import Soaking

# The slowest chamber that is waited for, and what the last degree may take beyond.
_SLOWEST_C_PER_S = 0.5 / 60.0
_MARGIN_S = 1800.0
_POLL_S = 10.0
# A chamber that stands still is not waited for to the end: so long, and a tenth of the slowest way.
_STARTS_WITHIN_S = 1200.0
_STARTS_C = 0.1 * _SLOWEST_C_PER_S * _STARTS_WITHIN_S
# While it is sampled it may swing a little further than when it settles.
_SWING = 2.0


class ChamberDrive:
    """A chamber that is brought to a step's temperature and watched while it is sampled.

    Messages begin with `name`.
    """

    def __init__(self, chamber: Chamber, *, clock: Clock, name: str = "temperature chamber") -> None:
        self._chamber = chamber
        self._name = name
        self._clock = clock
        self._soaking: Soaking | None = None
        self._read_degc: list[float] = []
        self._looked_s = -math.inf

    def reach(self, soaking: Soaking) -> None:
        """Return when it has held the temperature for the soak time; raises `InstrumentError`."""
        self._soaking, self._read_degc, self._looked_s = soaking, [], -math.inf
        self._chamber.set_temperature(soaking.temperature_degc)
        from_degc = found_degc = self._chamber.temperature_degc()
        began_s = now_s = self._clock.now_s()
        way_c = abs(soaking.temperature_degc - from_degc)
        deadline_s = began_s + way_c / _SLOWEST_C_PER_S + soaking.soak_s + _MARGIN_S
        within_s: float | None = None
        while True:
            held = abs(found_degc - soaking.temperature_degc) <= soaking.tolerance_c
            within_s = (now_s if within_s is None else within_s) if held else None
            if within_s is not None and now_s >= within_s + soaking.soak_s:
                return
            if now_s >= deadline_s or _stands_still(
                now_s - began_s, way_c=way_c, moved_c=abs(found_degc - from_degc), held=held
            ):
                told = _not_reached(soaking, from_degc, found_degc, now_s - began_s)
                raise InstrumentError(f"{self._name}: {told}")
            until_s = now_s + _POLL_S
            if within_s is not None:
                until_s = min(until_s, within_s + soaking.soak_s)
            self._clock.sleep_until(until_s)
            now_s, found_degc = self._clock.now_s(), self._chamber.temperature_degc()

    def watch(self) -> None:
        """Read it back every few seconds of a dwell; raises `InstrumentError` where it has drifted away."""
        soaking, now_s = self._soaking, self._clock.now_s()
        if soaking is None or now_s < self._looked_s + _POLL_S:
            return
        self._looked_s = now_s
        found_degc = self._chamber.temperature_degc()
        self._read_degc.append(found_degc)
        if abs(found_degc - soaking.temperature_degc) > _SWING * soaking.tolerance_c:
            raise InstrumentError(
                f"{self._name}: {found_degc:.2f} °C in the middle of a step at"
                f" {soaking.temperature_degc:g} °C (± {soaking.tolerance_c:g} °C, twice that while it is"
                " sampled); was its door opened, or did it stop?"
            )

    def read_back(self) -> float | None:
        """The mean of what was read back since the temperature was reached, °C; None where nothing was."""
        return fmean(self._read_degc) if self._read_degc else None


def _stands_still(elapsed_s: float, *, way_c: float, moved_c: float, held: bool) -> bool:
    """Whether so little has happened that nothing will."""
    return not held and elapsed_s >= _STARTS_WITHIN_S and way_c > 2 * _STARTS_C and moved_c < _STARTS_C


def _not_reached(soaking: Soaking, from_degc: float, found_degc: float, took_s: float) -> str:
    return (
        f"{soaking.temperature_degc:g} °C is asked for, found {found_degc:.2f} °C after"
        f" {took_s / 60.0:.0f} min, from {from_degc:.2f} °C; it is to hold within {soaking.tolerance_c:g} °C"
        f" for {soaking.soak_s / 60.0:.3g} min; does it run, is its door closed, and can it go there?"
    )
