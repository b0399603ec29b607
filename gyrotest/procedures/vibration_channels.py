"""The channels of a vibration test, made ready: at one instant each, the encoder decoded, dwell by dwell."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.ellipse import Ellipse
from gyrotest.analysis.encoder import AngleTrack, Decoder
from gyrotest.analysis.lowpass import require_no_aliasing
from gyrotest.analysis.skew import Aligner
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.encoder_unit import encoder_unit_deg
from gyrotest.procedures.scaling import Scaling, output_scaling
from gyrotest.procedures.vibration_inspection import inspected, step_words
from gyrotest.procedures.vibration_tally import DwellTally, stretches
from gyrotest.records.plan import Context
from gyrotest.records.recording import (
    ENCODER_ANGLE,
    ENCODER_COSINE,
    ENCODER_SINE,
    Dwell,
    SampleStream,
    Sampling,
)
from gyrotest.records.station import Encoder

CUT_OFF = 2.5
"""The low-pass cut-off over the highest working frequency (S4.2)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Piece:
    """Consecutive samples of a dwell, the `number`th of the recording (from 0).

    `first` is the position of the first sample on the acquisition's grid. `output` (n,) is the gyro's less
    the nominal one at rest, in `scaling.unit`; `angle_deg` (n,) the table's, which goes on from the piece
    before unless this one `begins` a stretch.
    """

    number: int
    dwell: Dwell
    first: int
    begins: bool
    output: NDArray[np.float64]
    angle_deg: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class VibrationChannels:
    """Output and angle of a vibration test; `ellipse` is None where the encoder gives the angle itself."""

    stream: SampleStream
    context: Context
    encoder: Encoder
    scaling: Scaling
    ellipse: Ellipse | None
    tallies: tuple[DwellTally, ...]

    @property
    def sampling(self) -> Sampling:
        """How the channels are sampled."""
        return self.stream.sampling

    @property
    def interval_s(self) -> float:
        """Time from sample to sample, s."""
        return self.sampling.interval_s

    @property
    def rate_hz(self) -> float:
        """Sampling rate, Hz."""
        return 1.0 / self.interval_s

    @property
    def line_deg(self) -> float | None:
        """Angle of a line of the grating, °; None where the encoder gives the angle itself."""
        return None if self.encoder.lines is None else 360.0 / self.encoder.lines

    def pieces(self) -> Iterator[Piece]:
        """Give every dwell's samples in their order; may be called again.

        Where samples are missing inside a dwell, a new stretch begins. Of every stretch a few samples are
        lost at either end where channels are skewed.

        Raises
        ------
        InsufficientDataError
            The encoder is starved of samples, lost its signal or leapt; the message names the dwell.
        """
        reading = _Reading(self)
        last = -1
        for stretch in stretches(self.stream, self.context.dwells):
            dwell = self.context.dwells[stretch.number]
            try:
                if stretch.begins:
                    reading.check()
                    last = stretch.number
                    reading.begin(stretch.first)
                piece = reading.piece(stretch.values, stretch.number, dwell)
            except InsufficientDataError as error:
                raise InsufficientDataError(
                    f"{step_words(self.context.dwells[last])}: {error}"
                ) from None
            last = stretch.number
            if piece.output.size:
                yield piece
        try:
            reading.check()
        except InsufficientDataError as error:
            raise InsufficientDataError(f"{step_words(self.context.dwells[last])}: {error}") from None


class _Reading:
    """The state that goes on from block to block of a stretch."""

    def __init__(self, channels: VibrationChannels) -> None:
        self._scaling = channels.scaling
        self._tracked = _tracked(channels)
        self._aligner = Aligner(channels.sampling.offsets_s or (0.0,), channels.interval_s)
        self._next = 0
        self._begins = False

    def begin(self, first: int) -> None:
        """Begin a stretch."""
        self._aligner.reset()
        self._tracked.reset()
        self._next, self._begins = first + self._aligner.lost, True

    def check(self) -> None:
        """Raise `InsufficientDataError` where the encoder failed in the stretch that ends."""
        self._tracked.check()

    def piece(self, values: NDArray[np.float64], number: int, dwell: Dwell) -> Piece:
        """Return what is complete by now; may be empty."""
        aligned = self._aligner.push(values)
        piece = Piece(
            number=number,
            dwell=dwell,
            first=self._next,
            begins=self._begins,
            output=self._scaling.outputs(aligned[:, 0]),
            angle_deg=self._tracked.push(aligned),
        )
        self._next += aligned.shape[0]
        self._begins = self._begins and not aligned.shape[0]
        return piece


class _Tracked:
    """The encoder's columns, turned into an angle."""

    def __init__(self, columns: tuple[int, ...], tracker: Decoder | AngleTrack, factor: float) -> None:
        self._columns, self._tracker, self._factor = columns, tracker, factor

    def push(self, aligned: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the angle (n,) of rows (n, columns), °."""
        if isinstance(self._tracker, Decoder):
            sine, cosine = (aligned[:, one] for one in self._columns)
            return self._tracker.push(sine, cosine)
        return self._tracker.push(aligned[:, self._columns[0]] * self._factor)

    def reset(self) -> None:
        """Begin a stretch."""
        self._tracker.reset()

    def check(self) -> None:
        """Raise `InsufficientDataError` where the encoder failed."""
        self._tracker.check()


def vibration_channels(
    stream: SampleStream, context: Context, *, highest_hz: float
) -> VibrationChannels:
    """Look through a recording once and make its channels ready.

    `highest_hz` is the highest working frequency.

    Raises
    ------
    InsufficientDataError
        The source is not synchronous, there is no encoder, sampling is too slow without an analogue
        filter, the output is clipped or stuck, samples are bad, some are missing and the case refuses
        gaps, the encoder's signals give no ellipse.
    """
    encoder = _known_encoder(stream.sampling, context)
    _refuse_asynchronous(stream.sampling, context)
    _refuse_aliasing(stream.sampling, context, highest_hz)
    if not context.dwells:
        raise InsufficientDataError(f"{context.case_name}: the recording has no dwells")
    scaling = output_scaling(context.output, stream.sampling.unit)
    found = inspected(stream, context, scaling)
    return VibrationChannels(
        stream=stream,
        context=context,
        encoder=encoder,
        scaling=scaling,
        ellipse=found.ellipse,
        tallies=found.tallies,
    )


def _tracked(channels: VibrationChannels) -> _Tracked:
    encoder, columns = channels.encoder, channels.sampling.columns
    if channels.ellipse is None or encoder.lines is None:
        place = columns.index(ENCODER_ANGLE)
        track = AngleTrack(rate_hz=channels.rate_hz, reversed_=encoder.reversed)
        return _Tracked((place,), track, encoder_unit_deg(channels.sampling, channels.context))
    decoder = Decoder(
        channels.ellipse,
        lines=encoder.lines,
        rate_hz=channels.rate_hz,
        reversed_=encoder.reversed,
    )
    return _Tracked((columns.index(ENCODER_SINE), columns.index(ENCODER_COSINE)), decoder, 1.0)


def _known_encoder(sampling: Sampling, context: Context) -> Encoder:
    encoder, columns = context.encoder, set(sampling.columns)
    signals = {ENCODER_SINE, ENCODER_COSINE} <= columns
    if encoder is None or not (signals or ENCODER_ANGLE in columns):
        raise InsufficientDataError(
            f"{context.case_name}: nothing measures the angle of the table; give the slot an 'encoder' in the"
            " station, e.g. {sine: ua, cosine: ub, lines: 9000}, of channels of the same source"
        )
    if signals and encoder.lines is None:
        raise InsufficientDataError(
            f"{context.case_name}: how many lines the grating has is not known; give the slot's 'encoder' its"
            " 'lines'"
        )
    return encoder


def _refuse_asynchronous(sampling: Sampling, context: Context) -> None:
    if sampling.synchronous:
        return
    source = context.source
    named = "the source" if source is None else f"{source.manufacturer} {source.model}".strip()
    raise InsufficientDataError(
        f"{context.case_name}: {named} does not sample its channels by one clock; a frequency response needs"
        " output and encoder from one synchronous source: 28 µs between them is 1° at 100 Hz"
    )


def _refuse_aliasing(sampling: Sampling, context: Context, highest_hz: float) -> None:
    try:
        require_no_aliasing(
            rate_hz=1.0 / sampling.interval_s,
            cutoff_hz=CUT_OFF * highest_hz,
            analogue_hz=sampling.filter_hz,
        )
    except InsufficientDataError as error:
        raise InsufficientDataError(f"{context.case_name}: {error}") from None
