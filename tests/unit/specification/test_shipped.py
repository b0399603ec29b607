"""The shipped specs and stations are good, and the page of all keys is up to date."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from gyrotest.errors import DocumentError
from gyrotest.specification.check import check_file
from gyrotest.specification.lookup import shipped_specs
from gyrotest.specification.schema import DIALECT, json_schema, reference_markdown
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station

STATIONS = sorted((Path(__file__).parents[3] / "specs" / "stations").glob("*.yaml"))


def test_mems50_is_a_good_spec() -> None:
    spec = load_spec(shipped_specs() / "mems50.yaml").spec
    case = spec.cases["bias_stability"]
    assert (case.duration.to("s"), case.interval.to("s"), case.repeats) == (3600.0, 1.0, 3)
    assert set(case.limits) == {
        "bias",
        "bias_stability_1s",
        "bias_stability_10s",
        "bias_stability_100s",
        "allan_minimum",
        "bias_instability_coefficient",
        "angle_random_walk",
        "bias_run_to_run",
    }


@pytest.mark.parametrize("path", STATIONS, ids=lambda path: path.stem)
def test_every_shipped_station_is_good(path: Path) -> None:
    assert load_station(path).station.name


def test_the_stations_that_are_promised_are_there() -> None:
    names = {"simulated", "34401a-gpib", "34401a-rs232", "34401a-prologix", "34465a-lan", "replay"}
    assert names <= {path.stem for path in STATIONS}


@pytest.mark.parametrize("document", ["spec", "station"])
def test_the_schema_is_closed_described_and_plain_json(document: Any) -> None:
    schema = json_schema(document)
    assert schema["$schema"] == DIALECT
    assert json.loads(json.dumps(schema)) == schema
    for record in (schema, *schema["$defs"].values()):
        if "properties" in record:
            assert record["additionalProperties"] is False
    for name in ("Case", "Limit", "Output", "Instrument", "Slot", "Station"):
        for key, place in schema["$defs"].get(name, {}).get("properties", {}).items():
            assert place.get("description"), f"{name}.{key}"


def test_the_schemas_pattern_takes_the_shipped_quantities() -> None:
    place = json_schema("spec")["$defs"]["Case"]["properties"]["duration"]
    for text in ("1 h", "10min", "0.5 °", "35 %", "3 µs", "1e-3 √h", "1 (s)"):
        assert re.search(place["pattern"], text), text
    for text in ("1", "s", "3,5 s", "nan s", "1 ; s"):
        assert not re.search(place["pattern"], text), text


def test_the_procedure_chooses_what_its_parameters_may_hold() -> None:
    case = json_schema("spec")["$defs"]["Case"]
    assert "static" in case["properties"]["procedure"]["enum"]
    then = {one["if"]["properties"]["procedure"]["const"]: one["then"] for one in case["allOf"]}
    assert then["static"]["properties"]["parameters"] == {"$ref": "#/$defs/static.parameters"}


def test_the_page_of_all_keys_is_up_to_date() -> None:
    page = Path(__file__).parents[3] / "docs" / "spec-reference.md"
    made = reference_markdown()
    assert page.read_text(encoding="utf-8") == made, (
        "make it again: gyrotest schema reference > docs/spec-reference.md"
    )


@pytest.mark.parametrize("page", ["specs.md", "stations.md"])
def test_the_documents_in_the_docs_are_good(page: str, tmp_path: Path) -> None:
    text = (Path(__file__).parents[3] / "docs" / page).read_text(encoding="utf-8")
    whole = [
        one
        for one in re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)
        if "slots:" in one or "cases:\n  rest" in one
    ]
    assert whole
    for number, example in enumerate(whole):
        path = tmp_path / f"{number}.yaml"
        path.write_text(example, encoding="utf-8")
        if page == "specs.md":
            load_spec(path)
        else:
            load_station(path)


def test_the_fragments_of_the_spec_page_make_a_spec(tmp_path: Path) -> None:
    text = (Path(__file__).parents[3] / "docs" / "specs.md").read_text(encoding="utf-8")
    head, cases, limits = re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)[1:4]
    path = tmp_path / "whole.yaml"
    path.write_text(head + cases + limits, encoding="utf-8")
    assert set(load_spec(path).spec.cases["bias_stability"].limits) >= {"bias", "bias_run_to_run"}


def test_a_file_is_checked_as_what_it_is(tmp_path: Path) -> None:
    assert check_file(shipped_specs() / "mems50.yaml") == "a good spec of MEMS50 (1 case)"
    station = shipped_specs() / "stations" / "replay.yaml"
    assert check_file(station) == "a good station, 'Replay' (1 instrument)"
    path = tmp_path / "a.yaml"
    for text, expected in (
        ("colour: red\n", "a.yaml:1: is neither a spec"),
        ("model: x\n", "output: is missing"),
        ("name: x\nslots: {}\n", "instruments: is missing"),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(DocumentError) as refused:
            check_file(path)
        assert expected in str(refused.value)
