"""Missions that people have, judged as their autopilots fly them: each leg, corner, climb, landing, return and limit.

What the planners' space finds clear is proven by the referee; what it finds wrong is told with the numbers of the
orders, the place, what is met, how deep, and the altitude that would clear it.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.landing import Descents, why_not_level
from skyverse.exports.leg_geometry import greatest_on_legs
from skyverse.exports.leg_space import Segments
from skyverse.exports.separation import Apart, FleetApart, fleet_apart
from skyverse.exports.way_home import WAYS, WayHome, ways_home
from skyverse.model.geodesy import to_wgs84
from skyverse.model.mission import FlightSummary
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import told_clock
from skyverse.numerics.tolerances import SAME_PLACE
from skyverse.referee.clearance import judge_segments
from skyverse.referee.judgement import CEILING_NUMBER, GROUND_NUMBER
from skyverse.summary import flight_summary
from skyverse.waypoints.flown import FlownMission
from skyverse.waypoints.mission_judge import LIFT_STEP, MissionJudge, Part

OFF_HOME = 10.0
"""Metres by which the altitude of home in a file may be off the ground there; relative heights are off as much."""
SPEED_ROUNDING = 0.05
"""m/s to which files round speeds."""
LEG_LIMITS = {"px4": 900.0, "ardupilot": math.inf, "dji": 2000.0}
"""Metres between two waypoints that the autopilot takes: MIS_DIST_WPS of PX4 until 1.15; DJI's SDK."""
ITEM_LIMITS = {"px4": 2000, "ardupilot": 724, "dji": 65_535}
"""Items that usual boards take."""


class Subject(Enum):
    """What a finding is about: the rows of the table."""

    LEGS = "legs"
    CORNERS = "corners"
    TAKEOFF = "take-off"
    END = "end"
    WAY_HOME = "way home"
    HOME = "home"
    LIMITS = "limits"
    APART = "separation"


@dataclass(frozen=True)
class MissionFinding:
    """One thing that is wrong with a mission.

    Attributes
    ----------
    subject
        What it is about.
    items
        The numbers of the orders concerned, as ground stations show them.
    said
        What is wrong, in words that stand alone.
    place
        Latitude, longitude and metres above mean sea level, where it has a place.
    what
        What is met: ``"ground"``, ``"ceiling"``, ``"bounds"``, or the kind and name of an obstacle.
    deep
        Metres by which it is too near.
    clear_at
        Metres above mean sea level at which the vehicle would be clear there; ``None`` where no height clears it.
    wrong
        Whether it refutes the mission; otherwise it is something to heed.
    part
        Which leg or corner of the flight it is, as `FlownMission.visits` count them.
    """

    subject: Subject
    items: tuple[int, ...]
    said: str
    place: tuple[float, float, float] | None = None
    what: str = ""
    deep: float | None = None
    clear_at: float | None = None
    wrong: bool = True
    part: int | None = None


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
    lowest, highest
        The least and the greatest height above ground after the take-off, if the ground is known.
    back
        Its way home; ``None`` for an aeroplane.
    summary
        Length, time and energy of the flight.
    photos
        How many photos its triggers by distance take; ``None`` if it has none.
    """

    flown: FlownMission
    scenario: Scenario
    findings: tuple[MissionFinding, ...]
    lowest: Height | None
    highest: Height | None
    back: WayHome | None
    summary: FlightSummary
    photos: int | None

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
    plan = _with_end(flown, scenario)
    unlimited = derived(scenario, max_height=None)  # a return is an emergency, and as high as it must be
    (back,) = ways_home(unlimited, [plan], flown.return_altitude)
    found += _of_way_home(flown, scenario, back)
    low, high = _heights(flown, scenario) if scenario.terrain is not None else (None, None)
    return CheckedMission(
        replace(flown, plan=plan),
        scenario,
        tuple(sorted(found, key=lambda one: (not one.wrong, list(Subject).index(one.subject)))),
        low,
        high,
        back,
        flight_summary(scenario.uavs[uav], plan.waypoints, plan.predicted()),
        _photos(flown),
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
            name = scenario.uavs[other].name
            items: tuple[int, ...] = ()
            place = None
            if met is not None and met.time is not None and met.position is not None:
                leg = int(np.searchsorted(flown.plan.arrivals, met.time))
                items, place = flown.numbers(min(leg, len(flown.visits) - 1)), _globe(scenario, np.array(met.position))
            said = f"comes too close to {name}" + (
                "" if met is None or met.time is None else f" at {told_clock(met.time)} min"
            )
            finding = MissionFinding(Subject.APART, items, f"{said}, if both start together", place, name)
            found[one] = replace(found[one], findings=(*found[one].findings, finding))
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
    said = (
        f"home is at {home[2]:.1f} m above the sea by the file, and the ground there at {ground:.1f} m by the terrain"
    )
    yield MissionFinding(
        Subject.HOME, (0,), f"{said}: it was planned over another ground", (*home[:2], ground), "ground"
    )


def _of_orders(flown: FlownMission) -> Iterator[MissionFinding]:
    """Yield what is not known of orders, or not flown by this autopilot."""
    autopilot = flown.plan.autopilot
    orders = flown.waypoints.orders
    curved = tuple(order.number for order in orders if order.curved)
    if curved:
        said = "the curves that these orders ask for are not published, so nothing is proven of them: fly straight legs"
        yield MissionFinding(Subject.LEGS, curved, said)
    if not flown.plan.corners_proven:
        said = f"{autopilot.title} turns an aeroplane at a distance of its own: legs are proven, and corners are not"
        yield MissionFinding(Subject.CORNERS, (), said, wrong=False)
    if flown.waypoints.aeroplane and math.isfinite(flown.plan.rates.climb):
        said = "the file is for an aeroplane, and is judged as flown by a vehicle that can stop"
        yield MissionFinding(Subject.LIMITS, (), said, wrong=False)
    if autopilot.name == "px4":
        follow = tuple(dict.fromkeys(visit.order.number for visit in flown.visits if visit.follows))
        circles = tuple(order.number for order in orders if order.turns)
        for items, what in ((follow, "heights above ground"), (circles, "circles of multirotors")):
            if items:
                yield MissionFinding(
                    Subject.LIMITS, items, f"PX4 takes no {what} in missions, and refuses these orders"
                )


def _of_parts(judge: MissionJudge, flown: FlownMission) -> list[MissionFinding]:
    """Return what is wrong with legs and corners; of a corner only what is not wrong with a leg at it, too."""
    parts = judge.refuted(flown)
    legs: dict[tuple[tuple[int, ...], str], MissionFinding] = {}
    for part in parts:
        if not part.radius:
            one = _of_part(judge, flown, part)
            kept = legs.setdefault((one.items, one.what), one)
            if (one.deep or 0.0) > (kept.deep or 0.0):  # of the parts of a leg the worst
                legs[one.items, one.what] = one
    found = list(legs.values())
    for part in parts:
        if part.radius:
            one = _of_part(judge, flown, part)
            at = (flown.numbers(part.k), one.what), (flown.numbers(part.k + 1), one.what)
            beside = [legs[leg].deep or 0.0 for leg in at if leg in legs]
            if not beside or (one.deep or 0.0) > max(beside) + LIFT_STEP:
                found.append(one)
    return found


def _of_part(judge: MissionJudge, flown: FlownMission, part: Part) -> MissionFinding:
    """Return what is wrong with a leg or corner."""
    scenario, fault = judge.scenario, part.checked.fault
    subject = Subject.CORNERS if part.radius else Subject.TAKEOFF if part.k == 0 else Subject.LEGS
    items = (flown.visits[part.k].order.number,) if part.radius else flown.numbers(part.k)
    lift = judge.clear_lift(part)
    place, what, deep, said = part.points[-1 if not part.radius else 2], "", None, "could not be decided"
    if isinstance(fault, Segments):
        world = part.checker.space.referee(fault)
        met = judge_segments(world, fault.starts, fault.ends).incursion
        if met is not None:
            place, deep = met.position, met.depth
            what, said = _met(scenario, met.obstacle, met.gap, met.required)
    elif fault is not None:
        said = fault.rpartition(", at (")[0]
        what = "bounds" if "bounds" in said else "ceiling" if "ceiling" in said else "ground"
        terrain, ends = scenario.terrain, part.points[-2:]
        if terrain is not None and what in ("ground", "bounds"):
            under = terrain.height(ends[:, :2]) - ends[:, 2]
            lowest = int(np.argmax(under))
            if what == "ground" or under[lowest] > 0:  # what is below the bounds is below ground
                place, needed = ends[lowest], scenario.ground_clearance + judge.error.vertical
                what, deep = "ground", float(under[lowest]) + needed
                said = _met(scenario, GROUND_NUMBER, -float(under[lowest]), needed)[1] if under[lowest] > 0 else said
    at = _globe(scenario, place)
    if what == "ground" and deep is not None:  # whatever else is above it
        lift = deep
    clear = None if lift is None or what in ("ceiling", "bounds") else at[2] + lift
    return MissionFinding(subject, items, said, at, what, deep, clear, part=part.k)


def _met(scenario: Scenario, obstacle: int, gap: float, required: float) -> tuple[str, str]:
    """Return what is met, and in words how."""
    if obstacle == GROUND_NUMBER:
        height = f"{gap:.3g} m above" if gap >= 0 else f"{-gap:.3g} m below"
        return "ground", f"may be {height} ground, where {required:.3g} m above it are required"
    if obstacle == CEILING_NUMBER:
        return "ceiling", f"may be {-gap:.3g} m above the ceiling of {scenario.max_height:.4g} m above ground"
    shape = scenario.obstacles[obstacle]
    what = " ".join(word for word in (shape.kind or "obstacle", shape.name) if word)
    if shape.kind == "fence":
        return what, "may cross the fence" if gap < 0 else f"may come within {gap:.3g} m of the fence"
    near = f"may be {-gap:.3g} m inside" if gap < 0 else f"may come within {gap:.3g} m of"
    return what, f"{near} {what}, of which {required:.3g} m must be kept"


def _of_landing(flown: FlownMission, scenario: Scenario) -> Iterator[MissionFinding]:
    """Yield why the vehicle cannot land where its orders say."""
    plan = flown.plan
    if flown.end != "land":
        return
    uav, top, place = plan.route.uav, plan.waypoints[-1], plan.ending[-1]
    above = replace_height(top, max(float(top[2]), float(place[2])))
    why = why_not_level(scenario, uav, place) or Descents(scenario).why_not_clear(uav, above, place)
    if why is not None:
        items = (flown.visits[-1].order.number,)
        yield MissionFinding(Subject.END, items, f"it cannot land there, as {why}", _globe(scenario, place), "ground")


def replace_height(place: Floats, z: float) -> Floats:
    """Return a place, (3,) metres, at another height."""
    return np.array([place[0], place[1], z])


def _of_limits(flown: FlownMission, scenario: Scenario) -> Iterator[MissionFinding]:
    """Yield which limits of the vehicle, of the autopilot and of its files a mission exceeds."""
    plan, vehicle = flown.plan, scenario.uavs[flown.plan.route.uav]
    autopilot, orders = plan.autopilot, flown.waypoints.orders
    most = min(vehicle.max_speed, autopilot.max_speed)
    fast = [(float(plan.speeds[k - 1]), flown.numbers(k)) for k in range(1, len(flown.visits))]
    fastest = max(fast, default=(0.0, ()))
    if fastest[0] > most + SPEED_ROUNDING:
        whose = "the vehicle" if vehicle.max_speed <= autopilot.max_speed else autopilot.title
        said = f"{fastest[0]:.3g} m/s is commanded, and {whose} flies {most:.3g} m/s at most"
        yield MissionFinding(Subject.LIMITS, fastest[1], said)
    if len(orders) > ITEM_LIMITS[autopilot.name]:
        said = f"{len(orders):,} items, and usual boards with {autopilot.title} take {ITEM_LIMITS[autopilot.name]:,}"
        yield MissionFinding(Subject.LIMITS, (), said, wrong=False)
    lengths = [math.dist(a, b) for a, b in pairwise(plan.waypoints)]
    longest = max(range(len(lengths)), key=lengths.__getitem__, default=0)
    if lengths and lengths[longest] > LEG_LIMITS[autopilot.name]:
        said = f"a leg of {lengths[longest]:,.0f} m, and {autopilot.title} may refuse more than"
        limit = f"{LEG_LIMITS[autopilot.name]:,.0f} m"
        yield MissionFinding(Subject.LIMITS, flown.numbers(longest + 1), f"{said} {limit}", wrong=False)


def _with_end(flown: FlownMission, scenario: Scenario) -> FlightPlan:
    """Return the flight with its end: a return leads up, over home and down."""
    plan = flown.plan
    if flown.end != "rtl":
        return plan
    level = max(float(plan.home[2]) + flown.return_altitude, float(plan.waypoints[-1][2]))
    return replace(
        plan,
        ending=np.stack([replace_height(plan.waypoints[-1], level), replace_height(plan.home, level), plan.home]),
    )


def _of_way_home(flown: FlownMission, scenario: Scenario, back: WayHome | None) -> Iterator[MissionFinding]:
    """Yield from when to when no return is proven."""
    if back is None:
        yield MissionFinding(Subject.WAY_HOME, (), "the return of an aeroplane is not judged", wrong=False)
        return
    arrivals = flown.plan.arrivals
    ends = flown.end == "rtl" and not back.ends_safely
    for gap in back.gaps:
        first, last = (int(np.searchsorted(arrivals, at)) for at in (gap.begin, gap.end))
        legs = range(first, min(last, len(flown.visits) - 1) + 1)
        items = tuple(dict.fromkeys(number for k in legs for number in flown.numbers(k)))
        when = f"from {told_clock(gap.begin)} to {told_clock(gap.end)} min of the flight"
        said = f"no return at {back.altitude:.4g} m above home is proven {when}: {gap.why}"
        subject = Subject.END if ends and gap is back.gaps[-1] else Subject.WAY_HOME
        yield MissionFinding(subject, items, said, _globe(scenario, gap.place), gap.why, wrong=gap.why != WAYS[-1])


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
    """Return how many photos the triggers by distance take along the flight."""
    spacing, count, found = 0.0, 0.0, False
    number = {id(visit.order): k for k, visit in enumerate(flown.visits)}
    points = flown.plan.waypoints
    for order in flown.waypoints.orders:
        k = number.get(id(order))
        if k is not None and k > 0 and spacing > 0:
            count += math.floor(math.dist(points[k - 1], points[k]) / spacing + SAME_PLACE) + 1
        if order.spacing is not None:
            spacing, found = order.spacing, True
    return int(count) if found else None
