"""The power of a unit under test: switched on with its protection set first, cycled, switched off."""

from dataclasses import dataclass

from gyrotest.errors import InstrumentError
from gyrotest.ports import Clock, PowerSupply
from gyrotest.records.bench import Supplied
from gyrotest.records.spec import Supply

# The voltage is up within 5 % of what is asked for and no longer moves; it is down below a tenth of a volt.
_UP_RATIO = 0.05
_STEADY_RATIO = 0.005
_DOWN_V = 0.1
_UP_WITHIN_S = 5.0
_DOWN_WITHIN_S = 60.0
_POLL_S = 0.02
_LONGEST_POLL_S = 0.5
# After the voltage is up a unit may still draw its inrush current; by then it may not.
_INRUSH_S = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class _Demand:
    voltage_v: float
    current_limit_a: float
    over_voltage_v: float

    def met_by(self, found: Supplied) -> bool:
        return abs(found.voltage_v - self.voltage_v) <= _UP_RATIO * self.voltage_v

    def __str__(self) -> str:
        return f"{self.voltage_v:.4g} V at up to {self.current_limit_a:.4g} A"


class Power:
    """One unit's supply. Whatever goes wrong while it is switched on, it is switched off again.

    Time passes through the clock only. Every method but `off` raises `InstrumentError`, whose message
    begins with `name`.
    """

    def __init__(
        self, supply: PowerSupply, how: Supply, *, clock: Clock, name: str = "power supply"
    ) -> None:
        self._supply = supply
        self._name = name
        self._clock = clock
        self._off_time_s = how.off_time.to("s")
        self._demand = _Demand(
            voltage_v=how.voltage.to("V"),
            current_limit_a=how.current_limit.to("A"),
            over_voltage_v=how.over_voltage.to("V"),
        )
        self.is_on = False
        self.switched_on_s: float | None = None

    def switch_on(self) -> str:
        """Protection, current limit, voltage, output on; what happened, once the voltage is up."""
        demand = self._demand
        self._supply.set(
            voltage_v=demand.voltage_v,
            current_limit_a=demand.current_limit_a,
            over_voltage_v=demand.over_voltage_v,
        )
        before_v = self._supply.measure().voltage_v
        try:
            self._supply.on()
            began_s = self._clock.now_s()
            came_up = self._come_up(began_s)
        except BaseException:
            self.off()
            raise
        self.is_on, self.switched_on_s = True, began_s
        already = f"; the output was at {before_v:.3g} V before" if before_v >= _DOWN_V else ""
        return f"{self._clock.utc():%Y-%m-%d %H:%M:%S} UTC: power on: {came_up}{already}"

    def cycle(self) -> str:
        """Off, until the voltage has fallen and the off time has passed, then on; what happened."""
        self._supply.off()
        self.is_on = False
        began_s = self._clock.now_s()
        self._wait_for_fall(began_s)
        down_s = self._clock.now_s()
        self._clock.sleep_until(down_s + self._off_time_s)
        off_s = self._clock.now_s() - began_s
        came_up = self.switch_on()
        return (
            f"{came_up}; off for {off_s:.3g} s before, the voltage down after {down_s - began_s:.2g} s"
        )

    def check(self) -> None:
        """See that the output still gives what it shall; switched off where it does not."""
        found = self._supply.measure()
        try:
            self._refuse_trip(found)
            if found.limiting:
                raise InstrumentError(self._limited(found))
            if not self._demand.met_by(found):
                raise InstrumentError(self._failed(found))
        except InstrumentError:
            self.off()
            raise

    def off(self) -> None:
        """Switch off; raises nothing: closing the supply tries once more."""
        self.is_on, self.switched_on_s = False, None
        try:
            self._supply.off()
        except InstrumentError:
            return

    def _come_up(self, began_s: float) -> str:
        demand, most_a, pause_s, last_v = self._demand, 0.0, _POLL_S, 0.0
        while True:
            found = self._supply.measure()
            took_s = self._clock.now_s() - began_s
            most_a = max(most_a, found.current_a)
            self._refuse_trip(found)
            moved_v, last_v = abs(found.voltage_v - last_v), found.voltage_v
            if demand.met_by(found) and moved_v <= _STEADY_RATIO * demand.voltage_v:
                break
            if took_s > _UP_WITHIN_S:
                raise InstrumentError(self._not_up(found, took_s))
            pause_s = self._pause(pause_s)
        found = self._after_inrush(found)
        return (
            f"{found.voltage_v:.4g} V after {took_s:.2g} s, {1e3 * found.current_a:.3g} mA"
            f" (at most {1e3 * max(most_a, found.current_a):.3g} mA seen)"
        )

    def _after_inrush(self, found: Supplied) -> Supplied:
        """Let the inrush pass: a unit that then still draws the current limit is an error."""
        deadline_s, pause_s = self._clock.now_s() + _INRUSH_S, _POLL_S
        while found.limiting:
            if self._clock.now_s() > deadline_s:
                raise InstrumentError(self._limited(found))
            pause_s = self._pause(pause_s)
            found = self._supply.measure()
            self._refuse_trip(found)
        return found

    def _wait_for_fall(self, began_s: float) -> None:
        pause_s = _POLL_S
        while (found := self._supply.measure()).voltage_v >= _DOWN_V:
            if self._clock.now_s() - began_s > _DOWN_WITHIN_S:
                raise InstrumentError(
                    f"{self._name}: {found.voltage_v:.3g} V remain {_DOWN_WITHIN_S:g} s after switching off,"
                    f" less than {_DOWN_V:g} V is expected; does another source feed the unit, or is a"
                    " large capacitance without a load?"
                )
            pause_s = self._pause(pause_s)

    def _pause(self, pause_s: float) -> float:
        """Wait, and return how long to wait the next time: a slow supply is asked less often."""
        self._clock.sleep_until(self._clock.now_s() + pause_s)
        return min(1.5 * pause_s, _LONGEST_POLL_S)

    def _refuse_trip(self, found: Supplied) -> None:
        if found.tripped:
            raise InstrumentError(
                f"{self._name}: the over-voltage protection has tripped: {self._demand} is asked for,"
                f" protection at {self._demand.over_voltage_v:.4g} V, found {_shown(found)}; is the spec's"
                " over_voltage too near the voltage, or does something feed back? Clear it at the supply"
            )

    def _not_up(self, found: Supplied, took_s: float) -> str:
        if found.limiting:
            return self._limited(found)
        cause = (
            "is the output's terminal switched, a fuse blown, or the sense line open?"
            if found.voltage_v < self._demand.voltage_v
            else "does something else feed the unit?"
        )
        return (
            f"{self._name}: the voltage does not come up: {self._demand} is asked for, found {_shown(found)}"
            f" {took_s:.2g} s after switching on; {cause}"
        )

    def _failed(self, found: Supplied) -> str:
        return (
            f"{self._name}: the supply failed in the meantime: {self._demand} is asked for, found"
            f" {_shown(found)}; look at the supply's display and at the unit, and start again"
        )

    def _limited(self, found: Supplied) -> str:
        return (
            f"{self._name}: in current limit: {self._demand} is asked for, found {_shown(found)}; is the"
            " unit connected with the right polarity, is it or its cable shorted, or is the spec's"
            " current_limit too low for it?"
        )


def _shown(found: Supplied) -> str:
    return f"{found.voltage_v:.4g} V and {found.current_a:.4g} A"
