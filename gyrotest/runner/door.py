"""The door: everything that can refuse a run before it starts, and the header that it starts with."""

import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, date, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from gyrotest.certificate.pdf import ensure_renderer
from gyrotest.certificate.record import read_record
from gyrotest.errors import CertificateError, RefusedError
from gyrotest.recordings.writer import check_free_space
from gyrotest.records.result import Verdict
from gyrotest.records.run import RunHeader
from gyrotest.records.spec import Spec, SpecDocument
from gyrotest.records.station import Station, StationDocument
from gyrotest.runner.fitness import check_fitness
from gyrotest.runner.folder import HEADER, RECORD, RunFolder
from gyrotest.runner.items import planned_case, planned_items
from gyrotest.runner.places import slots_of

_SERIAL_NUMBER = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")
_WINDOWS_DEVICE = re.compile(r"(?i)(con|prn|aux|nul|com[0-9]|lpt[0-9])(\..*)?")
_SOFTWARE = (
    "gyrotest",
    "pytest",
    "numpy",
    "scipy",
    "numba",
    "pyvisa",
    "pyvisa-py",
    "pyarrow",
    "weasyprint",
)
# A row of a recording, of which a temperature may stand beside each axis; and while segments become Parquet
# it is there twice. The rest is for what a batch costs beside its rows.
_BYTES_A_ROW, _BYTES_AN_AXIS, _SPARE = 17, 16, 1.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """What is asked for: by whom, of which units, on which bench, and where the results go."""

    spec: SpecDocument
    station: StationDocument
    serial_numbers: tuple[str, ...]
    out: Path
    operator: str = ""
    meta: Mapping[str, str] = field(default_factory=dict)
    command: str = ""
    one_after_another: bool = False


def check_order(order: Order) -> None:
    """Refuse what cannot end in a certificate; raises `RefusedError`."""
    for serial_number in order.serial_numbers:
        check_serial_number(serial_number, order.spec.spec.serial_pattern)
    _refuse_twice(order.serial_numbers)
    check_fitness(order.spec.spec, order.station.station)
    _check_slots(order)
    calibration_deviations(order.station.station, datetime.now(UTC).date())
    ensure_renderer()
    samples = sum(
        planned_case(name, order.spec.spec).plan.samples * case.repeats
        for name, case in order.spec.spec.cases.items()
    )
    _check_out(order.out)
    check_free_space(order.out, samples * len(order.serial_numbers) * _bytes_a_sample(order.spec.spec))


def _bytes_a_sample(spec: Spec) -> int:
    return round(2 * _SPARE * (_BYTES_A_ROW + _BYTES_AN_AXIS * max(len(spec.output.axes), 1)))


def check_serial_number(serial_number: str, pattern: str | None) -> None:
    """A serial number names folders and files: it is refused unless it is plain and matches the spec."""
    shown = serial_number if len(serial_number) <= 80 else f"{serial_number[:77]}…"
    if not _SERIAL_NUMBER.fullmatch(serial_number) or _WINDOWS_DEVICE.fullmatch(serial_number):
        raise RefusedError(
            f"serial number {shown!r}: accepted are 1 to 64 letters, digits, '.', '_' and '-', a letter or"
            " digit first, and no name that Windows keeps for a device"
        )
    if ".." in serial_number or serial_number.endswith("."):
        raise RefusedError(f"serial number {shown!r}: '..' and a full stop at the end are not accepted")
    if pattern is not None and not re.fullmatch(pattern, serial_number):
        raise RefusedError(
            f"serial number {shown!r} does not match the spec's serial_pattern '{pattern}'"
        )


def _refuse_twice(serial_numbers: Sequence[str]) -> None:
    folded = [one.casefold() for one in serial_numbers]
    for serial_number, name in zip(serial_numbers, folded, strict=True):
        if folded.count(name) > 1:
            raise RefusedError(
                f"serial number '{serial_number}' is given twice; each unit is tested once a run"
            )


def _check_slots(order: Order) -> None:
    slots = slots_of(order.spec.spec, order.station.station)
    if len(order.serial_numbers) > len(slots) and not order.one_after_another:
        raise RefusedError(
            f"{len(order.serial_numbers)} serial numbers, but station '{order.station.station.name}' has"
            f" {len(slots)} slot{'s' * (len(slots) != 1)} ({', '.join(slots)}): test fewer at once, add slots, or"
            " say --gyro-yes where the units are swapped between the runs"
        )


def calibration_deviations(station: Station, today: date) -> tuple[str, ...]:
    """Deviations that the calibration dates mean for the certificate; raises `RefusedError` if expired."""
    deviations = []
    for name, instrument in station.instruments.items():
        calibration = instrument.calibration
        if calibration is None or calibration.due >= today:
            continue
        fault = f"instrument '{name}' ({instrument.driver}): calibration {calibration.certificate} was due on"
        if not station.allow_expired_calibration:
            raise RefusedError(
                f"{fault} {calibration.due}: have it calibrated and enter the new dates, or set"
                " 'allow_expired_calibration: true' in the station, which the certificate then says"
            )
        deviations.append(
            f"{fault} {calibration.due}; used out of calibration by the station's permission."
        )
    return tuple(deviations)


def _check_out(out: Path) -> None:
    probe = out / ".gyrotest-write-check"
    try:
        out.mkdir(parents=True, exist_ok=True)
        probe.write_bytes(b"")
        probe.unlink()
    except OSError as error:
        raise RefusedError(
            f"{out}: the output folder cannot be written ({error.strerror}); give another with --gyro-out"
        ) from error


def open_run(order: Order, serial_number: str, slot: str) -> tuple[RunFolder, RunHeader]:
    """Make the run's folder and header for a serial number."""
    started = datetime.now(UTC)
    spec = order.spec.spec
    earlier = earlier_runs(order.out, serial_number, spec.model)
    folder = RunFolder.create(order.out, serial_number, spec.model, started)
    header = RunHeader(
        run_id=f"{folder.path.name}-{serial_number}",
        model=spec.model,
        serial_number=serial_number,
        started_utc=started,
        spec=order.spec,
        station=order.station,
        operator=order.operator,
        meta=order.meta,
        software=software_versions(),
        command=order.command,
        attempt=len(earlier) + 1,
        earlier_runs=earlier,
        deviations=calibration_deviations(order.station.station, started.date()),
        plan=planned_items(spec, serial_number),
        slot=slot,
    )
    folder.write_header(header)
    return folder, header


def reopen_run(order: Order, path: Path) -> tuple[RunFolder, RunHeader]:
    """Go on with an interrupted run of the same spec, serial number and station; raises `RefusedError`."""
    folder = RunFolder(path)
    try:
        header = folder.header()
    except CertificateError as error:
        raise RefusedError(f"--gyro-resume: {error}") from error
    for what, found, wanted in (
        ("serial number", header.serial_number, ", ".join(order.serial_numbers)),
        ("spec (SHA-256)", header.spec.sha256, order.spec.sha256),
        ("station (SHA-256)", header.station.sha256, order.station.sha256),
    ):
        if found != wanted:
            raise RefusedError(
                f"--gyro-resume: {path} was made with {what} {found}, now it is {wanted};"
                " a run goes on only with the same ones"
            )
    _refuse_ended(folder)
    now = datetime.now(UTC)
    note = f"Resumed on {now:%Y-%m-%d %H:%M:%S} UTC by '{order.command}'; what was acquired before was kept."
    again = calibration_deviations(order.station.station, now.date())
    header = replace(header, deviations=(*dict.fromkeys((*header.deviations, *again)), note))
    folder.write_header(header)
    return folder, header


def _refuse_ended(folder: RunFolder) -> None:
    try:
        verdict = read_record((folder.path / RECORD).read_bytes()).verdict
    except (OSError, CertificateError):
        return  # killed before, or while, it was written: it is put together anew
    if verdict is not Verdict.INCOMPLETE:
        raise RefusedError(
            f"--gyro-resume: {folder.path} has ended ({verdict.value.replace('_', ' ')}) and lacks nothing;"
            " start a new run, or make its certificate again with 'gyrotest report'"
        )


def earlier_runs(out: Path, serial_number: str, model: str) -> tuple[str, ...]:
    """The names of earlier runs of a serial number and model in the output folder."""
    found = []
    for path in sorted((out / serial_number).glob(f"*/{HEADER}")):
        try:
            header = RunFolder(path.parent).header()
        except CertificateError:
            found.append(f"{path.parent.name} (unreadable)")
            continue
        if header.model == model:
            found.append(path.parent.name)
    return tuple(found)


def software_versions() -> dict[str, str]:
    """Versions of what the figures depend on."""
    found = {"python": platform.python_version(), "system": f"{platform.system()} {platform.release()}"}
    for name in _SOFTWARE:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found
