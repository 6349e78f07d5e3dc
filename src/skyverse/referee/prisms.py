"""Grown prisms on polygons with holes: how deep a part of a curve may be inside, by its chord."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.model.shapes import Prism
from skyverse.model.uav import TrackingError
from skyverse.referee.solid_shapes import Outlines, SolidShapes
from skyverse.referee.solids import Chords, GrownSolids, chords, distance_to_segment, grown, vertical_depth
from skyverse.referee.tolerances import LET_PASS, OUTLINE_CONTACT, SURELY_OUTSIDE
from skyverse.referee.tracking_error import EXACT, reach, taller

EDGES_AT_ONCE = 2**19
"""Pairs of chords and edges looked at together, which bounds the memory."""


@dataclass(frozen=True, eq=False)
class GrownPrisms(GrownSolids):
    """Vertical prisms.

    Attributes
    ----------
    outlines
        Their outlines, with the altitudes between which they lie before they grow.
    grown_low, grown_high
        (m,) altitudes of the grown prisms, metres.
    """

    outlines: Outlines
    grown_low: Floats
    grown_high: Floats

    def of(self, some: Indices) -> Self:
        """Return some of the prisms, given by their numbers (k,)."""
        rows = {name: getattr(self, name)[some] for name in ("obstacle", "grown_low", "grown_high")}
        return replace(self, outlines=self.outlines.of(some), **rows)

    def hulls(self) -> tuple[Floats, Floats]:
        """Return the corners of boxes about the grown prisms."""
        p, first = self.outlines.p, self.outlines.first
        low, high = np.minimum.reduceat(p, first), np.maximum.reduceat(p, first)
        level = max(self.clearance - LET_PASS, 0.0)
        return np.column_stack([low - level, self.grown_low]), np.column_stack([high + level, self.grown_high])

    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return how deep parts may be inside: a part outside is beside the polygon, below or above."""
        depth = vertical_depth(part, self.grown_low[which], self.grown_high[which])
        some = np.flatnonzero(~(depth <= -SURELY_OUTSIDE))
        ends = np.cumsum(self.outlines.edges[which[some]])
        for these in np.split(some, np.flatnonzero(np.diff(ends // EDGES_AT_ONCE)) + 1):
            chord = chords(part[these, :, :2])
            depth[these] = np.minimum(depth[these], self._level_depth(chord, which[these]))
        return depth

    def gap(self, position: Floats, which: int) -> float:
        """Return the horizontal distance of a position to a prism, or that along z where it is larger, metres."""
        point = position[None, :2]
        deep = self._level_depth(Chords(point, point, np.zeros(1)), np.array([which]))[0]
        level = float(self.clearance - LET_PASS - deep)
        return max(level, float(self.outlines.low[which] - position[2]), float(position[2] - self.outlines.high[which]))

    def _level_depth(self, chord: Chords, which: Indices) -> Floats:
        """Return how deep thick chords may be inside grown polygons seen from above, (n,) metres.

        Outside, the distance to the polygon is the distance to its nearest edge. Inside, no point is deeper than its
        distance from any one edge, and along a chord that distance is largest at one of its ends.
        """
        outlines = self.outlines
        count = outlines.edges[which]
        begins = np.cumsum(count) - count
        of = np.repeat(np.arange(len(which)), count)
        edge = np.arange(len(of)) - begins[of] + outlines.first[which][of]
        a, b, p, q = chord.a[of], chord.b[of], outlines.p[edge], outlines.q[edge]
        from_a, from_b = distance_to_segment(a, p, q), distance_to_segment(b, p, q)
        from_edge = np.minimum(distance_to_segment(p, a, b), distance_to_segment(q, a, b))
        nearest = np.minimum.reduceat(np.minimum(np.minimum(from_a, from_b), from_edge), begins)
        inside = np.add.reduceat(_ray_crosses(a, p, q), begins) % 2 == 1
        touches = inside | np.logical_or.reduceat(_cross(a, b, p, q), begins)
        # a chord from corner to corner crosses no edge, and both its ends are on the outline
        touches |= (nearest <= OUTLINE_CONTACT) & np.any(chord.a != chord.b, axis=1)
        deepest = np.minimum.reduceat(np.maximum(from_a, from_b), begins)
        thick: Floats = self.clearance - LET_PASS + chord.off
        return thick + np.where(touches, deepest, -nearest)


def _cross(a: Floats, b: Floats, p: Floats, q: Floats) -> NDArray[np.bool_]:
    """Tell which segments a to b and p to q, (n, 2) each, cross; those that only touch have a distance of 0 anyway."""
    return (_side(a, b, p) * _side(a, b, q) < 0) & (_side(p, q, a) * _side(p, q, b) < 0)


def _side(a: Floats, b: Floats, p: Floats) -> Floats:
    """Return on which side of the lines from a to b points p, (n, 2) each, lie: 1 left, -1 right, 0 on the line."""
    return np.sign((b[:, 0] - a[:, 0]) * (p[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (p[:, 0] - a[:, 0]))


def _ray_crosses(a: Floats, p: Floats, q: Floats) -> Indices:
    """Tell, as 0 or 1, which edges from p to q a ray from a along x crosses; (n, 2) each."""
    spans = (p[:, 1] > a[:, 1]) != (q[:, 1] > a[:, 1])
    rise = np.where(spans, q[:, 1] - p[:, 1], 1.0)
    return (spans & (p[:, 0] + (a[:, 1] - p[:, 1]) / rise * (q[:, 0] - p[:, 0]) > a[:, 0])).astype(np.intp)


def grown_prisms(shapes: SolidShapes, error: TrackingError = EXACT) -> GrownPrisms:
    """Return all prisms, for a UAV with a tracking error."""
    clearance = reach(shapes.clearance, error)
    low, high = taller(shapes.outlines.low, shapes.outlines.high, error)
    outlines = shapes.outlines._replace(low=low, high=high)
    return GrownPrisms(clearance, shapes.of(Prism)[1], outlines, *grown(low, high, clearance))
