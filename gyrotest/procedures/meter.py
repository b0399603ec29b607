"""The meter's accuracy in a bias: of the indication that stands for it, and of the range."""

from collections.abc import Iterator

from gyrotest.procedures.scaling import Scaling
from gyrotest.procedures.uncertainty import rectangular
from gyrotest.procedures.wording import engineering, plain, rate_text
from gyrotest.records.plan import Context
from gyrotest.records.recording import Sampling
from gyrotest.records.result import Contribution
from gyrotest.records.spec import OutputKind
from gyrotest.units import printed_unit


def meter_contributions(
    context: Context, sampling: Sampling, scaling: Scaling, *, slope: float, indication: float
) -> Iterator[Contribution]:
    """Give the meter's shares, °/s; `slope` and `indication` in `scaling.unit` (per °/s)."""
    accuracy = context.accuracy
    if accuracy is None:
        return
    shares = [("reading", accuracy.of_reading, abs(indication))]
    if sampling.range is not None:
        shares.append(("range", accuracy.of_range, sampling.range * scaling.to_canonical))
    rate = scaling.unit == "deg/s"
    for what, share, of in shares:
        half = share.to("") * of
        if half > 0.0:
            yield rectangular(
                f"meter, {share} of {what}",
                rate_text(half) if rate else engineering(half, scaling.unit),
                f"{plain(abs(1.0 / slope), 4)}{'' if rate else f' (°/s)/{printed_unit(scaling.unit)}'}",
                half / abs(slope),
            )


def missing_of_meter(context: Context, sampling: Sampling) -> Iterator[str]:
    """Give what could not be had of the meter's accuracy."""
    accuracy = context.accuracy
    if context.output.kind is OutputKind.VOLTAGE and accuracy is None:
        yield "accuracy of the meter"
    elif accuracy is not None and sampling.range is None and accuracy.of_range.value != 0.0:
        yield "accuracy of the meter's range (range not known)"
