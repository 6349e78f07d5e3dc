"""Integrals along a flight, the length and the energy, between bounds that are proven."""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.referee.curve import PolynomialCurve, derivative
from skyverse.referee.limits import GRAVITY
from skyverse.referee.polynomial import bernstein, halve
from skyverse.referee.subdivision import MAX_DEPTH
from skyverse.referee.tolerances import SUMMARY_LET_PASS

MAX_PARTS = 2**20
"""Parts at one depth beyond which none is cut any more, which bounds the memory; the bounds hold all the same."""


class Enclosure(NamedTuple):
    """A number that is known to lie between two others, and the best estimate of it."""

    low: float
    estimate: float
    high: float

    def agrees(self, claimed: float) -> bool:
        """Tell whether a claimed value may differ from the true one by no more than what is let pass."""
        let_pass = SUMMARY_LET_PASS * (1 + abs(self.estimate))
        return self.low - let_pass <= claimed <= self.high + let_pass


def curve_length(curve: PolynomialCurve) -> Enclosure:
    """Return the length of a curve, metres."""
    return _integral(derivative(curve.pieces), curve.durations, 1.0, 1.0)


def flight_energy(curve: PolynomialCurve, hover_power: float) -> Enclosure:
    """Return the energy, J, of the flight of a multirotor that hovers at a power, W: see `FlightSummary.energy`."""
    thrust = derivative(derivative(curve.pieces))
    thrust[:, 0, 2] += GRAVITY
    return _integral(thrust, curve.durations, 1.5, hover_power / GRAVITY**1.5)


def _integral(rows: Floats, durations: Floats, exponent: float, factor: float) -> Enclosure:
    """Enclose the integral of `factor` |f|^`exponent` over time, for an exponent of at least 1.

    |f|^p is a convex function of the vector f. On a part of the curve, f is a mean of its Bernstein coefficients F_i,
    and over the part all weights of that mean have the same integral. By Jensen's inequality, the mean of |f|^p over
    the part is therefore at least |mean F_i|^p and at most the mean of |F_i|^p. Of a velocity, these are the chord and
    the control polygon. Parts are cut in two until the bounds are apart by less than a share of `SUMMARY_LET_PASS`.
    The sums themselves are rounded, which is far less.

    The estimate is (2 low + n high) / (n + 2), with the degree n of f, which is exact up to the fourth order
    (J. Gravesen, "Adaptive subdivision and the length and energy of Bezier curves", Computational Geometry 8, 1997).

    Parameters
    ----------
    rows
        (m, n + 1, 3) rows of f in the power basis.
    durations
        (m,) seconds that the pieces last.
    """
    parts = np.stack([part.b for part in bernstein(rows, durations)], axis=2)
    degree, lasts = parts.shape[1] - 1, durations
    low, high, allowed = 0.0, 0.0, 0.0
    for depth in range(MAX_DEPTH):
        least = factor * np.linalg.norm(parts.mean(axis=1), axis=1) ** exponent * lasts
        most = factor * (np.linalg.norm(parts, axis=2) ** exponent).mean(axis=1) * lasts
        allowed = allowed / 2 if depth else SUMMARY_LET_PASS * float(most.sum()) / len(parts)
        done = ~(most - least > allowed) | (len(parts) > MAX_PARTS)
        low, high = low + float(least[done].sum()), high + float(most[done].sum())
        if done.all():
            break
        parts, lasts = np.concatenate(halve(parts[~done])), np.tile(lasts[~done] / 2, 2)
    return Enclosure(low, (2 * low + degree * high) / (degree + 2), high)
