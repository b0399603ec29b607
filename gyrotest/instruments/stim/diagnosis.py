"""Bytes that make no frames: which other frames would fit, or what else is the likely cause."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.instruments.stim.decoding import FrameDecoder
from gyrotest.instruments.stim.models import MODELS, Frame, Model

_ENOUGH = 3
_EXAMINED = 4096


def likely_cause(data: bytes, model: Model, frame: Frame) -> str:
    """Say what was seen, what was expected, and what to look at."""
    seen = np.frombuffer(data, dtype=np.uint8)[-_EXAMINED:]
    begins = int(np.count_nonzero(seen == frame.identifier))
    told = (
        f"{len(data)} bytes but no {frame.name} frame (0x{frame.identifier:02X}) of a {model.name}:"
        f" {begins} of the last {len(seen)} bytes could begin one, and none passes its CRC"
    )
    fit = other_frames(seen)
    if fit:
        return f"{told}; they are {fit}: correct the station's driver, frame or crlf"
    return f"{told}; no frame of any known model fits either: is baud_rate that of the unit?"


def other_frames(seen: NDArray[np.uint8]) -> str:
    """The kind of frame of any model that fits these bytes; empty where none does."""
    for model in MODELS:
        for frame in model.frames:
            for crlf in (False, True):
                decoder = FrameDecoder(model, frame, crlf=crlf)
                if _fits(seen, decoder):
                    ended = " with CR LF" if crlf else " without CR LF"
                    return f"{frame.name} frames (0x{frame.identifier:02X}) of a {model.name}{ended}"
    return ""


def _fits(seen: NDArray[np.uint8], decoder: FrameDecoder) -> bool:
    """Whether some frames lie one behind the other: a short CRC alone fits by chance."""
    span = _ENOUGH * decoder.size
    begins = np.flatnonzero(seen[: max(0, len(seen) - span + 1)] == decoder.frame.identifier)
    rows = seen[begins[:, None] + np.arange(span)].reshape(-1, decoder.size)
    return bool(decoder.whole(rows).reshape(-1, _ENOUGH).all(axis=1).any()) if len(begins) else False
