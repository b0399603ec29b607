"""From a case to the plan of its acquisition: warm-up, interval, and how many samples a step has."""

from gyrotest.records.plan import Context, Plan, Step
from gyrotest.records.spec import Case


def plan_of_steps(case: Case, steps: tuple[Step, ...], *, auxiliary: tuple[str, ...] = ()) -> Plan:
    """Return the acquisition of these steps, at the case's interval and after its warm-up."""
    return Plan(
        warm_up_s=warm_up_s(case),
        interval_s=case.interval.to("s"),
        steps=steps,
        auxiliary=auxiliary,
    )


def single_step_plan(case: Case, *, auxiliary: tuple[str, ...] = ()) -> Plan:
    """Return the acquisition of a single step, for which nothing is set."""
    return plan_of_steps(case, (Step(samples=step_samples(case)),), auxiliary=auxiliary)


def step_samples(case: Case) -> int:
    """Return how many samples a step has: the case's duration is that of each step."""
    return round(case.duration.to("s") / case.interval.to("s"))


def warm_up_s(case: Case) -> float:
    """Return the time from power-on to the first sample."""
    return 0.0 if case.warm_up is None else case.warm_up.to("s")


def since_power_on_s(context: Context) -> float:
    """Return the time from power-on to the record's begin; where not known, the warm-up."""
    return warm_up_s(context.case) if context.since_power_on_s is None else context.since_power_on_s
