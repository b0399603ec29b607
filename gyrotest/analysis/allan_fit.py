"""The Allan variances of a fit: what noise terms make of them, and how they vary together."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.noise_terms import (
    Grid,
    allan_columns,
    allan_response,
    momentary_flicker_excess,
    momentary_walk_excess,
    spectrum_columns,
)
from gyrotest.analysis.spectral_lines import Excess

_POINTS_PER_DECADE = 300
_LOWEST = 0.02
_PIECE = 256
_BIAS, _WALK = 2, 3
_ROOT_3 = 3.0**0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class AllanFit:
    """Allan variances (k,) at `factors`, less the lines' share, with the terms' columns (k, 4).

    `response` (k, f), `spectra` (f, 4) and `widths_hz` (f,) make the covariance, over `overlap_s`
    (k, k) of record; `momentary` (k, 2) is by how much flicker noise and a random walk show larger
    where a sample is a momentary value and no mean; `besides` (k, k) is what adds to the covariance.
    """

    factors: NDArray[np.int64]
    variances: NDArray[np.float64]
    columns: NDArray[np.float64]
    response: NDArray[np.float64]
    spectra: NDArray[np.float64]
    widths_hz: NDArray[np.float64]
    overlap_s: NDArray[np.float64]
    momentary: NDArray[np.float64]
    besides: NDArray[np.float64]
    samples: int
    grid: Grid

    @property
    def tau_s(self) -> NDArray[np.float64]:
        """The averaging times (k,)."""
        return np.asarray(self.factors * self.grid.interval_s, dtype=np.float64)

    def since(self, first: int) -> "AllanFit":
        """Leave out the shortest averaging times."""
        return replace(
            self,
            factors=self.factors[first:],
            variances=self.variances[first:],
            columns=self.columns[first:],
            response=self.response[first:],
            overlap_s=self.overlap_s[first:, first:],
            momentary=self.momentary[first:],
            besides=self.besides[first:, first:],
        )

    def less(self, variances: NDArray[np.float64]) -> "AllanFit":
        """Take out what is no noise."""
        return replace(self, variances=self.variances - variances)

    def less_lines(self, lines: tuple[Excess, ...]) -> "AllanFit":
        """Take out the lines' share, and remember how well it is known."""
        if not lines:
            return self
        added = np.column_stack([one.allan_variances(self.factors, self.grid) for one in lines])
        doubt = added * [one.standard_uncertainty / float(one.power.sum()) for one in lines]
        return replace(
            self,
            variances=self.variances - added.sum(axis=1),
            besides=self.besides + doubt @ doubt.T,
        )

    def with_tails(self, fourth_cumulant: float) -> "AllanFit":
        """Allow for white noise whose distribution has heavier tails than the normal one.

        A sample's square counts 1/(m·n) in the Allan variance of m samples, so that a fourth cumulant κ₄
        adds κ₄/(m·m'·n) to the covariance of two.
        """
        share = self.factors**-1.0
        tails = max(fourth_cumulant, 0.0) / self.samples * np.outer(share, share)
        return replace(self, besides=self.besides + tails)

    def covariance(self, squares: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the variances' covariance (k, k) under a model: 1/T_ij ∫ S² H_i H_j df, and what is not known.

        Whether a sample is a mean or a momentary value is not known of a digital gyro: a rectangular
        distribution between the two.
        """
        density = self.spectra @ np.maximum(squares, 0.0)
        weighted = self.response * (density**2 * self.widths_hz)
        products = np.zeros(self.overlap_s.shape)
        # In pieces too small for a linear algebra library to call in other threads, which costs more.
        for begin in range(0, density.size, _PIECE):
            piece = slice(begin, begin + _PIECE)
            products += weighted[:, piece] @ self.response[:, piece].T
        unknown = self.momentary * (squares[[_BIAS, _WALK]] / _ROOT_3)
        covariance: NDArray[np.float64] = products / self.overlap_s + unknown @ unknown.T + self.besides
        return covariance

    def precision(self, squares: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the inverse of the covariance."""
        covariance = self.covariance(squares)
        scale = 1.0 / np.sqrt(np.diag(covariance))
        scales = np.outer(scale, scale)
        precision: NDArray[np.float64] = np.linalg.inv(covariance * scales) * scales
        return precision

    def guess(self) -> NDArray[np.float64]:
        """Return squared coefficients to begin with: white noise, and a little of all else."""
        tau = self.tau_s
        size = np.abs(self.variances)
        white = float(np.median(size * tau))
        return np.array(
            [0.01 * white * tau[0], white, 0.1 * float(size.min()), 1e-3 * white / tau[-1] ** 2]
        )


def allan_fit(
    factors: NDArray[np.int64],
    variances: NDArray[np.float64],
    samples: int,
    grid: Grid,
) -> AllanFit:
    """Return the fit's data of a record of so many samples."""
    p = grid.interval_s
    lowest, highest = _LOWEST / (float(factors[-1]) * p), 0.5 / p
    edges = np.geomspace(lowest, highest, int(_POINTS_PER_DECADE * np.log10(highest / lowest)) + 2)
    frequency_hz = np.sqrt(edges[1:] * edges[:-1])
    widths_hz = np.diff(edges)
    response = allan_response(frequency_hz, factors, grid)
    tau_s = factors * p
    return AllanFit(
        factors=factors,
        variances=variances,
        columns=allan_columns(factors, grid)[:, :4],
        response=response,
        spectra=spectrum_columns(frequency_hz, grid)[:, :4],
        widths_hz=widths_hz,
        overlap_s=samples * p - (tau_s[:, np.newaxis] + tau_s[np.newaxis, :]),
        momentary=np.column_stack(
            (
                response @ (momentary_flicker_excess(frequency_hz, grid) * widths_hz),
                momentary_walk_excess(factors, grid),
            )
        ),
        besides=np.zeros((factors.size, factors.size)),
        samples=samples,
        grid=grid,
    )
