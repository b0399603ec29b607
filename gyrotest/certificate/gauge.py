"""The small gauge in a row of results: the tolerance band, its limits, the value and its uncertainty."""

import base64
from dataclasses import dataclass

from gyrotest.certificate.numbers import plain
from gyrotest.records.result import JudgedResult

_WIDTH, _HEIGHT, _MIDDLE = 72.0, 9.0, 4.5
_BEYOND = 0.22
_INSIDE, _OUTSIDE, _TICK = "#a9d3b6", "#f0c4c4", "#2b3440"


@dataclass(frozen=True, slots=True, kw_only=True)
class Gauge:
    """An image and the words that stand for it."""

    source: str
    alt: str


def gauge(result: JudgedResult, colour: str) -> Gauge | None:
    """Draw a result between its limits; None where there is no value or no limit."""
    limit = result.limit
    if result.value is None or limit is None or (limit.min is None and limit.max is None):
        return None
    scale = _Scale.around(limit.min, limit.max, result.value)
    low, high = _ends(result)
    parts = [
        _line(0, _WIDTH, _OUTSIDE, 2.4),
        _line(
            0 if limit.min is None else scale.place(limit.min),
            _WIDTH if limit.max is None else scale.place(limit.max),
            _INSIDE,
            2.4,
        ),
        *(_tick(scale.place(one)) for one in (limit.min, limit.max) if one is not None),
        _line(scale.place(low), scale.place(high), colour, 1.2),
        _value(scale, result.value, colour),
    ]
    image = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH:g}pt" height="{_HEIGHT:g}pt" '
        f'viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}">{"".join(parts)}</svg>'
    )
    return Gauge(source=image_source(image), alt=_words(result))


def image_source(svg: str) -> str:
    """Return an SVG as the address of an image."""
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode("ascii")


@dataclass(frozen=True, slots=True)
class _Scale:
    low: float
    high: float

    @classmethod
    def around(cls, low: float | None, high: float | None, value: float) -> "_Scale":
        """Lay the scale; where one limit is missing, the band reaches to zero or to the value."""
        if low is None and high is not None:
            foot = 0.0 if high > 0 and value >= 0 else min(value, 2 * high, high - 1e-12)
            return cls(foot, high + _BEYOND * (high - foot))
        if high is None and low is not None:
            head = 0.0 if low < 0 and value <= 0 else max(value, 2 * low, low + 1e-12)
            return cls(low - _BEYOND * (head - low), head)
        begin, end = low or 0.0, high or 0.0
        margin = _BEYOND / 2 * ((end - begin) or 1.0)
        return cls(begin - margin, end + margin)

    def place(self, value: float) -> float:
        """Where a value lies; beyond the drawing's end, at the end."""
        fraction = (value - self.low) / (self.high - self.low)
        return 2.5 + min(max(fraction, 0.0), 1.0) * (_WIDTH - 5)


def _ends(result: JudgedResult) -> tuple[float, float]:
    value = result.value or 0.0
    if result.expanded_uncertainty is not None:
        return value - result.expanded_uncertainty, value + result.expanded_uncertainty
    return (
        value if result.lower_95 is None else result.lower_95,
        value if result.upper_95 is None else result.upper_95,
    )


def _line(begin: float, end: float, colour: str, width: float) -> str:
    return f'<path d="M{begin:.1f} {_MIDDLE}H{end:.1f}" stroke="{colour}" stroke-width="{width}" fill="none"/>'


def _tick(place: float) -> str:
    return f'<path d="M{place:.1f} 1V8" stroke="{_TICK}" stroke-width="0.9" fill="none"/>'


def _value(scale: _Scale, value: float, colour: str) -> str:
    """A dot; beyond the drawing's end an arrow that points there."""
    place = scale.place(value)
    if scale.low <= value <= scale.high:
        return f'<circle cx="{place:.1f}" cy="{_MIDDLE}" r="2.3" fill="{colour}"/>'
    way = 2.5 if value > scale.high else -2.5
    return f'<path d="M{place - way:.1f} 1.6L{place + way:.1f} {_MIDDLE}L{place - way:.1f} 7.4Z" fill="{colour}"/>'


def _words(result: JudgedResult) -> str:
    limit = result.limit
    low = plain(limit.min) if limit and limit.min is not None else "no lower limit"
    high = plain(limit.max) if limit and limit.max is not None else "no upper limit"
    return f"{plain(result.value or 0.0, digits=6)} between {low} and {high}"
