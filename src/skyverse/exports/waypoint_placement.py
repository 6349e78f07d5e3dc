"""Places waypoints on a trajectory so that straight legs between them are clear."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.leg_space import Breach, Segments
from skyverse.exports.legs import LegChecker
from skyverse.model.frame import Origin
from skyverse.model.geodesy import told_place
from skyverse.numerics.tolerances import LEG_ALLOWANCE, STRAIGHT_ON

MAX_WAYPOINTS = 700
"""The largest number of waypoints that autopilots accept."""
MAX_REPAIRS = 400
"""The largest number of attempts to mend a route."""
MAX_PUSH = 2.0
"""The largest distance by which a waypoint is moved outwards, as a multiple of the radius."""
MAX_BEND = 2.0
"""Metres: the largest deviation of a leg from the trajectory by the rise and fall of the ground below."""


class Obstruction(NamedTuple):
    """Why no waypoints were found: the leg or corner of the last attempt, in words, and its fault."""

    where: str
    fault: Breach | Segments


class FixedPlaces(NamedTuple):
    """Samples of a curve at which there must be waypoints.

    Attributes
    ----------
    stops
        Those at which the UAV stops in any case, and for each whether it is one that it has to visit.
    passes, places
        Those that it passes, and those that it has to visit in the way that is usual for its autopilot.
    only_passes
        Whether it stops at all others.
    """

    stops: Mapping[int, bool]
    passes: frozenset[int] = frozenset()
    places: frozenset[int] = frozenset()
    only_passes: bool = False


class WaypointPlacement:
    """A search that places waypoints on a curve, and moves them outwards where legs come too near to obstacles.

    Parameters
    ----------
    legs
        Checks the legs.
    climb
        (k, 3) metres: where the UAV's climb has to be clear from, if it climbs at all, and where it ends.
    curve
        (n, 3) metres: samples of the trajectory after that.
    radius, reach
        The acceptance radius, and how far legs may be off the curve, metres.
    may_stop
        Whether the UAV may stop where it cannot cut a corner.
    fixed
        Where there must be waypoints.
    by_curve
        Whether the bend, to the outside of which a waypoint is moved, is that of the curve. Else it is that of the
        waypoints, neighbours that were moved included: where bends are close together, the way between two of them may
        then lead backwards, but where they are not, fewer moves suffice.
    """

    def __init__(
        self,
        legs: LegChecker,
        climb: Floats,
        curve: Floats,
        radius: float,
        reach: float,
        may_stop: bool,
        fixed: FixedPlaces,
        *,
        by_curve: bool = False,
    ) -> None:
        self.legs, self.lead, self.curve, self.may_stop = legs, climb[:-1], curve, may_stop
        self.radius, self.reach = radius, reach
        self.stopped, self.passes, self.only_passes = set(fixed.stops), fixed.passes, fixed.only_passes
        self.fixed = frozenset(fixed.stops) | fixed.passes | fixed.places
        self.visited = frozenset(k for k in self.fixed if fixed.stops.get(k, True))
        self.blocked: tuple[int, ...] = ()
        between = [k for k in sorted(self.fixed) if 0 < k < len(curve) - 1]
        self.nodes: list[tuple[int, Floats]] = [(0, climb[-1]), *((k, curve[k]) for k in between)]
        self.nodes.append((len(curve) - 1, curve[-1]))
        self.pushed: dict[int, float] = {}
        self.by_curve = by_curve

    def run(self) -> list[tuple[int, Floats]] | Obstruction:
        """Return the waypoints as indices of samples and positions, or what obstructed the last attempt."""
        self._follow()
        for _ in range(MAX_REPAIRS):
            points = self._points()
            found = self.legs.trouble(points, self.radius, self._stops(self.nodes))
            if found is None:
                self._thin()
                return self.nodes
            where, fault = found
            obstruction = Obstruction(_named(self.legs.scenario.frame.origin, points, where), fault)
            self.blocked = self._beside(where, len(points))
            if len(self.nodes) > 2 * MAX_WAYPOINTS or not self._repair(where):
                break
        return obstruction

    def _points(self) -> Floats:
        return np.concatenate([self.lead, np.array([point for _, point in self.nodes])])

    def _stops(self, nodes: list[tuple[int, Floats]]) -> Floats:
        stops = [k in self.stopped or (self.only_passes and k not in self.passes) for k, _ in nodes]
        return np.array([*(0.0 for _ in self.lead), *map(float, stops)])

    def _beside(self, where: int, count: int) -> tuple[int, ...]:
        """Return the samples at the ends of a leg, or around a corner, as `LegChecker.trouble` counts them."""
        k = where % count - len(self.lead)
        around = range(k - 1, k + 2) if where >= count else range(k, k + 2)
        return tuple(self.nodes[j][0] for j in around if 0 <= j < len(self.nodes))

    def _follow(self) -> None:
        """Add waypoints until no leg is farther from the curve than half the reach (Ramer, Douglas and Peucker)."""
        k = 0
        while k < len(self.nodes) - 1:
            off, a = self._between(k, k + 1)
            if len(off) and off.max() > self.reach / 2:
                self._insert(k + 1, a + 1 + int(np.argmax(off)))
            elif len(off) and self._bends(k, k + 1):
                self._insert(k + 1, (a + self.nodes[k + 1][0]) // 2)
            else:
                k += 1

    def _insert(self, k: int, index: int) -> None:
        """Add waypoint k at a sample of the curve."""
        self.nodes.insert(k, (index, self.curve[index]))

    def _between(self, i: int, j: int) -> tuple[Floats, int]:
        """Return the distances of the samples between two waypoints from their leg, and the index before the first."""
        (a, p), (b, q) = self.nodes[i], self.nodes[j]
        return distances_to_segment(self.curve[a + 1 : b], p if i else self.curve[0], q), a

    def _bends(self, i: int, j: int) -> bool:
        return self.legs.bend(self.nodes[i][1], self.nodes[j][1]) > MAX_BEND

    def _repair(self, where: int) -> bool:
        """Split a leg that leaves the curve, or move its waypoints outwards; return whether anything was changed."""
        count = len(self.lead) + len(self.nodes)
        if where >= count:
            k = where - count - len(self.lead)
            return self._push(k) or self._stop(k)
        k = where - len(self.lead)
        if k < 0:
            return False
        off, a = self._between(k, k + 1)
        b = self.nodes[k + 1][0]
        tried = max(self.pushed.get(a, 0.0), self.pushed.get(b, 0.0))
        if len(off) and off.max() > max(tried, LEG_ALLOWANCE / 4):
            self._insert(k + 1, a + 1 + int(np.argmax(off)))
            return True
        stopped = [self._stop(j) for j in (k, k + 1) if self.pushed.get(self.nodes[j][0], 0.0) > 0]
        if any(stopped):
            return True  # a waypoint moved away from one obstacle has come too near to another
        moved = [self._push(k), self._push(k + 1)]
        if any(moved):
            return True
        if b - a > 1:
            self._insert(k + 1, (a + b) // 2)
            return True
        return False

    def _push(self, k: int) -> bool:
        """Move a waypoint to the outside of its bend, by twice as much each time; return whether it moved."""
        if not 0 < k < len(self.nodes) - 1:
            return False
        index, _ = self.nodes[k]
        done = self.pushed.get(index, 0.0)
        if index in self.fixed or done >= MAX_PUSH * self.reach:
            return False
        ahead, behind = self._neighbour(k + 1) - self.curve[index], self.curve[index] - self._neighbour(k - 1)
        bend = ahead / math.hypot(*ahead) - behind / math.hypot(*behind)
        size = math.hypot(*bend)
        if size < STRAIGHT_ON:
            return False
        self.pushed[index] = min(done + max(done, LEG_ALLOWANCE), MAX_PUSH * self.reach)
        self.nodes[k] = index, self.curve[index] - bend / size * self.pushed[index]
        return True

    def _neighbour(self, k: int) -> Floats:
        """Return the place of waypoint k, or where it is on the curve; the first is where the climb ends."""
        index, place = self.nodes[k]
        return self.curve[index] if self.by_curve and index else place

    def _stop(self, k: int) -> bool:
        """Let the UAV stop at a waypoint on the curve, whose corner cannot be cut; return whether it may."""
        if not (self.may_stop and 0 < k < len(self.nodes) - 1) or self.nodes[k][0] in self.stopped | self.passes:
            return False
        index, _ = self.nodes[k]
        self.stopped.add(index)
        self.nodes[k] = index, self.curve[index]
        return True

    def _thin(self) -> None:
        """Remove every waypoint without which the route is still clear and near the curve."""
        k = 1
        while k < len(self.nodes) - 1:
            without = self.nodes[:k] + self.nodes[k + 1 :]
            near = self._between(k - 1, k + 1)[0].max() <= 2 * self.reach and not self._bends(k - 1, k + 1)
            points = np.concatenate([self.lead, np.array([point for _, point in without])])
            j = k + len(self.lead)
            part = slice(max(j - 3, 0), j + 3)
            may_go = near and self.nodes[k][0] not in self.visited
            if may_go and self.legs.trouble(points[part], self.radius, self._stops(without)[part]) is None:
                self.nodes = without
            else:
                k += 1


def _named(origin: Origin | None, points: Floats, where: int) -> str:
    """Name a leg or corner of a polyline, as `LegChecker.trouble` counts them, and its place."""
    k = where % len(points)
    if where >= len(points):
        return f"the corner at the end of leg {k}, {told_place(origin, points[k])}"
    return f"leg {k + 1} from {told_place(origin, points[k])} to {told_place(origin, points[k + 1])}"


def distances_to_segment(points: Floats, a: Floats, b: Floats) -> Floats:
    """Return the distances of (n, 3) points from the segment between two, (n,) metres."""
    along = b - a
    square = float(np.sum(along**2))
    shares = np.clip(np.sum((points - a) * along, axis=1) / square, 0.0, 1.0) if square else np.zeros(len(points))
    return np.linalg.norm(points - a - shares[:, None] * along, axis=1)
