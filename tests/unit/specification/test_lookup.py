"""Names of specs and stations are found where they are looked for, in that order."""

from pathlib import Path

import pytest

from gyrotest.errors import SpecError, StationError
from gyrotest.specification.lookup import find_spec, find_station, shipped_specs


def test_a_path_is_taken_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    path.write_text("a: 1", encoding="utf-8")
    assert find_spec(str(path), ()) == path
    assert find_spec(str(path.with_suffix("")), ()) == path


def test_folders_come_in_turn_and_before_the_shipped_ones(tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    for folder in (first, second):
        folder.mkdir()
        (folder / "b.yml").write_text("a: 1", encoding="utf-8")
    (second / "mems50.yaml").write_text("a: 1", encoding="utf-8")
    assert find_spec("b", (first, second)) == first / "b.yml"
    assert find_spec("mems50.yaml", (first, second)) == second / "mems50.yaml"
    assert find_spec("mems50", (first,)) == shipped_specs() / "mems50.yaml"


def test_the_simulated_station_is_shipped() -> None:
    assert find_station("simulated", ()) == shipped_specs() / "stations" / "simulated.yaml"


def test_what_is_not_found_names_where_it_was_looked_for_and_what_is_near(tmp_path: Path) -> None:
    with pytest.raises(SpecError) as refused:
        find_spec("mems5", (tmp_path,))
    assert str(tmp_path) in str(refused.value)
    assert "did you mean 'mems50'?" in str(refused.value)
    with pytest.raises(StationError, match=r"no such station; .*34401a-gpib"):
        find_station("nowhere", ())


@pytest.mark.parametrize("name", ["", "..", "a" * 5000, "a\0b", "\x1b[31m"])
def test_a_hostile_name_is_not_found_and_not_printed_raw(name: str) -> None:
    with pytest.raises(SpecError) as refused:
        find_spec(name, ())
    assert str(refused.value).isprintable()
    assert len(str(refused.value)) < 1000
