"""Run records of digital gyros with three axes, and of a gyro on a rate table, for the certificate to draw."""

import dataclasses
import math
from datetime import timedelta
from typing import Any

import numpy as np

from gyrotest.records.figure import Curve, Figure, Panel, Points, Role, Width
from gyrotest.records.recording import (
    Auxiliary,
    Dwell,
    Identity,
    Recording,
    RecordingHeader,
    Sampling,
)
from gyrotest.records.result import JudgedResult, Verdict
from gyrotest.records.run import (
    SCHEMA_VERSION,
    Attempt,
    ExportedFile,
    InstrumentUse,
    ItemRecord,
    Origin,
    Outcome,
    PlannedItem,
    RunHeader,
    RunRecord,
)
from gyrotest.records.spec import (
    Between,
    Case,
    DecisionRule,
    Output,
    OutputKind,
    OutputMode,
    Spec,
    SpecDocument,
    Supply,
)
from gyrotest.records.station import Instrument, Motion, Slot, Station, StationDocument
from gyrotest.records.table import Cell, Column, Table
from gyrotest.units import Quantity
from tests.unit.certificate import records

AXES = ("x", "y", "z")
RATES = tuple(sign * rate for rate in (10.0, 20.0, 40.0, 60.0, 80.0) for sign in (1.0, -1.0))
CYCLES = 7
SERIAL = "N25581234567890"


def quantity(text: str) -> Quantity:
    return records.quantity(text)


def gyro() -> Identity:
    return Identity(manufacturer="Example", model="TRIAX300", serial_number=SERIAL, firmware="7")


TABLE = Identity(manufacturer="Acutronic", model="ACUTROL3000", serial_number="AC-117")
SUPPLY = Identity(manufacturer="Example", model="PSU 2", serial_number="PS-9")


def supply() -> Supply:
    return Supply(
        voltage=quantity("5 V"), current_limit=quantity("400 mA"), over_voltage=quantity("5.5 V")
    )


def station(**slot: Any) -> Station:
    motion = Motion(
        max_rate=quantity("200 deg/s"), max_acceleration=quantity("100 deg/s/s"), slip_ring=True
    )
    meter = records.station().instruments["meter"]
    return dataclasses.replace(
        records.station(),
        name="Table 2",
        instruments={
            "gyro": Instrument(driver="stim300", resource="ASRL/dev/ttyUSB0::INSTR"),
            "table": dataclasses.replace(
                meter, driver="acutrol3000", resource="TCPIP::10.0.0.2", motion=motion, asset="RT-02"
            ),
            "supply": dataclasses.replace(
                meter, driver="scpi_supply", resource="TCPIP::10.0.0.3", asset="PSU-4"
            ),
            "chamber": Instrument(driver="chamber", resource="TCPIP::10.0.0.4"),
        },
        slots={"1": Slot(**{"source": "gyro", "table": "table"} | slot)},
    )


def result(case: str, name: str, label: str, value: float, unit: str, **more: Any) -> JudgedResult:
    verdict = {"verdict": Verdict.PASS} if more.get("limit") else {}
    settings = {"case": case, "repeat": 1, **verdict, **more}
    if "expanded_uncertainty" not in settings:
        settings |= {"lower_95": value * 0.93, "upper_95": value * 1.08}
    return JudgedResult(name=name, label=label, value=value, unit=unit, **settings)


def noise_results(axis: str, repeat: int) -> tuple[JudgedResult, ...]:
    """Ten results of an axis at rest, seven of them with limits."""
    place = AXES.index(axis)
    shift = 1 + 0.04 * place + 0.01 * repeat
    limit = records.limit

    def one(name: str, label: str, value: float, unit: str, **more: Any) -> JudgedResult:
        return result("noise", name, label, value * shift, unit, axis=axis, repeat=repeat, **more)

    condition = f"read at 1 s; slope held over 0.02 … {40 + place} s"
    return (
        one(
            "bias",
            "Bias",
            (-1) ** place * 11.84,
            "deg/h",
            expanded_uncertainty=0.62,
            coverage_factor=2.05,
            condition="mean of 20 h, after 2 h warm-up, Earth's share removed",
            limit=limit(-250.0, 250.0, "deg/h"),
            budget=records.budget(3600 * shift),
            not_included=("temperature of the unit",),
        ),
        *(
            one(
                f"bias_stability_{length}s",
                f"Bias stability, {length} s",
                value,
                "deg/h",
                condition=f"1σ of {length} s means",
                limit=limit(None, 4 * value, "deg/h"),
            )
            for length, value in ((1, 9.2), (10, 3.1), (100, 1.04))
        ),
        one(
            "allan_minimum",
            "Allan minimum",
            0.47,
            "deg/h",
            condition=f"at τ = {900 + 130 * place} s",
            limit=limit(None, 1.0, "deg/h"),
        ),
        one(
            "angle_random_walk",
            "Angle random walk",
            0.148,
            "deg/sqrt(h)",
            condition=condition,
            limit=limit(None, 0.2, "deg/sqrt(h)", DecisionRule.GUARDED),
        ),
        one(
            "rate_random_walk",
            "Rate random walk",
            0.11,
            "(deg/h)/sqrt(h)",
            limit=limit(None, 1.0, "(deg/h)/sqrt(h)"),
        ),
        one("bias_instability_coefficient", "Bias instability coefficient", 0.71, "deg/h"),
        one("quantization_noise", "Quantization noise", 0.9, "arcsec", at_most=True),
        one("rate_ramp", "Rate ramp", 0.02, "(deg/h)/h", at_most=True),
    )


def axial(figure: Figure, axis: str) -> Figure:
    return dataclasses.replace(records.floats(figure), axis=axis)


def smoothing(length: int, axis: str, width: Width = Width.NARROW) -> Figure:
    rng = np.random.default_rng(length)
    time = np.linspace(0, 20, 240)
    values = rng.normal(0, 9.2 / math.sqrt(length), 240)
    curve = Curve(x=tuple(time.tolist()), y=tuple(values.tolist()))
    return Figure(
        name=f"smoothing_{length}s",
        axis=axis,
        title=f"Means of {length} s",
        width=width,
        panels=(Panel(y_label="Rate / (°/h)", x_label="Time / h", height=0.9, curves=(curve,)),),
        caption=f"1σ = {9.2 / math.sqrt(length):.2g} °/h.",
    )


def noise_figures(axis: str) -> tuple[Figure, ...]:
    whole = (records.time_series(1), records.allan(1))
    return (
        *(axial(one, axis) for one in whole),
        *(smoothing(length, axis) for length in (1, 10, 100)),
    )


def three_axes(repeats: int = 1) -> RunRecord:
    """A digital gyro of three axes at rest: ten results each, seven with limits, and a datasheet."""
    cases = {
        "noise": Case(
            procedure="static",
            warm_up=quantity("2 h"),
            duration=quantity("20 h"),
            interval=quantity("8 ms"),
            repeats=repeats,
            mountings={"x": (0.0, 1.0, 0.0), "y": (0.0, 0.0, 1.0), "z": (1.0, 0.0, 0.0)},
        )
    }
    sampling = Sampling(
        interval_s=0.008,
        aperture_s=0.008,
        unit="deg/s",
        channels=AXES,
        auxiliary=(Auxiliary(name="temperature", unit="degC"),),
    )
    attempts = [
        attempt(
            "noise",
            repeat,
            results=tuple(one for axis in AXES for one in noise_results(axis, repeat)),
            figures=tuple(one for axis in AXES for one in noise_figures(axis)),
            sampling=sampling,
            samples=9_000_000,
        )
        for repeat in range(1, repeats + 1)
    ]
    datasheet = {
        "angle_random_walk": quantity("0.15 deg/sqrt(h)"),
        "allan_minimum": quantity("0.5 deg/h"),
        "quantization_noise": quantity("1 arcsec"),
    }
    output = Output(
        kind=OutputKind.RATE,
        axes=AXES,
        mode=OutputMode.INCREMENTAL_ANGLE,
        full_scale=quantity("400 deg/s"),
        bandwidth=quantity("262 Hz"),
    )
    return run(
        cases, attempts, output=output, datasheet=datasheet, description="Three-axis digital gyro"
    )


def dwells(rates: tuple[float, ...] = RATES, samples: int = 3750) -> tuple[Dwell, ...]:
    """Rest, every rate, rest, twice over: the steps of a scale factor."""
    steps = (0.0, *rates, 0.0) * 2
    return tuple(
        Dwell(
            name="rest" if rate == 0.0 else f"{rate:+g} °/s",
            first=number * samples,
            samples=samples,
            began_s=45.0 * number,
            settling_s=4.2,
            rate_dps=rate,
            measured_rate_dps=rate + 0.0004 * math.sin(number),
        )
        for number, rate in enumerate(steps)
    )


def step_table() -> Table:
    """A row for each step."""
    heads = ("Step", "Rate / (°/s)", "Output / (°/s)", "u", "Residual / ppm", "Dropped")
    rows = tuple(
        (
            Cell(text=f"{number}"),
            Cell(text=f"{one.rate_dps:g}".replace("-", "−")),
            Cell(value=0.9901 * (one.rate_dps or 0.0) + 0.0358, digits=7),
            Cell(value=0.0004 + 1e-5 * number, digits=2),
            Cell(value=40 * math.sin(number), digits=3),
            Cell(text=f"{number % 3}"),
        )
        for number, one in enumerate(dwells(), start=1)
    )
    return Table(
        title="Steps",
        note="means of 30 s",
        columns=tuple(Column(heading=one, numbers=n > 0) for n, one in enumerate(heads)),
        rows=rows,
        sentences=("Dropped: samples farther than 6 MAD from the step's median.",),
    )


def residuals(axis: str = "", limit_ppm: float = 150.0) -> Figure:
    """Residuals of a straight line, forwards and backwards, with U and limits."""
    rates = tuple(sorted(RATES))
    span = (rates[0], rates[-1])

    def course(phase: float) -> tuple[float, ...]:
        return tuple(70 * math.sin(rate / 28 + phase) for rate in rates)

    return Figure(
        name="residuals",
        axis=axis,
        title="Residuals",
        note="least squares over all steps",
        panels=(
            Panel(
                y_label="Residual / ppm of full scale",
                x_label="Table rate / (°/s)",
                height=1.2,
                points=(
                    Points(x=rates, y=course(0.0), u=(22.0,) * len(rates), label="forwards"),
                    Points(x=rates, y=course(0.3), u=(22.0,) * len(rates), label="backwards", series=1),
                ),
                curves=(
                    Curve(x=span, y=(0.0, 0.0), role=Role.MEAN),
                    Curve(x=span, y=(limit_ppm,) * 2, role=Role.LIMIT, label=f"limit {limit_ppm:g} ppm"),
                    Curve(x=span, y=(-limit_ppm,) * 2, role=Role.LIMIT),
                ),
            ),
        ),
        caption="Deviation from the straight line; bars: expanded uncertainty.",
        table=step_table(),
    )


def response() -> Figure:
    rates = tuple(sorted(RATES))
    return Figure(
        name="response",
        title="Response",
        width=Width.HALF,
        panels=(
            Panel(
                y_label="Output / (°/s)",
                x_label="Table rate / (°/s)",
                points=(Points(x=rates, y=tuple(0.99 * one for one in rates)),),
                curves=(Curve(x=(-80.0, 80.0), y=(-79.2, 79.2), role=Role.MODEL),),
            ),
        ),
        caption="Means of the steps and the fitted line.",
    )


def cycles(count: int = CYCLES, width: Width = Width.HALF) -> Figure:
    """The bias of each power cycle, with its uncertainty."""
    numbers = tuple(float(n) for n in range(1, count + 1))
    values = tuple(0.183 + 0.009 * math.sin(2.4 * n) for n in numbers)
    ends = (0.5, count + 0.5)
    return Figure(
        name="bias_per_power_cycle",
        title="Bias per power cycle",
        width=width,
        panels=(
            Panel(
                y_label="Bias / (°/s)",
                x_label="Power cycle",
                points=(Points(x=numbers, y=values, u=(0.002,) * count),),
                curves=(
                    Curve(x=ends, y=(0.183, 0.183), role=Role.MEAN, label="mean"),
                    Curve(x=ends, y=(0.2, 0.2), role=Role.LIMIT, label="limit"),
                ),
            ),
        ),
        caption="Points: bias after each power-on; line: mean.",
    )


def table_results() -> tuple[JudgedResult, ...]:
    limit = records.limit

    def one(name: str, label: str, value: float, unit: str, u: float, **more: Any) -> JudgedResult:
        return result(
            "scale_factor",
            name,
            label,
            value,
            unit,
            axis="z",
            expanded_uncertainty=u,
            coverage_factor=2.03,
            **more,
        )

    return (
        one(
            "scale_factor",
            "Scale factor",
            0.99012,
            "",
            0.00004,
            limit=limit(0.98, 1.0, ""),
            condition="least squares over 20 steps, full scale 400 °/s",
            budget=records.budget(0.01),
        ),
        one("bias", "Bias", 0.0358, "deg/s", 0.0006, limit=limit(-0.1, 0.1, "deg/s")),
        one("nonlinearity", "Nonlinearity", 42.0, "ppm", 11.0, limit=limit(None, 150.0, "ppm")),
        one("asymmetry", "Asymmetry", 31.0, "ppm", 24.0, limit=limit(None, 200.0, "ppm")),
    )


def rate_table(*, by_hand: bool = False) -> RunRecord:
    """A scale factor on the table, with many steps, and seven power cycles."""
    cases = {
        "scale_factor": Case(
            procedure="scale_factor",
            warm_up=quantity("10 min"),
            duration=quantity("30 s"),
            interval=quantity("8 ms"),
            mountings={"z": (1.0, 0.0, 0.0)},
            axes=("z",),
        ),
        "bias_repeatability": Case(
            procedure="bias_repeatability",
            warm_up=quantity("10 min"),
            duration=quantity("10 min"),
            interval=quantity("8 ms"),
            repeats=CYCLES,
            between_repeats=Between.POWER_CYCLE,
        ),
    }
    sampling = Sampling(interval_s=0.008, aperture_s=0.008, unit="deg/s", channels=AXES)
    turned = attempt(
        "scale_factor",
        1,
        results=table_results(),
        figures=(
            *(dataclasses.replace(one, axis="z") for one in (response(), cycles())),
            residuals("z"),
        ),
        sampling=sampling,
        samples=3750 * len(dwells()),
        dwells=dwells(),
        exports=(
            ExportedFile(path=f"exports/compensation-{SERIAL}.json", sha256="ab" * 32),
            ExportedFile(path=f"exports/compensation-{SERIAL}.csv", sha256="cd" * 32),
        ),
    )
    manual = ("power switched off and on by hand (manual)",)
    cycled = [
        attempt(
            "bias_repeatability",
            repeat,
            results=tuple(
                result(
                    "bias_repeatability",
                    "bias",
                    "Bias",
                    0.18 + 0.005 * math.sin(repeat + place),
                    "deg/s",
                    axis=axis,
                    repeat=repeat,
                    expanded_uncertainty=0.0021,
                    coverage_factor=2.1,
                    condition="mean of 10 min",
                    limit=records.limit(-0.3, 0.3, "deg/s"),
                    budget=records.budget(1 + 0.1 * repeat),
                )
                for place, axis in enumerate(AXES)
            ),
            sampling=sampling,
            samples=75_000,
            remarks=manual if by_hand and repeat > 1 else (),
        )
        for repeat in range(1, CYCLES + 1)
    ]
    over = dataclasses.replace(
        cycled[-1],
        item=f"bias_repeatability-{SERIAL}-repeats",
        recording=None,
        remarks=(),
        results=tuple(
            result(
                "bias_repeatability",
                "bias_repeatability",
                "Bias repeatability",
                0.0093,
                "deg/s",
                axis=axis,
                repeat=None,
                condition=f"standard deviation over {CYCLES} power cycles",
                limit=records.limit(None, 0.02, "deg/s"),
            )
            for axis in AXES
        ),
        figures=tuple(dataclasses.replace(cycles(width=Width.FULL), axis=axis) for axis in AXES),
    )
    fed = {} if by_hand else {"supply": "supply"}
    output = Output(kind=OutputKind.RATE, axes=AXES, full_scale=quantity("400 deg/s"))
    return run(
        cases,
        [turned, *cycled, over],
        output=output,
        slot=fed,
        supply=supply(),
        description="Three-axis digital gyro",
    )


def two_cases() -> RunRecord:
    """The same results in two cases, of which the first page has room for one."""
    record = three_axes()
    again = tuple(dataclasses.replace(one, case="again") for one in record.results)
    return dataclasses.replace(record, results=record.results + again, items=())


def named_axes() -> RunRecord:
    """Axes that bear longer names, and one that failed."""
    names = {"x": "roll", "y": "pitch", "z": "yaw_redundant"}
    record = one_axis_fails()
    return dataclasses.replace(
        record,
        results=tuple(dataclasses.replace(one, axis=names[one.axis]) for one in record.results),
        items=(),
    )


def one_axis_fails() -> RunRecord:
    """Axis y is out of two limits."""
    record = three_axes()

    def worse(one: JudgedResult) -> JudgedResult:
        if one.axis != "y" or one.name not in {"allan_minimum", "bias"}:
            return one
        changed = dataclasses.replace(one, value=300.0, verdict=Verdict.FAIL)
        return (
            changed
            if one.lower_95 is None
            else dataclasses.replace(changed, lower_95=280.0, upper_95=330.0)
        )

    return dataclasses.replace(
        record, verdict=Verdict.FAIL, results=tuple(worse(one) for one in record.results)
    )


def many_steps() -> RunRecord:
    """A table of steps that no page holds."""
    record = rate_table()
    first = record.items[0]
    figure = residuals("z")
    assert figure.table is not None
    table = dataclasses.replace(figure.table, rows=figure.table.rows * 4)
    figures = (dataclasses.replace(figure, table=table),)
    attempt = dataclasses.replace(first.attempts[0], figures=figures)
    items = (dataclasses.replace(first, attempts=(attempt,)), *record.items[1:])
    return dataclasses.replace(record, items=items)


def by_hand() -> RunRecord:
    """The same without a power supply."""
    return rate_table(by_hand=True)


def three_repeats() -> RunRecord:
    """Three axes at rest, three times."""
    return three_axes(3)


def attempt(
    case: str,
    repeat: int,
    *,
    results: tuple[JudgedResult, ...],
    sampling: Sampling,
    samples: int,
    dwells: tuple[Dwell, ...] = (),
    **more: Any,
) -> Attempt:
    begin = records.START + timedelta(hours=repeat)
    item = f"{case}-{SERIAL}-r{repeat}"
    header = RecordingHeader(
        run_id=records.RUN_ID,
        item=item,
        attempt=1,
        serial_number=SERIAL,
        model="TRIAX300",
        spec_sha256=records.DIGEST,
        started_utc=begin,
        planned_samples=samples,
        sampling=sampling,
        source=gyro(),
    )
    return Attempt(
        item=item,
        number=1,
        outcome=Outcome.PASSED,
        started_utc=begin,
        ended_utc=begin + timedelta(minutes=30),
        issued_utc=records.ISSUED,
        origin=Origin.MEASURED,
        recording=Recording(
            path=f"recordings/{item}-1.parquet",
            sha256=f"{repeat:02x}" * 32,
            header=header,
            samples=samples,
            complete=True,
            dwells=dwells,
        ),
        instruments=tuple(
            InstrumentUse(name=name, driver=name, resource=name, identity=identity)
            for name, identity in (("gyro", gyro()), ("table", TABLE), ("supply", SUPPLY))
            if name != "table" or dwells
        ),
        results=results,
        **more,
    )


def run(
    cases: dict[str, Case], attempts: list[Attempt], *, output: Output, slot: Any = None, **more: Any
) -> RunRecord:
    spec = Spec(model="TRIAX300", manufacturer="Example Gyros", output=output, cases=cases, **more)
    plans = [
        PlannedItem(
            name=one.item,
            case=one.item.partition("-")[0],
            repeat=None if one.item.endswith("-repeats") else int(one.item.rpartition("-r")[2]),
        )
        for one in attempts
    ]
    header = RunHeader(
        run_id=records.RUN_ID,
        model="TRIAX300",
        serial_number=SERIAL,
        started_utc=records.START,
        spec=SpecDocument(path="specs/triax300.yaml", sha256=records.DIGEST, spec=spec),
        station=StationDocument(
            path="specs/stations/table2.yaml", sha256="b0d1" * 16, station=station(**(slot or {}))
        ),
        operator="A. Lindqvist",
        software={"gyrotest": "0.1.0"},
        plan=tuple(plans),
        slot="1",
    )
    return RunRecord(
        schema_version=SCHEMA_VERSION,
        run_id=records.RUN_ID,
        model="TRIAX300",
        serial_number=SERIAL,
        verdict=Verdict.PASS,
        simulated=False,
        replayed=False,
        issued_utc=records.ISSUED,
        header=header,
        items=tuple(
            ItemRecord(plan=plan, attempts=(one,)) for plan, one in zip(plans, attempts, strict=True)
        ),
        results=tuple(found for one in attempts for found in one.results),
    )
