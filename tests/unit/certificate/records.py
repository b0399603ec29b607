"""Run records of a static test, as a runner would make them, for the certificate to draw."""

import dataclasses
import math
from collections.abc import Mapping
from datetime import UTC, date, datetime, timedelta
from typing import Any

import numpy as np

from gyrotest.records.figure import Band, Bars, Curve, Figure, Mark, Panel, Role, Scale, Width
from gyrotest.records.recording import Gap, Identity, Recording, RecordingHeader, Sampling
from gyrotest.records.result import Contribution, JudgedLimit, JudgedResult, Verdict
from gyrotest.records.run import (
    SCHEMA_VERSION,
    Attempt,
    InstrumentUse,
    ItemRecord,
    Origin,
    Outcome,
    PlannedItem,
    RunHeader,
    RunRecord,
)
from gyrotest.records.spec import Case, DecisionRule, Limit, Output, OutputKind, Over, Spec, SpecDocument
from gyrotest.records.station import (
    Accuracy,
    Calibration,
    Instrument,
    Site,
    Slot,
    Station,
    StationDocument,
)
from gyrotest.units import Quantity

START = datetime(2026, 11, 21, 9, 12, 5, tzinfo=UTC)
ISSUED = datetime(2026, 11, 21, 13, 48, 31, tzinfo=UTC)
RUN_ID = "20261121T091205Z-MEMS50-1234"
CASE = "bias_stability"
DEAD_TIME = "duty 0.83 (5 × 166.7 ms in 1 s), corrected for dead time"
DIGEST = "3f9ac1d4" * 8


def quantity(text: str) -> Quantity:
    number, unit = text.split(" ", 1)
    return Quantity(float(number), unit)


def limit(
    low: float | None, high: float | None, unit: str, rule: DecisionRule = DecisionRule.SIMPLE
) -> JudgedLimit:
    return JudgedLimit(min=low, max=high, unit=unit, decision=rule)


def spec() -> Spec:
    return Spec(
        model="MEMS50",
        description="Single-axis analogue MEMS gyro",
        document="QS-0815 rev C",
        manufacturer="Gyro Works",
        serial_pattern="[0-9]{4,8}",
        output=Output(
            kind=OutputKind.VOLTAGE,
            scale_factor=quantity("50 mV/(deg/s)"),
            scale_factor_uncertainty=quantity("0.5 %"),
            zero_rate=quantity("2.5 V"),
            full_scale=quantity("100 deg/s"),
            bandwidth=quantity("50 Hz"),
        ),
        datasheet={
            "angle_random_walk": quantity("0.5 deg/sqrt(h)"),
            "allan_minimum": quantity("10 deg/h"),
        },
        cases={
            CASE: Case(
                procedure="static",
                warm_up=quantity("10 min"),
                duration=quantity("1 h"),
                interval=quantity("1 s"),
                repeats=3,
                mounting=(1.0, 0.0, 0.0),
                parameters={"smoothing": ["1 s", "10 s", "100 s"]},
                limits={
                    "bias": Limit(min=quantity("-2 deg/s"), max=quantity("2 deg/s")),
                    "bias_run_to_run": Limit(max=quantity("60 deg/h"), over=Over.REPEATS),
                },
            )
        },
    )


def station() -> Station:
    return Station(
        name="Bench 3",
        laboratory="Gyro Works, final test",
        address="Industrivägen 1, 412 63 Göteborg",
        line_frequency=quantity("50 Hz"),
        site=Site(latitude=quantity("57.7 deg"), heading=quantity("0 deg")),
        ambient={"temperature": "23.4 °C", "humidity": "41 % RH"},
        instruments={
            "meter": Instrument(
                driver="agilent34401a",
                resource="GPIB0::22::INSTR",
                settings={"nplc": 10},
                accuracy=Accuracy(of_reading=quantity("35 ppm"), of_range=quantity("5 ppm")),
                asset="DMM-07",
                calibration=Calibration(
                    certificate="K-26-0981",
                    date=date(2026, 3, 14),
                    due=date(2027, 3, 14),
                    traceable_to="SI, via RISE (SE)",
                ),
            )
        },
        slots={"1": Slot(source="meter")},
    )


def budget(scale: float = 1.0) -> tuple[Contribution, ...]:
    return (
        Contribution(
            source="Mean of the record (Allan deviation carried to 1 h)",
            kind="A",
            distribution="normal",
            half_width="0.00081 °/s",
            sensitivity="1",
            standard_uncertainty=0.00081 * scale,
            degrees_of_freedom=4.2,
        ),
        Contribution(
            source="Meter, 10 V range, 1 year",
            kind="B",
            distribution="rectangular",
            half_width="±(35 ppm + 5 ppm)",
            sensitivity="20 (°/s)/V",
            standard_uncertainty=0.00158 * scale,
        ),
        Contribution(
            source="Scale factor",
            kind="B",
            distribution="rectangular",
            half_width="0.5 %",
            sensitivity="0.218 °/s",
            standard_uncertainty=0.00063 * scale,
        ),
    )


def results_of(repeat: int) -> tuple[JudgedResult, ...]:
    """The nine results of one repeat of a unit that passes."""
    shift = 1 + 0.03 * (repeat - 2)

    def interval(name: str, label: str, value: float, unit: str, **more: Any) -> JudgedResult:
        value *= shift
        judged = {"verdict": Verdict.PASS} if more.get("limit") else {}
        return JudgedResult(
            case=CASE,
            repeat=repeat,
            name=name,
            label=label,
            value=value,
            unit=unit,
            lower_95=value * more.pop("below", 0.93),
            upper_95=value * more.pop("above", 1.08),
            **(judged | more),
        )

    return (
        JudgedResult(
            case=CASE,
            repeat=repeat,
            name="bias",
            label="Bias",
            value=-0.2184 * shift,
            unit="deg/s",
            expanded_uncertainty=0.0041,
            coverage_factor=2.06,
            condition="mean of 1 h, after 10 min warm-up, Earth's share removed",
            limit=limit(-2.0, 2.0, "deg/s"),
            verdict=Verdict.PASS,
            budget=budget(shift),
            not_included=("temperature of the unit",),
        ),
        interval(
            "bias_stability_1s",
            "Bias stability, 1 s",
            35.61,
            "deg/h",
            below=0.977,
            above=1.024,
            condition="1σ of 1 s means",
            limit=limit(None, 60.0, "deg/h"),
        ),
        interval(
            "bias_stability_10s",
            "Bias stability, 10 s",
            13.2,
            "deg/h",
            condition="1σ of 10 s means",
            limit=limit(None, 40.0, "deg/h"),
        ),
        interval(
            "bias_stability_100s",
            "Bias stability, 100 s",
            8.4,
            "deg/h",
            below=0.8,
            above=1.33,
            condition="1σ of 100 s means",
            limit=limit(None, 30.0, "deg/h"),
        ),
        interval(
            "allan_minimum",
            "Allan minimum",
            5.87,
            "deg/h",
            below=0.82,
            above=1.29,
            condition="at τ = 180 s",
            limit=limit(None, 12.0, "deg/h"),
        ),
        interval(
            "bias_instability_coefficient",
            "Bias instability coefficient",
            8.84,
            "deg/h",
            below=0.82,
            above=1.29,
            condition="Allan minimum ÷ 0.6643 (IEEE 952)",
            limit=limit(None, 18.0, "deg/h"),
            at_most=repeat == 3,
        ),
        interval(
            "angle_random_walk",
            "Angle random walk",
            0.4941,
            "deg/sqrt(h)",
            below=0.97,
            above=1.035,
            condition=DEAD_TIME,
            limit=limit(None, 0.6, "deg/sqrt(h)", DecisionRule.GUARDED),
        ),
        interval(
            "angle_random_walk_apparent",
            "Angle random walk, apparent",
            0.5412,
            "deg/sqrt(h)",
            below=0.97,
            above=1.035,
            condition="as read, not corrected for dead time",
        ),
    )


def over_repeats() -> JudgedResult:
    return JudgedResult(
        case=CASE,
        repeat=None,
        name="bias_run_to_run",
        label="Bias run to run",
        value=23.6,
        unit="deg/h",
        lower_95=12.3,
        upper_95=148.0,
        condition="standard deviation of 3 repeats, no power cycle",
        limit=JudgedLimit(
            min=None, max=60.0, unit="deg/h", decision=DecisionRule.SIMPLE, over=Over.REPEATS
        ),
        verdict=Verdict.PASS,
    )


def time_series(repeat: int) -> Figure:
    rng = np.random.default_rng(repeat)
    bins = np.linspace(0.0, 60.0, 600)
    mean = -0.2184 + 0.0025 * np.sin(bins / 7 + repeat) + rng.normal(0, 0.0016, 600)
    lower = mean - 0.021 - np.abs(rng.normal(0, 0.004, 600))
    upper = mean + 0.021 + np.abs(rng.normal(0, 0.004, 600))
    minutes = np.arange(0.5, 60.0)
    means = -0.2184 + 0.0025 * np.sin(minutes / 7 + repeat) + rng.normal(0, 0.0009, 60)
    return Figure(
        name="time_series",
        title="Bias record",
        note="3600 samples, 1 s, 1 h, 0 missing",
        caption="Top: output rate; band: minimum to maximum of every 6 samples; line: their mean. "
        "Bottom: means of 60 s on a finer scale; dotted: the mean.",
        alt="Output rate over one hour, and its means of 60 s",
        panels=(
            Panel(
                y_label="Rate / (°/s)",
                height=1.0,
                bands=(Band(x=tuple(bins), lower=tuple(lower), upper=tuple(upper)),),
                curves=(Curve(x=tuple(bins), y=tuple(mean)),),
            ),
            Panel(
                height=0.6,
                y_label="60 s mean / (°/s)",
                x_label="Time / min",
                curves=(
                    Curve(x=tuple(minutes), y=tuple(means)),
                    Curve(x=(0.0, 60.0), y=(-0.2184, -0.2184), role=Role.MEAN),
                ),
            ),
        ),
    )


def allan(repeat: int) -> Figure:
    tau = np.unique(np.round(np.geomspace(1, 400, 45)))
    minimum, walk = 5.87, 0.4941 * 60
    sigma = np.sqrt(walk**2 / tau + minimum**2 * 0.55 + (0.11 * tau**0.5) ** 2 * (1 + 0.1 * repeat))
    spread = 1 / np.sqrt(2 * np.maximum(3600 / tau - 1, 1))
    return Figure(
        name="allan_deviation",
        title="Allan deviation",
        note="overlapping estimator, 68 % confidence band",
        caption="Dotted: slopes −1/2 (angle random walk) and 0 (minimum). Dashed red: limits of the spec. "
        "Grey: the meter's own noise.",
        alt="Allan deviation over the averaging time",
        panels=(
            Panel(
                y_label="Allan deviation / (°/h)",
                x_label="Averaging time τ / s",
                x_scale=Scale.LOG,
                y_scale=Scale.LOG,
                height=1.0,
                bands=(
                    Band(
                        x=tuple(tau),
                        lower=tuple(sigma / (1 + spread)),
                        upper=tuple(sigma * (1 + spread)),
                        label="68 %",
                    ),
                ),
                curves=(
                    Curve(x=tuple(tau), y=tuple(sigma)),
                    Curve(
                        x=(1.0, 60.0),
                        y=(walk, walk / math.sqrt(60)),
                        role=Role.GUIDE,
                        label="slope −1/2",
                    ),
                    Curve(x=(40.0, 400.0), y=(minimum, minimum), role=Role.GUIDE, label="slope 0"),
                    Curve(
                        x=(1.0, 60.0),
                        y=(36.0, 36.0 / math.sqrt(60)),
                        role=Role.LIMIT,
                        label="limit ARW 0.6 °/√h",
                    ),
                    Curve(x=(1.0, 400.0), y=(12.0, 12.0), role=Role.LIMIT, label="limit minimum 12 °/h"),
                    Curve(
                        x=(1.0, 400.0),
                        y=(10.0, 10.0),
                        role=Role.DATASHEET,
                        label="datasheet minimum 10 °/h",
                    ),
                    Curve(
                        x=tuple(tau),
                        y=tuple(1.4 / np.sqrt(tau)),
                        role=Role.FLOOR,
                        label="meter's own noise",
                    ),
                ),
                marks=(
                    Mark(x=1.0, y=walk, label="ARW 0.494 °/√h"),
                    Mark(x=180.0, y=5.87, label="minimum 5.87 °/h at 180 s"),
                ),
            ),
        ),
    )


def histogram(repeat: int) -> Figure:
    edges = np.linspace(-40, 40, 41)
    middle = (edges[1:] + edges[:-1]) / 2
    model = np.exp(-((middle / 10.8) ** 2) / 2) / (10.8 * math.sqrt(2 * math.pi))
    heights = model * (1 + np.random.default_rng(repeat).normal(0, 0.06, 40))
    return Figure(
        name="histogram",
        title="Residual histogram",
        caption="Curve: normal distribution of the same standard deviation.",
        alt="Histogram of the samples about their mean",
        width=Width.HALF,
        panels=(
            Panel(
                y_label="Density / (h/°)",
                x_label="Residual / (°/h)",
                note="σ = 10.8 °/h",
                height=1.0,
                bars=Bars(edges=tuple(edges), heights=tuple(heights)),
                curves=(Curve(x=tuple(middle), y=tuple(model), role=Role.MODEL),),
            ),
        ),
    )


def floats(figure: Figure) -> Figure:
    """The same figure with Python's own floats."""

    def plain(value: Any) -> Any:
        if isinstance(value, np.floating):
            return float(value)
        if isinstance(value, tuple):
            return tuple(plain(item) for item in value)
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            fields = {one.name: plain(getattr(value, one.name)) for one in dataclasses.fields(value)}
            return type(value)(**fields)
        return value

    drawn: Figure = plain(figure)
    return drawn


def attempt_of(repeat: int, results: tuple[JudgedResult, ...], **changes: Any) -> Attempt:
    begin = START + timedelta(hours=repeat - 1, minutes=10)
    identity = Identity(
        manufacturer="HEWLETT-PACKARD", model="34401A", serial_number="US36012345", firmware="11-5-2"
    )
    item = f"{CASE}-r{repeat}"
    header = RecordingHeader(
        run_id=RUN_ID,
        item=item,
        attempt=1,
        serial_number="1234",
        model="MEMS50",
        spec_sha256=DIGEST,
        started_utc=begin,
        planned_samples=3600,
        sampling=Sampling(interval_s=1.0, aperture_s=1 / 6, readings=5, noise=1.1e-6, range=10.0),
        source=identity,
    )
    made = Attempt(
        item=item,
        number=1,
        outcome=Outcome.PASSED,
        started_utc=begin,
        ended_utc=begin + timedelta(hours=1),
        issued_utc=ISSUED,
        origin=Origin.MEASURED,
        recording=Recording(
            path=f"recordings/{item}-1.parquet",
            sha256=f"{repeat:02x}" * 32,
            header=header,
            samples=3600,
            complete=True,
            largest_lateness_s=0.0012,
        ),
        instruments=(
            InstrumentUse(
                name="meter", driver="agilent34401a", resource="GPIB0::22::INSTR", identity=identity
            ),
        ),
        results=results,
        figures=tuple(
            floats(figure) for figure in (time_series(repeat), allan(repeat), histogram(repeat))
        ),
    )
    return dataclasses.replace(made, **changes)


def header(**changes: Any) -> RunHeader:
    plan = tuple(PlannedItem(name=f"{CASE}-r{n}", case=CASE, repeat=n) for n in (1, 2, 3))
    made = RunHeader(
        run_id=RUN_ID,
        model="MEMS50",
        serial_number="1234",
        started_utc=START,
        spec=SpecDocument(path="specs/mems50.yaml", sha256=DIGEST, spec=spec()),
        station=StationDocument(
            path="specs/stations/bench3.yaml", sha256="b0d1" * 16, station=station()
        ),
        operator="A. Lindqvist",
        meta={"order": "WO 88213", "batch": "26-47"},
        software={"gyrotest": "0.1.0", "python": "3.11.2", "numpy": "2.3.1"},
        command="pytest --gyro-spec mems50.yaml --serial 1234",
        plan=(*plan, PlannedItem(name=f"{CASE}-repeats", case=CASE, repeat=None)),
        slot="1",
    )
    return dataclasses.replace(made, **changes)


def passing(**changes: Any) -> RunRecord:
    """A measured unit that passes all its limits in three repeats."""
    repeats = [results_of(n) for n in (1, 2, 3)]
    head = header()
    attempts = [attempt_of(n, results) for n, results in enumerate(repeats, start=1)]
    last = dataclasses.replace(
        attempts[-1],
        item=f"{CASE}-repeats",
        recording=None,
        figures=(),
        instruments=(),
        results=(over_repeats(),),
    )
    items = tuple(
        ItemRecord(plan=plan, attempts=(attempt,))
        for plan, attempt in zip(head.plan, (*attempts, last), strict=True)
    )
    made = RunRecord(
        schema_version=SCHEMA_VERSION,
        run_id=RUN_ID,
        model="MEMS50",
        serial_number="1234",
        verdict=Verdict.PASS,
        simulated=False,
        replayed=False,
        issued_utc=ISSUED,
        header=head,
        items=items,
        results=(*(one for results in repeats for one in results), over_repeats()),
    )
    return dataclasses.replace(made, **changes)


def judged(
    record: RunRecord, verdicts: Mapping[str, tuple[float, Verdict]], worst: Verdict
) -> RunRecord:
    """The record with other values and verdicts for the named results of the second repeat."""

    def changed(result: JudgedResult) -> JudgedResult:
        if result.name not in verdicts or result.repeat not in {2, None}:
            return result
        value, verdict = verdicts[result.name]
        if result.value is None or result.lower_95 is None or result.upper_95 is None:
            return dataclasses.replace(result, value=value, verdict=verdict)
        factor = value / result.value
        return dataclasses.replace(
            result,
            value=value,
            verdict=verdict,
            lower_95=result.lower_95 * factor,
            upper_95=result.upper_95 * factor,
        )

    return dataclasses.replace(
        record, verdict=worst, results=tuple(changed(result) for result in record.results)
    )


def failing() -> RunRecord:
    """Two values out of limits, and one that lies inside only by a conditional pass."""
    return judged(
        passing(),
        {
            "allan_minimum": (14.02, Verdict.FAIL),
            "bias": (2.0003, Verdict.FAIL),
            "bias_stability_100s": (29.1, Verdict.CONDITIONAL_PASS),
        },
        Verdict.FAIL,
    )


def incomplete() -> RunRecord:
    """A simulated run whose second repeat met a bench fault twice and whose third was never begun."""
    whole = passing()
    first, second, third, over = whole.items
    fault = "GPIB0::22::INSTR (HP 34401A): no reply to READ? within 5 s; is the trigger source IMM?"
    recording = second.attempts[0].recording
    assert recording is not None
    broken = dataclasses.replace(
        second.attempts[0],
        outcome=Outcome.ERROR,
        message=fault,
        results=(),
        figures=(),
        origin=Origin.SIMULATED,
        recording=dataclasses.replace(
            recording,
            samples=1411,
            complete=False,
            gaps=(Gap(after=1207, missing=14, reason="reconnected after a time-out"),),
        ),
        events=("reconnected after a time-out at sample 1207",),
    )
    items = (
        first,
        dataclasses.replace(
            second, attempts=(broken, dataclasses.replace(broken, number=2)), missing=f"error: {fault}"
        ),
        dataclasses.replace(third, attempts=(), missing="not started: interrupted by Ctrl-C"),
        dataclasses.replace(over, attempts=(), missing="skipped: repeats 2 and 3 have no bias"),
    )
    return dataclasses.replace(
        whole,
        verdict=Verdict.INCOMPLETE,
        simulated=True,
        items=items,
        results=tuple(one for one in whole.results if one.repeat == 1),
        missing=tuple(f"{item.plan.name}: {item.missing}" for item in items if item.missing),
        header=dataclasses.replace(
            whole.header,
            attempt=3,
            earlier_runs=(
                "20261119T081000Z-MEMS50-1234 (FAIL)",
                "20261120T081000Z-MEMS50-1234 (INCOMPLETE)",
            ),
            deviations=("calibration of 'meter' is not stated",),
        ),
    )


def empty() -> RunRecord:
    """A run that was stopped before anything was measured."""
    whole = passing()
    items = tuple(
        dataclasses.replace(item, attempts=(), missing="not started: interrupted")
        for item in whole.items
    )
    return dataclasses.replace(
        whole,
        verdict=Verdict.INCOMPLETE,
        items=items,
        results=(),
        missing=tuple(f"{item.plan.name}: {item.missing}" for item in items),
    )


def long_texts() -> RunRecord:
    """Everything that a person may write, longer than expected and full of special characters."""
    nasty = "<script>alert('x')</script> & \"quoted\" {{ braces }} {% raw %}"
    serial = "S" + "1234567890" * 6 + "ABC"
    base = failing()
    name = "An unusually long designation of a gyroscope that needs more than a single line, variant B/2"
    results = tuple(
        dataclasses.replace(
            one,
            label=f"{one.label}, {nasty}",
            condition=f"{one.condition}; {nasty}; {'word ' * 20}",
            unit="mV/(deg/s)/sqrt(h)",
        )
        for one in base.results
    )
    long_spec = dataclasses.replace(
        base.header.spec.spec, model=name, description=nasty, title=f"Acceptance test report {nasty}"
    )
    long_header = dataclasses.replace(
        base.header,
        serial_number=serial,
        operator=nasty,
        spec=dataclasses.replace(base.header.spec, spec=long_spec),
        meta={f"key {n} {nasty}": f"{nasty} {'x' * 90}" for n in range(6)},
        deviations=(nasty, "w" * 300),
        command=f"pytest --gyro-spec {'/very/long/path' * 20}",
    )
    return dataclasses.replace(
        base, serial_number=serial, model=name, header=long_header, results=results
    )


def many_repeats(count: int) -> RunRecord:
    """A run of many repeats of one case."""
    base = passing()
    plans = tuple(PlannedItem(name=f"{CASE}-r{n}", case=CASE, repeat=n) for n in range(1, count + 1))
    items = tuple(
        ItemRecord(plan=plan, attempts=(attempt_of(plan.repeat or 0, results_of(plan.repeat or 0)),))
        for plan in plans
    )
    return dataclasses.replace(
        base,
        items=items,
        header=dataclasses.replace(base.header, plan=plans),
        results=tuple(one for item in items for one in item.attempts[0].results),
    )
