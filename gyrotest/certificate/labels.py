"""Where the texts inside a plot stand: beside what they name, away from the curves and each other."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

_CHARACTER = 0.56  # mean width of a character, in font sizes
_HEIGHT = 1.25
_GAP = 4.0
_DISTANCES = (4.0, 8.0, 14.0, 20.0, 28.0, 36.0, 46.0)  # of a mark's text, the nearest is tried first
_SPACING = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A rectangle on the paper, y downwards."""

    left: float
    top: float
    width: float
    height: float

    def contains(self, points: NDArray[np.float64]) -> int:
        """Return how many points (n, 2) lie inside."""
        x, y = points[:, 0], points[:, 1]
        inside = (x >= self.left) & (x <= self.left + self.width)
        return int(np.count_nonzero(inside & (y >= self.top) & (y <= self.top + self.height)))

    def overlaps(self, other: "Box") -> bool:
        """Whether two rectangles share an area."""
        return (
            self.left < other.left + other.width
            and other.left < self.left + self.width
            and self.top < other.top + other.height
            and other.top < self.top + self.height
        )

    def outside(self, frame: "Box") -> bool:
        """Whether a part of it lies beyond the frame."""
        return (
            self.left < frame.left
            or self.top < frame.top
            or self.left + self.width > frame.left + frame.width
            or self.top + self.height > frame.top + frame.height
        )


@dataclass(slots=True)
class Layout:
    """The texts of one plot, placed one after another."""

    frame: Box
    font_size: float
    curves: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2)))
    taken: list[Box] = field(default_factory=list)

    def avoid(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> None:
        """Keep later texts away from a polyline."""
        self.curves = np.vstack((self.curves, dense(x, y)))

    def along(self, text: str, x: NDArray[np.float64], y: NDArray[np.float64]) -> Box:
        """Place the name of a curve beside it."""
        width, height = self._size(text)
        path = dense(x, y)
        rows = np.unique(np.linspace(0, len(path) - 1, 25).astype(int))
        places = [
            Box(left=left, top=top, width=width, height=height)
            for px, py in path[rows[::-1]]
            for left in (px - width, px - width / 2, px)
            for top in (py - height - 1.5, py + 1.5)
        ]
        return self._best(places)

    def around(self, text: str, x: float, y: float) -> Box:
        """Place the text of a mark around its point."""
        width, height = self._size(text)
        return self._best(
            Box(left=left, top=top, width=width, height=height)
            for distance in _DISTANCES
            for left in (x + distance, x - width - distance, x - width / 2)
            for top in (y - height - distance, y + distance, y - height / 2)
        )

    def corner(self, text: str) -> Box:
        """Place a note in the emptiest corner."""
        width, height = self._size(text)
        frame = self.frame
        return self._best(
            Box(left=left, top=top, width=width, height=height)
            for top in (frame.top + _GAP, frame.top + frame.height - height - _GAP)
            for left in (frame.left + frame.width - width - _GAP, frame.left + _GAP)
        )

    def _size(self, text: str) -> tuple[float, float]:
        return len(text) * _CHARACTER * self.font_size + 2, _HEIGHT * self.font_size

    def _best(self, places: Iterable[Box]) -> Box:
        best = min(places, key=self._cost)
        self.taken.append(best)
        return best

    def _cost(self, place: Box) -> float:
        hidden = sum(place.overlaps(other) for other in self.taken)
        return 1000.0 * place.outside(self.frame) + 100.0 * hidden + place.contains(self.curves)


def dense(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points (n, 2) along a polyline, at most a few points of paper apart."""
    if len(x) < 2:
        return np.column_stack((x, y))
    pieces = list(_pieces(x, y))
    return np.vstack((*pieces, [[x[-1], y[-1]]]))


def _pieces(x: NDArray[np.float64], y: NDArray[np.float64]) -> Iterator[NDArray[np.float64]]:
    counts = np.ceil(np.hypot(np.diff(x), np.diff(y)) / _SPACING).astype(int)
    for index, count in enumerate(np.maximum(counts, 1)):
        steps = np.arange(count) / count
        yield np.column_stack(
            (
                x[index] + steps * (x[index + 1] - x[index]),
                y[index] + steps * (y[index + 1] - y[index]),
            )
        )
