"""The way home: from when to when of its flight it is proven that a UAV returns by itself without meeting anything.

An autopilot that returns climbs to its return altitude, unless it is higher already, flies straight to home at that
height and descends there. The flight is cut into parts. For the middle of each part the climb, the level line and the
descent are asked for, grown by the part's size, so that they hold for all instants of the part; parts that fail are
halved. The UAV may be off its path by its tracking error when it is called back, and by as much again on its return.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.exports.autopilots import ACCEPTANCE
from skyverse.exports.flight_parts import Parts, flown_legs, joined_parts
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.leg_geometry import leg_deviation
from skyverse.exports.leg_space import Segments
from skyverse.exports.separation import kept_distance
from skyverse.exports.way_home_space import Lines, ReturnSpace, rounded_up, rounding, strayed
from skyverse.model.pad import ground_height
from skyverse.model.scenario import Scenario
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import LEG_ALLOWANCE, MAVLINK_ROUNDING, MIN_GROWTH, SAME_PLACE, SURFACE_DEPTH
from skyverse.space.tracking_error import NO_ERROR, is_wall_within

UNPROVEN_NEAR_HOME = {"px4": 0.0, "ardupilot": 0.0, "dji": 50.0}
"""Metres from home within which no return is proven: a DJI aircraft returns there without a climb."""
LARGEST_PART = 32.0
"""Metres: the longest part of a flight that is asked for at once."""
SMALLEST_PART, SMALLEST_LOST = 0.1, 1.0
"""Metres: the longest part that is not halved again; and the same where nothing leads home from its middle either."""
JOINED_SPANS = 1.0
"""Seconds: two times without a way home that are less apart are told as one."""
WAYS = (
    "the climb is not clear",
    "the level way home is not clear",
    "the descent is not clear",
    "a DJI aircraft this near home returns without a climb",
)
"""Why no way home is proven."""
TOO_HIGH = "the level way home leads above the ceiling where the ground is low"
"""Why the second of `WAYS` is not clear, if that is so."""
CEILING_SAMPLES = 65
"""Places on a level way home at which its height above the ground is found."""
UNPROVEN = "the referee does not prove it"
"""Why none is where players find all of `WAYS` clear."""


class Gap(NamedTuple):
    """A time without a proven way home.

    Attributes
    ----------
    begin, end
        Seconds into the mission.
    why
        Why, in words.
    place
        (3,) metres: a place of the flight from which it is not.
    """

    begin: float
    end: float
    why: str
    place: Floats


@dataclass(frozen=True, eq=False)
class WayHome:
    """How one UAV comes home by itself.

    Attributes
    ----------
    plan
        Its flight.
    altitude
        The return altitude, metres above home.
    gaps
        From when to when its way home is not proven, if it keeps its schedule.
    lines
        What the referee has to prove of the way home at all other instants.
    retraces
        Whether it leads back along the mission in place of straight home; then the legs of the mission are proven.
    """

    plan: FlightPlan
    altitude: float
    gaps: tuple[Gap, ...]
    lines: tuple[Lines, ...]
    retraces: bool = False

    @property
    def level(self) -> float:
        """The height z of the return altitude, metres."""
        return float(self.plan.home[2]) + self.altitude

    @property
    def everywhere(self) -> bool:
        """Whether it is proven at every instant of the flight."""
        return not self.gaps

    @property
    def nowhere(self) -> bool:
        """Whether it is proven at no instant of the flight."""
        return bool(self.gaps) and self.gaps[0][0] <= self.plan.begin and self.gaps[0][1] >= self.plan.arrivals[-1]

    @property
    def ends_safely(self) -> bool:
        """Whether it is proven from the last waypoint."""
        return not self.gaps or self.gaps[-1].end < self.plan.arrivals[-1]


class ReturnPad(NamedTuple):
    """A place where a UAV starts or lands, (3,) metres, and z above it up to which its error counts around it only."""

    base: Floats
    top: float


class Heights(NamedTuple):
    """Of parts of a flight, (n,) metres each: the lowest z, and from what z to what z the ways home from there lead."""

    bottom: Floats
    lowest: Floats
    highest: Floats


class Returns:
    """The returns of one UAV, at any altitude."""

    def __init__(self, scenario: Scenario, space: ReturnSpace, plan: FlightPlan) -> None:
        self.scenario, self.space, self.plan = scenario, space, plan
        vehicle, clearance = scenario.uavs[plan.route.uav], scenario.clearance
        self.error, self.acceptance = vehicle.tracking_error, ACCEPTANCE[plan.autopilot.name]
        self.called_back = strayed(self.error, self.error.horizontal, 0.0)  # it climbs from no lower than it was
        self.landing = strayed(self.error, self.acceptance.radius, 0.0)
        start, last, home_z = plan.route.points[0], plan.waypoints[-1], float(plan.home[2])
        self.home = np.array([*start[:2], home_z])
        ground = max(home_z, float(ground_height(scenario, start[:2]))) if scenario.terrain is not None else home_z
        self.low = min(ground + max(clearance, scenario.ground_clearance) + 2 * LEG_ALLOWANCE, float(start[2]))
        self.pad = self._pad(np.array([*start[:2], min(home_z + clearance, self.low)]), self.low, self.landing)
        base = last
        if len(plan.ending) == 1:
            below = float(plan.ending[0][2]) + max(clearance, scenario.ground_clearance)
            base = np.array([*plan.ending[0][:2], min(below, float(last[2]))])
        self.legs = flown_legs(plan, scenario, float(base[2]))
        self.pads = [self._pad(one, float(one[2]), self.called_back) for one in (start, base)]
        self.whole = self.legs.parts(LARGEST_PART)

    def _pad(self, base: Floats, low: float, error: TrackingError) -> ReturnPad:
        """Return the pad over a place; at its top it is clear of what is below it, by all that the UAV may stray."""
        if error == NO_ERROR or is_wall_within(self.scenario.terrain, base[:2], self.error.horizontal):
            return ReturnPad(base, low)
        return ReturnPad(base, low + self.scenario.clearance + error.horizontal + error.vertical)

    def _on_axis(self, pad: ReturnPad, error: TrackingError, aside: float, top: float) -> Iterator[Lines]:
        """Yield vertical lines on a pad up to `top`: without the error, and with it among all but what is below."""
        x, y, bottom = pad.base.tolist()
        if min(pad.top, top) <= bottom:
            return
        high, low = (np.array([[x, y, z]]) for z in (min(pad.top, top), bottom))
        some, margin = np.zeros(1, dtype=np.intp), 2 * MIN_GROWTH
        yield Lines(self.space.obstacles, Segments(high, low, margin, TrackingError(horizontal=aside)), some)
        if self.error != NO_ERROR:
            yield Lines(self.space.obstacles, Segments(high, low, margin, error, (x, y, bottom)), some)

    def home_lines(self, level: float) -> list[Lines]:
        """Return the lines over the pad at home, which all returns at a height z share."""
        top, low = (np.array([[*self.home[:2], max(z, self.low)]]) for z in (min(self.pad.top, level), self.low))
        ground = self.space.lines((top, low), NO_ERROR, rounding(1))
        return [*self._on_axis(self.pad, self.landing, self.acceptance.radius, level), *ground]

    def lines(self, parts: Parts, level: float) -> tuple[Iterator[Lines], Iterator[Lines], Iterator[Lines]]:
        """Return the lines of the first three of `WAYS`, the climb, the level line and the descent, of parts."""
        heights = self._heights(parts, level)
        return self._climb(parts, heights), self._level_line(parts, heights), self._descent(heights, level)

    def _heights(self, parts: Parts, level: float) -> Heights:
        """Return how high the ways home from parts lead, with the error of a UAV that is too high to climb."""
        bottom, top = self.legs.heights(parts)
        knows = top + self.error.vertical <= level  # it climbs to a height that it knows
        sinks = np.where(knows, 0.0, self.error.vertical)
        highest, lowest = np.maximum(top + sinks, level), np.maximum(bottom - sinks, level)
        early = np.where(bottom - self.error.vertical < level, self.acceptance.altitude, 0.0)
        return Heights(bottom, lowest - early, highest)

    def _aside(self, parts: Parts) -> Floats:
        """Return how far from the middle of its part a UAV may be to the side without straying, (n,) metres."""
        return parts.radius + self.legs.off(parts)

    def _climb(self, parts: Parts, heights: Heights) -> Iterator[Lines]:
        """Yield the lines straight up from parts; above a pad, those on the pad and those from its top on."""
        begins = heights.bottom
        for pad in self.pads:
            on = self._are_on(parts, pad)
            begins = np.maximum(begins, np.where(on, pad.top, -np.inf))
            for k in np.flatnonzero(on):
                lines = self._on_axis(pad, self.called_back, 0.0, float(heights.highest[k]))
                yield from (one._replace(some=np.array([k])) for one in lines)
        up = _at(parts.middle, np.minimum(begins, heights.highest)), _at(parts.middle, heights.highest)
        off = self._aside(parts), np.full(len(begins), MAVLINK_ROUNDING)
        yield from self.space.lines(up, self.called_back, off, climb=True)

    def _level_line(self, parts: Parts, heights: Heights) -> Iterator[Lines]:
        """Return the lines from above parts to above home, as tall as the heights are at which they may be flown."""
        tall = rounded_up(MAVLINK_ROUNDING + (heights.highest - heights.lowest) / 2, self.error.vertical)
        centre, aside = heights.highest + MAVLINK_ROUNDING - tall, self._aside(parts)
        more = leg_deviation(self.scenario, self._away(parts) + aside + 2 * self.error.horizontal)
        across = _at(parts.middle, centre), _at(self.home, centre)
        return self.space.lines(across, self.called_back, (aside + MAVLINK_ROUNDING + more, tall))

    def _descent(self, heights: Heights, level: float) -> Iterator[Lines]:
        """Return the lines from above home down to the pad there."""
        down = _at(self.home, heights.highest), _at(self.home, np.full_like(heights.highest, min(self.pad.top, level)))
        return self.space.lines(down, self.landing, rounding(len(heights.highest)))

    def _away(self, parts: Parts) -> Floats:
        """Return how far the middles of parts are from home, seen from above, (n,) metres."""
        return np.asarray(np.linalg.norm(parts.middle[:, :2] - self.home[:2], axis=1))

    @staticmethod
    def _are_on(parts: Parts, pad: ReturnPad) -> NDArray[np.bool_]:
        """Tell which parts are straight above a pad, (n,)."""
        off = np.abs(parts.corners[..., :2] - pad.base[:2]).max(axis=(1, 2, 3))
        return np.asarray((off <= SAME_PLACE) & (parts.box[0][:, 2] >= pad.base[2] - LEG_ALLOWANCE))

    def _in_bounds(self, parts: Parts, level: float) -> NDArray[np.bool_]:
        """Tell which parts are within the bounds, and all of their ways home, (n,)."""
        (low, high), bounds = parts.box, self.scenario.bounds
        least, most = np.array(bounds.min) - SURFACE_DEPTH, np.array(bounds.max) + SURFACE_DEPTH
        aside = np.maximum(self.legs.off(parts) - LEG_ALLOWANCE, 0.0)
        reach = np.column_stack([aside, aside]) + 2 * self.error.horizontal
        inside = (low[:, :2] - reach >= least[:2]).all(axis=1) & (high[:, :2] + reach <= most[:2]).all(axis=1)
        top = np.maximum(self.legs.heights(parts)[1] - LEG_ALLOWANCE, level) + self.error.vertical
        home = self.home[:2] - self.error.horizontal, self.home[:2] + self.error.horizontal
        return inside & (top <= most[2]) & bool((home[0] >= least[:2]).all() and (home[1] <= most[:2]).all())

    def clear(self, parts: Parts, level: float) -> NDArray[np.bool_]:
        """Tell which of `WAYS` are clear from parts of the flight, (n, 4)."""
        found = np.ones((len(parts.leg), len(WAYS)), dtype=np.bool_)
        for way, each in enumerate(self.lines(parts, level)):
            for lines in each:
                np.logical_and.at(found[:, way], lines.some, lines.free())
        found[:, 0] &= self._in_bounds(parts, level)
        found[:, 2] &= all(lines.free().all() for lines in self.home_lines(level))
        off = self._aside(parts) + self.error.horizontal
        near = UNPROVEN_NEAR_HOME[self.plan.autopilot.name]
        found[:, 3] = (near == 0) | (self._away(parts) - off > near)
        return found

    def at(self, altitude: float) -> WayHome:
        """Return the way home at an altitude, metres above home."""
        level, todo = float(self.home[2]) + altitude, self.whole
        none = np.zeros(0, dtype=np.intp)
        clear_parts, lost, whys = [todo.of(none)], [todo.of(none)], [none]
        while len(todo.leg):
            clear = self.clear(todo, level)
            free = np.logical_and.reduce(clear, axis=1)
            clear_parts.append(todo.of(free))
            rest = todo.of(~free)
            hopeless = ~self.clear(rest.points, level).all(axis=1)
            small = np.max(rest.sizes, axis=0) <= np.where(hopeless, SMALLEST_LOST, SMALLEST_PART)
            lost.append(rest.of(small))
            whys.append(np.argmin(clear[~free][small], axis=1))
            todo = rest.of(~small).halved()
        lines = [one for some in self.lines(joined_parts(clear_parts), level) for one in some]
        gaps = self._gaps(joined_parts(lost), np.concatenate(whys), level)
        return WayHome(self.plan, altitude, gaps, (*lines, *self.home_lines(level)) if lines else ())

    def _why(self, way: int, place: Floats, level: float) -> str:
        """Return why one of `WAYS` is not clear at a height z from a place."""
        if WAYS[way] == WAYS[1] and self.scenario.max_height is not None:
            ground = ground_height(self.scenario, np.linspace(place[:2], self.home[:2], CEILING_SAMPLES))
            if level + self.error.vertical - ground.min() > self.scenario.max_height:
                return TOO_HIGH
        return WAYS[way]

    def _gaps(self, lost: Parts, whys: Indices, level: float) -> tuple[Gap, ...]:
        """Return the times at which parts are flown, those that touch as one, with the first reason and place."""
        gaps: list[Gap] = []
        times, middle = self.legs.seconds(lost), lost.middle
        for part in np.lexsort((times[:, 1], times[:, 0])).tolist():
            begin, end = times[part].tolist()
            found = Gap(begin, end, self._why(int(whys[part]), middle[part], level), middle[part])
            if gaps and begin <= gaps[-1].end + JOINED_SPANS:
                told = found if gaps[-1].why == WAYS[-1] else gaps[-1]
                gaps[-1] = told._replace(begin=gaps[-1].begin, end=max(gaps[-1].end, end))
            else:
                gaps.append(found)
        return tuple(gaps)


def moved(back: WayHome | None, plan: FlightPlan) -> WayHome | None:
    """Return the way home of a flight that begins at another time."""
    if back is None or back.plan.begin == plan.begin:
        return back
    later = plan.begin - back.plan.begin
    gaps = tuple(gap._replace(begin=gap.begin + later, end=gap.end + later) for gap in back.gaps)
    return replace(back, plan=replace(back.plan, begin=plan.begin), gaps=gaps)


def layer(scenario: Scenario, first: FlightPlan, second: FlightPlan) -> float:
    """Return how many metres the heights at which two UAVs return must be apart to keep their separation."""
    keep = kept_distance(scenario, first.route.uav, second.route.uav)
    return keep.above + keep.error_above + ACCEPTANCE[first.autopilot.name].altitude


def _at(places: Floats, z: Floats) -> Floats:
    """Return places, (n, 3), or one place, (3,), at heights z, (n,) metres."""
    return np.column_stack([np.broadcast_to(places, (len(z), 3))[:, :2], z])
