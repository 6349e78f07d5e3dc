"""Checks legs and corners of a UAV that follows the ground, for every ground that its autopilot may know."""

import math
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.corner_lines import is_straight, search_corner
from skyverse.exports.leg_deviation import leg_deviation
from skyverse.exports.leg_segments import Checked, Foot, Segments, Shortfall, towards
from skyverse.exports.obstacle_search import ObstacleSearch, growths_of
from skyverse.exports.terrain_following import Band, Lines, Strips, TerrainFollowing, covered
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Terrain
from skyverse.numerics.tolerances import LEG_ALLOWANCE, MAVLINK_ROUNDING, SAME_PLACE
from skyverse.space.tube import NO_ERROR

MOST_STRIPS = 20_000
"""Strips of one leg or corner after which it counts as undecided."""


@dataclass(frozen=True, eq=False)
class FollowedLegs:
    """Checks legs with altitudes above ground.

    A leg is a line of x, y and height above ground, and what is flown a band of altitudes along it. Obstacles are
    looked for along straight segments in that band, at first along few that are grown by much, then along more.
    Ground and ceiling are compared with the heights along the line.

    Attributes
    ----------
    search
        Finds obstacles.
    following
        Of the scenario's terrain, and the UAV's tracking error.
    """

    search: ObstacleSearch
    following: TerrainFollowing

    @property
    def _scenario(self) -> Scenario:
        return self.search.scenario

    def leg(self, a: Floats, b: Floats, strays: bool, foot: Foot | None) -> Checked:
        """Return what is found of a leg from a to b, (3,) metres each, with or without the tracking error.

        With a `foot` it is a part of the column above it, in which the ground below is exempt from the error.
        """
        ends = np.stack([a, b])
        lines = self._lines(ends)
        rises = bool(np.abs(b - a)[:2].max() <= SAME_PLACE and b[2] > a[2])  # it climbs from where it is
        beside = self._beside(ends)
        fault = self._limits(lines, beside, strays, below=foot is None, rises=rises)
        if fault is not None:
            return Checked(fault)
        band = self.following.band(lines, beside, strays)
        if rises:
            band = band._replace(low=np.maximum(band.low, a[2]))
        return self._clear(band, beside, 0.0, strays, foot)

    def corner(self, entered: Floats, before: Floats, at: Floats, after: Floats, radius: float) -> Checked:
        """Return what is found of all ways around a corner, as `LegChecker.corner`.

        Between any two places the height above ground changes linearly, also where the corner is cut.
        """
        points = np.stack([entered, before, at, after])
        cut, here, on = self._cut(points, radius)
        if is_straight(cut, on - here):
            return Checked(None)
        beside = self._beside_corner(points)
        aside = float(np.linalg.norm(cut[:, :2], axis=1).max())
        whole, wide = _with_cut(here, on, cut), beside + aside
        fault = self._limits(whole, wide, strays=True)
        if fault is not None:
            return Checked(fault)
        found = self._clear(self.following.band(whole, wide, strays=True), wide, 0.0, True, None)
        if found.fault is None:
            return found

        def judge(starts: Floats, ends: Floats, between: float) -> Checked:
            band = self.following.band(Lines(starts, ends), beside + between, strays=True)
            if between == 0.0:
                return self._along_middle(band, beside, True, None)
            return self._clear(band, beside, between, True, None)

        return search_corner(cut, here, on, radius, 0.0, judge)

    def apart(self, a: Floats, b: Floats) -> float:
        """Return how far a leg, (3,) metres each, may be flown off the straight line in local metres."""
        ends = np.stack([a, b])
        lines = self._lines(ends)
        beside = self._beside(ends)
        return math.hypot(beside, self._deviation(self.following.band(lines, beside, strays=False), ends))

    def apart_after(self, points: Floats, radius: float) -> float:
        """Return how far off the straight lines from a cut corner on a UAV may fly, metres.

        The rows of `points` are the first four arguments of `corner`.
        """
        cut, here, on = self._cut(points, radius)
        beside = self._beside_corner(points)
        aside = float(np.linalg.norm(cut[:, :2], axis=1).max())
        band = self.following.band(_with_cut(here, on, cut), beside + aside, strays=False)
        straight = max(abs(float(towards(place - points[2], radius)[2])) for place in points[:2])
        return math.hypot(beside, self._deviation(band, points[2:]) + straight)

    def below_ceiling(self, near: float) -> Terrain:
        """Return a surface: what is no higher above it than the ceiling allows keeps below that, within `near` m."""
        ground, terrain = self.following.nearby(near, strays=True), self.following.terrain
        heights = terrain.heights - self._taken(ground.lowest_slope, strays=True) - ground.gap.heights
        return derived(terrain, heights=heights, lowest=None)

    def _cut(self, points: Floats, radius: float) -> tuple[Floats, Floats, Floats]:
        """Return how a corner is cut, (2, 3), where it is, and the next waypoint, (3,), all with heights above ground.

        The rows of `points` are the first four arguments of `corner`.
        """
        entered, before, at, after = self.following.above(points)
        return np.stack([towards(before - at, radius), towards(entered - at, radius)]), at, after

    def _beside_corner(self, points: Floats) -> float:
        return max(self._beside(points[1:3]), self._beside(points[2:]))

    def _lines(self, ends: Floats) -> Lines:
        above = self.following.above(ends)
        return Lines(above[:1], above[1:])

    def _beside(self, ends: Floats) -> float:
        """Return how far beside a leg, (2, 3) metres, a UAV may be."""
        return MAVLINK_ROUNDING + float(leg_deviation(self._scenario, math.hypot(*(ends[1] - ends[0])[:2])))

    def _deviation(self, band: Band, ends: Floats) -> float:
        """Return how many metres a band is above or below the straight lines between the ends of a leg, (2, 3)."""
        level = ends[0, 2] + band.shares * (ends[1, 2] - ends[0, 2])
        return float(np.maximum(band.high - level, level - band.low).max())

    def _limits(
        self, lines: Lines, beside: float, strays: bool, *, below: bool = True, rises: bool = False
    ) -> Shortfall | None:
        """Return where lines may be too near to the ground, or above the ceiling.

        Parameters
        ----------
        lines, strays
            As for `TerrainFollowing.band`.
        beside
            How far beside them a UAV may be, metres.
        below
            Whether the height above ground counts.
        rises
            Whether the UAV climbs from where it is, which does not depend on the ground that its autopilot knows.
        """
        ground = self.following.nearby(beside, strays)
        if below:
            taken = self._taken(ground.slope, strays) + (0.0 if rises else ground.gap.heights)
            low, place = self.following.least(lines, derived(ground.gap, heights=taken))
            needed = self._scenario.ground_clearance - LEG_ALLOWANCE / 2
            if low < needed:
                lower = 0.0 if rises else float(ground.gap.height(place[:2]))
                why = f", as the ground that its autopilot knows may be {lower:.3g} m lower (not with amsl)"
                said = f"may be {low:.4g} m above ground, and {needed:.4g} m are required"
                return Shortfall(said + (why if lower else ""), place)
        most = self._scenario.max_height
        if most is not None:
            more = self._taken(ground.lowest_slope, strays) + ground.gap.heights
            added = derived(ground.gap, heights=more)
            upside_down = Lines(lines.starts * [1, 1, -1], lines.ends * [1, 1, -1])
            least, place = self.following.least(upside_down, added)
            high = LEG_ALLOWANCE / 2 - least
            if high > most:
                place[2] = 2 * self.following.terrain.height(place[:2]) - place[2]
                return Shortfall(f"may be {high:.5g} m above ground, above the ceiling of {most:.5g} m", place)
        return None

    def _taken(self, slope: Terrain, strays: bool) -> Floats:
        """Return how much a height changes, (nx, ny) metres, as it is not counted from the ground below the UAV."""
        error = self.following.error if strays else NO_ERROR
        return error.horizontal * slope.heights + error.vertical

    def _clear(self, band: Band, beside: float, between: float, strays: bool, foot: Foot | None) -> Checked:
        """Return what is found of obstacles beside a band: within `beside` metres to the side, and `between` around."""
        middle = self._along_middle(band, beside + between, strays, foot)
        if middle.fault is not None:
            return middle
        least = beside + between
        strips, clear = Strips.of_lines(band), []
        while len(strips.first):
            starts, ends, half = covered(band, strips)
            extra = np.hypot(beside, half) + between
            blocked = self.search.blocked(starts, ends, extra, strays, foot)
            clear.append((starts[~blocked], ends[~blocked], extra[~blocked]))
            single = np.flatnonzero(blocked & (strips.stop - strips.first == 1))
            worst = self.search.blocked(starts[single], ends[single], np.full(len(single), least), strays, foot)
            if worst.any():
                first = single[worst][:1]
                return self.search.checked(starts[first], ends[first], least, strays, foot)
            strips = strips.of(blocked).quartered()
            if len(strips.first) > MOST_STRIPS:
                return Checked(Shortfall("could not be decided to be clear of obstacles", starts[blocked][0]))
        starts, ends, extra = (np.concatenate(column) for column in zip(*clear, strict=True))
        return self._grouped(starts, ends, extra, strays, foot)

    def _along_middle(self, band: Band, beside: float, strays: bool, foot: Foot | None) -> Checked:
        """Return what is found of the middle of a band: where that is not clear, no finer strips are."""
        starts, ends, _ = covered(band, Strips.middles(band))
        return self.search.checked(starts, ends, beside, strays, foot)

    def _grouped(self, starts: Floats, ends: Floats, extra: Floats, strays: bool, foot: Foot | None) -> Checked:
        """Return what is found of segments, (n, 3) each, that are grown by `extra` metres, (n,)."""
        growths, found = growths_of(extra), list[Segments]()
        for growth in np.unique(growths):
            some = growths == growth
            checked = self.search.checked(starts[some], ends[some], extra[some], strays, foot)
            if checked.fault is not None:
                return checked
            found += checked.clear
        return Checked(None, tuple(found))


def _with_cut(at: Floats, after: Floats, cut: Floats) -> Lines:
    """Return the line from a corner on, raised and lowered at its start by what may be cut, as in `FollowedLegs`."""
    high, low = max(float(cut[:, 2].max()), 0.0), min(float(cut[:, 2].min()), 0.0)
    return Lines((at + np.array([0.0, 0.0, high]))[None], after[None], high - low)
