"""The figures of a random-vibration case, in the order of the certificate."""

from gyrotest.procedures.random_vibration.agreement import Agreement
from gyrotest.procedures.random_vibration.agreement_figure import agreement_figure
from gyrotest.procedures.random_vibration.bode import bode_figure
from gyrotest.procedures.random_vibration.measured import MeasuredResponse
from gyrotest.procedures.random_vibration.quality_figure import quality_figure
from gyrotest.procedures.random_vibration.runs_figure import runs_figure, spread_figure
from gyrotest.records.figure import Figure
from gyrotest.records.plan import Context


def response_figures(
    measured: MeasuredResponse, agreement: Agreement, context: Context
) -> tuple[Figure, ...]:
    """Return the response, how the runs scatter, its quality, and the comparison of the methods."""
    return (
        bode_figure(measured, context),
        quality_figure(measured, context),
        *spread_figure(measured, context),
        runs_figure(measured),
        *agreement_figure(agreement, context),
    )
