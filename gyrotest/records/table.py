"""Tables: what a procedure wants printed in rows, its numbers unrounded."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A column: its heading, its share of the width, and whether numbers stand in it."""

    heading: str
    share: float = 1.0
    numbers: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """A text, or a number that is rounded for print as its 95 % interval asks.

    `at_most`: the number is an upper bound (printed with ≤), `at_least`: a lower one (≥). `digits` asks
    for so many significant digits instead. With `interval` the interval is printed and the number is not.
    """

    text: str = ""
    value: float | None = None
    lower_95: float | None = None
    upper_95: float | None = None
    at_most: bool = False
    at_least: bool = False
    interval: bool = False
    digits: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Rows of as many cells as there are columns, and sentences beneath them."""

    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""
    sentences: tuple[str, ...] = ()
