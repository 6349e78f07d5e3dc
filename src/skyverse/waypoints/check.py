"""Missions that people have, judged as their autopilots fly them: each leg, corner, climb, landing, return and limit.

What the planners' space finds clear is proven by the referee; what it finds wrong is told with the numbers of the
orders, the place, what is met, how deep, and the altitude that would clear it.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.landing import Descents, slow_touch_down, why_not_level
from skyverse.exports.leg_geometry import greatest_on_legs
from skyverse.exports.leg_space import Breach, LegRule
from skyverse.exports.return_altitudes import ways_home
from skyverse.exports.separation import Apart, FleetApart, fleet_apart
from skyverse.exports.way_home import Gap, WayHome
from skyverse.model.geodesy import to_wgs84
from skyverse.model.mission import FlightSummary
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.waypoints import OrderKind
from skyverse.numerics.tolerances import SAME_PLACE
from skyverse.referee.energy import energy_bounds
from skyverse.referee.judgement import CEILING_NUMBER, GROUND_NUMBER, Incursion
from skyverse.summary import flight_summary
from skyverse.waypoints.defaults import DEFAULTS
from skyverse.waypoints.findings import FindingKind, MissionFinding, Subject, kind_of
from skyverse.waypoints.flown import FlownMission
from skyverse.waypoints.mission_judge import LIFT_STEP, MissionJudge, Part
from skyverse.waypoints.way_back import flown_back, why_not_back

OFF_HOME = 10.0
"""Metres by which the altitude of home in a file may be off the ground there; relative heights are off as much."""
SPEED_ROUNDING = 0.05
"""m/s to which files round speeds."""
ONE_PHOTO = ("take photo", "takePhoto")
"""What formats of DJI's aircraft call one photo."""
NOT_BACK = "the way back along the mission is not clear"
"""Why no return is proven of a vehicle that retraces its mission."""


class Height(NamedTuple):
    """A height above ground, metres, and the orders between which it is flown."""

    metres: float
    items: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class CheckedMission:
    """What is found of one mission.

    Attributes
    ----------
    flown
        How it is flown.
    scenario
        Where, with the fence of its own file.
    findings
        What is wrong with it, and what must be heeded.
    back
        Its way home; ``None`` for an aeroplane.
    """

    flown: FlownMission
    scenario: Scenario
    findings: tuple[MissionFinding, ...]
    back: WayHome | None

    @cached_property
    def _heights(self) -> tuple[Height | None, Height | None]:
        return (None, None) if self.scenario.terrain is None else _heights(self.flown, self.scenario)

    @property
    def lowest(self) -> Height | None:
        """The least height above ground after the take-off, if the ground is known."""
        return self._heights[0]

    @property
    def highest(self) -> Height | None:
        """The greatest height above ground after the take-off, if the ground is known."""
        return self._heights[1]

    @cached_property
    def summary(self) -> FlightSummary:
        """Length, time and energy of the flight."""
        plan, uav = self.flown.plan, self.scenario.uavs[self.flown.plan.route.uav]
        ground = [slow_touch_down(self.scenario, plan)]
        return flight_summary(uav, plan.waypoints, plan.predicted(), self.scenario.wind, ground=ground)

    @property
    def photos(self) -> int | None:
        """How many photos it takes, as far as its file tells; ``None`` if it tells none."""
        return _photos(self.flown)

    @property
    def is_proven(self) -> bool:
        """Whether nothing is wrong with it."""
        return not any(finding.wrong for finding in self.findings)

    def of(self, subject: Subject) -> list[MissionFinding]:
        """Return what is wrong about a subject."""
        return [finding for finding in self.findings if finding.wrong and finding.subject is subject]


def check_flown(flown: FlownMission, scenario: Scenario, ground: float | None) -> CheckedMission:
    """Judge one mission.

    Parameters
    ----------
    flown
        How it is flown.
    scenario
        Where; it has an origin.
    ground
        The ground at home as the terrain has it, metres above mean sea level, if that is known.
    """
    uav = flown.plan.route.uav
    judge = MissionJudge(scenario, scenario.uavs[uav].tracking_error, flown.lifts)
    found = [*_of_home(flown, ground), *_of_orders(flown)]
    found += _of_parts(judge, flown)
    found += [*_of_landing(flown, scenario), *_of_limits(flown, scenario)]
    plan = flown.plan
    unlimited = derived(scenario, max_height=None)  # a return is an emergency, and as high as it must be
    (back,) = ways_home(unlimited, [plan], flown.return_altitude)
    returns = list(_of_way_home(flown, scenario, back))
    if flown.retraces and back is not None:
        known = {(one.items, one.what) for one in found}
        along = [one for one in _of_way_back(flown, scenario) if (one.items, one.what) not in known]
        gaps = (Gap(0.0, float(plan.arrivals[-1]), NOT_BACK, plan.home),) if along else ()
        back = replace(back, gaps=gaps, lines=(), retraces=True)
        returns = [*along, *(one for one in returns if one.subject is Subject.END and not flown.returns_along)]
    found += returns
    return CheckedMission(
        flown,
        scenario,
        tuple(sorted(found, key=lambda one: (not one.wrong, list(Subject).index(one.subject)))),
        back,
    )


def check_apart(checked: Sequence[CheckedMission], scenario: Scenario) -> tuple[FleetApart, list[CheckedMission]]:
    """Judge whether missions that start together keep their separation, and return them with what is found of that."""
    apart = fleet_apart(scenario, [one.flown.plan for one in checked])
    found = list(checked)
    for first, second in apart.of(Apart.CLOSE):
        pair = tuple(sorted((first, second)))
        met = next((one for one in apart.violations if tuple(sorted(one.uavs)) == pair), None)
        for one, other in ((first, second), (second, first)):
            flown = found[one].flown
            close = MissionFinding(Subject.APART, FindingKind.CLOSE, name=scenario.uavs[other].name)
            if met is not None and met.time is not None and met.position is not None:
                leg = min(int(np.searchsorted(flown.plan.arrivals, met.time)), len(flown.visits) - 1)
                place = _globe(scenario, np.array(met.position))
                close = replace(close, items=flown.numbers(leg), place=place, times=(met.time, met.time))
            found[one] = replace(found[one], findings=(*found[one].findings, close))
    return apart, found


def _globe(scenario: Scenario, place: Floats) -> tuple[float, float, float]:
    """Return latitude, longitude and metres above mean sea level of a place, (3,) metres."""
    origin = scenario.frame.origin
    assert origin is not None
    latitude, longitude, sea = to_wgs84(origin, place[None])[0].tolist()
    return latitude, longitude, sea


def _of_home(flown: FlownMission, ground: float | None) -> Iterator[MissionFinding]:
    """Yield what is wrong with the altitude of home that a file states."""
    home = flown.waypoints.home
    if home is None or not home[2] or ground is None or abs(home[2] - ground) <= OFF_HOME:  # 0 where nobody set it
        return
    at = (*home[:2], ground)
    yield MissionFinding(Subject.HOME, FindingKind.HOME_ALTITUDE, (0,), at, found=home[2], limit=ground)


def _of_orders(flown: FlownMission) -> Iterator[MissionFinding]:
    """Yield what is not known of orders, or not flown by this autopilot."""
    waypoints, orders = flown.waypoints, flown.waypoints.orders
    curved = tuple(order.number for order in orders if order.curved)
    if curved:
        yield MissionFinding(Subject.LEGS, FindingKind.CURVED, curved)
    other = {order.number: order.name for order in orders if order.kind is OrderKind.OTHER}
    if other:
        names = ", ".join(dict.fromkeys(other.values()))
        yield MissionFinding(Subject.ORDERS, FindingKind.NOT_FOLLOWED, tuple(other), name=names)
    if waypoints.rally and not flown.retraces and flown.plan.autopilot.name != "dji":
        yield MissionFinding(Subject.WAY_HOME, FindingKind.RALLY, limit=len(waypoints.rally))
    if not flown.plan.corners_proven:
        yield MissionFinding(Subject.CORNERS, FindingKind.TURNS)
    if waypoints.aeroplane and math.isfinite(flown.plan.rates.climb):
        yield MissionFinding(Subject.LIMITS, FindingKind.NOT_AEROPLANE)
    if flown.plan.autopilot.name == "px4":
        follow = tuple(dict.fromkeys(visit.order.number for visit in flown.visits if visit.follows))
        circles = tuple(order.number for order in orders if order.turns and math.isfinite(flown.plan.rates.climb))
        refused = ((follow, FindingKind.NO_TERRAIN_FOLLOWING), (circles, FindingKind.NO_CIRCLES))
        yield from (MissionFinding(Subject.LIMITS, kind, items) for items, kind in refused if items)


def _of_parts(judge: MissionJudge, flown: FlownMission) -> list[MissionFinding]:
    """Return what is wrong with legs, of each thing that one meets where that is worst, and then with corners.

    Of a corner it is only what is not wrong with a leg at it, too.
    """
    found: dict[tuple[object, ...], MissionFinding] = {}
    refuted = sorted(judge.refuted(flown), key=lambda one: bool(one.radius))
    parts = [part for one in refuted for part in judge.by_what_is_met(one)]
    for part, met in zip(parts, judge.met(parts), strict=True):
        one, corner = _of_part(judge, flown, part, met), bool(part.radius)
        known = [found.get((flown.numbers(k), one.what)) for k in range(part.k, part.k + 1 + corner)]
        deepest = max((leg.deep or 0.0 for leg in known if leg is not None), default=-1.0)
        if (one.deep or 0.0) > deepest + LIFT_STEP * corner:
            found[(one.items, one.what, corner) if corner else (one.items, one.what)] = one
    return list(found.values())


def _of_part(judge: MissionJudge, flown: FlownMission, part: Part, met: Incursion | None) -> MissionFinding:
    """Return what is wrong with a leg or corner that meets something, or breaks a rule."""
    subject = Subject.CORNERS if part.radius else Subject.TAKEOFF if part.k == 0 else Subject.LEGS
    items = (flown.visits[part.k].order.number,) if part.radius else flown.numbers(part.k)
    kind, place, name, found, limit = _met(judge, part, met)
    at, clear = _globe(judge.scenario, place), None
    if kind is FindingKind.GROUND and found is not None and limit is not None:  # whatever else is above it
        clear = at[2] + limit - found
    elif kind not in (FindingKind.CEILING, FindingKind.BOUNDS):
        lift = judge.clear_lift(part)
        clear = None if lift is None else at[2] + lift
    return MissionFinding(subject, kind, items, at, name, found, limit, clear, part=part.k, corner=bool(part.radius))


class _Met(NamedTuple):
    """What a leg or corner meets, where, (3,) metres, and the name and numbers of `MissionFinding`."""

    kind: FindingKind
    place: Floats
    name: str = ""
    found: float | None = None
    limit: float | None = None


def _met(judge: MissionJudge, part: Part, met: Incursion | None) -> _Met:
    scenario, fault = judge.scenario, part.checked.fault
    if isinstance(fault, Breach):
        if fault.rule is LegRule.GROUND:
            limit = scenario.ground_clearance
            return _Met(FindingKind.GROUND, fault.place, "", limit - fault.off, limit)
        if fault.rule is LegRule.CEILING:
            return _Met(FindingKind.CEILING, fault.place, "", -fault.off, 0.0)
        low, high = np.subtract(fault.place, scenario.bounds.min), np.subtract(scenario.bounds.max, fault.place)
        found, limit = -fault.off, 0.0
        if low[2] > min(low.min(), high.min()):
            return _Met(FindingKind.BOUNDS, fault.place, "", found, limit)
        if scenario.terrain is not None:  # what is below the bounds is below ground, or near it
            found = float(fault.place[2] - scenario.terrain.height(fault.place[:2])) - judge.error.vertical
            limit = scenario.ground_clearance
        return _Met(FindingKind.GROUND, fault.place, "", found, limit)
    if met is None:
        return _Met(FindingKind.UNDECIDED, part.points[-1 if not part.radius else 2])
    if met.obstacle in (GROUND_NUMBER, CEILING_NUMBER):
        kind = FindingKind.GROUND if met.obstacle == GROUND_NUMBER else FindingKind.CEILING
        limit = scenario.ground_clearance if kind is FindingKind.GROUND else 0.0
        return _Met(kind, met.position, "", limit - (met.required - met.gap), limit)
    shape = part.checker.space.scenario.obstacles[met.obstacle]
    kind = kind_of(shape)
    name = " ".join(word for word in (shape.kind or kind.value, shape.name) if word)
    return _Met(kind, met.position, name, scenario.clearance - (met.required - met.gap), scenario.clearance)


def _of_landing(flown: FlownMission, scenario: Scenario) -> Iterator[MissionFinding]:
    """Yield why the vehicle cannot land where its orders say."""
    plan = flown.plan
    if flown.end != "land":
        return
    uav, top, place = plan.route.uav, plan.waypoints[-1], plan.ending[-1]
    above = np.array([*top[:2], max(top[2], place[2])])
    why = why_not_level(scenario, uav, place) or Descents(scenario).why_not_clear(uav, above, place)
    if why is not None:
        items = (flown.visits[-1].order.number,)
        yield MissionFinding(Subject.END, FindingKind.LANDING, items, _globe(scenario, place), why)


def _of_limits(flown: FlownMission, scenario: Scenario) -> Iterator[MissionFinding]:
    """Yield which limits of the vehicle, of the autopilot and of its files a mission exceeds."""
    plan, vehicle = flown.plan, scenario.uavs[flown.plan.route.uav]
    autopilot, orders = plan.autopilot, flown.waypoints.orders
    most = min(vehicle.max_speed, autopilot.max_speed)
    fast = [(float(plan.speeds[k - 1]), flown.numbers(k)) for k in range(1, len(flown.visits))]
    fastest = max(fast, default=(0.0, ()))
    if fastest[0] > most + SPEED_ROUNDING:
        whose = "the vehicle" if vehicle.max_speed <= autopilot.max_speed else autopilot.title
        speed, items = fastest
        yield MissionFinding(Subject.LIMITS, FindingKind.SPEED, items, name=whose, found=speed, limit=most)
    defaults = DEFAULTS[autopilot.name]
    if len(orders) > defaults.most_items:
        yield MissionFinding(Subject.LIMITS, FindingKind.COUNT, found=len(orders), limit=defaults.most_items)
    lengths = [math.dist(a, b) for a, b in pairwise(plan.waypoints)]
    longest = max(range(len(lengths)), key=lengths.__getitem__, default=0)
    if lengths and lengths[longest] > defaults.longest_leg:
        items, limit = flown.numbers(longest + 1), defaults.longest_leg
        yield MissionFinding(Subject.LIMITS, FindingKind.LENGTH, items, found=lengths[longest], limit=limit)
    if vehicle.usable_energy is not None:
        flight = plan.predicted()
        taken = energy_bounds(scenario, plan.route.uav, flight, flight.start, flight.end)[1][-1]
        taken += slow_touch_down(scenario, plan)
        if taken > vehicle.usable_energy:
            kind, limit = FindingKind.BATTERY, vehicle.usable_energy
            yield MissionFinding(Subject.LIMITS, kind, found=float(taken), limit=limit)


def _of_way_home(flown: FlownMission, scenario: Scenario, back: WayHome | None) -> Iterator[MissionFinding]:
    """Yield from when to when no return is proven."""
    if back is None:
        yield MissionFinding(Subject.WAY_HOME, FindingKind.RETURN)
        return
    arrivals = flown.plan.arrivals
    ends = flown.end == "rtl" and not back.ends_safely
    for gap in back.gaps:
        first, last = (int(np.searchsorted(arrivals, at)) for at in (gap.begin, gap.end))
        legs = range(first, min(last, len(flown.visits) - 1) + 1)
        items = tuple(dict.fromkeys(number for k in legs for number in flown.numbers(k)))
        subject = Subject.END if ends and gap is back.gaps[-1] else Subject.WAY_HOME
        at, times = _globe(scenario, gap.place), (gap.begin, gap.end)
        yield MissionFinding(subject, FindingKind(gap.why), items, at, times=times)


def _of_way_back(flown: FlownMission, scenario: Scenario) -> Iterator[MissionFinding]:
    """Yield what is wrong with the way back along a mission."""
    why = why_not_back(flown)
    if why is not None:
        yield MissionFinding(Subject.WAY_HOME, FindingKind.NO_WAY_BACK, name=why)
        return
    yield from (replace(one, subject=Subject.WAY_HOME) for one in _of_parts(*flown_back(flown, scenario)))


def _heights(flown: FlownMission, scenario: Scenario) -> tuple[Height, Height]:
    """Return the least and the greatest height above ground after the take-off."""
    terrain, points = scenario.terrain, flown.plan.waypoints
    assert terrain is not None
    above = points[:, 2] - terrain.height(points[:, :2])
    low = [(float(height), k) for k, height in enumerate(above)]
    high = list(low)
    straight = np.array([k for k in range(1, len(points)) if not flown.visits[k].follows], dtype=np.intp)
    upside = derived(terrain, heights=-terrain.heights, lowest=None)
    ends = np.stack([points[straight - 1], points[straight]], axis=1)
    for found, ground, sign in ((high, terrain, 1.0), (low, upside, -1.0)):
        heights = sign * greatest_on_legs(ends * [1.0, 1.0, sign], ground, -np.inf)
        found += [(float(height), int(k)) for height, k in zip(heights, straight, strict=True)]
    (least, at), (most, over) = min(low), max(high)
    return Height(least, flown.numbers(at)), Height(most, flown.numbers(over))


def _photos(flown: FlownMission) -> int | None:
    """Return how many photos a mission takes: by the distance since each trigger was told, and one by one."""
    spacing, along, count, found = 0.0, 0.0, 0, False
    number = {id(visit.order): k for k, visit in enumerate(flown.visits)}
    points = flown.plan.waypoints
    for order in flown.waypoints.orders:
        k = number.get(id(order))
        if k is not None and k > 0 and spacing > 0:
            along += math.dist(points[k - 1][:2], points[k][:2])
        if order.spacing is not None:
            if spacing > 0 and along > 0:  # where the count begins anew, the photo that is due is its first one
                count += round(along / spacing) if order.spacing > 0 else math.floor(along / spacing + SAME_PLACE) + 1
            spacing, along, found = order.spacing, 0.0, True
        elif order.kind is OrderKind.CAMERA and (order.times > 0 or order.name in ONE_PHOTO):
            count, found = count + max(order.times, 1), True
    count += math.floor(along / spacing + SAME_PLACE) + 1 if spacing > 0 and along > 0 else 0
    return count if found else None
