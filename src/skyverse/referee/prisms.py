"""Prisms on polygons with holes: how deep a part of a curve may be inside, by its chord."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Prism
from skyverse.referee.boxes import TOLERANCE
from skyverse.referee.chord import Chords, chords, distance, distance_error

AT_ONCE = 2**19
"""Edges looked at together."""

TOUCH = 1e-8
"""Metres within which a chord may meet an outline; more than rounding."""


class Prisms(NamedTuple):
    """Prisms, and what is shut: grown by the clearance, less the tolerance.

    Attributes
    ----------
    p, q
        (e, 2) ends of the edges of all outlines and holes, one prism's after another's.
    first, edges
        (m,) index of each prism's first edge, and how many it has.
    low, high
        (m,) metres.
    shut, shut_low, shut_high
        (m,) metres that must be kept from the polygon, and the altitudes between which that is so.
    obstacle
        (m,) to which each belongs.
    """

    p: Floats
    q: Floats
    first: Indices
    edges: Indices
    low: Floats
    high: Floats
    shut: Floats
    shut_low: Floats
    shut_high: Floats
    obstacle: Indices

    def hulls(self) -> tuple[Floats, Floats]:
        """Return the corners of boxes about what is shut."""
        if not len(self.first):
            return np.zeros((0, 3)), np.zeros((0, 3))
        low, high = np.minimum.reduceat(self.p, self.first), np.maximum.reduceat(self.p, self.first)
        level = np.maximum(self.shut, 0.0)[:, None]
        return np.column_stack([low - level, self.shut_low]), np.column_stack([high + level, self.shut_high])

    def error(self, b: Floats, error: Floats) -> Floats:
        """Return bounds on the errors of depths, and of hulls."""
        return distance_error(b, error, float(np.abs(self.hulls()).max(initial=0.0)))

    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return how deep parts may be inside: what is not, is beside the polygon, or below, or above."""
        z = part[:, :, 2]
        deep: Floats = np.minimum(z.max(axis=1) - self.shut_low[which], self.shut_high[which] - z.min(axis=1))
        some = np.flatnonzero(~(deep <= -TOLERANCE))
        ends = np.cumsum(self.edges[which[some]])
        for these in np.split(some, np.flatnonzero(np.diff(ends // AT_ONCE)) + 1):
            chord = chords(part[these, :, :2])
            deep[these] = np.minimum(deep[these], self._level(chord, which[these]))
        return deep

    def gap(self, position: Floats, which: int) -> float:
        """Return the level distance of one position to a prism as given, or that along z where it is more."""
        spot = position[None, :2]
        level = float(self.shut[which] - self._level(Chords(spot, spot, np.zeros(1)), np.array([which]))[0])
        return max(level, float(self.low[which] - position[2]), float(position[2] - self.high[which]))

    def _level(self, chord: Chords, which: Indices) -> Floats:
        """Return how deep chords may be inside, seen from above.

        Outside, the distance to the polygon is that to its nearest edge. Inside, no place is deeper than it is far from
        any one edge, and that distance is greatest at an end of the chord.
        """
        if not len(which):
            return np.zeros(0)
        count = self.edges[which]
        begins = np.cumsum(count) - count
        of = np.repeat(np.arange(len(which)), count)
        edge = np.arange(len(of)) - begins[of] + self.first[which][of]
        a, b, p, q = chord.a[of], chord.b[of], self.p[edge], self.q[edge]
        from_a, from_b = distance(a, p, q), distance(b, p, q)
        apart = np.minimum(np.minimum(from_a, from_b), np.minimum(distance(p, a, b), distance(q, a, b)))
        nearest = np.minimum.reduceat(apart, begins)
        inside = np.add.reduceat(_passes(a, p, q), begins) % 2 == 1
        touches = inside | np.logical_or.reduceat(_cross(a, b, p, q), begins)
        # a chord may go from corner to corner: no edge is crossed, both ends are on the outline
        touches |= (nearest <= TOUCH) & np.any(chord.a != chord.b, axis=1)
        deep = np.minimum.reduceat(np.maximum(from_a, from_b), begins)
        level: Floats = self.shut[which] + chord.off
        return level + np.where(touches, deep, -nearest)


def _cross(a: Floats, b: Floats, p: Floats, q: Floats) -> NDArray[np.bool_]:
    """Tell which of the lines a to b and p to q, (n, 2) each, cross; those that only touch have no distance anyway."""
    crossed: NDArray[np.bool_] = (_side(a, b, p) * _side(a, b, q) < 0) & (_side(p, q, a) * _side(p, q, b) < 0)
    return crossed


def _side(a: Floats, b: Floats, p: Floats) -> Floats:
    side: Floats = np.sign((b[:, 0] - a[:, 0]) * (p[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (p[:, 0] - a[:, 0]))
    return side


def _passes(a: Floats, p: Floats, q: Floats) -> Indices:
    """Tell, as 0 or 1, which edges from p to q a ray from a along x crosses."""
    spans = (p[:, 1] > a[:, 1]) != (q[:, 1] > a[:, 1])
    rise = np.where(spans, q[:, 1] - p[:, 1], 1.0)
    passed: Indices = (spans & (p[:, 0] + (a[:, 1] - p[:, 1]) / rise * (q[:, 0] - p[:, 0]) > a[:, 0])).astype(np.intp)
    return passed


def shut_prisms(scenario: Scenario) -> Prisms:
    """Return the scenario's prisms."""
    some = [(k, shape) for k, shape in enumerate(scenario.obstacles) if isinstance(shape, Prism)]
    rings = [ring for _, shape in some for ring in (shape.vertices, *shape.holes)]
    p = np.array([corner for ring in rings for corner in ring]).reshape(-1, 2)
    size = np.array([len(ring) for ring in rings], dtype=np.intp)
    following, begins = np.arange(1, len(p) + 1), np.cumsum(size) - size
    following[begins + size - 1] = begins
    edges = np.array([len(shape.vertices) + sum(map(len, shape.holes)) for _, shape in some], dtype=np.intp)
    first = np.cumsum(edges) - edges
    low, high = (np.array([getattr(shape, side) for _, shape in some], dtype=np.float64) for side in ("low", "high"))
    # A wall thinner than the tolerance is still a wall: only a part of its thickness, area by length, is forgiven.
    thin = np.array([_thickness(shape) for _, shape in some], dtype=np.float64)
    shut = scenario.clearance - np.minimum(TOLERANCE, (thin + 2 * scenario.clearance) / 4)
    grown_low, grown_high = low - scenario.clearance, high + scenario.clearance
    flat = np.minimum(TOLERANCE, (grown_high - grown_low) / 4)
    number = np.array([k for k, _ in some], dtype=np.intp)
    return Prisms(p, p[following], first, edges, low, high, shut, grown_low + flat, grown_high - flat, number)


def _thickness(prism: Prism) -> float:
    """Return twice the area of a prism's polygon by the length of its edges, metres."""
    area = length = 0.0
    for k, ring in enumerate((prism.vertices, *prism.holes)):
        corners = np.array(ring)
        corners = corners - corners[0]
        ahead = np.roll(corners, -1, axis=0)
        part = abs(float(np.sum(corners[:, 0] * ahead[:, 1] - corners[:, 1] * ahead[:, 0]))) / 2
        area += -part if k else part
        length += float(np.linalg.norm(ahead - corners, axis=1).sum())
    return max(2 * area / length, 0.0)
