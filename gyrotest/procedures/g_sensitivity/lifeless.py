"""What is no gyro's output, though least squares would find coefficients in it."""

import numpy as np

from gyrotest.analysis.g_sensitivity import ShaftFit, Term
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.wording import engineering, rate_text
from gyrotest.records.plan import Context
from gyrotest.records.recording import Samples

_FEWEST = 2
_METER_MARGIN = 3.0
_LEAST_OF_EARTH = 0.1


def refuse_lifeless(samples: Samples, context: Context) -> None:
    """Refuse an output that varies no more over the whole record than what reads it does by itself (S1.6)."""
    noise, unit = samples.sampling.noise, samples.sampling.unit
    if noise is None:
        return
    output = samples.values[:, 0]
    readings = output[np.isfinite(output)]
    if readings.size < _FEWEST:
        return
    spread = float(readings.std(ddof=1))
    if spread < _METER_MARGIN * noise:
        raise InsufficientDataError(
            f"{context.case_name}: signal not distinguishable from the meter: over all angles its standard"
            f" deviation is {engineering(spread, unit)}, the meter's own noise {engineering(noise, unit)} (at"
            f" least {_METER_MARGIN:g} times that is expected); is the unit connected and powered?"
        )


def refuse_without_earth(found: ShaftFit, samples: Samples, context: Context) -> None:
    """Refuse an output that does not even go with the Earth's rate, where the meter's noise tells nothing.

    Taken off an output that never had it, the Earth's rate would look like a small g-sensitivity.
    """
    if samples.sampling.noise is not None:
        return
    terms = [Term.ALONG_X, Term.ALONG_Z]
    by_gravity = found.model.design(found.arcs)[:, terms] @ found.coefficients[terms]
    earth_dps = found.model.earth_dps(found.arcs)
    seen, expected = float(np.std(earth_dps + by_gravity)), float(np.std(earth_dps))
    if seen < _LEAST_OF_EARTH * expected:
        raise InsufficientDataError(
            f"{context.case_name}: the output varies by {rate_text(seen)} (rms) with the angle, where the Earth's"
            f" rate alone makes {rate_text(expected)}: is the unit connected and powered, and are its unit and its"
            " scale factor those of the spec and the station?"
        )
