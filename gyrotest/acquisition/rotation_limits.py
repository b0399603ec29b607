"""What a stage can do within one turn: how it runs up and stops, and what of a plan is beyond that."""

import math
from collections.abc import Iterator

from gyrotest.records.plan import Plan, Pointing, Rotating, Step
from gyrotest.records.station import Motion
from gyrotest.units import Dimension

TURN_DEG = 360.0
LATENCY_S = 0.1
"""Between two orders and their being carried out so much time may pass."""
SETTLE_S = 0.3
"""So long after the acceleration a stage's rate counts."""

_READ_S = 0.2
# How much longer than its acceleration asks for a stage may take to stop.
_STOPPING_MARGIN = 1.25


def stopping_deg(rate_dps: float, acceleration_dps2: float) -> float:
    """How far a stage still turns after it was told to stop, at most, °."""
    return _ramp_deg(rate_dps, acceleration_dps2) + abs(rate_dps) * LATENCY_S


def least_run_up_deg(rate_dps: float, acceleration_dps2: float) -> float:
    """The shortest way from rest in which a rate is reached, has settled and is read, °."""
    return _ramp_deg(rate_dps, acceleration_dps2) + abs(rate_dps) * (SETTLE_S + _READ_S)


def _ramp_deg(rate_dps: float, acceleration_dps2: float) -> float:
    return _STOPPING_MARGIN * rate_dps**2 / (2 * acceleration_dps2)


def rotation_faults(plan: Plan, motion: Motion) -> tuple[str, ...]:
    """What a stage with this motion cannot do of a plan; nothing is commanded for it."""
    found: dict[str, list[str]] = {}
    for step in plan.steps:
        for fault in _step_faults(step, plan, motion):
            found.setdefault(fault, []).append(step.name)
    faults = [f"{_steps(names)}: {fault}" for fault, names in found.items()]
    if plan.rotates and not motion.slip_ring and (motion.max_turns or 0.0) < 1.0:
        stated = (
            "nothing is stated"
            if motion.max_turns is None
            else f"±{motion.max_turns:g} turns are stated"
        )
        faults.append(
            f"the stage turns from 0° to 360° and back, and of its cables {stated} (motion.max_turns); give it"
            " cables that stand a turn and write 'max_turns: 1', or 'slip_ring: true'"
        )
    return tuple(faults)


def _steps(names: list[str]) -> str:
    more = len(names) - 1
    also = f" and {more} more step{'s' if more > 1 else ''}" if more else ""
    return f"step '{names[0]}'{also}"


def _step_faults(step: Step, plan: Plan, motion: Motion) -> Iterator[str]:
    if isinstance(step.stimulus, Pointing) and not 0.0 <= step.stimulus.position_deg <= TURN_DEG:
        yield f"{step.stimulus.position_deg:g}° is not within 0° to 360°; correct the case's angles"
    if isinstance(step.stimulus, Rotating):
        yield from _turn_faults(step.stimulus, step.samples * plan.interval_s, plan.interval_s, motion)


def _turn_faults(
    rotating: Rotating, sampled_s: float, interval_s: float, motion: Motion
) -> Iterator[str]:
    rate_dps, most_dps = abs(rotating.rate_dps), motion.max_rate.to(Dimension.RATE)
    if not 0.0 < rate_dps <= most_dps:
        yield (
            f"{rotating.rate_dps:g} deg/s is not more than 0 and at most the stage's {most_dps:g} deg/s"
            " (motion.max_rate); change the rate, or correct the station"
        )
        return
    acceleration_dps2 = motion.max_acceleration.to(Dimension.RATE_RAMP)
    least_deg = least_run_up_deg(rate_dps, acceleration_dps2)
    if rotating.run_up_deg < least_deg:
        yield (
            f"the run-up of {rotating.run_up_deg:g}° is too short: from rest to {rate_dps:g} deg/s at"
            f" {acceleration_dps2:g} deg/s² (motion.max_acceleration), until the rate has settled and is read,"
            f" takes {math.ceil(10 * least_deg) / 10:g}°; lengthen it, or lower the rate"
        )
    turned_deg = rate_dps * sampled_s
    if turned_deg > rotating.sampled_deg + rate_dps * interval_s:
        yield (
            f"its samples last {sampled_s:g} s, in which {turned_deg:.4g}° are turned; between the run-ups of"
            f" {rotating.run_up_deg:g}° there are {rotating.sampled_deg:g}°; take fewer samples"
        )
