"""The way home: from when to when of its flight it is proven that a UAV returns by itself without meeting anything.

An autopilot that returns climbs to its return altitude, unless it is higher already, flies straight to home at that
height and descends there. The flight is cut into parts. For the middle of each part the climb, the level line and the
descent are asked for, grown by the part's size, so that they hold for all instants of the part; parts that fail are
halved. The UAV may be off its path by its tracking error when it is called back, and by as much again on its return.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.exports.autopilots import ACCEPTANCE, RETURN_ALTITUDES
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.leg_geometry import leg_deviation
from skyverse.exports.return_lines import (
    Asked,
    Lines,
    Parts,
    ReturnSpace,
    flown_legs,
    joined_parts,
    rounded_up,
    strayed,
)
from skyverse.exports.separation import kept_distance
from skyverse.model.scenario import Scenario
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import LEG_ALLOWANCE, MAVLINK_ROUNDING, MIN_GROWTH, SAME_PLACE, SURFACE_DEPTH
from skyverse.space.tube import NO_ERROR, is_wall_within

UNPROVEN_NEAR_HOME = {"px4": 0.0, "ardupilot": 0.0, "dji": 50.0}
"""Metres from home within which no return is proven: a DJI aircraft returns there without a climb."""
USUAL_ALTITUDE = 30.0
"""Metres above home: a lower return altitude is taken only where none from here on is as good."""
MIN_RETURN_ALTITUDE = 5.0
"""Metres above home: no lower return altitude is chosen where there is room for it."""
ABOVE_FLIGHT = 0.2
"""Metres above the whole flight, its error included, of an altitude that is tried: altitudes are rounded to 0.1 m."""
ALTITUDES, LOW_ALTITUDES = 24, 4
"""How many return altitudes are tried, from the lowest to the upper bound; and how many lower ones."""
SEARCHED = 3
"""How many altitudes are searched where none is clear from all samples of the flight: those from most of them."""
LARGEST_PART = 32.0
"""Metres: the longest part of a flight that is asked for at once."""
SMALLEST_PART, SMALLEST_LOST = 0.1, 1.0
"""Metres: the longest part that is not halved again; and the same where nothing leads home from its middle either."""
SAMPLES = 64
"""Places of a flight from which an altitude is tried before it is searched."""
JOINED_SPANS = 1.0
"""Seconds: two times without a way home that are less apart are told as one."""
PAD_STEP = 0.25
"""Metres between the heights above a start or landing place at which a straying UAV is tried."""
WAYS = (
    "the climb is not clear",
    "the level way home is not clear",
    "the descent is not clear",
    "a DJI aircraft this near home returns without a climb",
)
"""Why no way home is proven."""


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
    """

    plan: FlightPlan
    altitude: float
    gaps: tuple[Gap, ...]
    lines: tuple[Lines, ...]

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
        return bool(self.gaps) and self.gaps[0][0] <= 0 and self.gaps[0][1] >= self.plan.arrivals[-1]

    @property
    def ends_safely(self) -> bool:
        """Whether it is proven from the last waypoint."""
        return not self.gaps or self.gaps[-1].end < self.plan.arrivals[-1]


class ReturnPad(NamedTuple):
    """A place where a UAV starts or lands, and the heights above it in which its error counts beside it only.

    Attributes
    ----------
    base
        (3,) metres: how low the centre of the UAV comes there.
    roof, top
        z of the highest roof below it, and z above which the error counts for all, metres.
    """

    base: Floats
    roof: float
    top: float


class _Returns:
    """The returns of one UAV, at any altitude."""

    def __init__(self, scenario: Scenario, space: ReturnSpace, plan: FlightPlan) -> None:
        self.scenario, self.space, self.plan = scenario, space, plan
        vehicle, clearance = scenario.uavs[plan.route.uav], scenario.clearance
        self.error, self.acceptance = vehicle.tracking_error, ACCEPTANCE[plan.autopilot.name]
        self.called_back = strayed(self.error, self.error.horizontal, 0.0)  # it does not climb from lower than it was
        self.landing = strayed(self.error, self.acceptance.radius, 0.0)
        start, last, home_z = plan.route.points[0], plan.waypoints[-1], float(plan.home[2])
        self.home = np.array([*start[:2], home_z])
        self.low = min(home_z + max(clearance, scenario.ground_clearance), float(start[2]))
        self.pad = self._pad(self._over(self.home, min(home_z + clearance, self.low)), self.low, self.landing)
        base = last
        if len(plan.ending) == 1:
            below = plan.ending[0]
            base = self._over(below, min(float(below[2]) + max(clearance, scenario.ground_clearance), float(last[2])))
        self.legs = flown_legs(plan, scenario, float(base[2]))
        self.pads = [self._pad(one, float(one[2]), self.called_back) for one in (start, base)]
        self.whole = self.legs.parts(LARGEST_PART)
        self.samples = self.legs.samples(SAMPLES)

    @staticmethod
    def _over(place: Floats, z: float) -> Floats:
        return np.array([*place[:2], z])

    def _pad(self, base: Floats, low: float, error: TrackingError) -> ReturnPad:
        """Return the pad over a place; its top is where the UAV may stray, as far as there is one above z = `low`."""
        roof, terrain = float(base[2]) - self.scenario.clearance, self.scenario.terrain
        if error == NO_ERROR or is_wall_within(terrain, base[:2], self.error.horizontal):
            return ReturnPad(base, roof, low)
        highest = self.scenario.clearance + error.horizontal + error.vertical
        levels = low + np.append(np.arange(0.0, highest, PAD_STEP), highest)
        points = np.column_stack([np.tile(base[:2], (len(levels), 1)), levels])
        clear = self._free(list(self.space.lines(points, points, error, _rounding(len(levels)))), len(levels))
        return ReturnPad(base, roof, float(levels[np.argmax(clear)]) if clear.any() else low)

    def _free(self, lines: Sequence[Lines], count: int) -> NDArray[np.bool_]:
        """Tell for each of some parts whether all of its lines are clear, (count,)."""
        free = np.ones(count, dtype=np.bool_)
        for one in lines:
            np.logical_and.at(free, one.some, self.space.free(one))
        return free

    def _over_pad(self, pad: ReturnPad, error: TrackingError, beside: float) -> Iterator[Lines]:
        """Yield vertical lines over a pad: without the error, and with it among all but roofs below and the ground."""
        x, y, bottom = pad.base.tolist()
        if pad.top <= bottom:
            return
        rows, some = (np.array([[x, y, z]]) for z in (pad.top, bottom)), np.zeros(1, dtype=np.intp)
        top, low = rows
        yield Lines(Asked("obstacles", TrackingError(horizontal=beside), 2 * MIN_GROWTH), top, low, some)
        if self.error != NO_ERROR:
            yield Lines(Asked("obstacles", error, 2 * MIN_GROWTH, (x, y, pad.roof)), top, low, some)

    def home_lines(self) -> list[Lines]:
        """Return the lines over the pad at home, which all returns share."""
        top, low = (self._over(self.home, max(z, self.low))[None] for z in (self.pad.top, self.low))
        ground = self.space.lines(top, low, NO_ERROR, _rounding(1))
        return [*self._over_pad(self.pad, self.landing, self.acceptance.radius), *ground]

    def lines(self, parts: Parts, level: float) -> Iterator[tuple[int, list[Lines]]]:
        """Yield the number of each of `WAYS` and the lines that stand for it, of parts of the flight."""
        count, middle, (low, high) = len(parts.leg), parts.middle, parts.box
        aside, rise = self.legs.off(parts)
        bottom, top = low[:, 2] - rise, high[:, 2] + rise
        knows = top + self.error.vertical <= level  # it climbs to a height that it knows
        sinks = np.where(knows, 0.0, self.error.vertical)
        highest, lowest = np.maximum(top + sinks, level), np.maximum(bottom - sinks, level)
        lowest = lowest - np.where(bottom - self.error.vertical < level, self.acceptance.altitude, 0.0)
        beside, tall = parts.radius + aside, rounded_up(MAVLINK_ROUNDING + (highest - lowest) / 2)
        over = [(self._on_pad(parts, pad), pad) for pad in self.pads]
        begins = np.minimum(np.max([bottom, *(np.where(on, p.top, -np.inf) for on, p in over)], axis=0), highest)
        up = _at(middle, begins), _at(middle, highest)
        climbing = beside, np.full(count, MAVLINK_ROUNDING)
        lines = list(self.space.lines(*up, self.called_back, climbing, climb=True))
        for on, pad in over:
            if on.any():
                for one in self._over_pad(pad, self.called_back, 0.0):
                    some = np.flatnonzero(on)
                    same = np.zeros(len(some), dtype=np.intp)
                    lines.append(Lines(one.asked, one.starts[same], one.ends[same], some))
        yield 0, lines
        more = leg_deviation(self.scenario, self._away(parts) + beside + 2 * self.error.horizontal)
        centre, goals = highest + MAVLINK_ROUNDING - tall, np.broadcast_to(self.home, middle.shape)
        across = _at(middle, centre), _at(goals, centre)
        yield 1, list(self.space.lines(*across, self.called_back, (beside + MAVLINK_ROUNDING + more, tall)))
        down = _at(goals, highest), _at(goals, np.minimum(self.pad.top, highest))
        yield 2, list(self.space.lines(*down, self.landing, _rounding(count)))

    def _away(self, parts: Parts) -> Floats:
        """Return how far the middles of parts are from home, seen from above, (n,) metres."""
        return np.asarray(np.linalg.norm(parts.middle[:, :2] - self.home[:2], axis=1))

    @staticmethod
    def _on_pad(parts: Parts, pad: ReturnPad) -> NDArray[np.bool_]:
        """Tell which parts are straight above a pad, (n,)."""
        beside = np.abs(parts.corners[..., :2] - pad.base[:2]).max(axis=(1, 2, 3))
        return np.asarray((beside <= SAME_PLACE) & (parts.box[0][:, 2] >= pad.base[2] - LEG_ALLOWANCE))

    def _in_bounds(self, parts: Parts, level: float) -> NDArray[np.bool_]:
        """Tell which parts are within the bounds, and all of their ways home, (n,)."""
        (low, high), bounds = parts.box, self.scenario.bounds
        least, most = np.array(bounds.min) - SURFACE_DEPTH, np.array(bounds.max) + SURFACE_DEPTH
        aside, rise = (np.maximum(off - LEG_ALLOWANCE, 0.0) for off in self.legs.off(parts))
        reach = np.column_stack([aside, aside]) + 2 * self.error.horizontal
        inside = (low[:, :2] - reach >= least[:2]).all(axis=1) & (high[:, :2] + reach <= most[:2]).all(axis=1)
        top = np.maximum(high[:, 2] + rise, level) + self.error.vertical
        home = self.home[:2] - self.error.horizontal, self.home[:2] + self.error.horizontal
        return inside & (top <= most[2]) & bool((home[0] >= least[:2]).all() and (home[1] <= most[:2]).all())

    def clear(self, parts: Parts, level: float) -> NDArray[np.bool_]:
        """Tell which of `WAYS` are clear from parts of the flight, (n, 4)."""
        found = np.ones((len(parts.leg), len(WAYS)), dtype=np.bool_)
        for way, lines in self.lines(parts, level):
            found[:, way] = self._free(lines, len(parts.leg))
        found[:, 0] &= self._in_bounds(parts, level)
        found[:, 2] &= self._home_is_free
        off = parts.radius + self.legs.off(parts)[0] + self.error.horizontal
        near = UNPROVEN_NEAR_HOME[self.plan.autopilot.name]
        found[:, 3] = (near == 0) | (self._away(parts) - off > near)
        return found

    @cached_property
    def _home_is_free(self) -> bool:
        return bool(self._free(self.home_lines(), 1)[0])

    def at(self, altitude: float) -> WayHome:
        """Return the way home at an altitude, metres above home."""
        level, todo = float(self.home[2]) + altitude, self.whole
        none = np.zeros(0, dtype=np.intp)
        proven, lost, whys = [todo.of(none)], [todo.of(none)], [none]
        while len(todo.leg):
            clear = self.clear(todo, level)
            free = np.logical_and.reduce(clear, axis=1)
            proven.append(todo.of(free))
            rest = todo.of(~free)
            hopeless = ~self.clear(rest.points, level).all(axis=1)
            small = np.max(rest.sizes, axis=0) <= np.where(hopeless, SMALLEST_LOST, SMALLEST_PART)
            lost.append(rest.of(small))
            whys.append(np.argmin(clear[~free][small], axis=1))
            todo = rest.of(~small).halved()
        lines = [one for _, some in self.lines(joined_parts(proven), level) for one in some]
        gaps = self._gaps(joined_parts(lost), np.concatenate(whys))
        return WayHome(self.plan, altitude, gaps, (*lines, *self.home_lines()) if lines else ())

    def _gaps(self, lost: Parts, whys: Indices) -> tuple[Gap, ...]:
        """Return the times at which parts are flown, those that touch as one, with the first reason and place."""
        gaps: list[Gap] = []
        times, middle = self.legs.seconds(lost), lost.middle
        for part in np.lexsort((times[:, 1], times[:, 0])).tolist():
            begin, end = times[part].tolist()
            found = Gap(begin, end, WAYS[whys[part]], middle[part])
            if gaps and begin <= gaps[-1].end + JOINED_SPANS:
                told = found if gaps[-1].why == WAYS[-1] else gaps[-1]
                gaps[-1] = told._replace(begin=gaps[-1].begin, end=max(gaps[-1].end, end))
            else:
                gaps.append(found)
        return tuple(gaps)

    def blocked(self, altitude: float) -> float:
        """Return from how many samples of the flight an altitude leads into something; its end counts as all others."""
        free = np.logical_and.reduce(self.clear(self.samples, float(self.home[2]) + altitude)[:, :-1], axis=1)
        return float((~free[:-1]).sum() + (len(free) - 1) * (not free[-1]))

    def best(self, taken: Sequence[tuple[float, float]]) -> WayHome:
        """Return the way home at the first altitude at which it is proven at every instant, or else the best.

        Altitudes are preferred that are as far from those that are `taken`, z and how far to keep from it, metres.
        """
        altitudes = self._altitudes([z + side * keep for z, keep in taken for side in (-1.0, 1.0)])
        blocked = {one: self.blocked(one) for one in altitudes}
        apart = [one for one in altitudes if all(abs(self.home[2] + one - z) >= keep for z, keep in taken)]
        for one in (*apart, *(one for one in altitudes if one not in apart)):
            if not blocked[one]:
                found = self.at(one)
                if all(gap.why == WAYS[-1] for gap in found.gaps):
                    return found
        tried = [self.at(one) for one in sorted(altitudes, key=lambda one: (blocked[one], one not in apart))[:SEARCHED]]

        def worse(way: WayHome) -> tuple[bool, int, bool]:
            lost = sum(gap.end - gap.begin for gap in way.gaps)
            return not way.ends_safely, int(lost), way.altitude not in apart  # a part of a second is no reason

        return min(tried, key=worse)

    def _altitudes(self, more: Sequence[float]) -> list[float]:
        """Return the return altitudes to try, metres above home, and those of some heights z: the usual ones first.

        Then come those that are no lower than the flight itself, and at last lower ones, the highest of them first.
        """
        scenario, waypoints, home = self.scenario, self.plan.waypoints, float(self.home[2])
        top = scenario.bounds.max[2] - self.error.vertical
        low = min(max(float(waypoints[0][2]), home + MIN_RETURN_ALTITUDE), top)
        flown = float(waypoints[:, 2].max())
        above = flown + self.error.vertical + max(self.plan.route.deviations, default=0.0) + ABOVE_FLIGHT
        levels = [*np.linspace(low, top, ALTITUDES), home + USUAL_ALTITUDE, flown, above, *more]
        if scenario.terrain is not None and scenario.max_height is not None:
            lowest = float(scenario.terrain.lowest_ground.height(waypoints[:, :2]).min())
            most = lowest + scenario.max_height - self.error.vertical - LEG_ALLOWANCE
            levels += np.linspace(low, most, ALTITUDES).tolist()
        least, most = RETURN_ALTITUDES[self.plan.autopilot.name]
        lower = np.linspace(least, low - home, LOW_ALTITUDES, endpoint=False)
        tenths = np.unique(np.round(10 * np.r_[np.clip(levels, low, top) - home, lower] - 0.499)) / 10
        able = [one for one in tenths.tolist() if least <= one <= most] or [least]

        def preference(altitude: float) -> tuple[int, float]:
            if altitude >= USUAL_ALTITUDE:
                return 0, altitude
            return (1, altitude) if home + altitude >= flown else (2, -altitude)

        return sorted(able, key=preference)


def ways_home(scenario: Scenario, plans: Sequence[FlightPlan], altitude: float | None = None) -> list[WayHome | None]:
    """Return how each UAV comes home, ``None`` for aeroplanes, whose circles are not judged.

    Return altitudes are the one that is asked for, metres above home, or else apart from one another by the separations
    of UAVs, where there is room. What the referee does not prove is not proven.
    """
    space, found = ReturnSpace(scenario), list[WayHome | None]()
    for plan in plans:
        if scenario.uavs[plan.route.uav].fixed_wing is not None:
            found.append(None)
            continue
        returns = _Returns(scenario, space, plan)
        taken = [(one.level, layer(scenario, one.plan, plan)) for one in found if one is not None]
        found.append(returns.best(taken) if altitude is None else returns.at(altitude))
    if space.proven([line for one in found if one is not None for line in one.lines]):
        return found
    return [one if one is None or space.proven(one.lines) else replace(one, gaps=_all_of(one.plan)) for one in found]


def _all_of(plan: FlightPlan) -> tuple[Gap]:
    """Return the whole flight as a gap."""
    return (Gap(0.0, float(plan.arrivals[-1]), "the referee does not prove it", plan.waypoints[0]),)


def layer(scenario: Scenario, first: FlightPlan, second: FlightPlan) -> float:
    """Return how many metres the heights at which two UAVs return must be apart to keep their separation."""
    keep = kept_distance(scenario, first.route.uav, second.route.uav)
    return keep.above + keep.error_above + ACCEPTANCE[first.autopilot.name].altitude


def _at(places: Floats, z: Floats) -> Floats:
    """Return places (n, 3) at heights z (n,), metres."""
    return np.column_stack([places[:, :2], z])


def _rounding(count: int) -> tuple[Floats, Floats]:
    """Return how far rounding puts each of some lines off, beside and up or down, metres."""
    off = np.full(count, MAVLINK_ROUNDING)
    return off, off
