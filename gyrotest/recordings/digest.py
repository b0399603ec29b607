"""The SHA-256 of a recording: of the file, or of its segments one after the other."""

import hashlib
from pathlib import Path

from gyrotest.recordings.layout import SEGMENT_SUFFIX

_CHUNK = 1 << 20


def sha256_of(path: Path) -> str:
    """SHA-256 (hex) of a file, or of a folder's segments in their order (`cat *.arrows`)."""
    digest = hashlib.sha256()
    files = sorted(path.glob(f"*{SEGMENT_SUFFIX}")) if path.is_dir() else [path]
    for file in files:
        with file.open("rb") as stream:
            while chunk := stream.read(_CHUNK):
                digest.update(chunk)
    return digest.hexdigest()
