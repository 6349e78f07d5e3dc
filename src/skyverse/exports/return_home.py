"""Chooses the return altitude and rally points of a UAV, and has the referee certify its way home."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.landing import ground_level, surface_below
from skyverse.exports.separation import kept_distance
from skyverse.exports.way_home import (
    CLEARANCE_SHARE,
    Destination,
    Parts,
    ReturnLines,
    WayHome,
    Worlds,
    flown_legs,
    grouped,
    joined,
    return_level,
    some_lines,
    with_ground_for_returns,
)
from skyverse.model.scenario import Scenario
from skyverse.model.timed_path import TimedPath
from skyverse.referee.clearance import judge_segments
from skyverse.referee.timed_paths import paths_apart
from skyverse.referee.world import referee_world

MIN_RETURN_ALTITUDE = 5.0
"""Metres above home: no lower return altitude is chosen where there is room for it."""
ALTITUDES = 12
"""How many return altitudes are tried, from the lowest to the upper bound."""
REFINEMENTS = 3
"""How often the step below the lowest good altitude is halved."""
MAX_RALLY_POINTS = 5
"""How many rally points are added at most: DJI takes none, and each is a place to keep clear of people."""
RALLY_PLACES = 5
"""How many places below the flight are tried for each rally point."""
JOINED_SPANS = 1.0
"""Seconds: two times without a way home that are less apart are told as one."""
TAKES_RALLY_POINTS = ("px4", "ardupilot")


@dataclass(frozen=True, eq=False)
class Return:
    """How one UAV comes home by itself.

    Attributes
    ----------
    plan
        Its flight.
    altitude
        The return altitude, metres above home.
    rally
        (k, 3) metres: where it may land as well, if that is nearer than home.
    lost
        (n, 2) seconds into the mission between which there is no way home, if it keeps its schedule.
    proven
        Whether the way home at all other instants is proven.
    lines
        The lines that prove it.
    level
        z at which it returns from its last waypoint, metres, and `landing`, (3,) metres, where it then lands.
    """

    plan: FlightPlan
    altitude: float
    rally: Floats
    lost: Floats
    proven: bool
    lines: ReturnLines
    level: float
    landing: Floats

    def sentence(self, scenario: Scenario, met: Sequence[str]) -> str:
        """Return what is proven; `met` are the names of UAVs whose paths it may cross on its way home."""
        name, kept = scenario.uavs[self.plan.route.uav].name, f"{CLEARANCE_SHARE * scenario.clearance:.4g} m"
        if scenario.terrain is not None and scenario.ground_clearance < scenario.clearance:
            kept += f", above ground by {CLEARANCE_SHARE * scenario.ground_clearance:.4g} m"
        if not self.proven:
            return f"{name}: whether it comes home by itself could not be proven."
        said = f"{name}: it returns at {self.altitude:.4g} m above home"
        if len(self.rally):
            said += f", to the nearest of home and {len(self.rally)} rally points"
        if len(self.lost):
            spans = ", ".join(f"from t = {begin:.4g} s to {end:.4g} s" for begin, end in self.lost[:5])
            more = f" and {len(self.lost) - 5} more times" if len(self.lost) > 5 else ""
            said += f", but NOT {spans}{more}: then there is no way home; otherwise"
        else:
            said += "; at every instant"
        said += f" the climb, the straight way home and the descent are clear by {kept}"
        if met:
            said += f"; it may cross the paths of {', '.join(met)}"
        elif len(scenario.uavs) > 1:
            said += "; it keeps its separation from the paths of all others"
        return f"{said}."


def plan_return(scenario: Scenario, worlds: Worlds, plan: FlightPlan) -> Return | None:
    """Return how a UAV comes home, or ``None`` for an aeroplane, whose circles are not judged.

    The lowest return altitude is taken at which there is a way home at every instant; if there is none, that with the
    shortest part of the flight without one, and rally points are added below the flight where the autopilot takes any.
    """
    if scenario.uavs[plan.route.uav].fixed_wing is not None:
        return None
    start = float(plan.waypoints[0][2])
    base = Destination(plan.home, start)
    altitude, lost, lines = _best_altitude(scenario, worlds, plan, base)
    chosen = [base]
    takes_more = plan.autopilot.name in TAKES_RALLY_POINTS
    while takes_more and len(lost.leg) and len(chosen) <= MAX_RALLY_POINTS:
        if not WayHome(scenario, worlds, plan, chosen, altitude).can_climb(lost):
            break
        tried = [
            (way := WayHome(scenario, worlds, plan, [*chosen, place], altitude), *way.search())
            for place in _rally_places(scenario, plan, lost)
        ]
        way, other, proof = min(tried, key=lambda found: _length(found[1], plan, scenario))
        if not _length(other, plan, scenario) < _length(lost, plan, scenario):
            break
        chosen, lost, lines = list(way.destinations), other, proof
    rally = np.array([one.place for one in chosen[1:]]).reshape(-1, 3)
    spans = _spans(lost, plan, scenario)
    last = plan.waypoints[-1]
    nearest = min(range(len(chosen)), key=lambda k: float(np.linalg.norm((chosen[k].place - last)[:2])))
    level = max(float(last[2]), return_level(plan.autopilot, plan.home, chosen[nearest], altitude))
    return Return(plan, altitude, rally, spans, True, lines, level, chosen[nearest].place)


def certified(scenario: Scenario, worlds: Worlds, returns: Sequence[Return]) -> list[Return]:
    """Return the ways home with what the referee proves of them: of all at once, or else of each."""
    if _proven(scenario, worlds, [one.lines for one in returns]):
        return list(returns)
    return [replace(one, proven=_proven(scenario, worlds, [one.lines])) for one in returns]


class _Searched(NamedTuple):
    """A return altitude, the parts of the flight without a way home at it, and the lines that prove the others."""

    altitude: float
    lost: Parts
    lines: ReturnLines


def _best_altitude(scenario: Scenario, worlds: Worlds, plan: FlightPlan, base: Destination) -> _Searched:
    """Return the lowest altitude with a way home at every instant, to a share of the steps, or else the best.

    Altitudes from which the way home is blocked at some samples of the flight are not searched, but for the best of
    them where all are.
    """

    def way(altitude: float) -> WayHome:
        return WayHome(scenario, worlds, plan, [base], altitude)

    def search(altitude: float) -> _Searched:
        return _Searched(altitude, *way(altitude).search())

    altitudes = _altitudes(scenario, plan)
    blocked = [way(altitude).blocked() for altitude in altitudes]
    if min(blocked):
        return search(altitudes[blocked.index(min(blocked))])
    best: _Searched | None = None
    for altitude in (one for one, count in zip(altitudes, blocked, strict=True) if not count):
        found = search(altitude)
        if best is None or _length(found.lost, plan, scenario) < _length(best.lost, plan, scenario):
            best = found
        if not len(found.lost.leg):
            break
    assert best is not None
    below = max([one for one in altitudes if one < best.altitude], default=best.altitude)
    for _ in range(REFINEMENTS):
        middle = round((below + best.altitude) / 2, 1)
        if len(best.lost.leg) or not below < middle < best.altitude:
            break
        lower = search(middle) if not way(middle).blocked() else None
        if lower is None or len(lower.lost.leg):
            below = middle
        else:
            best = lower
    return best


def crossed(scenario: Scenario, one: Return, other: FlightPlan, path: TimedPath) -> bool:
    """Tell whether it is not proven that a returning UAV keeps its separation from another one's whole path."""
    keep = kept_distance(scenario, one.plan.route.uav, other.route.uav)
    count = len(one.lines.growth)
    times, off = np.zeros((count, 2)), np.repeat(one.lines.growth[:, None], 2, axis=1)
    return not paths_apart(TimedPath(one.lines.starts, one.lines.ends, times, times, off), path, keep, timed=False)


def _altitudes(scenario: Scenario, plan: FlightPlan) -> list[float]:
    """Return the return altitudes to try, metres above home, the lowest first."""
    home, top = float(plan.home[2]), scenario.bounds.max[2]
    low = min(max(float(plan.waypoints[0][2]), home + MIN_RETURN_ALTITUDE), top)
    levels = np.unique(np.r_[np.linspace(low, top, ALTITUDES), np.clip(plan.waypoints[:, 2].max(), low, top)])
    return [float(value) for value in np.unique(np.floor(10 * (levels - home)) / 10) if value > 0] or [top - home]


def _rally_places(scenario: Scenario, plan: FlightPlan, lost: Parts) -> list[Destination]:
    """Return places to land at, spread over the parts of the flight without a way home, and below its end."""
    legs = flown_legs(plan, scenario)
    some = np.unique(np.linspace(0, len(lost.leg) - 1, RALLY_PLACES).round().astype(int))
    shares = (lost.begin[some] + lost.end[some]) / 2
    leg = lost.leg[some]
    above = [*(legs.starts[leg] + shares[:, None] * (legs.ends - legs.starts)[leg]), plan.waypoints[-1]]
    made = []
    for place in above:
        surface = surface_below(scenario, place, ground_level(scenario, plan.route.uav))
        until = min(surface + max(scenario.clearance, scenario.ground_clearance), float(place[2]))
        made.append(Destination(np.array([*place[:2], surface]), until))
    return made


def _length(parts: Parts, plan: FlightPlan, scenario: Scenario) -> float:
    """Return how many metres of the flight are in some parts of it."""
    return float(((parts.end - parts.begin) * flown_legs(plan, scenario).lengths[parts.leg]).sum())


def _spans(lost: Parts, plan: FlightPlan, scenario: Scenario) -> Floats:
    """Return the times between which parts of a flight are flown, (n, 2) seconds, those that touch as one."""
    arrivals = plan.arrivals
    last = float(arrivals[-1])
    begins, ends = np.r_[arrivals[:-1], last], np.r_[arrivals[1:], last]
    spans = np.stack([begins[lost.leg] + share * (ends - begins)[lost.leg] for share in (lost.begin, lost.end)], axis=1)
    told: list[list[float]] = []
    for begin, end in sorted(spans.tolist()):
        if told and begin <= told[-1][1] + JOINED_SPANS:
            told[-1][1] = max(told[-1][1], end)
        else:
            told.append([begin, end])
    return np.array(told).reshape(-1, 2)


def _proven(scenario: Scenario, worlds: Worlds, each: Sequence[ReturnLines]) -> bool:
    """Tell whether the referee proves that all lines keep the smaller clearance and their growth."""
    if not each:
        return True
    lines, scenario = joined(each), with_ground_for_returns(scenario)
    for some, margin, ground in grouped(lines, scenario, worlds.slope):
        terrain, most = scenario.terrain, scenario.max_height
        if terrain is not None:
            above = max(scenario.ground_clearance + margin, 0.0)
            terrain = terrain.model_copy(update={"clearance": above}) if ground else None
            most = most - margin if most is not None and ground else None
        clearance = max(scenario.clearance + margin, 0.0)
        grown = scenario.model_copy(update={"clearance": clearance, "terrain": terrain, "max_height": most})
        chosen = some_lines(lines, some)
        judged = judge_segments(referee_world(grown), chosen.starts, chosen.ends)
        if judged.incursion is not None or not judged.peaks.proven[0]:
            return False
    return True
