"""Read-only arrays: whoever holds a record of them cannot change it for the others."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

_Kind = TypeVar("_Kind", bound=np.generic)


def fixed(array: NDArray[_Kind]) -> NDArray[_Kind]:
    """Return an array that was just made, read-only from now on."""
    array.setflags(write=False)
    return array
