"""Checks with the referee that straight legs, flown as an autopilot flies them, keep clear of obstacles.

A leg that is straight in a file is not quite straight in local metres: Earth is round, altitudes above ground follow
the ground, and MAVLink rounds to 1e-7 degrees. The difference is bounded for each leg and added to the clearance.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.exports.global_positions import AltitudeReference, home, origin_of
from skyverse.model.geodesy import to_local, to_wgs84
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Terrain
from skyverse.numerics.tolerances import LEG_ALLOWANCE, MAVLINK_ROUNDING, MIN_GROWTH
from skyverse.referee.clearance import judge_segments
from skyverse.referee.world import RefereeWorld, referee_world

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


@dataclass(frozen=True)
class LegChecker:
    """Judges the legs of one scenario, with altitudes of one reference; it remembers its answers."""

    scenario: Scenario
    reference: AltitudeReference
    _grown_worlds: dict[float, RefereeWorld] = field(default_factory=dict)
    _known: dict[bytes, str | None] = field(default_factory=dict)
    _apart: dict[bytes, float] = field(default_factory=dict)

    def trouble(self, points: Floats, radius: float, stops: Floats) -> tuple[int, str] | None:
        """Return the first fault of a polyline, (n, 3), whose corners are cut within a radius, or ``None``.

        Where `stops`, (n,), is not 0, the corner is not cut. A fault is an index and a sentence; the index is that of
        the first vertex of the leg, or n plus that of the corner.
        """
        for k in range(len(points) - 1):
            said = self._remembered(self.leg, points[k : k + 2])
            if said is not None:
                return k, said
        if radius <= 0:
            return None
        for k in range(1, len(points) - 1):
            if stops[k]:
                continue
            entered = points[k - 1]
            if k > 1 and not stops[k - 1]:
                entered = points[k - 1] + towards(points[k - 2] - points[k - 1], radius)
            said = self._remembered(self.corner, np.concatenate([entered[None], points[k - 1 : k + 2]]), radius)
            if said is not None:
                return len(points) + k, said
        return None

    def _remembered(self, judge: Callable[..., str | None], points: Floats, *radius: float) -> str | None:
        asked = np.r_[points.ravel(), radius].tobytes()
        if asked not in self._known:
            self._known[asked] = judge(*points, *radius)
        return self._known[asked]

    def leg(self, a: Floats, b: Floats) -> str | None:
        """Return the fault of a leg from a to b, (3,) metres each, or ``None``."""
        if self.reference == "agl":  # heights above ground between the ends lie between those of the ends
            ends = np.stack([a, b])
            assert self.scenario.terrain is not None
            low = float((ends[:, 2] - self.scenario.terrain.height(ends[:, :2])).min())
            needed = self.scenario.ground_clearance - LEG_ALLOWANCE / 2
            if low < needed:
                return f"it is {low:.4g} m above ground, and {needed:.4g} m are required"
        return self._meets(a[None], b[None], self.apart(a, b))

    def corner(self, entered: Floats, before: Floats, at: Floats, after: Floats, radius: float) -> str | None:
        """Return the fault of any way that an autopilot may fly around a corner to the next vertex, or ``None``.

        An autopilot turns within the radius of `at` and from there flies to `after` or back to the leg. It therefore
        stays between the leg and the straight line from where it turned to `after`. It comes from `before`, or from
        `entered` if it has cut the corner at `before`.
        """
        p, q = towards(before - at, radius), towards(entered - at, radius)
        on = after - at
        long = float(np.linalg.norm(on))
        if long == 0 or max(np.linalg.norm(np.cross(side, on)) for side in (p, q)) / long < MIN_GROWTH / 10:
            return None  # there is no corner
        apart = max(self.apart(before, at), self.apart(at, after))
        slope = 0.0 if self.reference == "agl" or self.scenario.terrain is None else steepest(self.scenario.terrain)
        said = None
        for width in np.array(LINE_HALF_WIDTHS) * max(1.0, radius / WIDE_CORNER):
            deep = _middles(max(float(np.linalg.norm(p)), float(np.linalg.norm(q))), width)
            wide = _middles(float(np.linalg.norm(p - q)), width)
            sides = ((1 - wide)[:, None] * p + wide[:, None] * q)[None] * deep[:, None, None]
            starts = at + sides.reshape(-1, 3)
            # every possible way is at most this far from one of the lines to `after`, and nearer towards the end
            between = width * (1 if len(wide) == 1 else math.sqrt(2)) * (1 + slope)
            whole = np.broadcast_to(after, starts.shape)
            hopeless = self._meets(starts, whole, apart)
            if hopeless is not None:
                return hopeless  # the line itself meets something, so finer lines would, too
            late = starts + (1 - LATE_SHARE) * (after - starts)
            said = self._meets(starts, late, apart + between) or self._meets(late, whole, apart + LATE_SHARE * between)
            if said is None:
                return None
        return said

    def apart(self, a: Floats, b: Floats) -> float:
        """Return how many metres a flown leg can deviate from the straight line in local metres.

        It covers great circles, which PX4 follows, and straight lines in latitude and longitude.
        """
        ends = np.stack([a, b])
        asked = ends.tobytes()
        if asked not in self._apart:
            self._apart[asked] = self._bend(a, b, ends)
        return self._apart[asked]

    def _bend(self, a: Floats, b: Floats, ends: Floats) -> float:
        origin = origin_of(self.scenario)
        level = float(np.linalg.norm((b - a)[:2]))
        globe = to_wgs84(origin, ends)
        globe[:, 1] = np.unwrap(globe[:, 1], period=360)  # the shorter way, also across the antimeridian
        middle = to_local(origin, globe.mean(axis=0, keepdims=True))[0]
        bent = max(float(np.linalg.norm(middle - ends.mean(axis=0))), level**2 / (8 * MIN_EARTH_RADIUS))
        if self.reference == "agl":
            assert self.scenario.terrain is not None
            bent += _swell(self.scenario.terrain, a, b)
        return MAVLINK_ROUNDING + 1.1 * bent

    def _meets(self, starts: Floats, ends: Floats, extra: float) -> str | None:
        """Return the fault of segments from `starts` to `ends`, (n, 3) each, grown by `extra` metres, or ``None``."""
        step = MIN_GROWTH * 2 ** max(0, math.ceil(math.log2(extra / MIN_GROWTH)))
        if step not in self._grown_worlds:
            self._grown_worlds[step] = referee_world(self._grown(step))
        world = self._grown_worlds[step]
        both = np.concatenate([starts, ends])
        room = float(np.minimum(both - world.low, world.high - both).min())
        if room < extra - LEG_ALLOWANCE:
            return f"it may be {extra - room:.3g} m out of bounds"
        peaks, incursion = judge_segments(world, starts, ends)
        if incursion is not None:
            return incursion.sentence(world.scenario, "it", "there")
        return None if peaks.proven[0] else "whether it keeps the clearance could not be decided"

    def _grown(self, extra: float) -> Scenario:
        """Return the scenario with clearances less `LEG_ALLOWANCE` plus `extra` metres."""
        clearance = max(self.scenario.clearance - LEG_ALLOWANCE, 0.0) + extra
        terrain = self.scenario.terrain
        if terrain is not None:
            steep = extra + MAVLINK_ROUNDING * steepest(terrain)
            above = max(self.scenario.ground_clearance - LEG_ALLOWANCE, 0.0) + steep
            terrain = None if self.reference == "agl" else terrain.model_copy(update={"clearance": above})
        return self.scenario.model_copy(update={"clearance": clearance, "terrain": terrain})


def require_home(scenario: Scenario, uav: int) -> None:
    """Raise `InputError` if an obstacle lies between a UAV's home and its start, as where it starts on a roof."""
    start, below = np.array(scenario.uavs[uav].start), home(scenario, uav)
    if not below[2] < start[2]:
        return
    bare = scenario.model_copy(update={"clearance": 0.0, "terrain": None})
    incursion = judge_segments(referee_world(bare), below[None], start[None]).incursion
    if incursion is not None:
        named = scenario.obstacles[incursion.obstacle].name
        raise InputError(
            f"{scenario.uavs[uav].name}: its home, the ground below its start, cannot be risen from: "
            f"obstacle {incursion.obstacle}{f' ({named})' if named else ''} lies between; "
            "count altitudes from the sea (amsl)"
        )


def towards(way: Floats, radius: float) -> Floats:
    """Return a vector, (3,), cut to the length `radius`."""
    length = float(np.linalg.norm(way))
    return way * min(radius / length, 1.0) if length else way


def _middles(length: float, half: float) -> Floats:
    """Return the midpoints, as shares of a length, of the fewest equal parts that are at most 2 * `half` long."""
    count = max(math.ceil(length / (2 * half)), 1)
    return (np.arange(count) + 0.5) / count


def steepest(terrain: Terrain) -> float:
    """Return a bound of the ground's slope, from the slopes along the edges of its bilinear cells."""
    east = np.abs(np.diff(terrain.heights, axis=0)).max() / terrain.step[0]
    north = np.abs(np.diff(terrain.heights, axis=1)).max() / terrain.step[1]
    return float(np.hypot(east, north))


def _swell(terrain: Terrain, a: Floats, b: Floats) -> float:
    """Return how many metres the ground under a leg deviates from the straight line between its heights at the ends."""
    shares = [0.0, 1.0]
    for axis in range(2):
        if a[axis] != b[axis]:
            lines = (np.array([a[axis], b[axis]]) - terrain.origin[axis]) / terrain.step[axis]
            whole = np.arange(math.ceil(lines.min()), math.floor(lines.max()) + 1)
            shares += list((whole - lines[0]) / (lines[1] - lines[0]))
    at = np.unique(np.clip(shares, 0.0, 1.0))
    at = np.sort(np.concatenate([at, (at[:-1] + at[1:]) / 2]))
    level = terrain.height(a[:2] + at[:, None] * (b - a)[:2])
    off = level - (level[0] + at * (level[-1] - level[0]))
    first, middle, last = off[:-2:2], off[1:-1:2], off[2::2]
    # along the leg the ground is quadratic in each cell and exceeds its three samples by at most 1/8 of this
    bend = np.abs(first - 2 * middle + last)
    return float(np.max(np.maximum(np.maximum(np.abs(first), np.abs(middle)), np.abs(last)) + bend / 2))
