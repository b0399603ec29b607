"""One run owns a bench: a machine-wide lock for each resource, naming its owner."""

import getpass
import hashlib
import os
import tempfile
from collections.abc import Iterable
from contextlib import ExitStack, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from gyrotest.errors import RefusedError


class ResourceLocks:
    """Locks held until `release`; a second process is refused with the owner's name."""

    def __init__(self, owner: str) -> None:
        self._owner = f"{owner} (process {os.getpid()}, user {_user()})"
        self._held = ExitStack()

    def acquire(self, resources: Iterable[str]) -> None:
        """Lock every resource; raises `RefusedError` and releases all if one is taken."""
        folder = Path(tempfile.gettempdir()) / "gyrotest-locks"
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise RefusedError(f"{folder}: locks cannot be made there ({error.strerror})") from error
        with suppress(OSError):  # it is another user's, who has opened it to all
            folder.chmod(0o777)
        for resource in sorted(set(resources)):
            self._acquire_one(folder, resource)

    def _acquire_one(self, folder: Path, resource: str) -> None:
        name = hashlib.sha256(resource.strip().upper().encode()).hexdigest()[:24]
        lock = FileLock(folder / f"{name}.lock", timeout=0, mode=0o666)
        owner_file = folder / f"{name}.owner"
        try:
            self._held.enter_context(lock)
        except Timeout:
            self.release()
            owner = _read(owner_file)
            raise RefusedError(
                f"{resource}: already owned by {owner}; wait for it to end, or use another station"
            ) from None
        except OSError as error:
            self.release()
            raise RefusedError(
                f"{folder}: the lock of {resource} cannot be made ({error.strerror})"
            ) from error
        _write(owner_file, self._owner)

    def release(self) -> None:
        """Give everything back."""
        self._held.close()


def _write(path: Path, text: str) -> None:
    """Replace a file that may be another user's; the lock holds without it."""
    aside = path.with_name(f"{path.name}.{os.getpid()}")
    with suppress(OSError):
        aside.write_text(text, encoding="utf-8")
        aside.replace(path)


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8").strip() or "another run"
    except OSError:
        return "another run"


def _user() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError):
        return "unknown"
