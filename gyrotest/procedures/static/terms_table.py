"""The table of noise terms: fitted values beside the datasheet's, how good the fit is, lines and drift."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

from gyrotest.analysis.interval import NORMAL_95
from gyrotest.analysis.noise_model import Drift, DriftKind, NoiseModel, SpectralLine, TauRange
from gyrotest.procedures.rest.soundness import regularity_complaint
from gyrotest.procedures.static.noise_results import NoiseAnalysis
from gyrotest.procedures.static.terms import ANGLE_WALK, TERMS
from gyrotest.procedures.wording import engineering, plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.records.table import Cell, Column, Table
from gyrotest.units import Quantity, conversion_factor, printed_unit

_COLUMNS = (
    Column(heading="Noise term", share=30),
    Column(heading="Value", share=11, numbers=True),
    Column(heading="95 % interval", share=17),
    Column(heading="u", share=9, numbers=True),
    Column(heading="Unit", share=10),
    Column(heading="Carries τ", share=17),
    Column(heading="Datasheet", share=11, numbers=True),
    Column(heading="Ratio", share=9, numbers=True),
)
_UNLIKELY = 1e-3
_SMALL_DPS = 0.1
_MINUS = "\N{MINUS SIGN}"


def terms_table(noise: NoiseAnalysis, named: Mapping[str, Result], context: Context) -> Table:
    """Return the terms of a record's noise model and its Allan minimum beside the datasheet's figures."""
    return Table(
        title="Noise terms",
        note=_fit_note(noise.model),
        columns=_COLUMNS,
        rows=tuple(_rows(noise, named, context)),
        sentences=tuple(_sentences(noise.model)),
    )


def _rows(
    noise: NoiseAnalysis, named: Mapping[str, Result], context: Context
) -> Iterator[tuple[Cell, ...]]:
    for term in TERMS:
        fitted = term.of(noise.model)
        carries = _carried(fitted.carries) if fitted.resolved else ""
        found = named[term.name]
        yield _row(f"{term.letter} – {_lower(term.label)}", found, carries, context)
        as_read = named["angle_random_walk_apparent"]
        if term is ANGLE_WALK and as_read.value != found.value:
            yield _row(f"{term.letter} as read, with dead time", as_read, carries, context)
    lowest = noise.minimum
    at = "" if lowest is None else f"at {plain(lowest.tau_s, 3)} s"
    yield _row("Minimum of the curve (no term)", named["allan_minimum"], at, context)


def _row(label: str, found: Result, where: str, context: Context) -> tuple[Cell, ...]:
    stated = context.datasheet.get(found.name)
    unit = _shown_unit(found, stated, context)
    factor = conversion_factor(found.unit, unit)
    value, lower, upper = (
        None if one is None else one * factor for one in (found.value, found.lower_95, found.upper_95)
    )
    measured = Cell(value=value, lower_95=lower, upper_95=upper, at_most=found.at_most)
    bound = found.at_most and value == upper
    return (
        Cell(text=label),
        Cell(text="–") if value is None else measured,
        Cell(text="not resolved" if bound else "–")
        if bound or upper is None
        else replace(measured, interval=True),
        Cell(text="–")
        if found.at_most or lower is None or upper is None
        else Cell(value=(upper - lower) / (2.0 * NORMAL_95), digits=2),
        Cell(text=printed_unit(unit)),
        Cell(text=where or "–"),
        Cell(text="–" if stated is None else plain(stated.to(unit), 6)),
        _ratio(value, stated, unit, at_most=found.at_most),
    )


def _shown_unit(found: Result, stated: Quantity | None, context: Context) -> str:
    """Return the unit of the limit, as in the table of results; else the datasheet's, else the result's."""
    limit = context.case.limits.get(found.name)
    ends = (limit.max, limit.min) if limit else ()
    return next((one.unit for one in (*ends, stated) if one is not None), found.unit)


def _ratio(value: float | None, stated: Quantity | None, unit: str, *, at_most: bool) -> Cell:
    if value is None or stated is None or stated.value == 0.0:
        return Cell(text="–")
    return Cell(value=value / stated.to(unit), digits=3, at_most=at_most)


def _carried(carries: TauRange | None) -> str:
    if carries is None:
        return ""
    first, last = plain(carries.first_s, 3), plain(carries.last_s, 3)
    return f"{first} s" if first == last else f"{first} … {last} s"


def _lower(text: str) -> str:
    return text[:1].lower() + text[1:]


def _fit_note(model: NoiseModel) -> str:
    span = f"fit over τ = {plain(model.first_tau_s, 3)} … {plain(model.last_tau_s, 3)} s"
    return f"{span}, χ²/ν = {plain(model.misfit, 3)}, probability {_probability(model.fit_probability)}"


def _probability(probability: float) -> str:
    return f"< {_UNLIKELY:g}" if probability < _UNLIKELY else plain(probability, 2)


def _sentences(model: NoiseModel) -> Iterator[str]:
    yield (
        "Carries τ: where the term is at least a third of the fitted variance."
        " ≤ of a term: upper end of its 95 % interval; of the minimum: floor not reached."
        " Probability: of a fit worse than this by chance."
    )
    if model.fit_probability < _UNLIKELY:
        yield (
            "The five terms do not describe the curve within its uncertainty: theirs are widened by"
            f" √(χ²/ν) = {plain(model.misfit**0.5, 3)}."
        )
    too_regular = regularity_complaint(model)
    if too_regular:
        yield too_regular
    if model.lines:
        lines = "; ".join(_line(one) for one in model.lines)
        yield f"Spectral lines (± standard uncertainty), kept out of the fit: {lines}."
    if model.drift is not None:
        yield _drift(model.drift)


def _line(one: SpectralLine) -> str:
    amplitude = _with_uncertainty(one.amplitude_dps, one.standard_uncertainty_dps)
    return f"{engineering(one.frequency_hz, 'Hz', 4)}, amplitude {amplitude}"


def _drift(drift: Drift) -> str:
    course = "linear"
    if drift.kind is DriftKind.EXPONENTIAL and drift.time_constant_s is not None:
        course = f"exponential, time constant {plain(drift.time_constant_s, 2)} s"
    change = _with_uncertainty(drift.change_dps, drift.standard_uncertainty_dps)
    return f"Drift, kept out of the fit: {course}, {change} (± standard uncertainty) over the record."


def _with_uncertainty(rate_dps: float, standard_dps: float) -> str:
    """Return a rate with its standard uncertainty, of two digits, in °/h where that is the handier unit."""
    factor, unit = (3600.0, "°/h") if abs(rate_dps) < _SMALL_DPS else (1.0, "°/s")
    value, standard = rate_dps * factor, standard_dps * factor
    if standard <= 0.0:
        return f"{plain(value, 3)} {unit}".replace("-", _MINUS)
    rounded = float(f"{standard:.1e}")
    places = max(1 - math.floor(math.log10(rounded)), 0)
    return f"({value:.{places}f} ± {rounded:.{places}f}) {unit}".replace("-", _MINUS)
