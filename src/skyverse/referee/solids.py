"""What all kinds of grown shapes answer, whether boxes, spheres, cylinders, prisms or the ground.

Several of them judge parts of curves as thick straight lines, by their chords.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.referee.overlaps import BoxTree
from skyverse.referee.subdivision import MAX_DEPTH
from skyverse.referee.tolerances import LET_PASS, MACHINE_EPSILON, SUMS_ROUNDING


def share_of(part: Floats, whole: Floats) -> Floats:
    """Return which shares parts are of wholes, between 0 and 1; 0 of a whole that is nothing."""
    share: Floats = np.clip(np.divide(part, whole, out=np.zeros_like(part), where=whole > 0), 0.0, 1.0)
    return share


def distance_to_segment(points: Floats, a: Floats, b: Floats) -> Floats:
    """Return the distances (n,) of points (n, d) from the segments between a (n, d) and b (n, d), metres."""
    way = b - a
    share = share_of(np.sum((points - a) * way, axis=1), np.sum(way**2, axis=1))
    distance: Floats = np.sqrt(np.sum((a + share[:, None] * way - points) ** 2, axis=1))
    return distance


def nearest_points(p: Floats, q: Floats, r: Floats, s: Floats) -> tuple[Floats, Floats, Floats]:
    """Return where segments p-q and r-s, (m, 3) metres, are nearest: both shares and the distance, (m,) each.

    The squared distance is convex in both shares. From the share at which both derivatives are 0, clipped to the
    segment, one step to the best other share, and one back, reach its least value (C. Ericson, "Real-Time Collision
    Detection", 5.1.9). So that rounding of nearly parallel segments only ever chooses among distances, the least of
    three such candidates is taken.
    """
    u, v, w = q - p, s - r, p - r
    uu, uv, vv, uw, vw = (np.einsum("ij,ij->i", x, y) for x, y in ((u, u), (u, v), (v, v), (u, w), (v, w)))
    inner = share_of(uv * vw - vv * uw, uu * vv - uv * uv)
    candidates = []
    for share in (np.zeros(len(p)), np.ones(len(p)), inner):
        other = share_of(vw + share * uv, vv)
        candidates.append((share_of(other * uv - uw, uu), other))
    shares, others = (np.array(column) for column in zip(*candidates, strict=True))
    between = np.linalg.norm(w + shares[..., None] * u - others[..., None] * v, axis=2)
    best = np.argmin(between, axis=0)
    rows = np.arange(len(p))
    return shares[best, rows], others[best, rows], between[best, rows]


@dataclass(frozen=True, eq=False)
class GrownSolids(ABC):
    """Shapes of one kind, grown by the clearance less what is let pass.

    Attributes
    ----------
    clearance
        Metres by which the shapes are grown.
    obstacle
        (m,) the number of what each shape belongs to: an obstacle, a mover, a zone.
    """

    clearance: float
    obstacle: Indices

    @abstractmethod
    def hulls(self) -> tuple[Floats, Floats]:
        """Return the corners (m, 3), (m, 3) of boxes about the grown shapes, metres."""

    def of(self, some: Indices) -> Self:
        """Return some of the shapes, given by their numbers (k,)."""
        rows = [field.name for field in fields(self) if field.name != "clearance"]
        return replace(self, **{name: getattr(self, name)[some] for name in rows})

    @property
    def spread(self) -> float:
        """How much farther a hull reaches along an axis, at most, for each metre that its shape grows."""
        return 1.0

    @cached_property
    def tree(self) -> BoxTree:
        """The boxes about the grown shapes, as a tree."""
        return BoxTree(*self.hulls())

    @cached_property
    def farthest(self) -> float:
        """The largest absolute coordinate of the boxes about the grown shapes, metres."""
        return float(np.abs(self.hulls()).max(initial=0.0))

    def error(self, b: Floats, error: Floats) -> Floats:
        """Return bounds (n,) on the errors of the depths of pieces and their parts, and of the hulls, metres.

        Parameters
        ----------
        b, error
            (n, degree + 1, 3) coefficients of the pieces, and (n,) bounds on their errors, metres.
        """
        return distance_error(b, error, self.farthest)

    @abstractmethod
    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return upper bounds (n,) on how deep parts get inside grown shapes, metres; below 0 where they stay outside.

        Of a single coefficient, which is a point, it is the depth itself, or any number below 0.

        Parameters
        ----------
        part
            (n, degree + 1, 3) coefficients of the parts, metres.
        which
            (n,) the shape that each part is compared with.
        """

    @abstractmethod
    def gap(self, position: Floats, which: int) -> float:
        """Return the distance from a position (3,) to a shape as it is given, metres; negative inside the shape."""


def vertical_depth(part: Floats, low: Floats, high: Floats) -> Floats:
    """Return upper bounds (n,) on how deep parts (n, degree + 1, 3) get between altitudes `low` and `high`, (n,)."""
    z = part[:, :, 2]
    return np.minimum(z.max(axis=1) - low, high - z.min(axis=1))


def grown(low: Floats, high: Floats, clearance: float) -> tuple[Floats, Floats]:
    """Return where intervals from low to high begin and end when the clearance grows them, less what is let pass."""
    return low - (clearance - LET_PASS), high + (clearance - LET_PASS)


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
    halved = 6 * MAX_DEPTH * b.shape[1] * MACHINE_EPSILON * size
    return 4 * error + halved + SUMS_ROUNDING * farthest
