"""From a recording to the responses at single frequencies: decoded, fitted, phases without leaps."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.sine_response import SineResponse, steady_response, swept_response
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.sine_vibration.parameters import SineVibrationParameters
from gyrotest.procedures.vibration_channels import Piece, VibrationChannels, vibration_channels
from gyrotest.procedures.vibration_inspection import step_words
from gyrotest.records.plan import Context
from gyrotest.records.recording import Dwell, SampleStream

_HALF_TURN, _TURN = 180.0, 360.0
_MOST_RELATIVE = 0.3


@dataclass(frozen=True, slots=True, kw_only=True)
class SinePoint:
    """The response at a frequency, its phase as it goes on from the lowest one, against the nominal sign."""

    asked_hz: float
    response: SineResponse
    phase_deg: float

    @property
    def told(self) -> bool:
        """Whether the output's sine is told from its noise."""
        return self.response.relative_uncertainty <= _MOST_RELATIVE


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredSines:
    """Responses at ascending frequencies; `inverted`: the output moves against the nominal scale factor.

    `shortened` are steps of which samples are missing, and how many of their samples were used.
    """

    points: tuple[SinePoint, ...]
    inverted: bool
    channels: VibrationChannels
    shortened: tuple["Shortened", ...]

    @property
    def scale(self) -> float:
        """The sign of a sensitivity: that of the nominal scale factor, or against it."""
        sign = 1.0 if self.channels.scaling.scale_factor > 0.0 else -1.0
        return -sign if self.inverted else sign

    def at(self, frequency_hz: float) -> SinePoint:
        """Return the response at one of the frequencies."""
        return min(self.points, key=lambda one: abs(one.asked_hz - frequency_hz))


@dataclass(frozen=True, slots=True, kw_only=True)
class Shortened:
    """A step of which the longest stretch without gaps was used."""

    dwell: Dwell
    used: int


@dataclass
class _Collected:
    """The longest stretch of a dwell so far."""

    dwell: Dwell
    best: list[Piece] = field(default_factory=list)
    now: list[Piece] = field(default_factory=list)

    def push(self, piece: Piece) -> None:
        """Take a piece; one that begins a stretch ends the one before."""
        if piece.begins:
            self.close()
        self.now.append(piece)

    def close(self) -> None:
        """Keep the stretch that ends, if it is the longest."""
        if _size(self.now) > _size(self.best):
            self.best = self.now
        self.now = []

    @property
    def samples(self) -> int:
        """Samples of the longest stretch."""
        return _size(self.best)

    @property
    def late(self) -> int:
        """How many samples of the dwell come before it."""
        return self.best[0].first - self.dwell.first

    def angle_deg(self) -> NDArray[np.float64]:
        """Return the angle (n,), °."""
        return np.concatenate([one.angle_deg for one in self.best])

    def output(self) -> NDArray[np.float64]:
        """Return the output (n,)."""
        return np.concatenate([one.output for one in self.best])


def _size(pieces: list[Piece]) -> int:
    return sum(one.output.size for one in pieces)


def measured_sines(stream: SampleStream, context: Context) -> MeasuredSines:
    """Reduce a recording step by step; raises `InsufficientDataError` naming the step."""
    parameters: SineVibrationParameters = context.parameters
    expected = 1 if parameters.sweep is not None else len(parameters.frequencies)
    if len(context.dwells) != expected:
        raise InsufficientDataError(
            f"{context.case_name}: {len(context.dwells)} of {expected} steps are there; all are needed"
        )
    channels = vibration_channels(stream, context, highest_hz=parameters.highest_hz)
    responses: list[_Asked] = []
    shortened: list[Shortened] = []
    for number, collected in enumerate(_dwells(channels)):
        if channels.tallies[number].missing:
            shortened.append(Shortened(dwell=collected.dwell, used=collected.samples))
        responses.extend(_responses(collected, number, channels, context))
    responses.sort(key=lambda one: one.frequency_hz)
    return _turned(responses, channels, tuple(shortened))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Asked:
    """A response, and the frequency that was asked for."""

    frequency_hz: float
    response: SineResponse


def _dwells(channels: VibrationChannels) -> Iterator[_Collected]:
    """Give the dwells one by one: no more than one is held."""
    now, number = _Collected(dwell=channels.context.dwells[0]), 0
    for piece in channels.pieces():
        if piece.number != number:
            now.close()
            yield now
            now, number = _Collected(dwell=piece.dwell), piece.number
        now.push(piece)
    now.close()
    yield now


def _responses(
    collected: _Collected, number: int, channels: VibrationChannels, context: Context
) -> Iterator[_Asked]:
    parameters: SineVibrationParameters = context.parameters
    sweep, interval_s = parameters.sweep, channels.interval_s
    angle_deg, output = collected.angle_deg(), collected.output()
    try:
        if sweep is None:
            asked_hz = parameters.frequencies_hz[number]
            found = steady_response(angle_deg, output, interval_s=interval_s, frequency_hz=asked_hz)
            yield _Asked(frequency_hz=asked_hz, response=found)
            return
        growth_per_s = sweep.growth_per_s(collected.dwell.samples * interval_s)
        began_hz = sweep.low_hz * float(np.exp(growth_per_s * collected.late * interval_s))
        for asked_hz in parameters.frequencies_hz:
            found = swept_response(
                angle_deg,
                output,
                interval_s=interval_s,
                frequency_hz=asked_hz,
                low_hz=began_hz,
                growth_per_s=growth_per_s,
            )
            yield _Asked(frequency_hz=asked_hz, response=found)
    except InsufficientDataError as error:
        raise InsufficientDataError(f"{step_words(collected.dwell)}: {error}") from None


def _turned(
    responses: list[_Asked], channels: VibrationChannels, shortened: tuple[Shortened, ...]
) -> MeasuredSines:
    """Count phases from the nominal sign, and on from each frequency to the next: of those told from noise."""
    sign = 1.0 if channels.scaling.scale_factor > 0.0 else -1.0
    told = np.array([one.response.relative_uncertainty <= _MOST_RELATIVE for one in responses])
    told |= not told.any()
    lowest = responses[int(np.argmax(told))].response.ratio * sign
    inverted = bool(lowest.real < 0.0)
    phases = np.array([np.angle(one.response.ratio * sign, deg=True) for one in responses])
    phases[told] = np.unwrap(phases[told] - (_HALF_TURN if inverted else 0.0), period=_TURN)
    phases[told] -= _TURN * np.rint(phases[told][0] / _TURN)
    points = tuple(
        SinePoint(asked_hz=one.frequency_hz, response=one.response, phase_deg=float(phase))
        for one, phase in zip(responses, phases, strict=True)
    )
    return MeasuredSines(points=points, inverted=inverted, channels=channels, shortened=shortened)
