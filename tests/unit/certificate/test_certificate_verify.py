"""An altered certificate, record or recording is found, and the place is named."""

import dataclasses
import hashlib
import io
from collections.abc import Callable
from pathlib import Path

import pytest
from pypdf import PdfReader, PdfWriter
from pypdf.annotations import FreeText
from pypdf.generic import NameObject, StreamObject

from gyrotest.certificate.pdf import certificate_bytes, write_certificate
from gyrotest.certificate.record import record_bytes
from gyrotest.certificate.verify import verify_pdf, verify_run
from gyrotest.records.result import Verdict
from gyrotest.records.run import ExportedFile, RunRecord
from tests.unit.certificate import records

Drawn = Callable[[str], bytes]


@pytest.fixture
def sound(tmp_path: Path, drawn: Drawn) -> Path:
    path = tmp_path / "certificate.pdf"
    path.write_bytes(drawn("empty"))
    return path


def rewritten(path: Path, change: Callable[[PdfWriter], object]) -> tuple[str, ...]:
    writer = PdfWriter(clone_from=io.BytesIO(path.read_bytes()))
    change(writer)
    writer.write(path)
    return verify_pdf(path)


def test_sound_certificate_has_no_complaint(sound: Path) -> None:
    assert verify_pdf(sound) == ()


def test_resaved_certificate_with_the_same_words_has_no_complaint(sound: Path) -> None:
    before = sound.read_bytes()
    assert rewritten(sound, lambda writer: None) == ()
    assert sound.read_bytes() != before


def test_altered_visible_number_is_found(sound: Path) -> None:
    """A page of a unit that passes is put around the record of one that did not."""
    worse = records.empty()
    items = tuple(dataclasses.replace(one, missing="") for one in worse.items)
    better = dataclasses.replace(worse, verdict=Verdict.PASS, missing=(), items=items)
    passing = PdfReader(io.BytesIO(certificate_bytes(better)))

    def forge(writer: PdfWriter) -> None:
        page = writer.pages[0]
        stream = StreamObject()
        stream.set_data(passing.pages[0].get_contents().get_data())
        page[NameObject("/Contents")] = writer._add_object(stream)
        page[NameObject("/Resources")] = passing.pages[0]["/Resources"].clone(writer)

    complaints = rewritten(sound, forge)
    assert len(complaints) == 1
    assert complaints[0].startswith("certificate.pdf: page 1 says '✓ PASSno limit judged'")
    assert "where the record gives '⚠ INCOMPLETE" in complaints[0]


def test_text_laid_over_a_page_is_found(sound: Path) -> None:
    note = FreeText(text="PASS", rect=(400, 700, 500, 750))
    complaints = rewritten(sound, lambda writer: writer.add_annotation(0, note))
    assert any("page 1 carries annotations" in one for one in complaints)


def test_removed_page_is_found(sound: Path) -> None:
    complaints = rewritten(sound, lambda writer: writer.remove_page(1))
    assert any("has 1 pages, the record gives 2" in one for one in complaints)


def test_exchanged_record_is_found(sound: Path) -> None:
    forged = record_bytes(dataclasses.replace(records.empty(), verdict=Verdict.PASS))

    def exchange(writer: PdfWriter) -> None:
        for attachment in writer.attachment_list:
            if attachment.name == "run.json":
                attachment.content = forged

    complaints = " ".join(rewritten(sound, exchange))
    assert "the metadata names" in complaints
    assert "is not the one that is printed" in complaints
    assert "page 1 says" in complaints


@pytest.mark.parametrize("content", [b"", b"%PDF-1.7\n", b"no certificate at all" * 100])
def test_what_is_no_pdf_is_one_complaint(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "broken.pdf"
    path.write_bytes(content)
    assert len(verify_pdf(path)) == 1
    assert len(verify_pdf(tmp_path / "missing.pdf")) == 1


def test_pdf_without_a_record_is_a_complaint(tmp_path: Path) -> None:
    writer = PdfWriter()
    writer.add_blank_page(100, 100)
    writer.write(tmp_path / "blank.pdf")
    assert verify_pdf(tmp_path / "blank.pdf") == ("blank.pdf: no run.json is attached",)


def with_recordings(folder: Path) -> RunRecord:
    """A run's folder with a small file in the place of each recording."""
    (folder / "recordings").mkdir(parents=True)
    record = records.incomplete()
    items = []
    for item in record.items:
        attempts = []
        for attempt in item.attempts:
            assert attempt.recording is not None
            content = f"{attempt.item} {attempt.number}".encode()
            name = f"recordings/{attempt.item}-{attempt.number}.parquet"
            (folder / name).write_bytes(content)
            kept = dataclasses.replace(
                attempt.recording, path=name, sha256=hashlib.sha256(content).hexdigest()
            )
            attempts.append(dataclasses.replace(attempt, recording=kept, figures=()))
        items.append(dataclasses.replace(item, attempts=tuple(attempts)))
    record = dataclasses.replace(record, items=tuple(items))
    (folder / "run.json").write_bytes(record_bytes(record))
    return record


def test_sound_run_has_no_complaint(tmp_path: Path) -> None:
    record = with_recordings(tmp_path / "run")
    write_certificate(record, tmp_path / "run")
    assert verify_run(tmp_path / "run") == ()


def test_altered_and_lost_recordings_are_found(tmp_path: Path) -> None:
    with_recordings(tmp_path)
    (tmp_path / "recordings/bias_stability-r1-1.parquet").write_bytes(b"altered")
    (tmp_path / "recordings/bias_stability-r2-2.parquet").unlink()
    altered, lost = verify_run(tmp_path)
    assert altered.startswith("recordings/bias_stability-r1-1.parquet: its SHA-256 is")
    assert lost == "recordings/bias_stability-r2-2.parquet: the recording is missing"


def test_recording_outside_the_folder_is_not_read(tmp_path: Path) -> None:
    record = with_recordings(tmp_path / "run")
    attempt = record.items[0].attempts[0]
    assert attempt.recording is not None
    (tmp_path / "elsewhere").write_bytes(b"")
    moved = dataclasses.replace(attempt.recording, path="../elsewhere")
    item = dataclasses.replace(
        record.items[0], attempts=(dataclasses.replace(attempt, recording=moved),)
    )
    changed = dataclasses.replace(record, items=(item, *record.items[1:]))
    (tmp_path / "run/run.json").write_bytes(record_bytes(changed))
    assert verify_run(tmp_path / "run") == ("../elsewhere: lies outside the run's folder",)


def with_export(record: RunRecord, path: str, content: bytes) -> RunRecord:
    export = ExportedFile(path=path, sha256=hashlib.sha256(content).hexdigest())
    attempt = dataclasses.replace(record.items[0].attempts[0], exports=(export,))
    item = dataclasses.replace(record.items[0], attempts=(attempt,))
    return dataclasses.replace(record, items=(item, *record.items[1:]))


def test_altered_and_lost_exported_files_are_found(tmp_path: Path) -> None:
    record = with_export(with_recordings(tmp_path), "exports/compensation.json", b"{}")
    (tmp_path / "run.json").write_bytes(record_bytes(record))
    assert verify_run(tmp_path) == ("exports/compensation.json: the exported file is missing",)
    (tmp_path / "exports").mkdir()
    (tmp_path / "exports/compensation.json").write_bytes(b"{}")
    assert verify_run(tmp_path) == ()
    (tmp_path / "exports/compensation.json").write_bytes(b"{ }")
    (complaint,) = verify_run(tmp_path)
    assert complaint.startswith("exports/compensation.json: its SHA-256 is")


def test_exported_file_outside_the_folder_is_not_read(tmp_path: Path) -> None:
    record = with_export(with_recordings(tmp_path / "run"), "../elsewhere", b"x")
    (tmp_path / "elsewhere").write_bytes(b"x")
    (tmp_path / "run/run.json").write_bytes(record_bytes(record))
    assert verify_run(tmp_path / "run") == ("../elsewhere: lies outside the run's folder",)


def test_record_that_is_not_the_attached_one_is_found(tmp_path: Path) -> None:
    record = with_recordings(tmp_path)
    path = write_certificate(record, tmp_path)
    (tmp_path / "run.json").write_bytes(record_bytes(dataclasses.replace(record, simulated=False)))
    (complaint,) = verify_run(tmp_path)
    assert complaint.endswith(f"no certificate has this record attached ({path.name})")


def test_an_older_certificate_beside_the_newest_is_sound(tmp_path: Path) -> None:
    record = with_recordings(tmp_path)
    write_certificate(dataclasses.replace(record, verdict=Verdict.INCOMPLETE), tmp_path)
    write_certificate(record, tmp_path)
    (tmp_path / "run.json").write_bytes(record_bytes(record))
    assert verify_run(tmp_path) == ()


def test_an_incomplete_recording_is_a_folder_of_segments(tmp_path: Path) -> None:
    record = with_recordings(tmp_path)
    attempt = record.items[0].attempts[0]
    assert attempt.recording is not None
    folder = tmp_path / "recordings" / "interrupted"
    folder.mkdir()
    (folder / "0000.arrows").write_bytes(b"begun")
    kept = dataclasses.replace(
        attempt.recording,
        path="recordings/interrupted",
        complete=False,
        sha256=hashlib.sha256(b"begun").hexdigest(),
    )
    attempts = (dataclasses.replace(attempt, recording=kept),)
    item = dataclasses.replace(record.items[0], attempts=attempts)
    changed = dataclasses.replace(record, items=(item, *record.items[1:]))
    (tmp_path / "run.json").write_bytes(record_bytes(changed))
    assert verify_run(tmp_path) == ()
    (folder / "0000.arrows").write_bytes(b"other")
    (complaint,) = verify_run(tmp_path)
    assert "recordings/interrupted: its SHA-256 is" in complaint


def test_folder_without_a_record_is_a_complaint(tmp_path: Path) -> None:
    (complaint,) = verify_run(tmp_path)
    assert "run.json" in complaint
