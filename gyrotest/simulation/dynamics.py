"""How a simulated gyro follows its input rate: second order and a delay, exact between the samples.

The rate is taken to go straight between closely spaced knots. For such an input the answer of a linear
system is known in closed form at any time, so that nothing is approximated: neither the response nor
the instant at which a channel is sampled.
"""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_STATES = 2
_TAPS = 4
# What was before so many e-foldings is no longer seen.
_FORGOTTEN = 30.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Dynamics:
    """A unit's own dynamics: `H(s) = ω_n²/(s² + 2·damping·ω_n·s + ω_n²) · exp(−s·delay_s)`.

    Its −3 dB point is `bandwidth_hz`. Without damping there is nothing but the delay.
    """

    bandwidth_hz: float
    damping: float = 0.0
    delay_s: float = 0.0

    @property
    def acts(self) -> bool:
        """Whether the output follows the rate otherwise than at once."""
        return self.damping > 0.0 or self.delay_s > 0.0

    @property
    def natural_hz(self) -> float:
        """The natural frequency: where the −3 dB point lies depends on the damping."""
        # |H|² = 1/2: u² + (4ζ² − 2)·u − 1 = 0 with u = (f/f_n)².
        middle = 1.0 - 2.0 * self.damping**2
        return self.bandwidth_hz / math.sqrt(middle + math.sqrt(middle**2 + 1.0))

    @property
    def settling_s(self) -> float:
        """When what was before is no longer seen."""
        if self.damping == 0.0:
            return self.delay_s
        slowest = self.damping - math.sqrt(max(0.0, self.damping**2 - 1.0))
        return self.delay_s + _FORGOTTEN / (2.0 * math.pi * self.natural_hz * slowest)

    def response(self, frequency_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
        """The complex response, (n,); 1 at zero frequency."""
        s = 2j * math.pi * np.asarray(frequency_hz, dtype=np.float64)
        late = np.exp(-s * self.delay_s)
        if self.damping == 0.0:
            return np.asarray(late)
        natural = 2.0 * math.pi * self.natural_hz
        return np.asarray(late * natural**2 / (s**2 + 2.0 * self.damping * natural * s + natural**2))


def frequency_response(
    frequency_hz: NDArray[np.float64], truth: Mapping[str, float], axis: str = ""
) -> NDArray[np.complex128]:
    """A unit's output per input rate by the true figures of its record, (n,), output units per deg/s.

    The phase is that of the unit alone: a lag is negative. Nonlinearity and asymmetry are left out.
    """
    prefix = f"{axis}." if axis else ""
    dynamics = Dynamics(
        bandwidth_hz=truth[f"{prefix}bandwidth_hz"],
        damping=truth[f"{prefix}damping"],
        delay_s=truth[f"{prefix}delay_s"],
    )
    return np.asarray(truth[f"{prefix}scale_factor"] * dynamics.response(frequency_hz))


class Follower:
    """A unit's answer at instants that lie a fixed time beside the knots of its input, block by block.

    The knots are `interval_s` apart. What comes out with a knot's input is the answer `shift_s` after the
    time of the knot `ahead` before it.
    """

    def __init__(self, dynamics: Dynamics, *, interval_s: float, shift_s: float) -> None:
        shift_s -= dynamics.delay_s
        whole = math.floor(shift_s / interval_s + 1e-9)
        self.ahead = 1 + whole
        rest_s = max(0.0, shift_s - whole * interval_s)
        if dynamics.damping > 0.0:
            self._recursion = _held(dynamics, interval_s, rest_s)
        else:
            share = rest_s / interval_s
            self._recursion = _Recursion(taps=np.array([share, 1.0 - share]), poles=np.ones(1))
        self._state: NDArray[np.float64] | None = None

    def follow(self, rates_dps: NDArray[np.float64]) -> NDArray[np.float64]:
        """The answers to the next knots, (n,); before the first one the input was what it is there."""
        from scipy.signal import lfilter, lfiltic

        taps, poles = self._recursion.taps, self._recursion.poles
        if self._state is None:
            before = np.full(_TAPS, rates_dps[0])
            self._state = lfiltic(taps, poles, before, before)
        answers, self._state = lfilter(taps, poles, rates_dps, zi=self._state)
        return np.asarray(answers)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Recursion:
    """An answer by the last inputs, weighed by the taps, and the last answers, by the poles."""

    taps: NDArray[np.float64]
    poles: NDArray[np.float64]


def _held(dynamics: Dynamics, interval_s: float, rest_s: float) -> _Recursion:
    """The recursion that gives the answer a time after the knot before the last one."""
    from scipy.linalg import expm

    natural = 2.0 * math.pi * dynamics.natural_hz
    # The states, the input and its slope, between two knots: d/dt of all four is linear in them.
    flow = np.zeros((_STATES + 2, _STATES + 2))
    flow[0, 1] = 1.0
    flow[1, :3] = [-(natural**2), -2.0 * dynamics.damping * natural, natural**2]
    flow[2, 3] = 1.0
    through, partly = expm(flow * interval_s), expm(flow * rest_s)
    poles = np.asarray(np.poly(through[:_STATES, :_STATES]))
    # A numerator is the denominator times the answer to an impulse, which is over after four knots.
    taps = np.convolve(poles, _impulse(through, partly, interval_s))[:_TAPS]
    return _Recursion(taps=taps, poles=poles)


def _impulse(
    through: NDArray[np.float64], partly: NDArray[np.float64], interval_s: float
) -> NDArray[np.float64]:
    """The answers, a part of an interval after the knot before each, to an input of 1 at knot 0 alone."""
    state = np.zeros(_STATES)
    knots = np.array([0.0, 1.0, 0.0, 0.0, 0.0])
    answers = np.empty(_TAPS)
    for number, (here, there) in enumerate(itertools.pairwise(knots)):
        at = np.array([*state, here, (there - here) / interval_s])
        answers[number] = (partly @ at)[0]
        state = (through @ at)[:_STATES]
    return answers
