"""A segment: one Arrow IPC stream file to which batches are appended and flushed at once."""

import io
import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pyarrow as pa


class Segment:
    """An open segment. A batch that cannot be written whole is taken back, the ones before stay."""

    def __init__(self, path: Path, schema: "pa.Schema") -> None:
        import pyarrow as pa

        self.path = path
        self._file = path.open("xb", buffering=0)
        self._whole_bytes = 0
        self._spool = io.BytesIO()
        self._stream = pa.ipc.new_stream(pa.PythonFile(self._spool, mode="w"), schema)

    def append(self, batch: "pa.RecordBatch", metadata: dict[bytes, bytes]) -> None:
        """Write a batch and hand it to the operating system; raises `OSError`."""
        self._stream.write_batch(batch, custom_metadata=metadata)
        self._drain()

    def sync(self) -> None:
        """Have the operating system put everything on the disk."""
        os.fsync(self._file.fileno())

    def finish(self) -> None:
        """End the stream properly and put it on the disk; raises `OSError`."""
        self._stream.close()
        self._drain()
        self.sync()
        self._file.close()

    def abandon(self) -> None:
        """Close the file as it is."""
        self._file.close()

    def _drain(self) -> None:
        data = self._spool.getbuffer()
        try:
            self._write(data)
        except OSError:
            self._file.truncate(self._whole_bytes)
            self._file.seek(self._whole_bytes)
            raise
        finally:
            data.release()
            self._spool.seek(0)
            self._spool.truncate()

    def _write(self, data: memoryview) -> None:
        written = 0
        while written < len(data):
            written += self._file.write(data[written:]) or 0
        self._whole_bytes += written


def sync_folder(folder: Path) -> None:
    """Put a folder's entries on the disk, where the system can (not on Windows)."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
