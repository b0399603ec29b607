"""What a g-sensitivity case measures: of one mounting, and over all of them."""

from collections.abc import Iterator

from gyrotest.analysis.mounting import AXES
from gyrotest.procedures.g_sensitivity.parameters import GSensitivityParameters
from gyrotest.records.result import Measurand
from gyrotest.records.spec import Case, Over
from gyrotest.units import Dimension

PER_G = "deg/s/g"
MAGNITUDE = "g_sensitivity_magnitude"
MOUNTED_CROSS_AXIS = "mounted_cross_axis"
MOUNTED_BEFORE, MOUNTED_AFTER = "mounted_drift_before", "mounted_drift_after"
BEFORE, AFTER = "drift_before", "drift_after"
AGREEMENT, DIFFERENCE = "agreement", "agreement_difference"
METHOD_AGREEMENT = "method_agreement"


def coefficient_name(axis: str) -> str:
    """Name the coefficient of an own axis, from all mountings that see it."""
    return f"g_sensitivity_{axis}"


def mounted_name(axis: str) -> str:
    """Name the coefficient of an own axis as one mounting gives it."""
    return f"mounted_g_sensitivity_{axis}"


def cross_axis_name(axis: str) -> str:
    """Name how the output follows a turning about an own axis that is not the sensitive one."""
    return f"cross_axis_{axis}"


def method_difference_name(axis: str) -> str:
    """Name the difference between both methods in a coefficient."""
    return f"method_difference_{axis}"


def g_sensitivity_measurands(case: Case, parameters: GSensitivityParameters) -> tuple[Measurand, ...]:
    """Return everything that a case measures."""
    if case.repeats < 2:
        return tuple(_of_mounting(parameters))
    return (*_of_mounting(parameters), *_over_mountings(parameters))


def _of_mounting(parameters: GSensitivityParameters) -> Iterator[Measurand]:
    yield Measurand(name="bias", label="Bias", dimension=Dimension.RATE, unit="deg/s")
    for axis in AXES:
        yield _per_g(mounted_name(axis), f"g-sensitivity {axis}, this mounting")
    if parameters.turning:
        yield Measurand(
            name=MOUNTED_CROSS_AXIS,
            label="Cross-axis sensitivity to the shaft's rate",
            dimension=Dimension.NUMBER,
            unit="%",
        )
    yield _drift(MOUNTED_BEFORE, "Drift before compensation, this mounting")
    yield _drift(MOUNTED_AFTER, "Drift after compensation, this mounting")


def _over_mountings(parameters: GSensitivityParameters) -> Iterator[Measurand]:
    over = Over.REPEATS
    for axis in AXES:
        yield _per_g(coefficient_name(axis), f"g-sensitivity {axis}", over)
    yield _per_g(MAGNITUDE, "g-sensitivity, magnitude", over)
    if parameters.turning:
        for axis in AXES:
            if axis != parameters.sensitive_axis.value:
                yield Measurand(
                    name=cross_axis_name(axis),
                    label=f"Cross-axis sensitivity {axis}",
                    dimension=Dimension.NUMBER,
                    unit="%",
                    over=over,
                )
    yield _per_g(DIFFERENCE, "Doubly measured coefficient, difference", over)
    yield _ratio(AGREEMENT, "Difference of the mountings over its U", over)
    yield _drift(BEFORE, "Drift before compensation", over)
    yield _drift(AFTER, "Drift after compensation", over)
    if parameters.compare_with is not None:
        for axis in AXES:
            yield _per_g(
                method_difference_name(axis), f"g-sensitivity {axis}, less the other method's", over
            )
        yield _ratio(METHOD_AGREEMENT, "Difference of the methods over its U", over)


def _per_g(name: str, label: str, over: Over | None = None) -> Measurand:
    return Measurand(
        name=name, label=label, dimension=Dimension.RATE_PER_ACCELERATION, unit=PER_G, over=over
    )


def _ratio(name: str, label: str, over: Over) -> Measurand:
    return Measurand(name=name, label=label, dimension=Dimension.NUMBER, unit="%", over=over)


def _drift(name: str, label: str, over: Over | None = None) -> Measurand:
    return Measurand(name=name, label=label, dimension=Dimension.RATE, unit="deg/h", over=over)
