"""Intervals by likelihood ratio: how far a coefficient can go before the record becomes unlikely.

The values that belong to an interval are those whose deviance, everything else refitted and nothing
negative, lies within the chi-square quantile of the least one. At the edge of what is allowed the
interval passes by itself from a two-sided one to an upper limit, so that no choice between the two
spoils its coverage (cf. G. J. Feldman and R. D. Cousins, Phys. Rev. D 57, 3873, 1998).
"""

from collections.abc import Callable

_TRIES = 24
_CLOSE = 0.02

ONE_SIGMA_DEVIANCE = 1.0
NORMAL_95_DEVIANCE = 3.841458820694124


def upper_bound(
    excess: Callable[[float], float], *, value: float, sigma: float, deviance: float
) -> float:
    """Return where above `value` the excess deviance reaches `deviance`; `sigma` guides the search."""
    return _crossing(excess, value=value, first=value + sigma * deviance**0.5, deviance=deviance)


def lower_bound(
    excess: Callable[[float], float], *, value: float, sigma: float, deviance: float
) -> float:
    """Return where below `value` the excess deviance reaches `deviance`; 0 where it nowhere does."""
    if value - 6.0 * sigma * deviance**0.5 <= 0.0 and excess(0.0) <= deviance:
        return 0.0
    first = max(value - sigma * deviance**0.5, value / 2.0)
    return _crossing(excess, value=value, first=first, deviance=deviance)


def _crossing(excess: Callable[[float], float], *, value: float, first: float, deviance: float) -> float:
    """Search along the root of the excess deviance, which is nearly straight."""
    wanted = deviance**0.5
    inside, root_inside = value, 0.0
    outside: float | None = None
    root_outside = 0.0
    at = first
    for _ in range(_TRIES):
        root = max(excess(at), 0.0) ** 0.5
        if abs(root - wanted) < _CLOSE:
            break
        if root < wanted:
            inside, root_inside = at, root
        else:
            outside, root_outside = at, root
        if outside is None:
            at = max(value + (at - value) * min(max(wanted / max(root, 1e-3), 1.2), 4.0), 0.0)
        else:
            share = (wanted - root_inside) / (root_outside - root_inside)
            at = inside + (outside - inside) * min(max(share, 0.05), 0.95)
    return at
