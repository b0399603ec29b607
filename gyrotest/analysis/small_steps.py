"""Small up-and-down steps: how much of each change of the input the output follows, and from where on.

A level is a size of the change. It is followed where the output gives at least half of what the scale
factor promises; noise is not to decide that, so that each level is followed, not followed, or undecided.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.interval import coverage_factor
from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]

HALF = 0.5
"""Share of the promised change that counts as followed."""

_CONFIDENCE = 0.95
_FEWEST = 3


class Followed(Enum):
    """Whether the output follows a change of the input."""

    YES = "yes"
    NO = "no"
    UNDECIDED = "undecided"


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """Share of a change that the output follows, its standard uncertainty and degrees of freedom."""

    share: float
    standard_uncertainty: float
    degrees_of_freedom: float

    @property
    def half_width(self) -> float:
        """Half of the 95 % interval."""
        factor = coverage_factor(self.degrees_of_freedom, coverage=_CONFIDENCE)
        return factor * self.standard_uncertainty

    @property
    def followed(self) -> Followed:
        """Whether at least half is followed: decided only where the whole 95 % interval is on one side."""
        if self.share - self.half_width >= HALF:
            return Followed.YES
        return Followed.NO if self.share + self.half_width < HALF else Followed.UNDECIDED


@dataclass(frozen=True, slots=True, kw_only=True)
class Level:
    """A size of the change, °/s, and the responses to changes up and down."""

    size_dps: float
    up: Response
    down: Response

    @property
    def followed(self) -> Followed:
        """Whether it is followed both ways: not, where it is not followed in one of them."""
        both = (self.up.followed, self.down.followed)
        if Followed.NO in both:
            return Followed.NO
        return Followed.YES if both == (Followed.YES, Followed.YES) else Followed.UNDECIDED

    @property
    def weaker(self) -> Response:
        """The smaller one of both responses."""
        return min((self.up, self.down), key=lambda one: one.share)


@dataclass(frozen=True, slots=True, kw_only=True)
class SmallestFollowed:
    """The smallest level that is followed and above which all are.

    `place` None: not even the largest is shown to be followed. `not_followed` is the place of the largest
    level that is shown not to be, None where there is none; levels between the two are undecided.
    """

    place: int | None
    not_followed: int | None


def smallest_followed(levels: Sequence[Level]) -> SmallestFollowed:
    """Find the smallest level that is followed, all above it being followed as well.

    Parameters
    ----------
    levels
        In rising order.

    Raises
    ------
    InsufficientDataError
        No level.

    Notes
    -----
    S3.9. By how a level is decided, noise alone makes a level pass that gives less than half no more than
    once in forty times; what it can do otherwise is to leave a level undecided, and the result larger.
    """
    if not levels:
        raise InsufficientDataError("no level was tried")
    place = len(levels)
    while place > 0 and levels[place - 1].followed is Followed.YES:
        place -= 1
    missed = [at for at, one in enumerate(levels) if one.followed is Followed.NO]
    return SmallestFollowed(
        place=place if place < len(levels) else None, not_followed=missed[-1] if missed else None
    )


def contrast(places: NDArray[np.int64], count: int) -> _Array:
    """Return weights (count,) of the mean change of some means from the mean of their two neighbours.

    Parameters
    ----------
    places
        Shape (k,): where the changed means stand in the row of all means; none at an end of it.
    count
        Means in the row.

    Notes
    -----
    The mean of the neighbours takes a linear drift out.
    """
    if not places.size or places.min() < 1 or places.max() > count - 2 or count < _FEWEST:
        raise InsufficientDataError("a change needs a mean before and one after it")
    weights = np.zeros(count)
    np.add.at(weights, places, 1.0 / places.size)
    for neighbour in (places - 1, places + 1):
        np.add.at(weights, neighbour, -0.5 / places.size)
    return weights
