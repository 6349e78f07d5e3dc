"""Judges whether two UAVs keep their separation on timed paths: whatever the timing, or at all times that they allow.

The z axis is stretched so that the ellipsoid of separation becomes a ball. Each piece of one path is compared with each
piece of the other: they are apart if the segments, less what both UAVs may deviate, are apart, or if the UAVs cannot be
there at the same time. What is neither is cut in two.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.model.trajectory import TimedPath
from skyverse.referee.solids import nearest_points
from skyverse.referee.tolerances import LET_PASS, SUMS_ROUNDING

MAX_PARTS = 20_000
"""Pairs of parts that are compared for one pair of UAVs before it is undecided, and so not proven."""


class KeptDistance(NamedTuple):
    """What two UAVs keep between each other.

    Attributes
    ----------
    across, above
        The semi-axes of the ellipsoid of separation, metres.
    error_across, error_above
        The sum of both UAVs' tracking errors, horizontal and vertical, metres.
    """

    across: float
    above: float
    error_across: float = 0.0
    error_above: float = 0.0


class _Parts(NamedTuple):
    """Parts of pieces of one path: (m,) indices of pieces, and the shares of each between which the part lies."""

    piece: NDArray[np.intp]
    begin: Floats
    end: Floats


def paths_apart(first: TimedPath, second: TimedPath, keep: KeptDistance, *, timed: bool) -> bool:
    """Tell whether it is proven that two UAVs keep their separation.

    Parameters
    ----------
    first, second
        Their paths.
    keep
        The separation.
    timed
        Whether only times that the paths allow are judged; otherwise each UAV may be anywhere on its path at any time.
    """
    if keep.across <= LET_PASS or keep.above <= LET_PASS:
        return True
    stretch, tall, needed = _needed(first, second, keep)
    i, j = (grid.ravel() for grid in np.meshgrid(*(np.arange(len(p.starts)) for p in (first, second)), indexing="ij"))
    a, b = (_Parts(k, np.zeros(len(k)), np.ones(len(k))) for k in (i, j))
    compared = 0
    while len(a.piece):
        compared += len(a.piece)
        if compared > MAX_PARTS + len(i):
            return False
        (p, q), (r, s) = _ends(first, a, stretch), _ends(second, b, stretch)
        share, other, distance = nearest_points(p, q, r, s)
        off = tall * (_largest(first, a) + _largest(second, b))
        near = ~(distance - off >= needed)
        if timed:
            near &= _meet(first, a, second, b)
        worst = near & (distance < needed)
        if timed:
            worst &= _meet(first, _place(a, share), second, _place(b, other))
        if worst.any():
            return False
        a, b = _halved(a, b, near, np.linalg.norm(q - p, axis=1) >= np.linalg.norm(s - r, axis=1))
    return True


def _needed(first: TimedPath, second: TimedPath, keep: KeptDistance) -> tuple[Floats, float, float]:
    """Return by what x, y, z are stretched, (3,), the largest of it, and the distance that must be kept then."""
    stretch = np.array([1.0, 1.0, keep.across / keep.above])
    error = float(np.hypot(keep.error_across, keep.error_above * stretch[2]))
    size = max(float(np.abs(path * stretch).max()) for path in (first.starts, first.ends, second.starts, second.ends))
    return stretch, max(1.0, float(stretch[2])), keep.across + error - LET_PASS + SUMS_ROUNDING * size


def _ends(path: TimedPath, parts: _Parts, stretch: Floats) -> tuple[Floats, Floats]:
    """Return where parts begin and end, (m, 3) each, in stretched metres."""
    a, along = path.starts[parts.piece], (path.ends - path.starts)[parts.piece]
    return (a + parts.begin[:, None] * along) * stretch, (a + parts.end[:, None] * along) * stretch


def _place(parts: _Parts, share: Floats) -> _Parts:
    """Return single places, at shares (m,) of parts, as parts without length."""
    at = parts.begin + share * (parts.end - parts.begin)
    return _Parts(parts.piece, at, at)


def _at(ends: Floats, piece: NDArray[np.intp], share: Floats) -> Floats:
    """Return values (m,) at shares of pieces; an infinite value at either end of a piece is infinite all along it."""
    a, b = ends[piece].T
    with np.errstate(invalid="ignore"):
        return np.where(np.isfinite(a) & np.isfinite(b), a + share * (b - a), np.maximum(a, b))


def _largest(path: TimedPath, parts: _Parts) -> Floats:
    """Return the largest deviation on each part, (m,) metres."""
    ends = (_at(path.deviation, parts.piece, share) for share in (parts.begin, parts.end))
    return np.maximum(*ends)


def _meet(first: TimedPath, a: _Parts, second: TimedPath, b: _Parts) -> NDArray[np.bool_]:
    """Tell for each two parts whether both UAVs may be there at the same time."""
    begin_a, end_a = _at(first.earliest, a.piece, a.begin), _at(first.latest, a.piece, a.end)
    begin_b, end_b = _at(second.earliest, b.piece, b.begin), _at(second.latest, b.piece, b.end)
    return (begin_a <= end_b) & (begin_b <= end_a)


def _halved(a: _Parts, b: _Parts, near: NDArray[np.bool_], longer: NDArray[np.bool_]) -> tuple[_Parts, _Parts]:
    """Return the pairs that are near, the longer part of each cut in two."""
    cut = longer[near]
    made = []
    for parts, halve in ((a, cut), (b, ~cut)):
        piece, begin, end = (column[near] for column in parts)
        middle = (begin + end) / 2
        left, right = np.where(halve, middle, end), np.where(halve, middle, begin)
        made.append(_Parts(np.tile(piece, 2), np.r_[begin, right], np.r_[left, end]))
    return made[0], made[1]
