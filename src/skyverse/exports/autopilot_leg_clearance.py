"""Checks that straight legs, flown as an autopilot flies them, keep clear of obstacles.

A leg that is straight in a file is not quite straight in local metres: Earth is round, altitudes above ground follow
the ground, and MAVLink rounds to 1e-7 degrees. The difference is bounded for each leg and added to the clearance.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.global_positions import AltitudeReference, origin_of
from skyverse.exports.ground_under_legs import (
    breaks,
    ceiling_margin,
    greatest_height,
    lowered,
    second_differences,
    steepest,
    swell,
)
from skyverse.model.geodesy import to_local, to_wgs84
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Terrain
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import (
    LEG_ALLOWANCE,
    MAVLINK_ROUNDING,
    MIN_GROWTH,
    SAME_PLACE,
    SEAM_MARGIN,
    SURFACE_DEPTH,
)
from skyverse.space.tube import NO_ERROR, raised
from skyverse.space.world import World

LINE_HALF_WIDTHS = (0.32, 0.08, 0.02)
"""Metres: half the distance between the lines by which a cut corner is judged, tried from coarse to fine.

With an acceptance radius above `WIDE_CORNER` they grow in proportion, so that a large corner takes no more lines.
"""
WIDE_CORNER = 2.0
"""Metres."""
LATE_SHARE = 1 / 8
"""The last share of those lines, judged by itself, because the lines converge there."""
MIN_EARTH_RADIUS = 6_335_439.0
"""Metres: the least radius of curvature of the WGS84 ellipsoid."""


Foot = tuple[float, float, float]


class Segments(NamedTuple):
    """Straight segments that keep clear of all obstacles by the clearance.

    Attributes
    ----------
    starts, ends
        (n, 3) metres.
    growth
        Metres beside the clearance less `LEG_ALLOWANCE`.
    strays
        Whether the tracking error counts. In a column over the UAV's own start or target, segments are asked for twice:
        without the error, and with it among all but what lies below.
    foot
        In the latter case, x, y and z of the foot of that column, metres.
    touches
        Whether some of them are so near to a grown shape that they may lead through a seam, between shapes that touch.
    """

    starts: Floats
    ends: Floats
    growth: float
    strays: bool = True
    foot: Foot | None = None
    touches: bool = False


class Checked(NamedTuple):
    """What the search found of a leg or of a corner.

    Attributes
    ----------
    fault
        What is wrong, in words or as segments that meet something; ``None`` if nothing is.
    clear
        The segments that make it clear, which the referee has yet to prove.
    """

    fault: str | Segments | None
    clear: tuple[Segments, ...] = ()


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
    _beside: dict[Foot, World] = field(default_factory=dict)
    _known: dict[bytes, Checked] = field(default_factory=dict)
    _apart: dict[bytes, float] = field(default_factory=dict)

    def world(self, strays: bool, foot: Foot | None = None) -> World:
        """Return the planners' world of `grown`, with the tracking error or without it, perhaps that of a column."""
        error = self.error if strays else NO_ERROR
        if error not in self.worlds:
            self.worlds[error] = World(self.grown(0.0), error)
        if foot is None:
            return self.worlds[error]
        if foot not in self._beside:
            self._beside[foot] = self.worlds[error].beside(foot, self.roof(foot) + SURFACE_DEPTH)
        return self._beside[foot]

    def roof(self, foot: Foot) -> float:
        """Return z of the highest roof that is exempt from the error in a column, metres."""
        return foot[2] - self.scenario.clearance

    def trouble(self, points: Floats, radius: float, stops: Floats) -> tuple[int, str | Segments] | None:
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
        for k in range(1, len(points) - 1):
            if stops[k]:
                continue
            entered = points[k - 1]
            if k > 1 and not stops[k - 1]:
                entered = points[k - 1] + towards(points[k - 2] - points[k - 1], radius)
            corner = np.concatenate([entered[None], points[k - 1 : k + 2]])
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
        if self.reference == "agl":  # heights above ground between the ends lie between those of the ends
            ends = np.stack([a, b])
            assert self.scenario.terrain is not None
            above = ends[:, 2] - self.scenario.terrain.height(ends[:, :2])
            low = float(above.min())
            needed = self.scenario.ground_clearance - LEG_ALLOWANCE / 2
            if strays and self.error != NO_ERROR:
                low -= self._rise(ends)
            if low < needed and foot is None:
                return Checked(f"it is {low:.4g} m above ground, and {needed:.4g} m are required")
            most, high = self.scenario.max_height, self._highest_above_ground(ends, above, strays)
            if most is not None and high > most:
                return Checked(f"it may be {high:.5g} m above ground, above the ceiling of {most:.5g} m")
        return self._checked(a[None], b[None], self.apart(a, b), strays, foot)

    def _rise(self, ends: Floats) -> float:
        """Return how many metres the error takes, at most, of the heights above ground of a leg between two ends."""
        terrain, higher = self.scenario.terrain, self._higher
        assert terrain is not None
        places = ends[0, :2] + breaks(terrain, *ends)[:, None] * (ends[1] - ends[0])[:2]
        taken = higher.height(places) - terrain.height(places)
        return float(taken.max() + second_differences(taken).max() / 8)

    def _highest_above_ground(self, ends: Floats, above: Floats, strays: bool) -> float:
        """Return how high above the lowest ground a leg is at most that follows the ground, metres.

        Parameters
        ----------
        ends
            (2, 3) metres: the ends of the leg.
        above
            (2,) metres: how high they are above the ground.
        strays
            Whether the tracking error counts.
        """
        terrain = self.scenario.terrain
        assert terrain is not None
        lowest = self._lowest if strays else terrain.lowest_ground
        at = breaks(terrain, *ends)
        places = ends[0, :2] + at[:, None] * (ends[1] - ends[0])[:2]
        between = terrain.height(places) - lowest.height(places)
        high = above[0] + at * (above[1] - above[0]) + between
        beside = (MAVLINK_ROUNDING + 1.1 * self._curved(ends)) * (steepest(terrain) + steepest(lowest))
        return float(high.max() + second_differences(between).max() / 8) + beside + LEG_ALLOWANCE / 2

    def below_ceiling(self, points: Floats) -> Floats:
        """Return a curve's points (n, 3) metres, lowered where a leg might exceed the ceiling because of rounding.

        What is above the ceiling stays there, and so does what is in a column over the UAV's own start or target.
        """
        most = self.scenario.max_height
        if most is None:
            return points
        room = ceiling_margin(self.scenario)
        if self.reference == "agl":
            assert self.scenario.terrain is not None
            room += MAVLINK_ROUNDING * steepest(self.scenario.terrain)
        excess = greatest_height(points, self._lowest, most - room) - most + room
        excess[excess > room + LEG_ALLOWANCE] = 0.0  # a waypoint cannot mend that
        for foot, top in self.columns:
            beside = np.abs(points[:, :2] - foot[:2]).max(axis=1) <= SAME_PLACE
            excess[beside & (points[:, 2] <= top[2])] = 0.0
        return points - np.maximum(excess, 0.0)[:, None] * np.array([0.0, 0.0, 1.0])

    @cached_property
    def _lowest(self) -> Terrain:
        """The lowest ground, lowered by what it may fall, and the UAV rise, within the error."""
        assert self.scenario.terrain is not None
        return lowered(self.scenario.terrain.lowest_ground, self.error)

    @cached_property
    def _slope(self) -> float:
        """The steepest slope of the ground and of the ceiling above it; 0 where altitudes follow the ground."""
        terrain = self.scenario.terrain
        if terrain is None or self.reference == "agl":
            return 0.0
        return max(steepest(terrain), steepest(terrain.lowest_ground))

    @cached_property
    def _higher(self) -> Terrain:
        """The terrain, raised by what it may rise, and the UAV sink, within the error."""
        higher = raised(self.scenario.terrain, self.error)
        assert higher is not None
        return higher

    def corner(self, entered: Floats, before: Floats, at: Floats, after: Floats, radius: float) -> Checked:
        """Return what is found of all ways that an autopilot may fly around a corner to the next vertex.

        An autopilot turns within the radius of `at` and from there flies to `after` or back to the leg. It therefore
        stays between the leg and the straight line from where it turned to `after`. It comes from `before`, or from
        `entered` if it has cut the corner at `before`.
        """
        p, q = towards(before - at, radius), towards(entered - at, radius)
        on = after - at
        long = float(np.linalg.norm(on))
        if long == 0 or max(np.linalg.norm(np.cross(side, on)) for side in (p, q)) / long < MIN_GROWTH / 10:
            return Checked(None)  # there is no corner
        apart = max(self.apart(before, at), self.apart(at, after))
        fault: str | Segments | None = None
        for width in np.array(LINE_HALF_WIDTHS) * max(1.0, radius / WIDE_CORNER):
            deep = _middles(max(float(np.linalg.norm(p)), float(np.linalg.norm(q))), width)
            wide = _middles(float(np.linalg.norm(p - q)), width)
            sides = ((1 - wide)[:, None] * p + wide[:, None] * q)[None] * deep[:, None, None]
            starts = at + sides.reshape(-1, 3)
            # every possible way is at most this far from one of the lines to `after`, and nearer towards the end
            between = width * (1 if len(wide) == 1 else math.sqrt(2)) * (1 + self._slope)
            whole = np.broadcast_to(after, starts.shape)
            hopeless = self._checked(starts, whole, apart)
            if hopeless.fault is not None:
                return hopeless  # the line itself meets something, so finer lines would, too
            late = starts + (1 - LATE_SHARE) * (after - starts)
            early_half = self._checked(starts, late, apart + between)
            late_half = self._checked(late, whole, apart + LATE_SHARE * between)
            fault = early_half.fault if early_half.fault is not None else late_half.fault
            if fault is None:
                return Checked(None, (*early_half.clear, *late_half.clear))
        return Checked(fault)

    def apart(self, a: Floats, b: Floats) -> float:
        """Return by how many metres a flown leg can be nearer to something than the straight line in local metres.

        It covers great circles, which PX4 follows, and straight lines in latitude and longitude. Where these are to the
        side, the ground may be higher by its slope, and the ceiling lower.
        """
        ends = np.stack([a, b])
        asked = ends.tobytes()
        if asked not in self._apart:
            self._apart[asked] = self._bend(a, b, ends)
        return self._apart[asked]

    def _bend(self, a: Floats, b: Floats, ends: Floats) -> float:
        bent = self._curved(ends) * (1 + self._slope)
        if self.reference == "agl":
            assert self.scenario.terrain is not None
            bent += swell(self.scenario.terrain, a, b)
        return MAVLINK_ROUNDING + 1.1 * bent

    def _curved(self, ends: Floats) -> float:
        """Return how many metres a line between two ends, (2, 3) metres, bends because the Earth is round."""
        origin = origin_of(self.scenario)
        level = float(np.linalg.norm((ends[1] - ends[0])[:2]))
        globe = to_wgs84(origin, ends)
        globe[:, 1] = np.unwrap(globe[:, 1], period=360)  # the shorter way, also across the antimeridian
        middle = to_local(origin, globe.mean(axis=0, keepdims=True))[0]
        return max(float(np.linalg.norm(middle - ends.mean(axis=0))), level**2 / (8 * MIN_EARTH_RADIUS))

    def _checked(
        self, starts: Floats, ends: Floats, extra: float, strays: bool = True, foot: Foot | None = None
    ) -> Checked:
        """Return what is found of segments from `starts` to `ends`, (n, 3) each, grown by `extra` metres."""
        world = self.world(strays, foot)
        growth = MIN_GROWTH * 2 ** max(0, math.ceil(math.log2(extra / MIN_GROWTH)))
        both = np.concatenate([starts, ends])
        room = float(np.minimum(both - world.space.low, world.space.high - both).min())
        if room < max(extra - LEG_ALLOWANCE, -SURFACE_DEPTH):
            return Checked(f"it may be {extra - room:.3g} m out of bounds")
        met = world.first_crossing(starts, ends, growth)
        if met is not None:
            return Checked(Segments(starts[met : met + 1], ends[met : met + 1], growth, strays, foot))
        touches = world.first_crossing(starts, ends, growth + 2 * SEAM_MARGIN) is not None
        if touches:
            sealed = np.flatnonzero(~world.segments_free(starts, ends, margin=growth))
            if len(sealed):
                return Checked(Segments(starts[sealed[:1]], ends[sealed[:1]], growth, strays, foot, True))
        return Checked(None, (Segments(starts, ends, growth, strays, foot, touches),))

    def grown(self, extra: float) -> Scenario:
        """Return the scenario with clearances less the allowance plus `extra` metres, and a ceiling as much lower."""
        clearance = max(self.scenario.clearance - LEG_ALLOWANCE, 0.0) + extra
        terrain, most = self.scenario.terrain, self.scenario.max_height
        if self.reference == "agl":
            terrain = most = None
        if terrain is not None:
            steep = extra + MAVLINK_ROUNDING * steepest(terrain)
            above = max(self.scenario.ground_clearance - ground_allowance(self.scenario), 0.0) + steep
            if most is not None:
                most -= extra + MAVLINK_ROUNDING * steepest(terrain.lowest_ground)
            terrain = terrain.model_copy(update={"clearance": above})
        return self.scenario.model_copy(update={"clearance": clearance, "terrain": terrain, "max_height": most})


def ground_allowance(scenario: Scenario) -> float:
    """Return by how many metres an exported leg may come nearer to the ground than its clearance.

    That is what rounding takes of the altitude, and sideways where the ground is steepest: starts and targets may lie
    on their limits.
    """
    slope = 0.0 if scenario.terrain is None else steepest(scenario.terrain)
    return LEG_ALLOWANCE + MAVLINK_ROUNDING * slope


def towards(way: Floats, radius: float) -> Floats:
    """Return a vector, (3,), cut to the length `radius`."""
    length = float(np.linalg.norm(way))
    return way * min(radius / length, 1.0) if length else way


def _middles(length: float, half: float) -> Floats:
    """Return the midpoints, as shares of a length, of the fewest equal parts that are at most 2 * `half` long."""
    count = max(math.ceil(length / (2 * half)), 1)
    return (np.arange(count) + 0.5) / count
