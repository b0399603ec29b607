"""How a recording is laid out: names, columns, metadata and the checksum of a batch.

The header travels as JSON in the Arrow schema's metadata, of a segment and of the Parquet file.
"""

import json
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from datetime import datetime
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import RecordingError
from gyrotest.records.recording import Auxiliary, Dwell, Gap, Identity, RecordingHeader, Sampling

if TYPE_CHECKING:
    import pyarrow as pa

FORMAT = b"1"
FOLDER = "recordings"
SEGMENT_SUFFIX = ".arrows"
BATCH_ROWS = 65_536

FORMAT_KEY = b"gyrotest.format"
HEADER_KEY = b"gyrotest.recording"
METADATA_CRC_KEY = b"gyrotest.crc32"
SEGMENT_KEY = b"gyrotest.segment"
GAPS_KEY = b"gyrotest.gaps"
DWELLS_KEY = b"gyrotest.dwells"
CONTENT_KEY = b"content.gyrotest"

BATCH_ROW = b"row"
BATCH_UTC = b"utc"
BATCH_CRC = b"crc32"
BATCH_OUTCOME = b"outcome"


def recording_name(item: str, attempt: int) -> str:
    """The name of an attempt's recording, without a suffix."""
    return f"{item}-a{attempt}"


def recording_schema(header: RecordingHeader, extra: Mapping[bytes, bytes]) -> "pa.Schema":
    """The Arrow schema of a recording with its header and `extra` in the metadata."""
    import pyarrow as pa

    metadata = {FORMAT_KEY: FORMAT, HEADER_KEY: header_to_json(header), **extra}
    metadata[METADATA_CRC_KEY] = _metadata_crc(metadata)
    fields = [
        pa.field("index", pa.int64(), nullable=False),
        pa.field("time_s", pa.float64(), nullable=False),
    ]
    fields += [pa.field(name, pa.float64(), nullable=False) for name in header.sampling.columns]
    fields.append(pa.field("flags", pa.uint8(), nullable=False))
    return pa.schema(fields, metadata=metadata)


def batch_of(columns: Iterable[NDArray[Any]], schema: "pa.Schema") -> "pa.RecordBatch":
    """The columns as a batch, without a copy.

    `pa.array` and `to_numpy` load pandas on their first call, where that is installed: half a second,
    for which the first sample of a recording would have to wait.
    """
    import pyarrow as pa

    return pa.RecordBatch.from_arrays([_arrow(column) for column in columns], schema=schema)


def _arrow(column: NDArray[Any]) -> "pa.Array":
    import pyarrow as pa

    data = pa.py_buffer(np.ascontiguousarray(column))
    return pa.Array.from_buffers(
        pa.from_numpy_dtype(column.dtype), len(column), [None, data], null_count=0
    )


def columns_of(batch: "pa.RecordBatch") -> list[NDArray[Any]]:
    """The columns of a batch as arrays, without a copy; raises `RecordingError` on a null."""
    if any(column.null_count for column in batch.columns):
        raise RecordingError("a batch has empty cells, which gyrotest never writes")
    return [column.to_numpy(zero_copy_only=True) for column in batch.columns]


def checksum(columns: Iterable[NDArray[Any]], row: int, utc: str, outcome: str) -> int:
    """CRC-32 of a batch: its columns' bytes in their order, then `row utc outcome` as text."""
    crc = 0
    for column in columns:
        crc = zlib.crc32(np.ascontiguousarray(column).data, crc)
    return zlib.crc32(f"{row} {utc} {outcome}".encode(), crc)


def header_to_json(header: RecordingHeader) -> bytes:
    """The header as JSON."""
    plain = asdict(header) | {"started_utc": header.started_utc.isoformat(), "meta": dict(header.meta)}
    return json.dumps(plain, ensure_ascii=False, allow_nan=False, sort_keys=True).encode()


def header_from_metadata(metadata: Mapping[bytes, bytes] | None) -> RecordingHeader:
    """The header out of a schema's metadata; raises `RecordingError` if it is absent or damaged."""
    if not metadata or HEADER_KEY not in metadata:
        raise RecordingError("is no recording of gyrotest: its metadata hold no header")
    if metadata.get(FORMAT_KEY) != FORMAT:
        found = metadata.get(FORMAT_KEY, b"none").decode(errors="replace")
        raise RecordingError(f"has format {found}; this gyrotest reads format {FORMAT.decode()}")
    if metadata.get(METADATA_CRC_KEY) != _metadata_crc(metadata):
        raise RecordingError("its header is damaged: the checksum does not agree")
    return header_from_json(metadata[HEADER_KEY])


def _metadata_crc(metadata: Mapping[bytes, bytes]) -> bytes:
    """CRC-32 (hex) of gyrotest's other entries in the metadata, `key=value` in the keys' order."""
    ours = sorted(key for key in metadata if key.startswith(b"gyrotest.") and key != METADATA_CRC_KEY)
    return b"%08x" % zlib.crc32(b"\n".join(key + b"=" + metadata[key] for key in ours))


def header_from_json(text: bytes) -> RecordingHeader:
    """The header out of its JSON."""
    plain = json.loads(text)
    sampling = plain["sampling"]
    sampling |= {
        "channels": tuple(sampling["channels"]),
        "auxiliary": tuple(Auxiliary(**one) for one in sampling.get("auxiliary", ())),
        "offsets_s": tuple(sampling.get("offsets_s", ())),
    }
    return RecordingHeader(
        **plain
        | {
            "started_utc": datetime.fromisoformat(plain["started_utc"]),
            "sampling": Sampling(**sampling),
            "source": Identity(**plain["source"]),
        }
    )


def gaps_to_json(gaps: Iterable[Gap]) -> bytes:
    """Gaps as JSON, for the metadata."""
    return json.dumps([asdict(gap) for gap in gaps], ensure_ascii=False).encode()


def dwells_to_json(dwells: Iterable[Dwell]) -> bytes:
    """Steps that were carried out as JSON, for the metadata."""
    return json.dumps([asdict(dwell) for dwell in dwells], ensure_ascii=False).encode()


def dwells_from_json(text: bytes) -> tuple[Dwell, ...]:
    """Steps out of the metadata."""
    return tuple(Dwell(**dwell) for dwell in json.loads(text))


def gaps_from_json(text: bytes) -> tuple[Gap, ...]:
    """Gaps out of the metadata."""
    return tuple(Gap(**gap) for gap in json.loads(text))
