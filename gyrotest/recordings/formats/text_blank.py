"""Blank lines between the rows of a text table: a row may be missing there."""

import re
from pathlib import Path

_BLANK = re.compile(rb"\n[ \r]*\n")
_WHITE = b" \r\n"


def blank_between_rows(path: Path, *, data_line: int, block_bytes: int) -> bool:
    """Whether a blank line stands before the last row of data; `data_line` counts from 1.

    A search of the bytes, for readers that skip blank lines without a word.
    """
    with path.open("rb") as stream:
        for _ in range(data_line - 1):
            stream.readline()
        rest = b""
        while block := stream.read(block_bytes):
            text = rest + block
            # White space at the end of a block is looked at with what follows, or is the file's end.
            end = len(text.rstrip(_WHITE))
            if _BLANK.search(text, 0, end):
                return True
            rest = text[end:]
    return False
