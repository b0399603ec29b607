"""What is to be known of one mounting beside its results."""

from collections.abc import Iterator

from gyrotest.analysis.g_sensitivity import second_harmonic
from gyrotest.procedures.g_sensitivity.mounting_record import MountingRecord
from gyrotest.procedures.wording import plain, rate_text

_SEEN = 4.0


def mounting_remarks(found: MountingRecord) -> Iterator[str]:
    """Say what was dropped, and what the model does not explain."""
    if found.dropped:
        yield f"Outliers: {found.dropped} of {found.planned} samples dropped."
    if found.missing:
        yield f"{found.missing} of {found.planned} samples are missing."
    if found.left_out:
        yield (
            f"Run-up and reversal: {found.left_out} of {found.planned} samples left out by the measured rate."
        )
    if found.counted:
        yield (
            "The encoder counts from where each turn begins: the angle's zero is that of the end of the run-up."
        )
    if not found.found.arcs.turns:
        return
    twice = second_harmonic(found.found)
    if twice.amplitude > _SEEN * twice.uncertainty:
        yield (
            f"The residual follows twice the angle by {rate_text(twice.amplitude)}"
            f" ({plain(twice.amplitude / twice.uncertainty, 2)} standard uncertainties): drift by the square of"
            " gravity, or an error of the encoder."
        )
