"""What the pages of a certificate say, and how the file is made."""

import dataclasses
import io
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from pypdf import PdfReader

from gyrotest.certificate import pdf
from gyrotest.certificate.csv import results_csv
from gyrotest.certificate.pdf import certificate_bytes, ensure_renderer, write_certificate
from gyrotest.certificate.record import record_bytes, record_sha256
from gyrotest.errors import CertificateError, RefusedError
from gyrotest.records.result import Verdict
from gyrotest.records.run import RunRecord
from gyrotest.records.station import Slot
from tests.unit.certificate import bench_records, records

Pages = Callable[[str], tuple[str, ...]]
Drawn = Callable[[str], bytes]
ALL = ["passing", "failing", "incomplete", "empty", "long_texts"]


def flat(text: str) -> str:
    return re.sub(r"\s+", " ", text)


@pytest.mark.parametrize("name", ALL)
def test_every_page_names_certificate_unit_hash_and_its_number(pages: Pages, name: str) -> None:
    record = getattr(records, name)()
    found = pages(name)
    digest = record_sha256(record_bytes(record))
    assert len(found) >= 2
    for number, text in enumerate(found, start=1):
        assert record.run_id in text
        assert record.serial_number in text.replace("\n", "")
        assert f"Record SHA-256 {digest[:16]}" in text
        assert f"Page {number} of {len(found)}" in text
        assert "reproduced in full" in text
    assert digest in "".join(found)
    assert flat(found[-1]).count("End of certificate") == 1


def test_certificate_shows_value_uncertainty_limits_and_verdict(pages: Pages) -> None:
    text = flat(pages("passing")[0])
    assert "✓ PASS" in text
    assert "22 of 22 limits met" in text
    assert "1 −0.2118 ± 0.0041 k = 2.06 −2 2 °/s ✓ PASS" in text
    assert "1 0.479 [0.465, 0.496] – 0.6 °/√h ✓ PASS" in text
    assert "3 ≤ 9.1 [7.5, 11.7] ✓ PASS" in text
    assert "1 0.525 [0.509, 0.543] – – °/√h info" in text
    assert "all 24 [12, 148] – 60 °/h ✓ PASS" in text
    assert "Göteborg" in text
    assert "Not conforming" not in text


def test_certificate_states_rule_uncertainty_equipment_and_hashes(pages: Pages) -> None:
    text = flat(" ".join(pages("passing")))
    assert "ILAC-G8:09/2019 4.2.1" in text
    assert "ILAC-G8:09/2019 4.2.2" in text
    assert "Applied to: Angle random walk." in text
    assert "Student's t for 95.45 %" in text
    assert "Not included: temperature of the unit" in text
    assert "integrated for 83.3 % of the time" in text
    assert "34401A US36012345 DMM-07 K-26-0981 2026-03-14 2027-03-14 SI, via RISE (SE)" in text
    assert "Combined standard uncertainty (k = 1) 0.0018" in text
    assert records.DIGEST in text
    assert "01" * 32 in text
    assert "Deviations from the plan: none." in text
    assert "Fig. 9" in text


@pytest.mark.parametrize("path", ["/home/a/specs/gyro.yaml", "C:\\specs\\gyro.yaml", "specs/gyro.yaml"])
def test_files_are_named_without_the_folders_they_lay_in(path: str) -> None:
    record = records.empty()
    spec = dataclasses.replace(record.header.spec, path=path)
    station = dataclasses.replace(record.header.station, path=path.replace("gyro", "bench"))
    header = dataclasses.replace(record.header, spec=spec, station=station)
    reader = PdfReader(io.BytesIO(certificate_bytes(dataclasses.replace(record, header=header))))
    text = flat(" ".join(page.extract_text() for page in reader.pages))
    assert "Spec gyro.yaml" in text
    assert "Station bench.yaml" in text
    assert "specs" not in text


def test_page_break_before_the_equipment_is_made_only_where_one_page_would_hold_all() -> None:
    record = records.empty()
    missing = tuple(f"item {n}: not started: {'a long reason, ' * 20}" for n in range(3))
    deviations = tuple(f"deviation {n}: {'of some length ' * 30}" for n in range(7))
    header = dataclasses.replace(record.header, deviations=deviations)
    crowded = dataclasses.replace(record, header=header, missing=missing)
    for one, broken in ((record, True), (crowded, False)):
        pages = [
            flat(page.extract_text()) for page in PdfReader(io.BytesIO(certificate_bytes(one))).pages
        ]
        assert len(pages) == 2
        assert ("Tested by" in pages[0]) == broken
        assert "Measuring equipment" in pages[1]


def test_failing_values_are_named_with_their_limits(pages: Pages) -> None:
    text = flat(pages("failing")[0])
    assert "✗ FAIL" in text
    assert "19 of 22 limits met" in text
    assert "Not conforming: Bias, repeat 2: 2.0003 ± 0.0041 °/s, limit −2 … 2 °/s;" in text
    assert "Allan minimum, repeat 2: 14.0 [11.5, 18.1] °/h, limit ≤ 12 °/h." in text
    assert "Inside by less than the uncertainty: Bias stability, 100 s, repeat 2" in text


def test_missing_items_attempts_and_gaps_are_named(pages: Pages) -> None:
    text = flat(" ".join(pages("incomplete")))
    assert "3 items missing" in text
    assert "bias_stability-r3: not started: interrupted by Ctrl-C" in text
    assert "no statement of conformity is made" in text
    assert "14 samples missing after sample 1207" in text
    assert "attempt 2 counts" in text
    assert "20261119T081000Z-MEMS50-1234 (FAIL)" in text
    assert "1411 of 3600 samples" in text


@pytest.mark.parametrize(
    ("name", "changes", "mark"),
    [
        ("incomplete", {}, "SIMULATED · INCOMPLETE"),
        ("empty", {}, "INCOMPLETE"),
        ("empty", {"verdict": Verdict.PASS, "simulated": True}, "SIMULATED"),
        ("empty", {"verdict": Verdict.PASS, "replayed": True}, "REPLAYED"),
    ],
)
def test_watermark_stands_on_every_page(name: str, changes: dict[str, object], mark: str) -> None:
    record = dataclasses.replace(getattr(records, name)(), **changes)
    found = PdfReader(io.BytesIO(certificate_bytes(record))).pages
    assert all(mark in flat(page.extract_text()) for page in found)


def test_a_measured_units_certificate_has_no_watermark(pages: Pages) -> None:
    assert not any(re.search("SIMULATED|REPLAYED|INCOMPLETE", text) for text in pages("passing"))


def test_special_characters_are_printed_as_they_are(pages: Pages) -> None:
    text = "".join(" ".join(pages("long_texts")).split())
    assert "<script>alert('x')</script>&\"quoted\"{{braces}}{%raw%}" in text


def test_control_characters_are_replaced() -> None:
    record = records.empty()
    header = dataclasses.replace(record.header, operator="A\x00\x1bB", meta={"x\x07": "y\x0c"})
    shown = PdfReader(io.BytesIO(certificate_bytes(dataclasses.replace(record, header=header))))
    assert "A\N{REPLACEMENT CHARACTER}\N{REPLACEMENT CHARACTER}B" in shown.pages[0].extract_text()


@pytest.mark.parametrize("verdict", list(Verdict))
def test_every_verdict_is_shown_in_words(verdict: Verdict) -> None:
    record = dataclasses.replace(records.empty(), verdict=verdict, missing=())
    text = PdfReader(io.BytesIO(certificate_bytes(record))).pages[0].extract_text()
    assert verdict.value.replace("_", " ") in flat(text)


def test_value_that_was_not_evaluated_is_no_number() -> None:
    record = records.passing()
    first = dataclasses.replace(
        record.results[0],
        value=None,
        expanded_uncertainty=None,
        coverage_factor=None,
        budget=(),
        verdict=Verdict.INCOMPLETE,
        reason="no gap-free stretch",
    )
    record = dataclasses.replace(record, verdict=Verdict.INCOMPLETE, results=(first,), items=())
    text = flat(PdfReader(io.BytesIO(certificate_bytes(record))).pages[0].extract_text())
    assert "– no gap-free stretch −2 2 °/s ⚠ INCOMPLETE" in text


def test_amended_certificate_names_what_it_replaces() -> None:
    record = dataclasses.replace(records.empty(), amends="20261101T000000Z-MEMS50-1234")
    text = PdfReader(io.BytesIO(certificate_bytes(record))).pages[0].extract_text()
    assert "this certificate replaces 20261101T000000Z-MEMS50-1234" in flat(text)


def test_overdue_and_unstated_calibrations_are_deviations() -> None:
    record = records.passing()
    document = record.header.station
    meter = document.station.instruments["meter"]
    assert meter.calibration is not None
    late = dataclasses.replace(meter.calibration, due=record.header.started_utc.date().replace(month=1))
    station = dataclasses.replace(
        document.station,
        instruments={
            "meter": dataclasses.replace(meter, calibration=late),
            "supply": dataclasses.replace(meter, calibration=None, asset=""),
            "neighbour": dataclasses.replace(meter, calibration=None, asset="ELSE-1"),
        },
        slots={
            "1": Slot(source="meter", supply="supply"),
            "2": Slot(source="neighbour"),
        },
    )
    spec = dataclasses.replace(record.header.spec.spec, supply=bench_records.supply())
    header = dataclasses.replace(
        record.header,
        station=dataclasses.replace(document, station=station),
        spec=dataclasses.replace(record.header.spec, spec=spec),
    )
    changed = dataclasses.replace(record, header=header, items=())
    reader = PdfReader(io.BytesIO(certificate_bytes(changed)))
    text = flat(" ".join(page.extract_text() for page in reader.pages))
    assert "instrument 'meter': calibration was due on 2026-01-21" in text
    assert "instrument 'supply': calibration not stated" in text
    assert "overdue" in text
    assert "not stated not stated not stated" in text
    assert "neighbour" not in text


def test_record_and_results_are_attached_byte_for_byte(drawn: Drawn) -> None:
    reader = PdfReader(io.BytesIO(drawn("passing")))
    record = records.passing()
    assert reader.attachments["run.json"] == [record_bytes(record)]
    assert reader.attachments["results.csv"] == [results_csv(record).encode()]


def test_metadata_come_from_the_record(drawn: Drawn) -> None:
    metadata = PdfReader(io.BytesIO(drawn("passing"))).metadata
    assert metadata is not None
    assert metadata.title == f"Test certificate {records.RUN_ID}"
    assert metadata.keywords == f"SHA-256 {record_sha256(record_bytes(records.passing()))}"
    assert metadata.creation_date == records.ISSUED
    assert metadata.modification_date == records.ISSUED


def test_file_declares_pdf_a_3u_and_embeds_its_fonts(drawn: Drawn) -> None:
    reader = PdfReader(io.BytesIO(drawn("passing")))
    xmp = reader.xmp_metadata
    assert xmp is not None
    assert b"<pdfaid:part>3" in xmp.stream.get_data() or b'pdfaid:part="3"' in xmp.stream.get_data()
    names = {
        str(font.get_object()["/BaseFont"])
        for page in reader.pages
        for font in page["/Resources"]["/Font"].values()
    }
    assert {name.partition("+")[2] for name in names} == {"Inter", "Inter-Semi-Bold"}


def test_same_record_gives_the_same_bytes(drawn: Drawn) -> None:
    assert certificate_bytes(records.incomplete()) == drawn("incomplete")


@pytest.mark.parametrize(
    "address",
    ["file:///etc/hostname", "http://127.0.0.1:9/x.png", "/etc/hostname", "font:Inter-Regular.ttf"],
)
@pytest.mark.parametrize(
    "page", ['<img src="{}">', '<link rel="stylesheet" href="{}">', "<style>@import url({});</style>"]
)
def test_page_cannot_load_anything_from_outside(page: str, address: str) -> None:
    with pytest.raises(CertificateError, match="outside itself"):
        pdf._typeset(page.format(address), identifier=b"")


def test_file_is_named_by_unit_time_and_verdict(tmp_path: Path) -> None:
    path = write_certificate(records.empty(), tmp_path)
    assert path == tmp_path / "1234_MEMS50_20261121T091205Z_INCOMPLETE.pdf"
    assert [one.name for one in tmp_path.iterdir()] == [path.name]


def test_no_certificate_is_ever_overwritten(tmp_path: Path) -> None:
    first = write_certificate(records.empty(), tmp_path)
    before = first.read_bytes()
    amended = dataclasses.replace(records.empty(), amends="another")
    names = [write_certificate(amended, tmp_path).name for _ in range(2)]
    assert names == [f"{first.stem}-2.pdf", f"{first.stem}-3.pdf"]
    assert first.read_bytes() == before


def named(record: RunRecord, model: str) -> RunRecord:
    return dataclasses.replace(record, model=model)


@pytest.mark.parametrize("model", ["../../etc/x", "A B/2\\C:*?", "…", "x" * 300, ""])
def test_model_cannot_lead_the_file_out_of_its_folder(tmp_path: Path, model: str) -> None:
    path = write_certificate(named(records.empty(), model), tmp_path)
    assert path.parent == tmp_path
    assert re.fullmatch(r"1234_[A-Za-z0-9.-]+_20261121T091205Z_INCOMPLETE\.pdf", path.name)
    assert len(path.name) < 200


def test_folder_that_cannot_be_written_is_an_error_of_one_line(tmp_path: Path) -> None:
    with pytest.raises(CertificateError, match="cannot be written") as caught:
        write_certificate(records.empty(), tmp_path / "missing")
    assert "\n" not in str(caught.value)


def test_renderer_is_found_where_the_tests_run() -> None:
    ensure_renderer()


def test_missing_libraries_are_refused_with_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> None:
        raise OSError("cannot load library 'libpango-1.0-0'")

    monkeypatch.setattr(pdf, "_loads", lambda *names: False)
    monkeypatch.setattr(pdf, "_weasyprint", missing)
    with pytest.raises(RefusedError, match=r"Pango is missing.*install"):
        ensure_renderer()
