"""The low-pass that all channels of a frequency response share, sample by sample as they come."""

from typing import cast

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]
_ORDER = 3
_OVERSAMPLED = 10.0
_ROUNDED = 1e-9


class Lowpass:
    """A third-order Butterworth low-pass, the same for every channel, so that it cancels in their ratio.

    Parameters
    ----------
    cutoff_hz, rate_hz
        The −3 dB frequency, below half the sampling rate; and that rate.
    channels
        How many signals pass it.

    Raises
    ------
    ValueError
        The cut-off is not between 0 and half the sampling rate.

    Notes
    -----
    S4.2: H(s) = ω_c³/(s³ + 2ω_c s² + 2ω_c² s + ω_c³), by the bilinear transform with the cut-off in place.
    The state begins as if the first sample had stood for ever: a large angle to begin with is no step.
    """

    def __init__(self, cutoff_hz: float, rate_hz: float, channels: int) -> None:
        from scipy.signal import butter, sosfilt_zi

        if not 0.0 < cutoff_hz < rate_hz / 2.0:
            raise ValueError(
                f"a low-pass lies below half of the sampling rate of {rate_hz:g} Hz, found {cutoff_hz:g} Hz"
            )
        self.cutoff_hz, self.rate_hz, self.channels = cutoff_hz, rate_hz, channels
        self._sections: _Array = butter(_ORDER, cutoff_hz, fs=rate_hz, output="sos")
        self._rest: _Array = sosfilt_zi(self._sections)[:, np.newaxis, :]
        self._state: _Array | None = None

    def begin_stretch(self) -> None:
        """Forget what was: the next sample does not follow the last one."""
        self._state = None

    def push(self, signals: _Array) -> _Array:
        """Filter the next samples of all signals, (channels, n); returns as many."""
        from scipy.signal import sosfilt

        if signals.shape[0] != self.channels:
            raise ValueError(f"this low-pass has {self.channels} channels, found {signals.shape[0]}")
        if not signals.shape[1]:
            return signals
        if self._state is None:
            self._state = self._rest * signals[np.newaxis, :, :1]
        filtered, self._state = sosfilt(self._sections, signals, axis=1, zi=self._state)
        return filtered

    def transfer(self, frequency_hz: _Array) -> NDArray[np.complex128]:
        """Return what it makes of a sine of each frequency (k,): complex, 1 at 0 Hz."""
        from scipy.signal import sosfreqz

        _, found = sosfreqz(self._sections, worN=np.asarray(frequency_hz), fs=self.rate_hz)
        return cast("NDArray[np.complex128]", found)


def require_no_aliasing(*, rate_hz: float, cutoff_hz: float, analogue_hz: float | None) -> None:
    """Refuse samples in which noise above half their rate may pass for a signal below the cut-off.

    Parameters
    ----------
    rate_hz, cutoff_hz
        The sampling rate, and the digital low-pass's cut-off.
    analogue_hz
        Cut-off of the analogue low-pass before the sampling; None where there is none or it is not stated.

    Raises
    ------
    InsufficientDataError
        Sampled at less than ten times the cut-off without an analogue filter below half the rate.

    Notes
    -----
    S4.2: a digital filter cannot undo aliasing.
    """
    # A rate is the inverse of an interval, which need not come out even.
    enough_hz = _OVERSAMPLED * cutoff_hz * (1.0 - _ROUNDED)
    if rate_hz >= enough_hz or (analogue_hz is not None and analogue_hz < rate_hz / 2.0):
        return
    stated = "none is stated" if analogue_hz is None else f"{analogue_hz:g} Hz is stated"
    raise InsufficientDataError(
        f"sampled at {rate_hz:g} Hz with a low-pass of {cutoff_hz:g} Hz: aliasing cannot be told from signal;"
        f" sample at {_OVERSAMPLED * cutoff_hz:g} Hz or more, or state an analogue filter below"
        f" {rate_hz / 2.0:g} Hz in front of the sampling ({stated})"
    )
