"""The places of a flight from which a UAV may return, in parts that are halved until something is known of each."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.leg_deviation import leg_deviation
from skyverse.exports.leg_segments import towards
from skyverse.model.scenario import Scenario
from skyverse.numerics.tolerances import MAVLINK_ROUNDING


class Parts(NamedTuple):
    """Parts of a flight.

    A leg is a strip: its corner may be cut, so that it begins anywhere between its waypoint and the far end of the cut.

    Attributes
    ----------
    leg
        (n,) indices of legs.
    begin, end
        (n,) shares of the leg's length.
    near, far
        (n,) shares of the cut: 0 is the waypoint, 1 the far end.
    """

    leg: NDArray[np.intp]
    begin: Floats
    end: Floats
    near: Floats
    far: Floats

    def of(self, some: NDArray[np.bool_] | NDArray[np.intp]) -> "Parts":
        """Return some of the parts."""
        return Parts._make(column[some] for column in self)

    def halved(self, across: NDArray[np.bool_]) -> "Parts":
        """Return both halves of each part: cut across the strip where `across`, (n,), else along it."""
        along, beside = (self.begin + self.end) / 2, (self.near + self.far) / 2
        first = self._replace(end=np.where(across, self.end, along), far=np.where(across, beside, self.far))
        second = self._replace(begin=np.where(across, self.begin, along), near=np.where(across, beside, self.near))
        return joined_parts([first, second])


def joined_parts(each: list[Parts]) -> Parts:
    """Return all parts of several."""
    return Parts._make(np.concatenate(columns) for columns in zip(*each, strict=True))


class Spread(NamedTuple):
    """How far places of parts may be from their middles, along the parts and across them: (n,) metres, each.

    Attributes
    ----------
    any_way, level, upright
        In any direction, seen from above, and up and down.
    """

    any_way: tuple[Floats, Floats]
    level: tuple[Floats, Floats]
    upright: tuple[Floats, Floats]


@dataclass(frozen=True, eq=False)
class FlownLegs:
    """The legs of one UAV's flight, as far as its return is concerned.

    Attributes
    ----------
    starts, ends
        (n, 3) metres: the waypoints of each leg.
    cut
        (n, 3) metres: from the first waypoint to the far end of the cut of its corner; 0 where none is cut.
    width
        (n,) metres: how far the UAV may be beside the line of the cut at its far end.
    off
        (n,) metres: how far the UAV may be off a leg, because its straight line is another one.
    rise
        (n,) metres: how much higher it may be, because it may follow the ground.
    """

    starts: Floats
    ends: Floats
    cut: Floats
    width: Floats
    off: Floats
    rise: Floats

    @property
    def lengths(self) -> Floats:
        """(n,) metres."""
        return np.linalg.norm(self.ends - self.starts, axis=1)

    def whole(self, longest: float) -> Parts:
        """Return parts of all legs that are no longer than `longest` metres."""
        counts = np.maximum(np.ceil(self.lengths / longest).astype(int), 1)
        leg = np.repeat(np.arange(len(counts)), counts)
        begin = np.concatenate([np.arange(count) / count for count in counts])
        return Parts(leg, begin, begin + 1 / counts[leg], np.zeros(len(leg)), np.ones(len(leg)))

    def samples(self, count: int) -> Parts:
        """Return places that are spread evenly over the flight, as parts without length."""
        shares = (np.arange(count) + 0.5) / count * self.lengths.sum()
        ends = np.cumsum(self.lengths)
        leg = np.minimum(np.searchsorted(ends, shares), len(ends) - 1)
        at = 1 - (ends[leg] - shares) / self.lengths[leg]
        return Parts(leg, at, at, np.zeros(count), np.zeros(count))

    def last_place(self) -> Parts:
        """Return the end of the flight as a part without length."""
        one = np.ones(1)
        return Parts(np.array([len(self.starts) - 1]), one, one, 0 * one, 0 * one)

    def places(self, parts: Parts, along: Floats, beside: Floats) -> Floats:
        """Return the places (n, 3) at shares (n,) of the legs' lengths and of their cuts, metres."""
        begin = self.starts[parts.leg] + beside[:, None] * self.cut[parts.leg]
        return begin + along[:, None] * (self.ends[parts.leg] - begin)

    def middles(self, parts: Parts) -> Floats:
        """Return the middle (n, 3) of each part, metres."""
        return self.places(parts, (parts.begin + parts.end) / 2, (parts.near + parts.far) / 2)

    def box(self, parts: Parts) -> tuple[Floats, Floats]:
        """Return the least and greatest corner, (n, 3) metres each, of the box around each part; a leg is straight."""
        corners = np.stack([self.places(parts, a, u) for a in parts[1:3] for u in parts[3:]])
        wide = self._width(parts)[:, None]
        return corners.min(axis=0) - wide, corners.max(axis=0) + wide

    def spread(self, parts: Parts) -> "Spread":
        """Return how far places of a part may be from its middle."""
        leg = parts.leg
        cut = self.cut[leg]
        way = self.ends[leg] - self.starts[leg]
        ways = [_sizes(way - u[:, None] * cut) for u in parts[3:]]
        half, beside, width = (parts.end - parts.begin) / 2, (parts.far - parts.near) / 2, self._width(parts)
        return Spread._make(
            (half * np.maximum(near, far), (1 - parts.begin) * (beside * size) + width)
            for near, far, size in zip(*ways, _sizes(cut), strict=True)
        )

    def halvable(self, parts: Parts) -> tuple[Floats, Floats]:
        """Return the metres of `spread` in any direction that halving makes less, along the parts and across them.

        The far half of a cut stays as wide beside its line as the whole.
        """
        along, across = self.spread(parts).any_way
        return along, across - (1 - parts.begin) * parts.near * self.width[parts.leg]

    def _width(self, parts: Parts) -> Floats:
        return (1 - parts.begin) * parts.far * self.width[parts.leg]

    def metres(self, parts: Parts) -> float:
        """Return how many metres of the flight are in some parts of it, where a cut counts by its share."""
        return float(((parts.end - parts.begin) * (parts.far - parts.near) * self.lengths[parts.leg]).sum())


def flown_legs(plan: FlightPlan, scenario: Scenario, low: float) -> FlownLegs:
    """Return the legs of a flight plan from the first waypoint to the end, a landing down to z = `low` included.

    A return during the take-off is one from its end: it uses the same lines.
    """
    points, rise = plan.waypoints, plan.route.deviations
    cut, width = _cut_corners(plan)
    off = MAVLINK_ROUNDING + leg_deviation(scenario, np.linalg.norm(np.diff(points, axis=0), axis=1))
    if len(plan.ending) == 1:
        landed = np.array([*plan.ending[0][:2], min(low, points[-1][2])])
        points = np.concatenate([points, landed[None]])
        off, width, rise = np.r_[off, MAVLINK_ROUNDING], np.r_[width, 0.0], np.r_[rise, MAVLINK_ROUNDING]
        cut = np.concatenate([cut, np.zeros((1, 3))])
    return FlownLegs(points[:-1], points[1:], cut, width, off, rise)


def _cut_corners(plan: FlightPlan) -> tuple[Floats, Floats]:
    """Return how corners are cut, as `cut` and `width` of `FlownLegs`.

    A UAV turns to a leg at its first waypoint, or up to the radius before it, on the leg before or on the way to that
    from where it turned to it: in a triangle of the waypoint and two places p and q before it. To its first leg it may
    turn before the end of the take-off.
    """
    points, stops = plan.waypoints, plan.full_stops
    cut, width = np.zeros((len(points) - 1, 3)), np.zeros(len(points) - 1)
    below = towards(plan.home - points[0], plan.takeoff_cut)
    cut[:1] = below
    for k in range(1, len(points) - 1):
        if stops[k]:
            continue
        before, at, radius = points[k - 1], points[k], plan.route.radius
        entered = before + below if k == 1 else before
        if k > 1 and not stops[k - 1]:
            entered = before + towards(points[k - 2] - before, radius)
        p, q = towards(before - at, radius), towards(entered - at, radius)
        cut[k] = (p + q) / 2
        width[k] = math.dist(p, q) / 2
    return cut, width


def _sizes(vectors: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the lengths of vectors (n, 3), as `Spread` counts them."""
    x, y, z = (vectors * vectors).T
    level = x + y
    return np.sqrt(level + z), np.sqrt(level), np.abs(vectors[:, 2])
