"""Spec files → specs: `load_spec` reads one and complains of everything in it at once."""

import re
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from gyrotest.errors import SpecError
from gyrotest.ports import Procedure
from gyrotest.records.spec import Case, Output, OutputKind, Spec, SpecDocument
from gyrotest.registry import PROCEDURES, load
from gyrotest.specification.axes import output_axes_complaints
from gyrotest.specification.cases import Catalogue, case_complaints
from gyrotest.specification.checked import Complaint, checked, unrelated
from gyrotest.specification.earlier_cases import earlier_case_complaints
from gyrotest.specification.limits import unknown_measurand
from gyrotest.specification.parameters import section_or_raise
from gyrotest.specification.power import supply_complaints
from gyrotest.specification.reading import known_faults, raise_faults
from gyrotest.specification.yaml_document import read_yaml
from gyrotest.units import Dimension, Quantity, same_dimension

LONGEST_NAME = 64

# What an output of a kind is, and its scale factor. Counts may come without one: what needs it asks for it.
_OUTPUTS = {
    OutputKind.VOLTAGE: Dimension.VOLTAGE,
    OutputKind.RATE: Dimension.RATE,
    OutputKind.COUNT: Dimension.COUNT,
}
_SCALE_FACTORS = {
    OutputKind.VOLTAGE: Dimension.SCALE_FACTOR_VOLTAGE,
    OutputKind.RATE: Dimension.NUMBER,
    OutputKind.COUNT: Dimension.SCALE_FACTOR_COUNT,
}

# What a datasheet may state, beside anything that a case can measure.
DATASHEET: Mapping[str, Dimension] = {
    "bias": Dimension.RATE,
    "allan_minimum": Dimension.RATE,
    "bias_instability_coefficient": Dimension.RATE,
    "angle_random_walk": Dimension.ANGLE_RANDOM_WALK,
    "rate_random_walk": Dimension.RATE_RANDOM_WALK,
    "rate_ramp": Dimension.RATE_RAMP,
    "quantization_noise": Dimension.ANGLE,
    "bias_run_to_run": Dimension.RATE,
    "bias_repeatability": Dimension.RATE,
}


def installed_procedure(name: str) -> Procedure:
    """Return the procedure that is installed under a name; raises `GyrotestError`."""
    procedure: Procedure = load(PROCEDURES, name)()
    return procedure


def load_spec(path: Path, procedures: Catalogue = installed_procedure) -> SpecDocument:
    """Read and check a spec; raises `SpecError` with all its faults."""
    document = read_yaml(path, SpecError)
    found = checked(document.tree, Spec, known_faults(document))
    later = list(_complaints(found.record, procedures, found.complaints))
    raise_faults(document, (*found.complaints, *later), SpecError)
    return SpecDocument(path=document.path, sha256=document.sha256, spec=found.record)


def case_parameters(case: Case, procedure: Procedure) -> Any:
    """Return a case's parameters as its procedure's record; raises `SpecError`."""
    return section_or_raise(case.parameters, procedure.parameters, "parameters", SpecError)


def _complaints(
    spec: Spec, procedures: Catalogue, earlier: tuple[Complaint, ...]
) -> Iterator[Complaint]:
    yield from unrelated(_head_complaints(spec), earlier)
    yield from unrelated(_output_complaints(spec.output), earlier)
    yield from unrelated(output_axes_complaints(spec.output), earlier)
    if spec.supply is not None:
        yield from unrelated(supply_complaints(spec.supply), earlier)
    yield from unrelated(_datasheet_complaints(spec.datasheet), earlier)
    for name, case in spec.cases.items():
        key = ("cases", name)
        if not re.fullmatch("[a-z][a-z0-9_]{0,63}", name):
            message = (
                "a case is named by small letters, digits and '_', a letter first, e.g. 'bias_stability'"
            )
            yield Complaint(key, message)
        found = case_complaints(case, spec.output, procedures, key, earlier)
        yield from unrelated(found, earlier)
    yield from unrelated(earlier_case_complaints(spec.cases, procedures), earlier)


def _head_complaints(spec: Spec) -> Iterator[Complaint]:
    if not spec.model.strip() or not spec.model.isprintable() or len(spec.model) > LONGEST_NAME:
        message = f"{spec.model[:80]!r} is not a name of 1 to {LONGEST_NAME} printable characters"
        yield Complaint(("model",), message)
    if not spec.cases:
        yield Complaint(("cases",), "is empty; a spec tests something in at least one case")
    if spec.serial_pattern is not None and (reason := _pattern_fault(spec.serial_pattern)):
        message = (
            f"'{spec.serial_pattern}' is no regular expression: {reason}; write e.g. '[0-9]{{4,8}}'"
        )
        yield Complaint(("serial_pattern",), message)


def _pattern_fault(pattern: str) -> str:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            re.compile(pattern)
    except (re.error, Warning, OverflowError, RecursionError) as error:
        return str(error)
    return ""


def _output_complaints(output: Output) -> Iterator[Complaint]:
    voltage = output.kind is OutputKind.VOLTAGE
    because = (("output", "kind"),)
    scale, zero = output.scale_factor, output.zero_rate
    if scale is None and voltage:
        message = (
            "is missing; a gyro with a voltage output needs one, e.g. 'scale_factor: 50 mV/(deg/s)'"
        )
        yield Complaint(("output", "scale_factor"), message, because)
    if scale is not None:
        wanted = _SCALE_FACTORS[output.kind]
        yield from _of_kind(scale, wanted, output.kind, "scale_factor")
        if scale.value == 0:
            yield Complaint(
                ("output", "scale_factor"), "is zero; the output would say nothing of the rate"
            )
    if zero is not None:
        wanted = _OUTPUTS[output.kind]
        yield from _of_kind(zero, wanted, output.kind, "zero_rate")
    yield from _sign_complaints(output)


def _of_kind(value: Quantity, wanted: Dimension, kind: OutputKind, name: str) -> Iterator[Complaint]:
    if not same_dimension(value.unit, wanted.value):
        found = f"'{value}' is not {wanted.spoken()}, as 'kind: {kind}' needs"
        message = f"{found}; write e.g. '{wanted.example()}'"
        yield Complaint(("output", name), message, (("output", "kind"),))


def _sign_complaints(output: Output) -> Iterator[Complaint]:
    uncertainty = output.scale_factor_uncertainty
    if uncertainty is not None and not 0 <= uncertainty.to("") < 1:
        yield Complaint(
            ("output", "scale_factor_uncertainty"), f"'{uncertainty}' is not from 0 % to below 100 %"
        )
    for name in ("full_scale", "bandwidth"):
        value: Quantity | None = getattr(output, name)
        if value is not None and value.value <= 0:
            yield Complaint(("output", name), f"'{value}' is not more than zero")


def _datasheet_complaints(datasheet: Mapping[str, Quantity]) -> Iterator[Complaint]:
    for name, value in datasheet.items():
        wanted = (
            Dimension.RATE if re.fullmatch("bias_stability_[0-9.]+[a-z]+", name) else DATASHEET.get(name)
        )
        if wanted is None:
            yield Complaint(("datasheet", name), unknown_measurand(name, list(DATASHEET)))
        elif not same_dimension(value.unit, wanted.value):
            message = f"'{value}' is not {wanted.spoken()}; write e.g. '{wanted.example()}'"
            yield Complaint(("datasheet", name), message)
