"""The waypoints of one UAV: few, and proven clear when an autopilot flies straight between them."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.exports.global_positions import AltitudeReference
from skyverse.exports.leg_clearance import LegChecker
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import LEG_ALLOWANCE

MIN_ACCEPTANCE_RADIUS = 0.05
"""Metres: autopilots accept no smaller acceptance radius."""
MAX_WAYPOINTS = 700
"""The largest number of waypoints that autopilots accept."""
PLACES_PER_PIECE = 16
"""Places on each piece of a trajectory at which a waypoint may stand."""
MAX_REPAIRS = 400
MIN_RADIUS_SHARE = 0.25
"""The share of the first radius down to which it is halved before the UAV may stop at corners instead."""
MAX_PUSH = 2.0
"""How many radii a waypoint may be moved outwards."""
MAX_SWELL = 10.0
"""Metres by which a leg above ground may follow rise and fall that the trajectory does not."""


@dataclass(frozen=True, eq=False)
class Route:
    """One UAV's waypoints.

    Attributes
    ----------
    uav
        The index of the UAV.
    points
        (n, 3) metres. The first is the start; with a takeoff the second lies vertically above it.
    times
        (n,) seconds into the mission at which the UAV arrives: those of the trajectory plus all stops before.
    radius
        The acceptance radius with which the route is proven, metres; 0 where the UAV stops at every waypoint.
    takeoff
        The height of the vertical climb from the start, metres.
    off
        The largest deviation of flown legs from the trajectory, metres; with altitudes above ground it includes the
        rise and fall of the ground.
    holds
        (n,) seconds that the UAV stops at each waypoint; above 0 where the corner must not be cut.
    """

    uav: int
    points: Floats
    times: Floats
    radius: float
    takeoff: float
    off: float
    holds: Floats

    @property
    def speeds(self) -> Floats:
        """(n - 1,) m/s along the legs."""
        along = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        speeds: Floats = along / np.maximum(np.diff(self.times) - self.holds[:-1], 1e-9)
        return speeds

    def sentence(self, scenario: Scenario) -> str:
        """Return a sentence on what is proven."""
        name, clearance = scenario.uavs[self.uav].name, max(scenario.clearance - LEG_ALLOWANCE, 0)
        low = max(scenario.ground_clearance - LEG_ALLOWANCE, 0)
        ground = "" if scenario.terrain is None else f", {low:.4g} m above ground"
        cut = f"corners cut within {self.radius:.3g} m" if self.radius else "stopping at each"
        held = int((self.holds > 0).sum())
        cut += f" but at {held}, where it stops" if held else ""
        return (
            f"{name}: {len(self.points)} waypoints, {cut}: straight legs proven within bounds and clear of every "
            f"obstacle by {clearance:.4g} m{ground}, at most {self.off:.3g} m off the trajectory."
        )


def route(
    scenario: Scenario,
    uav: int,
    trajectory: Trajectory,
    reference: AltitudeReference,
    *,
    radius: float,
    takeoff: float,
    stops: bool,
) -> Route:
    """Return a UAV's waypoints.

    Parameters
    ----------
    scenario
        The scenario, which has an origin.
    uav, trajectory
        The index of the UAV, and its trajectory.
    reference
        The reference of altitudes, in which they change linearly between waypoints.
    radius
        The largest acceptance radius, metres. It is halved until the route can be proven.
    takeoff
        The height of the first climb, metres; halved twice, then left out, where an obstacle is above the start.
    stops
        Whether the UAV stops at every waypoint and cuts no corner.

    Raises
    ------
    InputError
        If no radius gives a proven route, or it has more waypoints than autopilots accept.
    """
    legs = LegChecker(scenario, reference)
    instants, curve = _samples(trajectory)
    said = ""
    for climb in [takeoff, takeoff / 2, takeoff / 4, 0.0] if takeoff > 0 else [0.0]:
        lifted = curve[0] + np.array([0.0, 0.0, climb])
        if climb and legs.leg(curve[0], lifted) is not None:
            continue
        for size, may_stop in _sizes(radius, not stops and scenario.uavs[uav].fixed_wing is None):
            search = WaypointPlacement(legs, curve, climb, 0.0 if stops else size, size, may_stop)
            found = search.run()
            if isinstance(found, str):
                said = found
            elif len(found) <= MAX_WAYPOINTS:
                return _made(uav, search, instants, found, climb)
            else:
                said = f"it takes {len(found)} waypoints, and autopilots take {MAX_WAYPOINTS}"
                break
    name = scenario.uavs[uav].name
    raise InputError(
        f"{name}: straight legs between waypoints could not be proven with an acceptance radius from {radius:g} m down "
        f"to {MIN_ACCEPTANCE_RADIUS:g} m: {said}; fly it as a trajectory (.csv, .trajectory.json), or plan with a "
        "larger clearance"
    )


def _sizes(radius: float, may_stop: bool) -> list[tuple[float, bool]]:
    """Return the acceptance radii to try, and for each whether the UAV may stop where a corner is not clear."""
    halved = []
    while radius >= MIN_ACCEPTANCE_RADIUS:
        halved.append(radius)
        radius /= 2
    if not may_stop:
        return [(size, False) for size in halved]
    return [(size, False) for size in halved if size >= MIN_RADIUS_SHARE * halved[0]] + [
        (size, True) for size in halved
    ]


def _made(
    uav: int, search: "WaypointPlacement", instants: Floats, found: list[tuple[int, Floats]], climb: float
) -> Route:
    legs, curve, radius = search.legs, search.curve, search.radius
    points, times = np.array([point for _, point in found]), instants[[k for k, _ in found]]
    # the takeoff does not count as a deviation
    ends = [(0, curve[0]), *found[1:]]
    off = max(float(_off(curve[a : b + 1], p, q).max()) + legs.apart(p, q) for (a, p), (b, q) in pairwise(ends))
    holds = np.array([2 + radius if k in search.stopped else 0.0 for k, _ in found])
    times = times + np.cumsum(np.r_[0.0, holds[:-1]])
    if climb:
        holds = np.r_[0.0, holds]
        points = np.concatenate([curve[:1], points])
        pace = np.linalg.norm(points[2] - points[1]) / max(times[1] - times[0], 1e-9)
        times = np.concatenate([times[:1], times + climb / max(pace, 0.5)])
    return Route(uav, points, times, radius, climb, off, holds)


def _samples(trajectory: Trajectory) -> tuple[Floats, Floats]:
    """Return times and positions on a trajectory, without repetitions where it stands still."""
    shares = np.arange(PLACES_PER_PIECE) / PLACES_PER_PIECE
    t = np.concatenate(
        [(trajectory.knots[:-1, None] + np.diff(trajectory.knots)[:, None] * shares).ravel(), [trajectory.end]]
    )
    curve = trajectory.at(t).position
    moved = np.linalg.norm(np.diff(curve, axis=0), axis=1) > 1e-6
    keep = np.r_[True, moved]
    keep[-1] = True
    if keep[:-1].sum() > 1 and not moved[-1]:
        keep[np.flatnonzero(keep[:-1])[-1]] = False  # the end replaces the samples at the same place
    return t[keep], curve[keep]


def _off(points: Floats, a: Floats, b: Floats) -> Floats:
    """Return the distances of (n, 3) points from the segment between two, (n,) metres."""
    along = b - a
    length = float(along @ along)
    shares = np.clip((points - a) @ along / length, 0.0, 1.0) if length else np.zeros(len(points))
    off: Floats = np.linalg.norm(points - a - shares[:, None] * along, axis=1)
    return off


class WaypointPlacement:
    """Places waypoints on a curve, and moves them outwards where they would cut into something."""

    def __init__(
        self, legs: LegChecker, curve: Floats, climb: float, radius: float, reach: float, may_stop: bool
    ) -> None:
        self.legs, self.curve, self.radius, self.reach, self.may_stop = legs, curve, radius, reach, may_stop
        self.stopped: set[int] = set()
        lifted = curve[0] + np.array([0.0, 0.0, climb])
        self.begin = curve[:1] if climb else curve[:0]
        self.nodes: list[tuple[int, Floats]] = [(0, lifted), (len(curve) - 1, curve[-1])]
        self.pushed: dict[int, float] = {}

    def run(self) -> list[tuple[int, Floats]] | str:
        """Return waypoints as samples' indices and global_positions, or what is wrong with the best that was tried."""
        self._follow()
        for _ in range(MAX_REPAIRS):
            found = self._trouble()
            if found is None:
                self._thin()
                return self.nodes
            where, said = found
            if len(self.nodes) > 2 * MAX_WAYPOINTS or not self._repair(where):
                return said
        return said

    def _points(self) -> Floats:
        return np.concatenate([self.begin, np.array([point for _, point in self.nodes])])

    def _stops(self, nodes: list[tuple[int, Floats]]) -> Floats:
        return np.array([*(0.0 for _ in self.begin), *(float(k in self.stopped) for k, _ in nodes)])

    def _trouble(self) -> tuple[int, str] | None:
        found = self.legs.trouble(self._points(), self.radius, self._stops(self.nodes))
        if found is None:
            return None
        where, said = found
        return where, f"{self._name(where)}: {said}"

    def _name(self, where: int) -> str:
        points = self._points()
        at = points[where - len(points)] if where >= len(points) else points[where]
        noun = "corner at" if where >= len(points) else "leg from"
        return f"the {noun} ({', '.join(f'{value:.6g}' for value in at)})"

    def _follow(self) -> None:
        """Add waypoints until no leg is farther from the curve than the reach: Ramer, Douglas and Peucker."""
        k = 0
        while k < len(self.nodes) - 1:
            off, a = self._between(k, k + 1)
            if len(off) and off.max() > self.reach / 2:
                best = a + 1 + int(np.argmax(off))
                self.nodes.insert(k + 1, (best, self.curve[best]))
            elif len(off) and self._swells(k, k + 1):
                middle = (a + self.nodes[k + 1][0]) // 2
                self.nodes.insert(k + 1, (middle, self.curve[middle]))
            else:
                k += 1

    def _between(self, i: int, j: int) -> tuple[Floats, int]:
        """Return how far the curve between two waypoints is from the leg that joins them, and where it begins."""
        (a, p), (b, q) = self.nodes[i], self.nodes[j]
        return _off(self.curve[a + 1 : b], p if i else self.curve[0], q), a

    def _swells(self, i: int, j: int) -> bool:
        return self.legs.apart(self.nodes[i][1], self.nodes[j][1]) > MAX_SWELL

    def _repair(self, where: int) -> bool:
        """Split a leg that cuts off the curve, or move waypoints outwards; tell whether anything could be done."""
        count = len(self.begin) + len(self.nodes)
        if where >= count:
            k = where - count - len(self.begin)
            return self._push(k) or self._stop(k)
        k = where - len(self.begin)
        if k < 0:
            return False
        off, a = self._between(k, k + 1)
        b = self.nodes[k + 1][0]
        tried = max(self.pushed.get(a, 0.0), self.pushed.get(b, 0.0))
        if len(off) and off.max() > max(tried, LEG_ALLOWANCE / 4):
            best = a + 1 + int(np.argmax(off))
            self.nodes.insert(k + 1, (best, self.curve[best]))
            return True
        stopped = [self._stop(j) for j in (k, k + 1) if self.pushed.get(self.nodes[j][0], 0.0) > 0]
        if any(stopped):
            return True  # moved out of one thing's way into another's
        moved = [self._push(k), self._push(k + 1)]
        if any(moved):
            return True
        if b - a > 1:
            middle = (a + b) // 2
            self.nodes.insert(k + 1, (middle, self.curve[middle]))
            return True
        return False

    def _push(self, k: int) -> bool:
        """Move a waypoint away from the inside of its bend, a little more each time."""
        if not 0 < k < len(self.nodes) - 1:
            return False
        index, _ = self.nodes[k]
        done = self.pushed.get(index, 0.0)
        if done >= MAX_PUSH * self.reach:
            return False
        ahead, behind = self.nodes[k + 1][1] - self.curve[index], self.curve[index] - self.nodes[k - 1][1]
        bend = ahead / np.linalg.norm(ahead) - behind / np.linalg.norm(behind)
        size = float(np.linalg.norm(bend))
        if size < 1e-6:
            return False
        self.pushed[index] = min(done + max(done, LEG_ALLOWANCE), MAX_PUSH * self.reach)
        self.nodes[k] = index, self.curve[index] - bend / size * self.pushed[index]
        return True

    def _stop(self, k: int) -> bool:
        """Stop at a waypoint whose corner cannot be cut, back on the curve."""
        if not (self.may_stop and 0 < k < len(self.nodes) - 1) or self.nodes[k][0] in self.stopped:
            return False
        index, _ = self.nodes[k]
        self.stopped.add(index)
        self.nodes[k] = index, self.curve[index]
        return True

    def _thin(self) -> None:
        """Leave out every waypoint without which the rest is still proven and near the curve."""
        k = 1
        while k < len(self.nodes) - 1:
            without = self.nodes[:k] + self.nodes[k + 1 :]
            near = self._between(k - 1, k + 1)[0].max() <= 2 * self.reach and not self._swells(k - 1, k + 1)
            beside = np.concatenate([self.begin, np.array([point for _, point in without])])
            j = k + len(self.begin)
            part = slice(max(j - 3, 0), j + 3)
            if near and self.legs.trouble(beside[part], self.radius, self._stops(without)[part]) is None:
                self.nodes = without
            else:
                k += 1
