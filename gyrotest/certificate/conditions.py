"""Under which conditions was measured: sampling, power, stimuli, place and directions of the axes."""

from collections.abc import Iterator, Sequence

from gyrotest.certificate.angles import angles
from gyrotest.certificate.numbers import plain
from gyrotest.certificate.printing import numbers_in_words, printed_text
from gyrotest.certificate.statement import remarks
from gyrotest.certificate.stimuli import stimuli
from gyrotest.records.recording import Recording, Sampling
from gyrotest.records.run import RunRecord
from gyrotest.records.spec import Between, Case, OutputKind
from gyrotest.records.station import Slot

_GAP_FREE = 0.999  # duty from which on nothing of the signal is left out


def conditions(record: RunRecord) -> tuple[str, ...]:
    """Everything that is to be known of how it was measured, a sentence each."""
    return tuple(_conditions(record))


def _conditions(record: RunRecord) -> Iterator[str]:
    yield from _samplings(record)
    if not record.replayed:
        yield from _power(record)
    yield from stimuli(record)
    yield from angles(record)
    site = record.header.station.station.site
    if site is not None:
        heading = f", heading {site.heading}" if site.heading is not None else ""
        yield printed_text(f"Latitude {site.latitude}{heading}.")
    yield from _directions(record)
    yield from remarks(record)


def _samplings(record: RunRecord) -> Iterator[str]:
    """How the source sampled, each way once, with what dead time there was."""
    # How long a replayed file's samples were integrated for is not known.
    ways = [one.header.sampling for one in _recordings(record) if not one.header.source.replayed]
    spoken = record.header.spec.spec.output.kind is not OutputKind.VOLTAGE
    for way in dict.fromkeys(ways):
        if way.synchronous:
            yield _by_one_clock(way)
        elif spoken and way.duty >= _GAP_FREE:
            yield _own_samples(way) + _beside(way)
        else:
            yield _readings(way) + _beside(way)


def _by_one_clock(way: Sampling) -> str:
    """What a synchronous source samples."""
    known = "how well the times between them are known is not stated"
    if way.skew_uncertainty_s is not None:
        known = f"times between them known to within {_microseconds(way.skew_uncertainty_s)}"
    late = ", ".join(
        f"{name} {_microseconds(offset)}"
        for name, offset in zip(way.columns, way.offsets_s, strict=False)
        if offset
    )
    corrected = f"; later than {way.columns[0]} and corrected for it: {late}" if late else ""
    analogue = "not stated" if way.filter_hz is None else f"{plain(way.filter_hz, digits=4)} Hz"
    return (
        f"{', '.join(way.columns)} sampled {1.0 / way.interval_s:.0f} times a second by one clock{corrected};"
        f" {known}. Analogue low-pass: {analogue}."
    )


def _microseconds(time_s: float) -> str:
    return f"{plain(time_s * 1e6, digits=4)} µs"


def _own_samples(way: Sampling) -> str:
    """What a digital gyro sends."""
    several = f" of the axes {', '.join(way.channels)}" if len(way.channels) > 1 else ""
    each = "as the unit sends it"
    if way.readings > 1:
        each = f"the mean of {way.readings} readings of the unit's own"
    return f"One sample{several} every {plain(way.interval_s)} s, {each}, without gaps."


def _readings(way: Sampling) -> str:
    """What a meter reads."""
    outputs = f" of {', '.join(way.channels)}" if len(way.channels) > 1 else ""
    return (
        f"One sample{outputs} every {plain(way.interval_s)} s is the mean of {way.readings} reading"
        f"{'' if way.readings == 1 else 's'} of {plain(way.aperture_s * 1000, digits=4)} ms: the signal is "
        f"integrated for {plain(100 * way.duty, digits=3)} % of the time."
        + (
            " White noise read through the dead time is folded; a result that depends on it says so."
            * (way.duty < _GAP_FREE)
        )
    )


def _beside(way: Sampling) -> str:
    """What is recorded beside the output, and what is sampled later than it."""
    beside = ", ".join(f"{one.name} (in {printed_text(one.unit)})" for one in way.auxiliary)
    text = f" Recorded beside it: {beside}." if beside else ""
    late = [
        f"{name} {plain(offset, digits=4)} s"
        for name, offset in zip(way.columns, way.offsets_s, strict=False)
        if offset
    ]
    return f"{text} Sampled later than {way.columns[0]}: {', '.join(late)}." if late else text


def _power(record: RunRecord) -> Iterator[str]:
    spec, slot = record.header.spec.spec, _slot(record)
    supply = spec.supply
    by_supply = slot is not None and slot.supply is not None and supply is not None
    if by_supply and supply is not None and slot is not None:
        output = f", output {slot.supply_output}" if slot.supply_output > 1 else ""
        yield printed_text(
            f"Powered with {supply.voltage} by '{slot.supply}'{output}: current limit {supply.current_limit}, "
            f"over-voltage protection {supply.over_voltage}."
        )
    else:
        yield "Powered by hand: no power supply of the station was used."
    for name, case in spec.cases.items():
        if case.between_repeats is Between.POWER_CYCLE and case.repeats > 1:
            how = (
                f"off for {supply.off_time}" if by_supply and supply is not None else "by hand (manual)"
            )
            yield printed_text(
                f"Power cycles before repeats {numbers_in_words(range(2, case.repeats + 1))} of {name}: {how}."
            )


def _directions(record: RunRecord) -> Iterator[str]:
    """How the unit was mounted in each case, and which of its axes were judged; cases that are alike together."""
    axes, alike = record.header.spec.spec.output.axes, dict[tuple[str, str], list[str]]()
    for name, case in record.header.spec.spec.cases.items():
        for what, told in _of_case(case, axes):
            alike.setdefault((what, told), []).append(name)
    for (what, told), names in alike.items():
        yield f"{what} in {', '.join(names)}: {told}."


def _of_case(case: Case, axes: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Give what is said of a case's axes, and what of."""
    if case.mounting is not None:
        yield "Sensitive axis", _direction(case.mounting)
    if case.mountings:
        yield "Sensitive axes", "; ".join(f"{axis} {_direction(way)}" for axis, way in _mounted(case))
    if case.axes and set(case.axes) != set(axes):
        yield "Judged", f"{_axes(case.axes)} of {', '.join(axes)}"


def _mounted(case: Case) -> Iterator[tuple[str, tuple[float, float, float]]]:
    for axis, way in case.mountings.items():
        if not case.axes or axis in case.axes:
            yield axis, way


def _direction(way: tuple[float, float, float]) -> str:
    up, north, east = way
    return f"up {plain(up)}, north {plain(north)}, east {plain(east)}"


def _axes(axes: Sequence[str]) -> str:
    return f"axis {axes[0]}" if len(axes) == 1 else f"axes {', '.join(axes)}"


def _slot(record: RunRecord) -> Slot | None:
    return record.header.station.station.slots.get(record.header.slot)


def _recordings(record: RunRecord) -> list[Recording]:
    return [one.recording for item in record.items for one in item.attempts if one.recording]
