"""Names → files: specs and stations are found as paths, in the project's folders, among the shipped ones."""

import difflib
from collections.abc import Iterator, Sequence
from pathlib import Path

import gyrotest
from gyrotest.errors import DocumentError, Fault, SpecError, StationError

_SUFFIXES = ("", ".yaml", ".yml")


def shipped_specs() -> Path:
    """Return the folder of the specs that come with gyrotest, installed or in a checkout."""
    package = Path(gyrotest.__file__).parent
    installed = package / "specs"
    return installed if installed.is_dir() else package.parent / "specs"


def find_spec(name_or_path: str, folders: Sequence[Path]) -> Path:
    """Find a spec by its path or its name; raises `SpecError` with what was tried."""
    return _find(name_or_path, [*folders, shipped_specs()], "spec", SpecError)


def find_station(name_or_path: str, folders: Sequence[Path]) -> Path:
    """Find a station by its path or its name; raises `StationError` with what was tried."""
    return _find(name_or_path, [*folders, shipped_specs() / "stations"], "station", StationError)


def _find(name: str, folders: Sequence[Path], kind: str, error: type[DocumentError]) -> Path:
    for candidate in _candidates(name, folders):
        if _is_file(candidate):
            return candidate
    shown = "".join(letter if letter.isprintable() else "?" for letter in name[:100]) or "''"
    raise error([Fault(shown, None, "", _not_found(name, folders, kind))])


def _candidates(name: str, folders: Sequence[Path]) -> Iterator[Path]:
    if name:
        for place in (Path(), *folders):
            yield from (place / f"{name}{suffix}" for suffix in _SUFFIXES)


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name too long, or with a NUL in it, names no file
        return False


def _not_found(name: str, folders: Sequence[Path], kind: str) -> str:
    tried = ", ".join(dict.fromkeys(str(folder) for folder in (Path(), *folders)))
    known = sorted({path.stem for folder in folders for path in _yaml_files(folder)})
    near = difflib.get_close_matches(Path(name[:100]).stem.lower(), known, n=1)
    hint = f"did you mean '{near[0]}'?" if near else f"found there: {', '.join(known) or 'none'}"
    return f"no such {kind}; looked in {tried}, with and without .yaml; {hint}"


def _yaml_files(folder: Path) -> list[Path]:
    return [path for suffix in _SUFFIXES[1:] for path in folder.glob(f"*{suffix}")]
