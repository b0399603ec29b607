"""Whether a certificate, or a run's folder, still says what was recorded.

A certificate is drawn again from the record attached to it, and what its pages say is compared word
for word. That finds altered numbers; that nobody made record and certificate anew only a signature
can tell.
"""

import io
import logging
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING

from gyrotest.certificate.appendix import exports
from gyrotest.certificate.csv import results_csv
from gyrotest.certificate.pdf import RECORD_NAME, RESULTS_NAME, certificate_bytes
from gyrotest.certificate.record import read_record, record_sha256
from gyrotest.errors import CertificateError
from gyrotest.recordings.digest import sha256_of
from gyrotest.records.recording import Recording
from gyrotest.records.run import ExportedFile

if TYPE_CHECKING:
    from pypdf import PdfReader

_SHOWN = 60


def verify_pdf(path: Path) -> tuple[str, ...]:
    """Return what is wrong with a certificate; nothing where it is sound."""
    from pypdf.errors import PyPdfError

    logging.getLogger("pypdf").setLevel(logging.CRITICAL)  # what matters of it is told below
    # A damaged file makes the reader stumble in many ways.
    damage = (PyPdfError, OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError)
    try:
        return tuple(f"{path.name}: {complaint}" for complaint in _pdf_complaints(path.read_bytes()))
    except CertificateError as error:
        return (f"{path.name}: {error}",)
    except damage as error:
        return (f"{path.name}: cannot be read as a certificate: {error}",)


def verify_run(folder: Path) -> tuple[str, ...]:
    """Return what is wrong with a run's record, recordings, exported files and certificates."""
    place = folder / RECORD_NAME
    try:
        data = place.read_bytes()
        record = read_record(data)
    except (OSError, CertificateError) as error:
        return (f"{place}: {error}",)
    recordings = [one.recording for item in record.items for one in item.attempts if one.recording]
    root = folder if record.amends is None else folder.parent
    complaints = [
        found for recording in recordings for found in _recording_complaints(folder, root, recording)
    ]
    complaints += [found for one in exports(record) for found in _export_complaints(folder, one)]
    certificates = sorted(folder.glob("*.pdf"))
    for pdf in certificates:
        complaints += verify_pdf(pdf)
    if certificates and not any(_attached_to(pdf) == data for pdf in certificates):
        # A run that went on after an interruption has older certificates too, of its record then.
        names = ", ".join(pdf.name for pdf in certificates)
        complaints.append(f"{place}: no certificate has this record attached ({names})")
    return tuple(complaints)


def _pdf_complaints(content: bytes) -> Iterator[str]:
    from pypdf import PdfReader

    reader = PdfReader(io.BytesIO(content))
    data = _attached(reader, RECORD_NAME)
    if data is None:
        yield f"no {RECORD_NAME} is attached"
        return
    record = read_record(data)
    drawn = certificate_bytes(record, data)
    if drawn == content:
        return
    texts = [page.extract_text() for page in reader.pages]
    yield from _hash_complaints(reader, texts, record_sha256(data))
    if _attached(reader, RESULTS_NAME) != results_csv(record).encode():
        yield f"{RESULTS_NAME} differs from the attached record"
    again = PdfReader(io.BytesIO(drawn))
    yield from _page_complaints(reader, again)
    maker = record.header.software.get("gyrotest", "?")
    for complaint in _text_complaints(texts, [page.extract_text() for page in again.pages]):
        yield f"{complaint} (made by gyrotest {maker})"


def _attached(reader: "PdfReader", name: str) -> bytes | None:
    found = reader.attachments.get(name)
    return found[0] if found else None


def _hash_complaints(reader: "PdfReader", texts: list[str], digest: str) -> Iterator[str]:
    keywords = (reader.metadata.keywords if reader.metadata else None) or ""
    if digest not in keywords:
        yield f"the attached record's SHA-256 is {digest}, the metadata names '{keywords}'"
    if not any(digest in text for text in texts):
        yield f"the attached record's SHA-256 {digest} is not the one that is printed"


def _page_complaints(found: "PdfReader", expected: "PdfReader") -> Iterator[str]:
    if len(found.pages) != len(expected.pages):
        yield f"has {len(found.pages)} pages, the record gives {len(expected.pages)}"
    for number, (page, again) in enumerate(zip(found.pages, expected.pages, strict=False), start=1):
        if len(page.get("/Annots", ())) != len(again.get("/Annots", ())):
            yield f"page {number} carries annotations that the certificate does not have"


def _text_complaints(found: list[str], expected: list[str]) -> Iterator[str]:
    for number, (text, again) in enumerate(zip(found, expected, strict=False), start=1):
        if text != again:
            yield f"page {number} {_difference(text, again)}"


def _difference(found: str, expected: str) -> str:
    """Tell the first line that differs."""
    for ours, theirs in zip_longest(found.splitlines(), expected.splitlines(), fillvalue=""):
        if ours != theirs:
            return f"says '{ours[:_SHOWN]}' where the record gives '{theirs[:_SHOWN]}'"
    return "differs from the record"


def _recording_complaints(folder: Path, root: Path, recording: Recording) -> Iterator[str]:
    place = (folder / recording.path).resolve()
    if not place.is_relative_to(root.resolve()):
        yield f"{recording.path}: lies outside the run's folder"
    elif not place.exists():
        yield f"{recording.path}: the recording is missing"
    elif recording.sha256 is None:
        if recording.complete:
            yield f"{recording.path}: the record has no hash of it"
    else:
        digest = sha256_of(place)
        if digest != recording.sha256:
            yield f"{recording.path}: its SHA-256 is {digest}, the record says {recording.sha256}"


def _export_complaints(folder: Path, export: ExportedFile) -> Iterator[str]:
    place = (folder / export.path).resolve()
    if not place.is_relative_to(folder.resolve()):
        yield f"{export.path}: lies outside the run's folder"
    elif not place.is_file():
        yield f"{export.path}: the exported file is missing"
    elif (digest := sha256_of(place)) != export.sha256:
        yield f"{export.path}: its SHA-256 is {digest}, the record says {export.sha256}"


def _attached_to(pdf: Path) -> bytes | None:
    from pypdf import PdfReader
    from pypdf.errors import PyPdfError

    try:
        return _attached(PdfReader(pdf), RECORD_NAME)
    except (PyPdfError, OSError, ValueError):
        return None  # that it cannot be read has been said
