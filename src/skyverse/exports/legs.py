"""Whether straight legs and cut corners, flown as an autopilot flies them, are clear: searched, and then proven.

A leg that is straight for an autopilot is not quite straight in local metres, altitudes above ground follow the ground,
and MAVLink rounds to 1e-7 degrees. The difference is bounded for each leg and added to the clearance.
"""

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.leg_geometry import (
    GroundUnder,
    ceiling_margin,
    corner_lines,
    greatest_height,
    ground_under,
    growth_of,
    is_straight,
    leg_deviation,
    lowered,
    steepest,
    towards,
)
from skyverse.exports.leg_space import Breach, Checked, LegRule, LegSpace, Place, Segments, first_unproven
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Terrain
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import LEG_ALLOWANCE, MAVLINK_ROUNDING, SAME_PLACE
from skyverse.space.tracking_error import NO_ERROR

Polyline = tuple[Floats, float | Floats, Floats]
"""Waypoints: (n, 3) metres, the acceptance radii, metres, one or (n,), and (n,) not 0 where a corner is not cut."""


@dataclass(frozen=True, eq=False)
class LegChecker:
    """Checks the legs and corners of one UAV; it remembers its answers.

    Attributes
    ----------
    space
        What they are asked in.
    error
        How far the flown position may be from the legs.
    lifts
        (base, top) of the axes of the pads at the UAV's own start and target on which the error does not count for
        what lies below, (3,) metres each.
    """

    space: LegSpace
    error: TrackingError = NO_ERROR
    lifts: tuple[tuple[Floats, Floats], ...] = ()
    _known: dict[bytes, Checked] = field(default_factory=dict)
    _known_margins: dict[bytes, tuple[float, float]] = field(default_factory=dict)

    @property
    def scenario(self) -> Scenario:
        """The scenario."""
        return self.space.given

    def trouble(self, points: Floats, radius: float | Floats, stops: Floats) -> tuple[int, Breach | Segments] | None:
        """Return the first fault of a `Polyline`, or ``None``.

        It comes with an index: that of the first vertex of the leg, or n plus that of the corner.
        """
        for where, checked, _ in self.parts(points, radius, stops):
            if checked.fault is not None:
                return where, checked.fault
        return None

    def parts(self, points: Floats, radius: float | Floats, stops: Floats) -> Iterator[tuple[int, Checked, bytes]]:
        """Yield the index, as in `trouble`, of each leg and corner of a polyline, what is found of it, and its key."""
        for k in range(len(points) - 1):
            yield k, *self.part(points[k : k + 2])
        for k, corner, near in cut_corners(points, radius, stops):
            yield len(points) + k, *self.part(corner, near)

    def part(self, points: Floats, *radius: float) -> tuple[Checked, bytes]:
        """Return what is found of a leg, (2, 3), or of a corner, (4, 3), that is cut within a radius, and its key."""
        return self._remembered(self.corner if radius else self.leg, points, *radius)

    def _remembered(self, check: Callable[..., Checked], points: Floats, *radius: float) -> tuple[Checked, bytes]:
        asked = points.tobytes() + np.array(radius, dtype=np.float64).tobytes()
        if asked not in self._known:
            self._known[asked] = check(*points, *radius)
        return self._known[asked], asked

    def refuse(self, key: bytes, fault: Segments) -> None:
        """Remember that the referee does not prove a leg or corner, which counts as faulty from now on."""
        self._known[key] = Checked(fault)

    def leg(self, a: Floats, b: Floats) -> Checked:
        """Return what is found of a leg from a to b, (3,) metres each."""
        return _together([self._straight(*part) for part in self._cut_at_pads(a, b)])

    def _cut_at_pads(self, a: Floats, b: Floats) -> Iterator[tuple[Floats, Floats, bool, Place | None]]:
        """Yield the parts of a leg, whether the error counts for each, and the place of a pad in which it does."""
        low, high = (a, b) if a[2] <= b[2] else (b, a)
        for base, top in self.lifts:
            on_axis = np.abs(np.stack([a, b])[:, :2] - base[:2]).max() <= SAME_PLACE
            if on_axis and base[2] - SAME_PLACE <= low[2] < top[2]:
                held = (a, b) if high[2] <= top[2] else (low, top)
                x, y, z = base.tolist()
                yield *held, False, None
                yield *held, True, (x, y, z)
                if high[2] > top[2]:
                    yield top, high, True, None
                return
        yield a, b, True, None

    def _straight(self, a: Floats, b: Floats, strays: bool, pad: Place | None) -> Checked:
        """Return what is found of a leg from a to b, (3,) metres each, with or without the tracking error."""
        ends = np.stack([a, b])
        if self.space.reference == "agl":
            fault = self._heights_fault(ends, self._above(ends), strays, ground=pad is None)
            if fault is not None:
                return Checked(fault)
        near, upright = self._margins(ends, strays)
        return self.space.check(Segments(a[None], b[None], near, self._stray(strays, upright), pad))

    def _stray(self, strays: bool, upright: float) -> TrackingError:
        """Return the tracking error or none, with some metres more up and down."""
        error = self.error if strays else NO_ERROR
        return derived(error, vertical=error.vertical + growth_of(upright)) if upright else error

    def _heights_fault(self, points: Floats, above: Floats, strays: bool, *, ground: bool = True) -> Breach | None:
        """Return where a UAV that follows the ground may be too low, or above the ceiling.

        Parameters
        ----------
        points, above
            (n, 3) metres and heights above ground, (n,): the ends of a leg, or more points around a cut corner. Between
            any two the height above ground changes linearly.
        strays, ground
            Whether the tracking error counts, and whether the ground does.
        """
        aside = MAVLINK_ROUNDING + self._deviation(points) + self.error.horizontal * strays
        under = self._ground_under(points, aside)
        off = (under.slope * self.error.horizontal + self.error.vertical) * strays
        low, high, lower = float(above.min()) - under.lower, float(above.max()) + under.lower, under.lower
        if len(points) == 2:
            shift = ground_under(self._lower, points, aside).slope * aside
            signs = np.array([1.0, -1.0])[:, None] * above
            highest, lowest = (
                float(greatest_height(np.column_stack([points[:, :2], z]), self._lower, -np.inf).max()) for z in signs
            )
            low, high = max(low, -lowest - shift), min(high, highest + shift)
        if _is_climb(points):
            low, lower = float(above.min()), 0.0
        needed, most = self.scenario.ground_clearance - LEG_ALLOWANCE / 2, self.scenario.max_height
        if ground and low - off < needed:
            return Breach(LegRule.GROUND, points[np.argmin(above)], needed - low + off, needed, lower)
        if most is not None and high + off + LEG_ALLOWANCE / 2 > most:
            return Breach(LegRule.CEILING, points[np.argmax(above)], high + off - most, most)
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

    def _ground_under(self, points: Floats, near: float) -> GroundUnder:
        assert self.scenario.terrain is not None
        return ground_under(self.scenario.terrain, points, near)

    def _deviation(self, points: Floats) -> float:
        """Return how far aside of straight legs between points, (n, 3), they may be flown, metres."""
        longest = float(np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1).max())
        return float(leg_deviation(self.scenario, longest))

    def below_ceiling(self, points: Floats) -> Floats:
        """Return a curve's points (n, 3) metres, lowered where legs between them, or rounding, exceed the ceiling.

        What is above the ceiling stays there, and so does what is on the pad at the UAV's own start or target.
        """
        most, terrain = self.scenario.max_height, self.scenario.terrain
        if most is None:
            return points
        assert terrain is not None
        lowest = lowered(terrain.lowest_ground, self.error)
        room = ceiling_margin(self.scenario)
        excess = greatest_height(points, lowest, most - room) - most + room
        above = points[:, 2] - lowest.height(points[:, :2])
        excess[above > most + LEG_ALLOWANCE] = 0.0  # a waypoint cannot mend that
        for base, top in self.lifts:
            on_axis = np.abs(points[:, :2] - base[:2]).max(axis=1) <= SAME_PLACE
            excess[on_axis & (points[:, 2] <= top[2])] = 0.0
        return points - np.maximum(excess, 0.0)[:, None] * np.array([0.0, 0.0, 1.0])

    @cached_property
    def _slope(self) -> float:
        """The steepest slope of the ground and of the ceiling above it; 0 where altitudes follow the ground."""
        terrain = self.scenario.terrain
        if terrain is None or self.space.reference == "agl":
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
        if self.space.reference == "agl":
            first, second, here, on = self._above(corner)
            ends = [at + cut[0], at + cut[1], at, after]
            shares = [min(radius / max(math.dist(one, at), SAME_PLACE), 1.0) for one in (before, entered)]
            turns = [here + share * (high - here) for share, high in zip(shares, (second, first), strict=True)]
            fault = self._heights_fault(np.stack(ends), np.array([*turns, here, on]), strays=True)
            if fault is not None:
                return Checked(fault)
        off, upright = self._around(corner, cut)
        error, steep = self._stray(True, upright), 1 + self._slope * bool(cut[:, :2].any())
        for starts, late, whole, near, near_late in corner_lines(cut, at, after, radius):
            hopeless = self.space.check(Segments(starts, whole, off, error))
            if hopeless.fault is not None:
                return hopeless  # the line itself meets something, so finer lines would, too
            halves = (
                Segments(starts, late, off + near * steep, error),
                Segments(late, whole, off + near_late * steep, error),
            )
            found = _together([self.space.check(half) for half in halves])
            if found.fault is None:
                return found
        # beside level lines a way is no lower, so that over level ground corners need what legs need
        sloping = bool(cut[:, 2].any())
        strays = [
            derived(error, horizontal=error.horizontal + one, vertical=error.vertical + one * sloping)
            for one in (growth_of(near), growth_of(near_late))
        ]
        halves = Segments(starts, late, off, strays[0]), Segments(late, whole, off, strays[1])
        return _together([self.space.check(half) for half in halves])

    def _margins(self, points: Floats, strays: bool) -> tuple[float, float]:
        """Return what must be added to the clearance of legs between points, (n, 3) metres, and more up and down.

        Where the flown leg is to the side, the ground may be higher by its slope, and the ceiling lower. With altitudes
        above ground a leg follows the ground, but for a climb from where the UAV is.
        """
        asked = points.tobytes() + bytes([strays])
        if asked not in self._known_margins:
            off, upright = self._deviation(points), 0.0
            if self.space.reference == "agl" and not _is_climb(points):
                aside = MAVLINK_ROUNDING + off + self.error.horizontal * strays
                under = self._ground_under(points, aside)
                upright = under.slope * aside + under.lower + (under.bend if off else 0.0)
            self._known_margins[asked] = MAVLINK_ROUNDING + off * (1 + self._slope), upright
        return self._known_margins[asked]

    def _around(self, corner: Floats, cut: Floats) -> tuple[float, float]:
        """Return the same for what is flown around a corner, (4, 3) metres, from within its `cut`, (2, 3), on.

        Where a UAV that follows the ground turns, it may be as far off the straight leg before as it is there.
        """
        before, here = self._margins(corner[1:3], strays=True), np.concatenate([corner[2] + cut, corner[2:]])
        after = self._margins(here, strays=True)
        return max(before[0], after[0]), before[1] + after[1]

    def deviations(self, points: Floats, radius: float | Floats, stops: Floats) -> Floats:
        """Return how far each leg of a `Polyline` may be off the straight line, (n - 1,) metres.

        With altitudes above ground that also holds for what is flown after a cut corner.
        """
        found = np.array([math.hypot(*self._margins(np.stack(leg), strays=True)) for leg in pairwise(points)])
        if self.space.reference == "agl":
            for k, corner, near in cut_corners(points, radius, stops):
                cut = np.stack([towards(place - corner[2], near) for place in corner[:2]])
                found[k] = max(found[k], math.hypot(*self._around(corner, cut)) + float(np.abs(cut[:, 2]).max()))
        return found

    def bend(self, a: Floats, b: Floats) -> float:
        """Return how far a leg is off the straight line, metres, as far as that depends on how long it is."""
        ends = np.stack([a, b])
        return self._ground_under(ends, 0.0).bend if self.space.reference == "agl" else self._deviation(ends)


def _together(found: Sequence[Checked]) -> Checked:
    """Return what is found of a leg or corner of which this is found of its parts."""
    fault = next((one.fault for one in found if one.fault is not None), None)
    return Checked(fault, () if fault is not None else tuple(part for one in found for part in one.clear))


def _is_climb(points: Floats) -> bool:
    """Tell whether points, (n, 3), lead straight up from where the UAV is, whatever ground its autopilot knows."""
    return bool(np.abs(points - points[0])[:, :2].max() <= SAME_PLACE and points[-1, 2] > points[0, 2])


def cut_corners(points: Floats, radius: float | Floats, stops: Floats) -> Iterator[tuple[int, Floats, float]]:
    """Yield the index of each vertex of a `Polyline` whose corner is cut, four points, and the radius of the cut.

    The points, (4, 3) metres, are that where the leg before begins, if its corner is cut as far as possible, the vertex
    before, the vertex and the one after.
    """
    radii = np.broadcast_to(radius, len(points))
    for k in range(1, len(points) - 1):
        if stops[k] or radii[k] <= 0:
            continue
        entered = points[k - 1]
        if k > 1 and not stops[k - 1]:
            entered = points[k - 1] + towards(points[k - 2] - points[k - 1], radii[k - 1])
        yield k, np.concatenate([entered[None], points[k - 1 : k + 2]]), float(radii[k])


def refused(checkers: Sequence[LegChecker], polylines: Sequence[Polyline]) -> set[int]:
    """Return the numbers of polylines that the referee does not prove; their checkers then know which parts are not.

    Each polyline has a checker, all of one space; what these found clear is judged, all that asks the same at once.
    """
    pairs = zip(checkers, polylines, strict=True)
    return unproven((k, legs, *part[1:]) for k, (legs, polyline) in enumerate(pairs) for part in legs.parts(*polyline))


def unproven(each: Iterable[tuple[int, LegChecker, Checked, bytes]]) -> set[int]:
    """Return the numbers of parts that the referee does not prove; their checkers know them by their keys from then on.

    Each part is given with its number, its checker, what that found, and its key, as of `LegChecker.part`.
    """
    wanted: dict[tuple[Any, ...], list[tuple[int, bytes, Segments]]] = defaultdict(list)
    checkers = {}
    for number, legs, checked, key in each:
        checkers[number] = legs
        for segments in checked.clear:
            wanted[id(legs.space), *segments[2:]].append((number, key, segments))
    found = set()
    for parts in wanted.values():
        world = checkers[parts[0][0]].space.referee(parts[0][2])
        while parts:
            of = np.repeat(np.arange(len(parts)), [len(segments.starts) for _, _, segments in parts])
            starts, ends = (np.concatenate([part[2][end] for part in parts]) for end in (0, 1))
            piece = first_unproven(world, starts, ends)
            if piece is None:
                break
            number, key, segments = parts.pop(int(of[piece]))
            checkers[number].refuse(key, segments.only(piece - int(np.argmax(of == of[piece]))))
            found.add(number)
    return found
