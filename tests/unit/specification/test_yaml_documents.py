"""YAML documents: what is read, with which lines, and what is refused at the door."""

import hashlib
import time
from pathlib import Path

import pytest

from gyrotest.errors import SpecError
from gyrotest.specification.yaml_document import LARGEST_BYTES, read_yaml


def written(folder: Path, content: str | bytes) -> Path:
    path = folder / "a.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def refusal(path: Path) -> str:
    with pytest.raises(SpecError) as refused:
        read_yaml(path, SpecError)
    return str(refused.value)


def test_scalars_are_read_by_the_core_rules(tmp_path: Path) -> None:
    text = "a: yes\nb: 1:30\nc: 2026-01-15\nd: 010\ne: 1e3\nf: '5'\ng: true\nh: ~\ni: .nan\nj: 0x1F\nk: 1e999\n"
    tree = read_yaml(written(tmp_path, text), SpecError).tree
    assert tree == {
        "a": "yes",
        "b": "1:30",
        "c": "2026-01-15",
        "d": 10,
        "e": 1000.0,
        "f": "5",
        "g": True,
        "h": None,
        "i": ".nan",
        "j": "0x1F",
        "k": "1e999",
    }


def test_every_key_and_item_has_its_line(tmp_path: Path) -> None:
    document = read_yaml(written(tmp_path, "a:\n  b:\n    - 1\n    - c: 2\n"), SpecError)
    assert document.lines[("a", "b")] == 2
    assert document.lines[("a", "b", 1)] == 4
    assert document.lines[("a", "b", 1, "c")] == 4
    assert document.fault(("a", "b", 1, "missing"), "x").line == 4
    assert str(document.fault(("a", "b", 1, "c"), "x")).endswith("a.yaml:4: a.b[1].c: x")


def test_the_hash_is_of_the_bytes_and_a_byte_order_mark_is_no_content(tmp_path: Path) -> None:
    plain = read_yaml(written(tmp_path, b"a: 1\r\n"), SpecError)
    marked = read_yaml(written(tmp_path, b"\xef\xbb\xbfa: 1\n"), SpecError)
    assert plain.tree == marked.tree
    assert plain.sha256 == hashlib.sha256(b"a: 1\r\n").hexdigest()
    assert plain.sha256 != marked.sha256


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("", "a.yaml:1: is empty"),
        ("# only a comment\n", "a.yaml:1: is empty"),
        ("- 1\n- 2\n", "a.yaml:1: holds a list; a mapping is expected"),
        ("just text\n", "a.yaml:1: holds the single value 'just text'"),
        (b"a: 1\nb: \xff\n", "a.yaml:2: byte 0xff is not UTF-8"),
        ("a: 1".encode("utf-16"), "not UTF-8"),
        ("a: 1\nb: \x00\n", "a.yaml:2: the character U+0000 is not allowed"),
        ("a:\n\tb: 1\n", "a.yaml:2: a tab stands where YAML allows only spaces"),
        ("a: b: c\n", "a.yaml:1: a second ': ' in one line"),
        ("a: 1\nb\n", "a line without ': '"),
        ("a: [1, 2\nb: 3\n", "is not YAML"),
        ("a: 'open\n", "is not YAML"),
        ("a: " + "[" * 50 + "]" * 50, "nested deeper than 20 levels"),
        ("a: " + "[" * 100_000, "nested deeper than 20 levels"),
        ("a: " + "x" * LARGEST_BYTES, f"larger than {LARGEST_BYTES // 1024} kB"),
    ],
)
def test_what_cannot_be_read_is_refused_with_its_line(
    tmp_path: Path, content: str | bytes, expected: str
) -> None:
    assert expected in refusal(written(tmp_path, content))


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path) -> None:
    assert refusal(tmp_path / "none.yaml").endswith("none.yaml: no such file")
    assert "is a folder" in refusal(tmp_path) or "cannot be read" in refusal(tmp_path)
    assert "cannot be read" in refusal(tmp_path / "a\0b")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a: 1\nb: 2\na: 3\n", "3: a: the key stands here twice (first in line 1)"),
        ("a: {b: 1, b: [1, 2]}\n", "1: a.b: the key stands here twice"),
        ("a: &x 1\nb: 2\n", "1: a: an anchor ('&x') is not allowed"),
        ("a: &x 1\nb: *x\n", "2: b: a reference ('*x') is not allowed"),
        ("a: &x {c: 1}\nb: {<<: *x}\n", "2: b.<<: a reference"),
        ("a: !!python/object:os.system x\n", "1: a: a tag ("),
        ("a: !!str 5\n", "1: a: a tag ("),
        ("a: 1\n---\nb: 2\n", "2: : a second document begins here"),
        ("? [1, 2]\n: 3\n", "1: : a key must be plain text"),
        ('a: "\\ud800"\n', "1: a: half of a surrogate pair"),
    ],
)
def test_what_is_ambiguous_or_hostile_is_a_fault(tmp_path: Path, text: str, expected: str) -> None:
    document = read_yaml(written(tmp_path, text), SpecError)
    faults = [f"{fault.line}: {fault.key}: {fault.message}" for _, fault in document.faults]
    assert any(fault.startswith(expected) for fault in faults), faults


def test_all_duplicates_are_told(tmp_path: Path) -> None:
    document = read_yaml(written(tmp_path, "a: 1\na: 2\nb: 1\nb: 2\nb: 3\n"), SpecError)
    assert [fault.line for _, fault in document.faults] == [2, 4, 5]


def test_a_billion_laughs_are_not_laughed(tmp_path: Path) -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 12)]
    began = time.process_time()
    with pytest.raises(
        SpecError, match=r"1: a0: an anchor .*; the same is true of 110 more below"
    ) as raised:
        read_yaml(written(tmp_path, "\n".join(lines)), SpecError)
    assert len(raised.value.faults) == 1
    assert time.process_time() - began < 2.0
