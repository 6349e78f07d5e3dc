"""Parts of curves as thick straight lines: the chord of a part, and how far the part is from its chord at most."""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.referee.subdivision import MAX_DEPTH
from skyverse.referee.tolerances import MACHINE_EPSILON


class Chords(NamedTuple):
    """Straight lines from `a` to `b`, (n, d) metres, and how far the parts are from them at most, (n,) metres."""

    a: Floats
    b: Floats
    off: Floats


def chords(part: Floats) -> Chords:
    """Return the chords of parts (n, degree + 1, d), which are given by their Bernstein coefficients.

    A part lies in the convex hull of its coefficients, so it is no farther from the chord than they are. The chord lies
    on the line from the first coefficient to the one farthest from it, and reaches as far as the coefficients do to
    both sides: a straight part is its own chord, and so is a single coefficient.
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


def distance_to_segment(points: Floats, a: Floats, b: Floats) -> Floats:
    """Return the distances (n,) of points (n, d) from the segments between a (n, d) and b (n, d), metres."""
    way = b - a
    square = np.sum(way**2, axis=1)
    share = np.clip(np.sum((points - a) * way, axis=1) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    return np.sqrt(np.sum((a + share[:, None] * way - points) ** 2, axis=1))


def distance_error(b: Floats, error: Floats, farthest: float) -> Floats:
    """Return bounds (n,) on the errors of distances to the chords of pieces and of all their parts, metres.

    Counted are the errors of positions along three axes, the halvings, and the few sums with the shapes' numbers.

    Parameters
    ----------
    b, error
        (n, degree + 1, 3) coefficients of the pieces, and (n,) bounds on their errors, metres.
    farthest
        The largest absolute coordinate of the shapes, metres.
    """
    size = np.abs(b).max(axis=(1, 2), initial=0.0)
    halved = 4 * (MAX_DEPTH + 16) * b.shape[1] * MACHINE_EPSILON * size
    return 4 * error + halved + 64 * MACHINE_EPSILON * farthest
