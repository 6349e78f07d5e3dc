"""The Euclidean norm, also where the squares of its terms underflow, and the distances and lengths made of it."""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner_query, kernel
from skyverse.numerics.tolerances import MIN_NORM, UNDERFLOWING_SQUARES

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


@kernel
def distance(a: Floats, b: Floats) -> float:
    """Return the Euclidean distance between two points (3,)."""
    return norm(a[0] - b[0], a[1] - b[1], a[2] - b[2])


@kernel
def length_of(path: Floats) -> float:
    """Return the length of a path (k, 3) of straight legs, metres."""
    total = 0.0
    for i in range(1, len(path)):
        total += distance(path[i - 1], path[i])
    return total


def off_chord(points: Floats) -> Floats:
    """Return how far points, (n, 3), are from the segment between the first and the last of them, (n,) metres."""
    along = points[-1] - points[0]
    passed = np.sum((points - points[0]) * along, axis=1)
    shares = np.clip(passed / max(float(np.sum(along**2)), MIN_NORM), 0.0, 1.0)
    return np.linalg.norm(points - points[0] - shares[:, None] * along, axis=1)
