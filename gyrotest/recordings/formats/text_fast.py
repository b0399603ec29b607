"""The fast way through a clean text table, by pyarrow, block by block."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.recordings.formats.selection import Content, Part
from gyrotest.recordings.formats.text_blank import blank_between_rows
from gyrotest.recordings.formats.text_head import MISSING, TextHead

_BLOCK_BYTES = 1 << 21
_NULLS = sorted(
    {form for marker in MISSING for form in (marker, marker.upper(), marker.title())} | {"NaN"}
)
# A separator that no text has: the whole line is the one cell.
_NONE = "\x1f"


def is_clean(path: Path, head: TextHead) -> bool:
    """Whether pyarrow can be asked: no UTF-16, one separator between cells, no blank line it would skip."""
    return (
        head.encoding != "utf-16"
        and (head.separator is not None or len(head.names) == 1)
        and not blank_between_rows(path, data_line=head.data_line, block_bytes=_BLOCK_BYTES)
    )


class FastText:
    """One pass. `rows` were read and given out; unless `finished`, the rest is for another way."""

    def __init__(
        self,
        path: Path,
        head: TextHead,
        values: tuple[int, ...],
        time: int | None,
        where: tuple[tuple[int, tuple[Content, ...]], ...],
    ) -> None:
        self.rows = 0
        self.finished = False
        self._path, self._head, self._where = path, head, where
        self._values, self._time = values, time

    def parts(self) -> Iterator[Part]:
        """Yield rows until the end, or until a row that pyarrow does not take as it is."""
        import pyarrow as pa

        try:
            with self._open() as reader:
                for batch in reader:
                    if self._has_comment(batch):
                        return
                    yield self._part(batch)
            self.finished = True
        except (pa.ArrowException, StopIteration):
            return

    def _open(self) -> Any:
        import pyarrow as pa
        from pyarrow import csv

        numbers = set(self._values) if self._time is None else {*self._values, self._time}
        texts = {at for at, _ in self._where} | ({0} - numbers)
        types = {f"f{at}": pa.string() for at in texts} | {
            f"f{at}": pa.float64() for at in numbers - texts
        }
        return csv.open_csv(
            self._path,
            read_options=csv.ReadOptions(
                use_threads=False,
                block_size=_BLOCK_BYTES,
                skip_rows=self._head.data_line - 1,
                autogenerate_column_names=True,
            ),
            parse_options=csv.ParseOptions(delimiter=self._head.separator or _NONE),
            convert_options=csv.ConvertOptions(
                check_utf8=False,
                column_types=types,
                include_columns=sorted(types),
                null_values=_NULLS,
                decimal_point=self._head.decimal,
            ),
        )

    def _has_comment(self, batch: Any) -> bool:
        """Whether a row is a comment (its first cell, if it is not read as a number, shows it)."""
        import pyarrow as pa
        import pyarrow.compute as pc

        first = batch.column("f0") if "f0" in batch.schema.names else None
        if first is None or not pa.types.is_string(first.type):
            return False
        return bool(pc.any(pc.match_substring_regex(first, r"^\s*[%#]")).as_py())

    def _part(self, batch: Any) -> Part:
        numbers = np.arange(self.rows, self.rows + batch.num_rows, dtype=np.int64)
        values, *beside = (_floats(batch.column(f"f{at}")) for at in self._values)
        part = Part(
            row=numbers,
            values=values,
            time=None if self._time is None else _floats(batch.column(f"f{self._time}")),
            beside=tuple(beside),
        )
        self.rows += batch.num_rows
        return part.kept(self._kept(batch)) if self._where else part

    def _kept(self, batch: Any) -> Any:
        import pyarrow as pa
        import pyarrow.compute as pc

        keep: NDArray[np.bool_] = np.ones(batch.num_rows, dtype=bool)
        for at, contents in self._where:
            cells = batch.column(f"f{at}")
            texts = [one for one in contents if isinstance(one, str)]
            numbers = {float(one) for one in contents if not isinstance(one, str)}
            trimmed = pc.utf8_trim_whitespace(cells)
            found = pc.is_in(trimmed, value_set=pa.array(texts, pa.string()), skip_nulls=True)
            accepted = found.to_numpy(zero_copy_only=False)
            if numbers:
                accepted = accepted | np.array(
                    [self._head.number(cell) in numbers for cell in cells.to_pylist()], dtype=bool
                )
            keep &= accepted
        return keep


def _floats(column: Any) -> NDArray[np.float64]:
    import pyarrow as pa

    floats: NDArray[np.float64] = column.cast(pa.float64()).to_numpy(zero_copy_only=False)
    return floats
