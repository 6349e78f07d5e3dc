"""Elementary functions of arrays that round alike on all processors: the C library computes one element after another.

numpy has functions of its own for processors with AVX-512, which round otherwise. Its sine, cosine and square root are
the same everywhere.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats

_ARCSINH, _ARCTAN2 = np.frompyfunc(math.asinh, 1, 1), np.frompyfunc(math.atan2, 2, 1)
_EXP, _POWER = np.frompyfunc(math.exp, 1, 1), np.frompyfunc(math.pow, 2, 1)


def arcsinh(x: ArrayLike) -> Floats:
    """Return the inverse hyperbolic sines."""
    return np.asarray(_ARCSINH(x), dtype=np.float64)


def arctan2(y: ArrayLike, x: ArrayLike) -> Floats:
    """Return the angles of vectors from the x-axis, radians."""
    return np.asarray(_ARCTAN2(y, x), dtype=np.float64)


def exp(x: ArrayLike) -> Floats:
    """Return the exponentials."""
    return np.asarray(_EXP(x), dtype=np.float64)


def power(base: ArrayLike, exponent: ArrayLike) -> Floats:
    """Return powers of numbers that are not negative."""
    return np.asarray(_POWER(base, exponent), dtype=np.float64)
