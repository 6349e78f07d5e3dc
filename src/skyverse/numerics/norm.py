"""The Euclidean norm, also where the squares of its terms underflow."""

import math

from skyverse.numerics.kernel import inner_query
from skyverse.numerics.tolerances import UNDERFLOWING_SQUARES

_SCALE = 2.0**600
"""A power of two, so that scaling by it rounds nothing; it lifts even the smallest subnormal number far enough."""


@inner_query
def norm(x: float, y: float, z: float) -> float:
    """Return the Euclidean norm of a vector; it is 0 only if all three components are.

    Parameters
    ----------
    x, y, z
        The components, in metres.
    """
    squares = x**2 + y**2 + z**2
    if squares < UNDERFLOWING_SQUARES:
        return math.sqrt((x * _SCALE) ** 2 + (y * _SCALE) ** 2 + (z * _SCALE) ** 2) / _SCALE
    return math.sqrt(squares)
