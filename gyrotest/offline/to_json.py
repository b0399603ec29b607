"""Analyses as JSON: plain numbers whose names carry the unit, `null` for what there is not."""

import json
import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest import __version__
from gyrotest.analysis.minimum import AllanMinimum
from gyrotest.analysis.noise_model import Drift, NoiseTerm, SpectralLine, TauRange
from gyrotest.analysis.noise_type import NoiseType
from gyrotest.offline.analysis import Analysis
from gyrotest.offline.readings import Reading, readings
from gyrotest.procedures.static.terms import TERMS
from gyrotest.records.spec import SpecDocument
from gyrotest.units import Quantity

SCHEMA = "gyrotest.analysis/1"

# The units that the model computes in, as the ends of names.
_UNITS = {
    "quantization_noise": "deg",
    "angle_random_walk": "deg_per_sqrt_s",
    "bias_instability_coefficient": "dps",
    "rate_random_walk": "dps_per_sqrt_s",
    "rate_ramp": "dps_per_s",
}


def json_text(analyses: Sequence[Analysis], refused: Iterable[str], spec: SpecDocument | None) -> str:
    """Return all that was found, and what was refused, with a line feed at the end."""
    document = {
        "schema": SCHEMA,
        "gyrotest_version": __version__,
        "spec": None
        if spec is None
        else {"path": spec.path, "sha256": spec.sha256, "model": spec.spec.model},
        "records": [_record(one) for one in analyses],
        "refused": list(refused),
    }
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _record(analysis: Analysis) -> dict[str, Any]:
    source = analysis.source
    return {
        "file": str(source.path),
        "array": source.array,
        "column": source.column,
        "samples": analysis.samples,
        "interval_s": analysis.interval_s,
        "sample_rate_hz": 1.0 / analysis.interval_s,
        "begin_s": analysis.begin_s,
        "duration_s": analysis.duration_s,
        "duty": analysis.duty,
        "mean_dps": analysis.mean_dps,
        "mean_standard_uncertainty_dps": _number(analysis.mean_standard_uncertainty_dps),
        **_terms(analysis),
        "allan_minimum": _minimum(analysis),
        "fit": _fit(analysis),
        "spectral_lines": [_line(one) for one in analysis.model.lines],
        "drift": _drift(analysis.model.drift),
        "curve": _curve(analysis),
        "remarks": list(analysis.remarks),
    }


def _terms(analysis: Analysis) -> dict[str, Any]:
    named = {one.name: one for one in readings(analysis)}
    found: dict[str, Any] = {}
    for term in TERMS:
        fitted, unit = term.of(analysis.model), _UNITS[term.name]
        true, apparent = f"{term.name}_{unit}", f"{term.name}_apparent_{unit}"
        beside = _beside(named[term.name], analysis.datasheet.get(term.name), term.dimension.value)
        if f"{term.name}_apparent" not in named:
            found[true] = _term(fitted) | beside
            continue
        found[true] = _corrected(named[term.name], 1.0 / term.per_core) | beside
        found[apparent] = _term(fitted)
    return found


def _term(term: NoiseTerm) -> dict[str, Any]:
    return {
        "value": _number(term.value),
        "standard_uncertainty": _number(term.standard_uncertainty),
        "lower_68": _number(term.lower_68),
        "upper_68": _number(term.upper_68),
        "lower_95": _number(term.lower_95),
        "upper_95": _number(term.upper_95),
        "resolved": term.resolved,
        "carried_by_tau_s": _range(term.carries),
    }


def _corrected(reading: Reading, factor: float) -> dict[str, Any]:
    """An angle random walk after the correction for dead time; `value` None where that cannot be done."""
    known = reading.value is not None
    return {
        "value": None if reading.value is None else reading.value * factor,
        "lower_95": reading.lower_95 * factor if known else None,
        "upper_95": reading.upper_95 * factor if known else None,
        "resolved": known and not reading.at_most,
        "carried_by_tau_s": _range(reading.carries),
    }


def _beside(reading: Reading, stated: Quantity | None, unit: str) -> dict[str, Any]:
    """The datasheet's figure and the measured value (or upper limit) over it."""
    if stated is None:
        return {"datasheet": None, "ratio_to_datasheet": None}
    return {"datasheet": stated.to(unit), "ratio_to_datasheet": _number(reading.ratio)}


def _minimum(analysis: Analysis) -> dict[str, Any] | None:
    found: AllanMinimum | None = analysis.minimum
    if found is None:
        return None
    reading = readings(analysis)[-1]
    return {
        "tau_s": found.tau_s,
        "deviation_dps": found.deviation_dps,
        "lower_95_dps": _number(found.lower_95_dps),
        "upper_95_dps": _number(found.upper_95_dps),
        "floor_reached": found.reached,
    } | _beside(reading, analysis.datasheet.get("allan_minimum"), "deg/s")


def _fit(analysis: Analysis) -> dict[str, Any]:
    model, factors = analysis.model, analysis.curve.averaging_factor
    components = model.components_dps(factors)
    return {
        "first_tau_s": model.first_tau_s,
        "last_tau_s": model.last_tau_s,
        "chi_square_per_degree_of_freedom": _number(model.misfit),
        "probability": _number(model.fit_probability),
        "deviation_dps": _numbers(model.allan_deviation_dps(factors)),
        "components_dps": {
            term.name: _numbers(part) for term, part in zip(TERMS, components, strict=True)
        },
    }


def _curve(analysis: Analysis) -> dict[str, Any]:
    curve = analysis.curve
    return {
        "estimator": "overlapping",
        "averaging_factor": curve.averaging_factor.tolist(),
        "tau_s": _numbers(curve.tau_s),
        "deviation_dps": _numbers(curve.deviation_dps),
        "lower_68_dps": _numbers(curve.lower_dps),
        "upper_68_dps": _numbers(curve.upper_dps),
        "edf": _numbers(curve.edf),
        "noise_type": noise_names(analysis),
        "n_differences": curve.n_differences.tolist(),
    }


def noise_names(analysis: Analysis) -> list[str]:
    """Name the noise that rules each point of a curve."""
    return [NoiseType(int(kind)).name.lower() for kind in analysis.curve.noise_type]


def _line(line: SpectralLine) -> dict[str, Any]:
    return {
        "frequency_hz": line.frequency_hz,
        "amplitude_dps": line.amplitude_dps,
        "standard_uncertainty_dps": _number(line.standard_uncertainty_dps),
    }


def _drift(drift: Drift | None) -> dict[str, Any] | None:
    if drift is None:
        return None
    return {
        "kind": drift.kind.value,
        "change_dps": drift.change_dps,
        "standard_uncertainty_dps": _number(drift.standard_uncertainty_dps),
        "time_constant_s": _number(drift.time_constant_s),
    }


def _range(times: TauRange | None) -> list[float] | None:
    return None if times is None else [times.first_s, times.last_s]


def _numbers(values: NDArray[np.float64]) -> list[float | None]:
    return [_number(one) for one in values.tolist()]


def _number(value: float | None) -> float | None:
    """JSON has no infinity and no NaN."""
    return value if value is not None and math.isfinite(value) else None
