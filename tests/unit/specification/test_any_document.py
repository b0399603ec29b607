"""Whatever stands in a document: it is a record or a list of complaints, never another exception."""

import json
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gyrotest.errors import SpecError, StationError
from gyrotest.specification.lookup import shipped_specs
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station

JUNK = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 10**30),
    st.floats(),
    st.sampled_from(
        ["", "x", "1 s", "-1 V", "0 deg/h", "static", "simulated", "yes", "\x00", "a: b", "☃"]
    ),
    st.text(max_size=5),
    st.lists(st.sampled_from([1, "1 s", None, [], {}]), max_size=4),
    st.dictionaries(
        st.sampled_from(["min", "max", "kind", "smoothing", "x", ""]), st.just("1 s"), max_size=3
    ),
)


def places(tree: Any, key: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    below = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    return [key, *(place for part, value in below for place in places(value, (*key, part)))]


def changed(tree: Any, key: tuple[Any, ...], value: Any) -> Any:
    if not key:
        return value
    copy = dict(tree) if isinstance(tree, dict) else list(tree)
    copy[key[0]] = changed(copy[key[0]], key[1:], value)
    return copy


def plain(path: Path) -> Any:
    # dates as text, as gyrotest reads them
    return json.loads(json.dumps(yaml.safe_load(path.read_text(encoding="utf-8")), default=str))


@pytest.mark.parametrize(
    "name", ["mems50.yaml", "stations/simulated.yaml", "stations/34401a-rs232.yaml"]
)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_changed_document_is_read_or_refused(tmp_path: Path, name: str, data: st.DataObject) -> None:
    tree = plain(shipped_specs() / name)
    for _ in range(data.draw(st.integers(1, 4))):
        tree = changed(tree, data.draw(st.sampled_from(places(tree))), data.draw(JUNK))
    path = tmp_path / "changed.yaml"
    path.write_text(json.dumps(tree, allow_nan=True), encoding="utf-8")
    load, error = (load_station, StationError) if "stations" in name else (load_spec, SpecError)
    faults = None
    try:
        load(path)
    except error as refused:
        faults = refused.faults
    assert faults is None or (faults and all(fault.line and fault.message for fault in faults))


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    content=st.one_of(
        st.binary(max_size=200), st.text(alphabet=":-{}[]&*!|>'\"#%@`?,\n\t abc01", max_size=80)
    )
)
def test_any_bytes_are_read_or_refused(tmp_path: Path, content: bytes | str) -> None:
    path = tmp_path / "any.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(SpecError) as refused:
        load_spec(path)
    assert refused.value.faults
