"""How a unit lies on a rotation stage: its own axes in those of the stage.

The stage's axes are x, horizontal at angle 0; y, along the level shaft; z, up at angle 0.
"""

import math
from collections.abc import Iterable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InsufficientDataError

AXES = ("x", "y", "z")
SHAFT = 1
"""Place of the stage axis that lies along the shaft."""

_SAME = 1e-9
_Array = NDArray[np.float64]


def own_axes(frame: Mapping[str, str], sensitive_axis: str, turned_deg: float) -> _Array:
    """Return the unit's own axes in the stage's.

    Parameters
    ----------
    frame
        Along which stage axis each own axis lies, before the unit is turned: `{x: z, y: x, z: y}`; `-x`
        is against it.
    sensitive_axis
        One of x, y, z.
    turned_deg
        By how much the unit is turned right-handed about its own sensitive axis.

    Returns
    -------
    Shape (3, 3): the rows are own x, y, z by their components along the stage's x, y, z. What a vector
    has along the stage's axes, this matrix gives along the unit's own.

    Raises
    ------
    InsufficientDataError
        The frame or the axis is none; `frame_complaints` tells beforehand.
    """
    faults = list(frame_complaints(frame))
    if sensitive_axis not in AXES:
        faults.append(f"a sensitive axis is one of {', '.join(AXES)}, found '{sensitive_axis}'")
    if faults:
        raise InsufficientDataError("; ".join(faults))
    mounted = np.array([_direction(frame[one]) for one in AXES])
    about = AXES.index(sensitive_axis)
    first, second = (about + 1) % 3, (about + 2) % 3
    # Of whole quarters exactly.
    cosine, sine = (round(one, 15) for one in _circle(turned_deg))
    turned = mounted.copy()
    turned[first] = cosine * mounted[first] + sine * mounted[second]
    turned[second] = cosine * mounted[second] - sine * mounted[first]
    return turned


def frame_complaints(frame: Mapping[str, str]) -> Iterator[str]:
    """Give what is wrong with a frame: an axis that is missing or none, or axes that are no right-handed three."""
    example = "write e.g. {x: z, y: x, z: y}"
    if set(frame) != set(AXES):
        yield f"a frame says where x, y and z lie, found {', '.join(sorted(frame)) or 'nothing'}; {example}"
        return
    wrong = [one for one in frame.values() if one.removeprefix("-") not in AXES]
    if wrong:
        yield f"'{wrong[0]}' is no axis of the stage: x, y or z, or -x, -y, -z against it; {example}"
        return
    handedness = np.linalg.det(np.array([_direction(frame[one]) for one in AXES]))
    if handedness < 0.5:
        what = "two axes lie along one" if handedness > -0.5 else "they are left-handed"
        yield (
            f"the frame {{{', '.join(f'{own}: {frame[own]}' for own in AXES)}}} is no mounting of a unit:"
            f" {what}; {example}, or '-' before an axis that points the other way"
        )


def undetermined_axes(mountings: Iterable[_Array]) -> tuple[str, ...]:
    """Return the own axes along which gravity turns in none of the mountings, each as of `own_axes`.

    An axis along the shaft feels no gravity that turns: its coefficient is not found there.
    """
    across = [np.delete(axes, SHAFT, axis=1).T for axes in mountings]
    if not across:
        return AXES
    directions = np.concatenate(across)
    _, sizes, right = np.linalg.svd(directions)
    rank = int(np.sum(sizes > _SAME * sizes[0]))
    unseen = right[rank:]
    return tuple(
        one for place, one in enumerate(AXES) if np.abs(unseen[:, place]).max(initial=0.0) > _SAME
    )


def _direction(axis: str) -> tuple[float, float, float]:
    sign = -1.0 if axis.startswith("-") else 1.0
    at = AXES.index(axis.removeprefix("-"))
    return (sign * (at == 0), sign * (at == 1), sign * (at == 2))


def _circle(angle_deg: float) -> tuple[float, float]:
    angle = math.radians(angle_deg)
    return math.cos(angle), math.sin(angle)
