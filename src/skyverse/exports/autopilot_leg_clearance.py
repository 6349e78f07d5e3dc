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
from skyverse.exports.global_positions import AltitudeReference
from skyverse.exports.leg_geometry import (
    Base,
    Checked,
    ObstacleSearch,
    Segments,
    Shortfall,
    ceiling_margin,
    greatest_height,
    ground_under,
    is_straight,
    leg_deviation,
    lowered,
    search_corner,
    steepest,
    towards,
)
from skyverse.model.quantities import derived
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
    lifts
        (base, top) of the vertical lines over the UAV's own start and target in which the error does not count for what
        lies below, (3,) metres each.
    worlds
        What is compiled for each error; checkers of the same scenario and reference may share it.
    """

    scenario: Scenario
    reference: AltitudeReference
    error: TrackingError = NO_ERROR
    lifts: tuple[tuple[Floats, Floats], ...] = ()
    worlds: dict[TrackingError, World] = field(default_factory=dict)
    _known: dict[bytes, Checked] = field(default_factory=dict)
    _known_margins: dict[bytes, tuple[float, float]] = field(default_factory=dict)

    @cached_property
    def search(self) -> ObstacleSearch:
        """What finds obstacles."""
        return ObstacleSearch(self.scenario, self.reference, self.error, self.worlds)

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
        found = [self._straight(*part) for part in self._cut_at_pads(a, b)]
        fault = next((one.fault for one in found if one.fault is not None), None)
        return Checked(fault, () if fault is not None else tuple(part for one in found for part in one.clear))

    def _cut_at_pads(self, a: Floats, b: Floats) -> Iterator[tuple[Floats, Floats, bool, Base | None]]:
        """Yield the parts of a leg, whether the error counts for each, and the place of a pad in which it does."""
        for base, top in self.lifts:
            low, high = (a, b) if a[2] <= b[2] else (b, a)
            if np.abs(np.stack([a, b])[:, :2] - base[:2]).max() > SAME_PLACE or low[2] < base[2] - SAME_PLACE:
                continue
            if low[2] >= top[2]:
                yield a, b, True, None
                return
            held = (a, b) if high[2] <= top[2] else (low, top)
            x, y, z = base.tolist()
            yield *held, False, None
            yield *held, True, (x, y, z)
            if high[2] > top[2]:
                yield top, high, True, None
            return
        yield a, b, True, None

    def _straight(self, a: Floats, b: Floats, strays: bool, base: Base | None) -> Checked:
        """Return what is found of a leg from a to b, (3,) metres each, with or without the tracking error."""
        if self.reference == "agl":
            ends = np.stack([a, b])
            fault = self._limits(ends, self._above(ends), strays, below=base is None)
            if fault is not None:
                return Checked(fault)
        beside, upright = self._margins(np.stack([a, b]), strays)
        return self.search.checked(Segments(a[None], b[None], beside, strays, base, upright))

    def _limits(self, points: Floats, above: Floats, strays: bool, *, below: bool = True) -> Shortfall | None:
        """Return where a UAV that follows the ground may be too low, or above the ceiling.

        Parameters
        ----------
        points, above
            (n, 3) metres and heights above ground, (n,): the ends of a leg, or more points around a cut corner. Between
            any two the height above ground changes linearly.
        strays, below
            Whether the tracking error counts, and whether the ground does.
        """
        scenario, terrain = self.scenario, self.scenario.terrain
        assert terrain is not None
        aside = MAVLINK_ROUNDING + self._beside(points) + self.error.horizontal * strays
        ground = ground_under(terrain, points, aside)
        off = (ground.slope * self.error.horizontal + self.error.vertical) * strays
        low, high = float(above.min()) - ground.lower, float(above.max()) + ground.lower
        if len(points) == 2:
            shift = ground_under(self._lower, points, aside).slope * aside
            signs = np.array([1.0, -1.0])[:, None] * above
            highest, lowest = (
                float(greatest_height(np.column_stack([points[:, :2], z]), self._lower, -np.inf).max()) for z in signs
            )
            low, high = max(low, -lowest - shift), min(high, highest + shift)
        lower = ground.lower
        if _is_climb(points):
            low, lower = float(above.min()), 0.0
        needed, most = scenario.ground_clearance - LEG_ALLOWANCE / 2, scenario.max_height
        if below and low - off < needed:
            said = f"may be {low - off:.4g} m above ground, and {needed:.4g} m are required"
            why = f", as the ground that its autopilot knows may be {lower:.3g} m lower (not with amsl)"
            return Shortfall(said + (why if lower else ""), points[np.argmin(above)])
        if most is not None and high + off + LEG_ALLOWANCE / 2 > most:
            said = f"may be {high + off:.5g} m above ground, above the ceiling of {most:.5g} m"
            return Shortfall(said, points[np.argmax(above)])
        return None

    @cached_property
    def _lower(self) -> Terrain:
        """How much lower the lowest ground is, as heights below 0."""
        terrain = self.scenario.terrain
        assert terrain is not None
        return derived(terrain, heights=terrain.lowest_ground.heights - terrain.heights, lowest=None)

    def _above(self, points: Floats) -> Floats:
        """Return how high above ground points (n, 3) are, (n,) metres."""
        assert self.scenario.terrain is not None
        return np.asarray(points[:, 2] - self.scenario.terrain.height(points[:, :2]))

    def _beside(self, points: Floats) -> float:
        """Return how far beside straight legs between points, (n, 3), they may be flown, metres."""
        longest = float(np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1).max())
        return float(leg_deviation(self.scenario, longest))

    def below_ceiling(self, points: Floats) -> Floats:
        """Return a curve's points (n, 3) metres, lowered where legs between them, or rounding, exceed the ceiling.

        What is above the ceiling stays there, and so does what is on the pad at the UAV's own start or target.
        """
        most = self.scenario.max_height
        if most is None:
            return points
        room = ceiling_margin(self.scenario)
        excess = greatest_height(points, self._lowest, most - room) - most + room
        above = points[:, 2] - self._lowest.height(points[:, :2])
        excess[above > most + LEG_ALLOWANCE] = 0.0  # a waypoint cannot mend that
        for base, top in self.lifts:
            beside = np.abs(points[:, :2] - base[:2]).max(axis=1) <= SAME_PLACE
            excess[beside & (points[:, 2] <= top[2])] = 0.0
        return points - np.maximum(excess, 0.0)[:, None] * np.array([0.0, 0.0, 1.0])

    @cached_property
    def _lowest(self) -> Terrain:
        """The lowest ground, lowered by what it may fall, and the UAV rise, within the error."""
        terrain = self.scenario.terrain
        assert terrain is not None
        return lowered(terrain.lowest_ground, self.error)

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
        cut = np.stack([towards(before - at, radius), towards(entered - at, radius)])
        if is_straight(cut, after - at):
            return Checked(None)
        corner = np.stack([entered, before, at, after])
        if self.reference == "agl":
            first, second, here, on = self._above(corner)
            ends = [at + cut[0], at + cut[1], at, after]
            shares = [min(radius / max(math.dist(one, at), SAME_PLACE), 1.0) for one in (before, entered)]
            turns = [here + share * (high - here) for share, high in zip(shares, (second, first), strict=True)]
            fault = self._limits(np.stack(ends), np.array([*turns, here, on]), strays=True)
            if fault is not None:
                return Checked(fault)
        apart, upright = self._around(corner, cut)

        def judge(starts: Floats, ends: Floats, beside: float) -> Checked:
            return self.search.checked(Segments(starts, ends, apart + beside, True, None, upright))

        return search_corner(cut, at, after, radius, self._slope, judge)

    def apart(self, a: Floats, b: Floats) -> float:
        """Return how many metres a leg, (3,) metres each, may be flown off the straight line in local metres."""
        return math.hypot(*self._margins(np.stack([a, b]), strays=True))

    def _margins(self, points: Floats, strays: bool) -> tuple[float, float]:
        """Return what must be added to the clearance of legs between points, (n, 3) metres, and more up and down.

        Where the flown leg is to the side, the ground may be higher by its slope, and the ceiling lower. With altitudes
        above ground a leg follows the ground, but for a climb from where the UAV is.
        """
        asked = points.tobytes() + bytes([strays])
        if asked not in self._known_margins:
            beside, upright = self._beside(points), 0.0
            if self.reference == "agl" and not _is_climb(points):
                assert self.scenario.terrain is not None
                aside = MAVLINK_ROUNDING + beside + self.error.horizontal * strays
                ground = ground_under(self.scenario.terrain, points, aside)
                upright = ground.slope * aside + ground.lower + (ground.bend if beside else 0.0)
            self._known_margins[asked] = MAVLINK_ROUNDING + beside * (1 + self._slope), upright
        return self._known_margins[asked]

    def _around(self, corner: Floats, cut: Floats) -> tuple[float, float]:
        """Return the same for what is flown around a corner, (4, 3) metres, from within its `cut`, (2, 3), on.

        Where a UAV that follows the ground turns, it may be as far off the straight leg before as it is there.
        """
        before, here = self._margins(corner[1:3], strays=True), np.concatenate([corner[2] + cut, corner[2:]])
        after = self._margins(here, strays=True)
        return max(before[0], after[0]), before[1] + after[1]

    def deviations(self, points: Floats, radius: float, stops: Floats) -> Floats:
        """Return how far each leg of a polyline, as in `trouble`, may be off the straight line, (n - 1,) metres.

        With altitudes above ground that also holds for what is flown after a cut corner.
        """
        found = np.array([self.apart(a, b) for a, b in pairwise(points)])
        if self.reference == "agl" and radius > 0:
            for k, corner in cut_corners(points, radius, stops):
                cut = np.stack([towards(place - corner[2], radius) for place in corner[:2]])
                found[k] = max(found[k], math.hypot(*self._around(corner, cut)) + float(np.abs(cut[:, 2]).max()))
        return found

    def swell(self, a: Floats, b: Floats) -> float:
        """Return how far a leg is off the straight line, metres, as far as that depends on how long it is."""
        if self.reference != "agl":
            return self.apart(a, b)
        assert self.scenario.terrain is not None
        return ground_under(self.scenario.terrain, np.stack([a, b]), 0.0).bend


def _is_climb(points: Floats) -> bool:
    """Tell whether points, (n, 3), lead straight up from where the UAV is, whatever ground its autopilot knows."""
    return bool(np.abs(points - points[0])[:, :2].max() <= SAME_PLACE and points[-1, 2] > points[0, 2])


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
