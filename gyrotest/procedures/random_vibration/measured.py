"""From a recording to frequency responses: at rest and run by run, decoded, filtered, averaged, fitted."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.cross_spectra import CrossSpectra, Spectra, pooled
from gyrotest.analysis.frequency_response import Response, h1, h2, hv
from gyrotest.analysis.lowpass import Lowpass
from gyrotest.analysis.noise_ratio import NoiseRatio, noise_ratio
from gyrotest.analysis.response_curve import ResponseCurve, fit_response
from gyrotest.analysis.response_repeatability import ResponseRepeatability, response_repeatability
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.random_vibration.noise_in_motion import noise_beyond_rest
from gyrotest.procedures.random_vibration.parameters import RandomVibrationParameters
from gyrotest.procedures.scaling import Scaling
from gyrotest.procedures.vibration_channels import CUT_OFF, VibrationChannels, vibration_channels
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.recording import SampleStream, Sampling

_LOWEST = 1.1
_SHARED, _MOVING = 0.5, 0.1  # coherence at rest, and its rate beside that of the runs


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredResponse:
    """The response of all runs together (Hv, and H1 and H2 beside it) and of each, with curves through them.

    Gains are those of the output as a rate by the nominal scale factor: near 1 °/s a °/s. `inverted` says
    that the output moves against the sign of that factor; the phases are less the half turn then.
    `rate_dps` is the table's rate in the band, rms, as the encoder tells it.
    `noise_beyond_rest` (k,) is by how much of itself a gain may err at each line for noise of unknown origin.
    """

    response: Response
    output_noise: Response
    reference_noise: Response
    curve: ResponseCurve
    runs: tuple[Response, ...]
    run_curves: tuple[ResponseCurve, ...]
    noise: NoiseRatio
    noise_beyond_rest: NDArray[np.float64]
    repeatability: ResponseRepeatability | None
    segments: int
    rate_dps: float
    inverted: bool
    scaling: Scaling
    sampling: Sampling

    @property
    def scale(self) -> float:
        """What a gain of 1 is as a sensitivity, in `scaling.unit` per °/s."""
        return -self.scaling.scale_factor if self.inverted else self.scaling.scale_factor


def measured_response(stream: SampleStream, context: Context) -> MeasuredResponse:
    """Reduce a recording block by block; raises `InsufficientDataError`."""
    parameters: RandomVibrationParameters = context.parameters
    _refuse_cutoff(stream.sampling, parameters)
    channels = vibration_channels(stream, context, highest_hz=parameters.cutoff_hz / CUT_OFF)
    rest, *runs = _spectra(channels, parameters)
    _refuse_the_same(runs, context)
    inverted = _is_inverted(runs, parameters)
    upright = tuple(_turned(one) for one in runs) if inverted else tuple(runs)
    return _response(upright, rest, parameters, channels, inverted=inverted)


def _response(
    runs: tuple[Spectra, ...],
    rest: Spectra,
    parameters: RandomVibrationParameters,
    channels: VibrationChannels,
    *,
    inverted: bool,
) -> MeasuredResponse:
    together, noise = pooled(runs), noise_ratio(rest)
    _refuse_moving(rest, together, noise)
    each = tuple(hv(one, noise) for one in runs)
    response = hv(together, noise)
    curves = tuple(_curve(one, parameters) for one in each)
    return MeasuredResponse(
        response=response,
        output_noise=h1(together),
        reference_noise=h2(together),
        curve=_curve(response, parameters),
        runs=each,
        run_curves=curves,
        noise=noise,
        noise_beyond_rest=noise_beyond_rest(together, rest),
        repeatability=response_repeatability(curves) if len(curves) > 1 else None,
        segments=together.segments,
        rate_dps=_rate_dps(together),
        inverted=inverted,
        scaling=channels.scaling,
        sampling=channels.stream.sampling,
    )


def _curve(response: Response, parameters: RandomVibrationParameters) -> ResponseCurve:
    return fit_response(response, degree=parameters.degree, coherence_floor=parameters.coherence_floor)


def _rate_dps(spectra: Spectra) -> float:
    """The table's rate in the band, rms."""
    return float(np.sqrt(spectra.reference.sum() / spectra.segment_s))


def _refuse_moving(rest: Spectra, runs: Spectra, noise: NoiseRatio) -> None:
    """Refuse a record at rest that was none: what both channels see would count as their noise."""
    rest_dps, runs_dps = _rate_dps(rest), _rate_dps(runs)
    if (noise.coherence or 0.0) > _SHARED and rest_dps > _MOVING * runs_dps:
        raise InsufficientDataError(
            f"step 'rest': the table moves with {plain(rest_dps, 3)} °/s rms in the band, and the output follows"
            f" it (in the runs {plain(runs_dps, 3)} °/s); it must stand still there, for noise is told from it:"
            " of a recording, see that it begins with as much rest as 'parameters.rest' says"
        )


def _refuse_the_same(runs: Sequence[Spectra], context: Context) -> None:
    """Refuse runs of the same samples: they would repeat without an error."""
    for number, (one, other) in enumerate(itertools.pairwise(runs), start=1):
        if np.array_equal(one.cross, other.cross):
            raise InsufficientDataError(
                f"{context.case_name}: runs {number} and {number + 1} hold the same samples; record each by"
                " itself, and do not 'rewind' what is replayed"
            )


def _refuse_cutoff(sampling: Sampling, parameters: RandomVibrationParameters) -> None:
    rate_hz, cutoff_hz = 1.0 / sampling.interval_s, parameters.cutoff_hz
    if cutoff_hz >= rate_hz / 2.0:
        raise InsufficientDataError(
            f"sampled at {rate_hz:g} Hz, and the low-pass is {cutoff_hz:g} Hz; it must lie below half of the"
            f" sampling rate: sample at {10.0 * cutoff_hz:g} Hz"
        )


def _spectra(channels: VibrationChannels, parameters: RandomVibrationParameters) -> list[Spectra]:
    """Return the spectra of every dwell, in one pass; the output becomes a rate by the nominal factor."""
    averages = [_averages(channels, parameters) for _ in range(parameters.runs + 1)]
    lowpass = Lowpass(parameters.cutoff_hz, channels.rate_hz, 2)
    names = ["rest", *(f"run {number}" for number in range(1, parameters.runs + 1))]
    for piece in channels.pieces():
        average = averages[piece.number]
        if piece.begins:
            lowpass.begin_stretch()
            average.begin_stretch()
        rate_dps = piece.output / channels.scaling.scale_factor
        angle_deg, rate_dps = lowpass.push(np.stack((piece.angle_deg, rate_dps)))
        average.push(angle_deg, rate_dps)
    return [_averaged(one, name) for one, name in zip(averages, names, strict=True)]


def _averages(channels: VibrationChannels, parameters: RandomVibrationParameters) -> CrossSpectra:
    segment = (
        None if parameters.segment is None else 2 * round(parameters.segment_s * channels.rate_hz / 2)
    )
    return CrossSpectra(
        rate_hz=channels.rate_hz,
        low_hz=parameters.low_hz,
        high_hz=parameters.high_hz,
        segment=segment,
        window=parameters.window.value,
    )


def _averaged(average: CrossSpectra, name: str) -> Spectra:
    try:
        return average.spectra()
    except InsufficientDataError as error:
        raise InsufficientDataError(f"step '{name}': {error}") from None


def _is_inverted(runs: Sequence[Spectra], parameters: RandomVibrationParameters) -> bool:
    """Whether the output moves against its nominal sign where the band begins, and a gyro lags least."""
    lowest = runs[0].frequency_hz <= _LOWEST * parameters.low_hz
    return bool(sum(float(one.cross[lowest].real.sum()) for one in runs) < 0.0)


def _turned(spectra: Spectra) -> Spectra:
    cross = -spectra.cross
    cross.setflags(write=False)
    return replace(spectra, cross=cross)
