"""Parts of curves as thick straight lines: a chord, and how far the part is off it at most."""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.referee.polynomial import DEPTH, EPS


class Chords(NamedTuple):
    """Straight lines from (n, d) to (n, d), and (n,) metres that the parts are off them at most."""

    a: Floats
    b: Floats
    off: Floats


def chords(part: Floats) -> Chords:
    """Return the chords of parts (n, degree + 1, d), given by their Bernstein coefficients.

    A part lies in the convex hull of its coefficients, and so as near to the chord as these do. The chord goes from the
    first towards the one farthest from it, as far as they reach to both sides: a straight part is its chord, and a
    single coefficient too.
    """
    first = part[:, 0]
    reach = part - first[:, None]
    far = np.argmax(np.sum(reach**2, axis=2), axis=1)
    way = reach[np.arange(len(part)), far]
    length = np.sqrt(np.sum(way**2, axis=1))
    unit = way / np.where(length > 0, length, 1.0)[:, None]
    along = np.sum(reach * unit[:, None], axis=2)
    off = np.sqrt(np.sum((reach - along[:, :, None] * unit[:, None]) ** 2, axis=2)).max(axis=1)
    low, high = along.min(axis=1)[:, None], along.max(axis=1)[:, None]
    return Chords(first + low * unit, first + high * unit, off)


def distance(points: Floats, a: Floats, b: Floats) -> Floats:
    """Return the distances of points (n, d) from the straight lines between a (n, d) and b (n, d); (n,) metres."""
    way = b - a
    square = np.sum(way**2, axis=1)
    share = np.clip(np.sum((points - a) * way, axis=1) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    apart: Floats = np.sqrt(np.sum((a + share[:, None] * way - points) ** 2, axis=1))
    return apart


def distance_error(b: Floats, error: Floats, farthest: float) -> Floats:
    """Return bounds on the errors of distances to chords of pieces (n, degree + 1, 3), however often halved.

    Those of places along three axes, of halving them, and of the few sums with numbers up to `farthest`.
    """
    size = np.abs(b).max(axis=(1, 2), initial=0.0)
    whole: Floats = 4 * error + 4 * (DEPTH + 16) * b.shape[1] * EPS * size + 64 * EPS * farthest
    return whole
