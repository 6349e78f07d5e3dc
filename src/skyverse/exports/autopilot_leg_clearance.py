"""Checks that straight legs, flown as an autopilot flies them, keep clear of obstacles.

A leg that is straight for an autopilot is not quite straight in local metres, altitudes above ground follow the ground,
and MAVLink rounds to 1e-7 degrees. The difference is bounded for each leg and added to the clearance.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.corner_lines import is_straight, search_corner
from skyverse.exports.followed_legs import FollowedLegs
from skyverse.exports.global_positions import AltitudeReference
from skyverse.exports.ground_under_legs import ceiling_margin, greatest_height, lowered, steepest, swell
from skyverse.exports.leg_deviation import leg_deviation
from skyverse.exports.leg_segments import Checked, Foot, Segments, Shortfall, towards
from skyverse.exports.obstacle_search import ObstacleSearch
from skyverse.exports.terrain_following import TerrainFollowing
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Terrain
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import LEG_ALLOWANCE, MAVLINK_ROUNDING, SAME_PLACE
from skyverse.space.tube import NO_ERROR
from skyverse.space.world import World


@dataclass(frozen=True, eq=False)
class LegChecker:
    """Checks the legs and corners of one scenario, with altitudes of one reference; it remembers its answers.

    It searches with the planners' `World`, which is fast. Whatever is exported is then proven by the referee, in
    `leg_certificate`.

    Attributes
    ----------
    scenario, reference
        As given.
    error
        How far the flown position may be from the legs.
    columns
        (foot, top) of the vertical lines over the UAV's own start and target in which the error does not count for what
        lies below, (3,) metres each.
    worlds
        What is compiled for each error; checkers of the same scenario and reference may share it.
    """

    scenario: Scenario
    reference: AltitudeReference
    error: TrackingError = NO_ERROR
    columns: tuple[tuple[Floats, Floats], ...] = ()
    worlds: dict[TrackingError, World] = field(default_factory=dict)
    _known: dict[bytes, Checked] = field(default_factory=dict)
    _apart: dict[bytes, float] = field(default_factory=dict)

    @cached_property
    def search(self) -> ObstacleSearch:
        """What finds obstacles."""
        return ObstacleSearch(self.scenario, self.reference, self.error, self.worlds)

    @cached_property
    def _followed(self) -> FollowedLegs | None:
        """What checks legs with altitudes above ground; ``None`` with others."""
        if self.reference != "agl":
            return None
        assert self.scenario.terrain is not None
        return FollowedLegs(self.search, TerrainFollowing(self.scenario.terrain, self.error))

    def trouble(self, points: Floats, radius: float, stops: Floats) -> tuple[int, Shortfall | Segments] | None:
        """Return the first fault of a polyline, (n, 3), whose corners are cut within a radius, or ``None``.

        Where `stops`, (n,), is not 0, the corner is not cut. A fault comes with an index: that of the first vertex of
        the leg, or n plus that of the corner.
        """
        for where, checked, _ in self.parts(points, radius, stops):
            if checked.fault is not None:
                return where, checked.fault
        return None

    def parts(self, points: Floats, radius: float, stops: Floats) -> Iterator[tuple[int, Checked, bytes]]:
        """Yield the index, as in `trouble`, of each leg and corner of a polyline, what is found of it, and its key."""
        for k in range(len(points) - 1):
            yield k, *self._remembered(self.leg, points[k : k + 2])
        if radius <= 0:
            return
        for k, corner in cut_corners(points, radius, stops):
            yield len(points) + k, *self._remembered(self.corner, corner, radius)

    def _remembered(self, check: Callable[..., Checked], points: Floats, *radius: float) -> tuple[Checked, bytes]:
        asked = np.r_[points.ravel(), radius].tobytes()
        if asked not in self._known:
            self._known[asked] = check(*points, *radius)
        return self._known[asked], asked

    def refuse(self, key: bytes, fault: Segments) -> None:
        """Remember that the referee does not prove a leg or corner, which counts as faulty from now on."""
        self._known[key] = Checked(fault)

    def leg(self, a: Floats, b: Floats) -> Checked:
        """Return what is found of a leg from a to b, (3,) metres each."""
        found = [self._straight(*part) for part in self._cut_at_columns(a, b)]
        fault = next((one.fault for one in found if one.fault is not None), None)
        return Checked(fault, () if fault is not None else tuple(part for one in found for part in one.clear))

    def _cut_at_columns(self, a: Floats, b: Floats) -> Iterator[tuple[Floats, Floats, bool, Foot | None]]:
        """Yield the parts of a leg, whether the error counts for each, and the foot of a column in which it does."""
        for foot, top in self.columns:
            low, high = (a, b) if a[2] <= b[2] else (b, a)
            if np.abs(np.stack([a, b])[:, :2] - foot[:2]).max() > SAME_PLACE or low[2] < foot[2] - SAME_PLACE:
                continue
            if low[2] >= top[2]:
                yield a, b, True, None
                return
            held = (a, b) if high[2] <= top[2] else (low, top)
            x, y, z = foot.tolist()
            yield *held, False, None
            yield *held, True, (x, y, z)
            if high[2] > top[2]:
                yield top, high, True, None
            return
        yield a, b, True, None

    def _straight(self, a: Floats, b: Floats, strays: bool, foot: Foot | None) -> Checked:
        """Return what is found of a leg from a to b, (3,) metres each, with or without the tracking error."""
        if self._followed is not None:
            return self._followed.leg(a, b, strays, foot)
        return self.search.checked(a[None], b[None], self.apart(a, b), strays, foot)

    def below_ceiling(self, points: Floats) -> Floats:
        """Return a curve's points (n, 3) metres, lowered where legs between them, or rounding, exceed the ceiling.

        What is above the ceiling stays there, and so does what is in a column over the UAV's own start or target.
        """
        most = self.scenario.max_height
        if most is None:
            return points
        room = ceiling_margin(self.scenario)
        excess = greatest_height(points, self._lowest, most - room) - most + room
        above = points[:, 2] - self._lowest.height(points[:, :2])
        excess[above > most + LEG_ALLOWANCE] = 0.0  # a waypoint cannot mend that
        for foot, top in self.columns:
            beside = np.abs(points[:, :2] - foot[:2]).max(axis=1) <= SAME_PLACE
            excess[beside & (points[:, 2] <= top[2])] = 0.0
        return points - np.maximum(excess, 0.0)[:, None] * np.array([0.0, 0.0, 1.0])

    @cached_property
    def _lowest(self) -> Terrain:
        """The lowest ground, lowered by what it may fall, and the UAV rise, within the error.

        Heights above ground are counted from `Terrain.heights`, and the UAV may follow any ground down to the lowest.
        """
        terrain = self.scenario.terrain
        assert terrain is not None
        if self._followed is None:
            return lowered(terrain.lowest_ground, self.error)
        return self._followed.below_ceiling(MAVLINK_ROUNDING)

    @cached_property
    def _slope(self) -> float:
        """The steepest slope of the ground and of the ceiling above it; 0 where altitudes follow the ground."""
        terrain = self.scenario.terrain
        if terrain is None or self.reference == "agl":
            return 0.0
        return max(steepest(terrain), steepest(terrain.lowest_ground))

    def corner(self, entered: Floats, before: Floats, at: Floats, after: Floats, radius: float) -> Checked:
        """Return what is found of all ways that an autopilot may fly around a corner to the next vertex.

        An autopilot turns within the radius of `at` and from there flies to `after` or back to the leg. It therefore
        stays between the leg and the straight line from where it turned to `after`. It comes from `before`, or from
        `entered` if it has cut the corner at `before`.
        """
        if self._followed is not None:
            return self._followed.corner(entered, before, at, after, radius)
        cut = np.stack([towards(before - at, radius), towards(entered - at, radius)])
        if is_straight(cut, after - at):
            return Checked(None)
        apart = max(self.apart(before, at), self.apart(at, after))
        return search_corner(
            cut, at, after, radius, self._slope, lambda a, b, beside: self.search.checked(a, b, apart + beside)
        )

    def apart(self, a: Floats, b: Floats) -> float:
        """Return by how many metres a flown leg can be nearer to something than the straight line in local metres.

        Where the flown leg is to the side, the ground may be higher by its slope, and the ceiling lower.
        """
        ends = np.stack([a, b])
        asked = ends.tobytes()
        if asked not in self._apart:
            if self._followed is None:
                beside = float(leg_deviation(self.scenario, math.hypot(*(b - a)[:2])))
                self._apart[asked] = MAVLINK_ROUNDING + beside * (1 + self._slope)
            else:
                self._apart[asked] = self._followed.apart(a, b)
        return self._apart[asked]

    def deviations(self, points: Floats, radius: float, stops: Floats) -> Floats:
        """Return how far each leg of a polyline, as in `trouble`, may be off the straight line, (n - 1,) metres.

        With altitudes above ground that also holds for what is flown after a cut corner.
        """
        found = np.array([self.apart(a, b) for a, b in pairwise(points)])
        if self._followed is None or radius <= 0:
            return found
        for k, corner in cut_corners(points, radius, stops):
            found[k] = max(found[k], self._followed.apart_after(corner, radius))
        return found

    def swell(self, a: Floats, b: Floats) -> float:
        """Return how far a leg is off the straight line, metres, as far as that depends on how long it is."""
        if self.reference != "agl":
            return self.apart(a, b)
        assert self.scenario.terrain is not None
        return swell(self.scenario.terrain, a, b)


def cut_corners(points: Floats, radius: float, stops: Floats) -> Iterator[tuple[int, Floats]]:
    """Yield the index of each vertex of a polyline, as in `LegChecker.trouble`, whose corner is cut, and four points.

    These, (4, 3) metres, are that where the leg before begins, if its corner is cut as far as possible, the vertex
    before, the vertex and the one after.
    """
    for k in range(1, len(points) - 1):
        if stops[k]:
            continue
        entered = points[k - 1]
        if k > 1 and not stops[k - 1]:
            entered = points[k - 1] + towards(points[k - 2] - points[k - 1], radius)
        yield k, np.concatenate([entered[None], points[k - 1 : k + 2]])
