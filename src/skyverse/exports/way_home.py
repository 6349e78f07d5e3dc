"""The way home: whether a UAV that returns by itself, at any instant of its flight, meets anything on its way.

An autopilot that returns climbs to its return altitude, unless it is higher already, flies straight to its destination
and descends there. The flight is cut into parts. For the middle of each part the climb and the straight line are
checked, with a clearance that grows by half the part's length, so that they hold for all instants of the part; parts
that fail are halved. `space` searches; what is handed out is certified by the referee.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.exports.autopilot_leg_clearance import MIN_EARTH_RADIUS, steepest, towards
from skyverse.exports.autopilots import Autopilot
from skyverse.exports.flight_plan import FlightPlan
from skyverse.model.scenario import Scenario
from skyverse.numerics.tolerances import MAVLINK_ROUNDING
from skyverse.space.world import World

CLEARANCE_SHARE = 0.5
"""The share of the clearance that is kept on the way home: with the rest, parts of a flight may have a length."""
LARGEST_PART = 16.0
"""Metres: half the length of the longest part of a flight that is checked at once."""
SMALLEST_PART = 0.05
"""Metres: half the length of the shortest part; what then fails has no way home."""
SMALLEST_LOST = 0.5
"""Metres: the same where the way home is blocked from the middle of the part."""
SAMPLES = 64
"""Places of a flight from which an altitude is tried before it is searched."""
NEAR_HOME = 50.0
"""Metres from home within which a DJI aircraft returns without a climb, as its manual says; both are checked there."""
LANDS_AT_ONCE = 5.0
"""Metres from home within which a DJI aircraft lands where it is."""


class Destination(NamedTuple):
    """A place to land at: (3,) metres, and z down to which the descent is checked."""

    place: Floats
    until: float


class Parts(NamedTuple):
    """Parts of a flight.

    Attributes
    ----------
    leg
        (n,) indices of legs.
    begin, end
        (n,) shares of the leg's length.
    """

    leg: NDArray[np.intp]
    begin: Floats
    end: Floats


@dataclass(frozen=True, eq=False)
class FlownLegs:
    """The legs of one UAV's flight, as far as its return is concerned.

    Attributes
    ----------
    starts, ends
        (n, 3) metres.
    off
        (n,) metres: how far the UAV may be off a leg, because the leg is bent seen from above.
    cut
        (n,) metres: how far it may be off the start of a leg, because it cuts the corner; at the end it is on the leg.
    rise
        (n,) metres: how much higher it may be, because the leg is bent: above ground it follows the ground.
    """

    starts: Floats
    ends: Floats
    off: Floats
    cut: Floats
    rise: Floats

    @property
    def lengths(self) -> Floats:
        """(n,) metres."""
        return np.linalg.norm(self.ends - self.starts, axis=1)


def flown_legs(plan: FlightPlan, scenario: Scenario) -> FlownLegs:
    """Return the legs of a flight plan from the first waypoint to the end, a landing included.

    A return during the take-off is one from its end: it uses the same lines.
    """
    points, rise = plan.waypoints, plan.route.bends
    shift, cut = _cut_corners(plan)
    off = bends(scenario, np.linalg.norm(np.diff(points, axis=0), axis=1))
    if len(plan.ending) == 1:
        low = plan.ending[0].copy()
        low[2] = min(low[2] + max(scenario.clearance, scenario.ground_clearance), points[-1][2])
        points = np.concatenate([points, low[None]])
        off, cut, rise = np.r_[off, 0.0], np.r_[cut, 0.0], np.r_[rise, 0.0]
    starts = points[:-1].copy()
    starts[: len(shift)] += shift
    return FlownLegs(starts, points[1:], off, cut, rise)


def _cut_corners(plan: FlightPlan) -> tuple[Floats, Floats]:
    """Return where legs begin when corners are cut: the middle of all such places, and how far they are from it.

    A UAV turns to a leg at its first waypoint, or up to the radius before it, on the leg before or on the way to that
    from where it turned to it: in a triangle of the waypoint and two places p and q before it. Both are (m, 3) and (m,)
    metres, the first from the waypoint.
    """
    points, stops = plan.waypoints, plan.full_stops
    shift, off = np.zeros((len(points) - 1, 3)), np.zeros(len(points) - 1)
    for k in range(1, len(points) - 1):
        if stops[k]:
            continue
        before, at, radius = points[k - 1], points[k], plan.route.radius
        entered = before
        if k > 1 and not stops[k - 1]:
            entered = before + towards(points[k - 2] - before, radius)
        p, q = towards(before - at, radius), towards(entered - at, radius)
        shift[k] = (p + q) / 4
        off[k] = max(float(np.linalg.norm(place - shift[k])) for place in (np.zeros(3), p, q))
    return shift, off


def bends(scenario: Scenario, away: Floats) -> Floats:
    """Return how far lines of constant altitude on Earth may be off straight lines in local metres, (m,).

    Over a distance d, `away` (m,) metres, the Earth falls away by d^2 / (2 R), and a line in latitude and longitude is
    off a great circle by less than d^2 tan(latitude) / (8 R).
    """
    origin = scenario.frame.origin
    tilt = 0.0 if origin is None else abs(float(np.tan(np.radians(origin.latitude))))
    return MAVLINK_ROUNDING + 1.1 * away**2 * (1 + tilt / 4) / (2 * MIN_EARTH_RADIUS)


def return_level(autopilot: Autopilot, home: Floats, destination: Destination, altitude: float) -> float:
    """Return z at which a UAV below it returns: PX4 counts from its destination, others from home."""
    if autopilot.name == "px4":
        return float(destination.place[2]) + altitude
    return max(float(home[2]) + altitude, float(destination.place[2]))


class ReturnLines(NamedTuple):
    """Straight lines that a returning UAV flies.

    Attributes
    ----------
    starts, ends
        (m, 3) metres.
    growth
        (m,) metres by which a line is thickened, so that it stands for a whole part of the flight.
    ground
        (m,) whether the ground matters; above a place of the flight it cannot be nearer than there.
    """

    starts: Floats
    ends: Floats
    growth: Floats
    ground: NDArray[np.bool_]


class Worlds(NamedTuple):
    """The compiled space with the ground and without it, and a bound of the ground's slope."""

    whole: World
    bare: World
    slope: float


def return_worlds(scenario: Scenario) -> Worlds:
    """Compile a scenario's space for returns."""
    scenario = with_ground_for_returns(scenario)
    slope = 0.0 if scenario.terrain is None else steepest(scenario.terrain)
    return Worlds(World(scenario), World(scenario.model_copy(update={"terrain": None})), slope)


def with_ground_for_returns(scenario: Scenario) -> Scenario:
    """Return a scenario whose clearance from the ground may be lessened as that from obstacles is.

    Ways home keep a share of the clearance from obstacles. Less than the same share must not be left above ground where
    the clearance from the ground is the smaller one; it is raised by the difference beforehand.
    """
    less = (1 - CLEARANCE_SHARE) * (scenario.clearance - scenario.ground_clearance)
    if scenario.terrain is None or less <= 0:
        return scenario
    terrain = scenario.terrain.model_copy(update={"clearance": scenario.ground_clearance + less})
    return scenario.model_copy(update={"terrain": terrain})


class WayHome:
    """Checks the return of one UAV at one return altitude, to the nearest of some destinations.

    Parameters
    ----------
    scenario, worlds
        The scenario, and its compiled space.
    plan
        The flight.
    destinations
        Where it may land, home first.
    altitude
        The return altitude, metres above home.
    """

    def __init__(
        self,
        scenario: Scenario,
        worlds: Worlds,
        plan: FlightPlan,
        destinations: Sequence[Destination],
        altitude: float,
    ) -> None:
        self.scenario, self.worlds, self.plan = scenario, worlds, plan
        self.destinations, self.altitude = tuple(destinations), altitude
        self.legs = flown_legs(plan, scenario)
        self.levels = np.array([return_level(plan.autopilot, plan.home, one, altitude) for one in destinations])
        self.places = np.array([one.place for one in destinations])
        self.until = np.array([one.until for one in destinations])
        error = scenario.uavs[plan.route.uav].tracking_error
        self.error = float(np.hypot(error.horizontal, error.vertical))

    def search(self) -> tuple[Parts, ReturnLines]:
        """Return the parts of the flight without a way home, and the lines that prove the way home of all others."""
        lengths = self.legs.lengths
        counts = np.maximum(np.ceil(lengths / (2 * LARGEST_PART)).astype(int), 1)
        leg = np.repeat(np.arange(len(counts)), counts)
        begin = np.concatenate([np.arange(count) / count for count in counts])
        todo = Parts(leg, begin, begin + 1 / counts[leg])
        lost: list[Parts] = []
        proof: list[ReturnLines] = []
        while len(todo.leg):
            lines, part = self.lines(todo)
            free = np.ones(len(todo.leg), dtype=bool)
            np.logical_and.at(free, part, self._free(lines))
            proof.append(some_lines(lines, free[part]))
            smallest = np.where(self._hopeless(lines, part, free), SMALLEST_LOST, SMALLEST_PART)
            long = (todo.end - todo.begin) * lengths[todo.leg] > 2 * smallest
            lost.append(_chosen(todo, ~free & ~long))
            left = _chosen(todo, ~free & long)
            middle = (left.begin + left.end) / 2
            todo = Parts(np.tile(left.leg, 2), np.r_[left.begin, middle], np.r_[middle, left.end])
        gone = Parts(*(np.concatenate([getattr(part, name) for part in lost]) for name in Parts._fields))
        return gone, joined(proof)

    def blocked(self) -> int:
        """Return from how many places of the flight, evenly spread, the way home meets something."""
        shares = (np.arange(SAMPLES) + 0.5) / SAMPLES * self.legs.lengths.sum()
        ends = np.cumsum(self.legs.lengths)
        leg = np.searchsorted(ends, shares)
        at = 1 - (ends[leg] - shares) / self.legs.lengths[leg]
        lines, part = self.lines(Parts(leg, at, at))
        return int(self._hopeless(lines, part, np.zeros(SAMPLES, dtype=bool)).sum())

    def can_climb(self, parts: Parts) -> bool:
        """Tell whether the climb is clear from any of some parts, so that another destination may help there."""
        lines, part = self.lines(parts)
        _, first = np.unique(part, return_index=True)  # the climb to the nearest destination stands first
        return bool(self._free(some_lines(lines, first)).any())

    def _hopeless(self, lines: ReturnLines, part: NDArray[np.intp], free: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Tell for each part that is not free whether its lines meet something even without growth."""
        found = np.zeros(len(free), dtype=bool)
        asked = ~free[part]
        margin = -(1 - CLEARANCE_SHARE) * self.scenario.clearance
        for ground, world in ((True, self.worlds.whole), (False, self.worlds.bare)):
            some = asked & (lines.ground == ground)
            met = ~world.segments_free(lines.starts[some], lines.ends[some], margin=margin)
            found[part[some][met]] = True
        return found

    def lines(self, parts: Parts) -> tuple[ReturnLines, NDArray[np.intp]]:
        """Return the lines that stand for the returns from parts of the flight, and the part of each line."""
        along = (self.legs.ends - self.legs.starts)[parts.leg]
        middle = self.legs.starts[parts.leg] + ((parts.begin + parts.end) / 2)[:, None] * along
        half = (parts.end - parts.begin) / 2 * self.legs.lengths[parts.leg] + self.legs.off[parts.leg]
        half += (1 - parts.begin) * self.legs.cut[parts.leg]
        away = np.linalg.norm(middle[:, None, :2] - self.places[None, :, :2], axis=2)
        part, goal = np.nonzero(away <= (away.min(axis=1) + 2 * half)[:, None])
        top, over, down = middle[part].copy(), self.places[goal].copy(), self.places[goal].copy()
        level = np.maximum(middle[part, 2], self.levels[goal])
        top[:, 2] = over[:, 2] = level
        down[:, 2] = np.minimum(self.until[goal], level)
        bend = bends(self.scenario, away[part, goal]) + self.error
        grown = half[part] + bend
        rise = self.legs.rise[parts.leg][part]
        rise[middle[part, 2] + half[part] + rise + self.error <= level] = 0.0  # it climbs to a level that it knows
        up = ReturnLines(middle[part], top, grown, np.zeros(len(part), dtype=bool))
        across = ReturnLines(top, over, grown + rise, np.ones(len(part), dtype=bool))
        below = ReturnLines(over, down, bend, np.ones(len(part), dtype=bool))
        found, owners = [up, across, below], [part, part, part]
        if self.plan.autopilot.name == "dji":
            near = away[part, goal] - half[part] <= NEAR_HOME
            flat = over[near].copy()
            flat[:, 2] = middle[part[near], 2]
            found.append(ReturnLines(middle[part[near]], flat, (grown + rise)[near], np.ones(len(flat), dtype=bool)))
            owners.append(part[near])
            close = away[part, goal] - half[part] <= LANDS_AT_ONCE
            under = middle[part[close]].copy()
            under[:, 2] = np.minimum(self.until[goal[close]], under[:, 2])
            found.append(ReturnLines(middle[part[close]], under, grown[close], np.ones(len(under), dtype=bool)))
            owners.append(part[close])
        return joined(found), np.concatenate(owners)

    def _free(self, lines: ReturnLines) -> NDArray[np.bool_]:
        """Tell for each line whether it keeps the smaller clearance and its growth, (m,)."""
        free = np.zeros(len(lines.growth), dtype=bool)
        for some, margin, ground in grouped(lines, self.scenario, self.worlds.slope):
            world = self.worlds.whole if ground else self.worlds.bare
            free[some] = world.segments_free(lines.starts[some], lines.ends[some], margin=margin)
        return free


def grouped(lines: ReturnLines, scenario: Scenario, slope: float) -> Iterator[tuple[NDArray[np.bool_], float, bool]]:
    """Yield which lines share a margin, metres added to the clearance, and whether the ground matters to them."""
    growth = np.where(lines.ground, 1 + slope, 1.0) * lines.growth
    margins = rounded_up(growth - (1 - CLEARANCE_SHARE) * scenario.clearance)
    grounds = lines.ground & (scenario.terrain is not None)
    for margin in np.unique(margins).tolist():
        for ground in (False, True):
            some = (margins == margin) & (grounds == ground)
            if some.any():
                yield some, float(margin), ground


def rounded_up(margin: Floats) -> Floats:
    """Return margins rounded up, above 0 to powers of two and below to halves of them: a world is made for each."""
    power = 2.0 ** np.ceil(np.log2(np.maximum(np.abs(margin), SMALLEST_PART)))
    return np.where(margin > 0, power, np.ceil(2 * margin / power) * power / 2)


def some_lines(lines: ReturnLines, some: NDArray[np.bool_] | NDArray[np.intp]) -> ReturnLines:
    """Return some of the lines."""
    return ReturnLines(lines.starts[some], lines.ends[some], lines.growth[some], lines.ground[some])


def joined(each: Sequence[ReturnLines]) -> ReturnLines:
    """Return all lines of several."""
    starts, ends, growth = (np.concatenate([getattr(one, name) for one in each]) for name in ReturnLines._fields[:3])
    return ReturnLines(starts, ends, growth, np.concatenate([one.ground for one in each]))


def _chosen(parts: Parts, some: NDArray[np.bool_]) -> Parts:
    return Parts(parts.leg[some], parts.begin[some], parts.end[some])
