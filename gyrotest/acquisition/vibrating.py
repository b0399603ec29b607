"""A vibration table in an acquisition: driven by an instrument, set by hand, or part of what is played back."""

from collections.abc import Callable
from typing import Protocol, runtime_checkable

from gyrotest.ports import Clock, VibrationDrive
from gyrotest.records.plan import Excitation, Plan, Vibrating

_WATCH_S = 1.0


@runtime_checkable
class VibrationLimits(Protocol):
    """Settings of a drive that know what it can do, before there is a connection to it."""

    def refusal(self, vibrating: Vibrating, *, sampled_s: float) -> str | None:
        """Why a vibration (a sweep: of that duration) cannot be; None where it can."""


def vibration_words(vibrating: Vibrating) -> str:
    """A vibration as a person is told of it."""
    level, low, high = f"{vibrating.rms_dps:g} °/s rms", vibrating.low_hz, vibrating.high_hz
    if vibrating.excitation is Excitation.NONE:
        return "at rest"
    if vibrating.excitation is Excitation.SINE:
        return f"a sine of {level} at {low:g} Hz"
    if vibrating.excitation is Excitation.SWEEP:
        return f"a sine of {level} swept from {low:g} to {high:g} Hz"
    return f"random vibration of {level} from {low:g} to {high:g} Hz"


def vibration_faults(plan: Plan, limits: VibrationLimits) -> tuple[str, ...]:
    """What a drive with these limits cannot do of a plan; nothing is commanded for it."""
    faults = (
        (step.name, limits.refusal(step.stimulus, sampled_s=step.samples * plan.interval_s))
        for step in plan.steps
        if isinstance(step.stimulus, Vibrating) and step.stimulus.excitation is not Excitation.NONE
    )
    return tuple(f"step '{name}': {fault}" for name, fault in faults if fault is not None)


class VibrationTable:
    """Brings a vibration table to what a plan's steps ask for, and watches it there.

    The drive is opened by its owner, who also closes it. After a fault it is put down, and opened anew
    for what comes next.
    """

    def __init__(self, drive: VibrationDrive, *, clock: Clock) -> None:
        self._drive = drive
        self._clock = clock
        self._put_down = False
        self._moves = False
        self._watched_s = 0.0

    def reach(self, vibrating: Vibrating, *, sampled_s: float) -> None:
        """Return when it vibrates and has settled; raises `InstrumentError`.

        A sweep settles at its lowest frequency, and begins with the first sample.
        """
        self._begin(vibrating)
        if vibrating.settle_s > 0.0:
            self._clock.sleep_until(self._clock.now_s() + vibrating.settle_s)
        if self._moves:
            self._drive.check()
        if vibrating.excitation is Excitation.SWEEP:
            self._drive.sweep(
                rms_dps=vibrating.rms_dps,
                low_hz=vibrating.low_hz,
                high_hz=vibrating.high_hz,
                duration_s=sampled_s,
            )
        self._watched_s = self._clock.now_s()

    def watch(self) -> None:
        """See, about once a second, that it still does what it was asked for; raises `InstrumentError`."""
        now_s = self._clock.now_s()
        if self._moves and now_s - self._watched_s >= _WATCH_S:
            self._watched_s = now_s
            self._drive.check()

    def rest(self) -> None:
        """Bring it to rest; never raises."""
        self._drive.stop()
        self._moves = False

    def put_down(self) -> None:
        """After a fault: at rest and disconnected; never raises."""
        self._drive.close()
        self._put_down, self._moves = True, False

    def take_up(self) -> None:
        """Open it anew where it was put down; raises `InstrumentError`."""
        if self._put_down:
            self._drive.open()
            self._put_down = False

    def _begin(self, vibrating: Vibrating) -> None:
        rms_dps, low_hz = vibrating.rms_dps, vibrating.low_hz
        if vibrating.excitation is Excitation.NONE:
            self.rest()
            return
        self._moves = True
        if vibrating.excitation is Excitation.RANDOM:
            self._drive.random(rms_dps=rms_dps, low_hz=low_hz, high_hz=vibrating.high_hz)
        else:
            self._drive.sine(rms_dps=rms_dps, frequency_hz=low_hz)


class VibrationByHand:
    """A vibration table with a controller of its own: the operator sets it, and says when it is done.

    `ask` returns when it is done; `told` gets what was confirmed, for the certificate, `note` what the
    operator is to know.
    """

    def __init__(
        self,
        *,
        clock: Clock,
        ask: Callable[[str], None],
        told: Callable[[str], None],
        note: Callable[[str], None],
    ) -> None:
        self._clock = clock
        self._ask = ask
        self._told = told
        self._note = note
        self._now: Vibrating | None = None

    def reach(self, vibrating: Vibrating, *, sampled_s: float) -> None:
        """Return when the operator has set it and it has settled; raises `AcquisitionError` of a refusal.

        What is set already is not asked for again. A sweep is begun by hand, so it settles by itself.
        """
        swept = vibrating.excitation is Excitation.SWEEP
        if vibrating != self._now or swept:
            self._now = None
            self._ask(_request(vibrating, sampled_s=sampled_s))
            self._told(
                f"Vibration set by hand, as the operator confirmed: {vibration_words(vibrating)}."
            )
        self._now = vibrating
        if vibrating.settle_s > 0.0 and not swept:
            self._clock.sleep_until(self._clock.now_s() + vibrating.settle_s)

    def watch(self) -> None:
        """Nothing is read back from it."""

    def rest(self) -> None:
        """Say that it may be switched off; never raises."""
        if self._now is not None and self._now.excitation is not Excitation.NONE:
            self._note("the vibration table may be switched off")
        self._now = None


class VibrationRecorded:
    """What is played back was vibrated when it was recorded: nothing is moved."""

    def reach(self, vibrating: Vibrating, *, sampled_s: float) -> None:
        """Nothing to do."""

    def watch(self) -> None:
        """Nothing to look at."""

    def rest(self) -> None:
        """Nothing to stop."""


def _request(vibrating: Vibrating, *, sampled_s: float) -> str:
    if vibrating.excitation is Excitation.NONE:
        return "switch the vibration table off and wait until it rests"
    words = vibration_words(vibrating)
    if vibrating.excitation is Excitation.SWEEP:
        return f"set the vibration table to {words} in {sampled_s:g} s, logarithmically, and begin the sweep"
    return f"set the vibration table to {words} and switch it on"
