"""Figures of a static test: the record over time, its residuals, its Allan deviation."""

from gyrotest.procedures.rest.record import RestRecord
from gyrotest.procedures.static.allan_figure import allan_figure
from gyrotest.procedures.static.noise_results import NoiseAnalysis
from gyrotest.procedures.static.smoothing_figures import smoothing_figures
from gyrotest.procedures.static.time_figures import histogram_figure, record_figure
from gyrotest.records.figure import Figure
from gyrotest.records.plan import Context
from gyrotest.records.result import Result


def static_figures(
    record: RestRecord, noise: NoiseAnalysis, results: tuple[Result, ...], context: Context
) -> tuple[Figure, ...]:
    """Return the figures, in the order of the certificate."""
    return (
        record_figure(record),
        histogram_figure(record),
        *smoothing_figures(record, context.parameters, results),
        allan_figure(record, noise, results, context),
    )
