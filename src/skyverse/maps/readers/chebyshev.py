"""Polynomials through a function's values at Chebyshev points, in place of projections that cost microseconds a place.

Source: J.-P. Berrut, L. N. Trefethen, "Barycentric Lagrange interpolation", SIAM Review 46 (2004), 501-517.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats

CHEBYSHEV_NODES = 16
"""Chebyshev points along each side of the rectangle."""


class ChebyshevMap:
    """The polynomial in two variables through a function's values at the Chebyshev points of a rectangle.

    Over a map of 100 km it meets projections and the Earth's curvature to a micrometre.

    Parameters
    ----------
    function
        Takes two arrays (n,) and returns (k, n).
    first, second
        The range of each variable.
    """

    def __init__(
        self,
        function: Callable[[Floats, Floats], Floats],
        first: tuple[float, float],
        second: tuple[float, float],
    ) -> None:
        self._ranges = first, second
        a, b = (low + (high - low) * _POINTS for low, high in self._ranges)
        each, other = np.meshgrid(a, b, indexing="ij")
        self._values = function(each.ravel(), other.ravel()).reshape(-1, CHEBYSHEV_NODES, CHEBYSHEV_NODES)

    def grid(self, first: NDArray[Any], second: NDArray[Any]) -> Floats:
        """Return the values (k, n, m) at every pair of one of `first` (n,) and one of `second` (m,)."""
        left, right = (_weights(at, *span) for at, span in zip((first, second), self._ranges, strict=True))
        return np.einsum("kin,mn->kim", np.einsum("in,knm->kim", left, self._values), right)


_ANGLES = (2 * np.arange(CHEBYSHEV_NODES) + 1) * np.pi / (2 * CHEBYSHEV_NODES)
_POINTS = (1 - np.cos(_ANGLES)) / 2
_BARYCENTRIC_WEIGHTS = (-1.0) ** np.arange(CHEBYSHEV_NODES) * np.sin(_ANGLES)


def _weights(at: NDArray[Any], low: float, high: float) -> Floats:
    """Return the weight (n, nodes) of each Chebyshev point's value at each place, by the barycentric formula."""
    apart = ((at - low) / (high - low))[:, None] - _POINTS
    met = apart == 0
    shares = _BARYCENTRIC_WEIGHTS / np.where(met, 1.0, apart)
    shares[met.any(axis=1)] = 0.0
    shares[met] = 1.0
    return shares / shares.sum(axis=1, keepdims=True)
