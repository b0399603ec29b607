"""Figures of a static test."""

from gyrotest.procedures.static.noise_results import NoiseAnalysis
from gyrotest.procedures.static.record import StaticRecord
from gyrotest.records.figure import Figure
from gyrotest.records.plan import Context
from gyrotest.records.result import Result


def static_figures(
    record: StaticRecord, noise: NoiseAnalysis, results: tuple[Result, ...], context: Context
) -> tuple[Figure, ...]:
    """Return the figures."""
    return ()
