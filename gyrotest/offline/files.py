"""Which files a name on the command line stands for: itself, or the recordings of a run's folder."""

from pathlib import Path

from gyrotest.errors import RecordingError
from gyrotest.recordings.layout import FOLDER, SEGMENT_SUFFIX

_SHOWN = 10


def files_of(path: Path) -> tuple[Path, ...]:
    """Return a file, or a recording's segments, as it is, and of a run's folder all its recordings.

    Raises `RecordingError` for any other folder, naming what is in it.
    """
    try:
        if not path.is_dir() or _holds_segments(path):
            return (path,)
        inside = path / FOLDER if (path / FOLDER).is_dir() else path
        found = _recordings(inside) if inside.name == FOLDER else ()
        held = _held(path)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror}") from error
    if not found:
        raise RecordingError(
            f"{path}: is a folder without recordings of gyrotest; name files in it, it holds {held}"
        )
    return found


def _recordings(folder: Path) -> tuple[Path, ...]:
    """Return the closed recordings, and the segments of those that never were closed."""
    closed = set(folder.glob("*.parquet"))
    open_ones = {
        one
        for one in folder.iterdir()
        if _holds_segments(one) and folder / f"{one.name}.parquet" not in closed
    }
    return tuple(sorted(closed | open_ones))


def _holds_segments(path: Path) -> bool:
    return path.is_dir() and any(path.glob(f"*{SEGMENT_SUFFIX}"))


def _held(folder: Path) -> str:
    names = sorted(one.name for one in folder.iterdir())
    return ", ".join(names[:_SHOWN]) + (", …" if len(names) > _SHOWN else "") if names else "nothing"
