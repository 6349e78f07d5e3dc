"""Chooses the return altitude and rally points of a UAV, and has the referee certify its way home."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.errors import InputError, is_number
from skyverse.exports.autopilots import Autopilot
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.flown_legs import Parts
from skyverse.exports.return_choice import USUAL_ALTITUDE, ReturnChoice, lost_share, preference
from skyverse.exports.return_destinations import ACCEPTANCE, destination, rally_points
from skyverse.exports.return_lines import ReturnLines, ReturnSpace
from skyverse.exports.return_obstruction import Obstruction, obstruction
from skyverse.exports.way_home import Found, WayHome
from skyverse.model.scenario import Scenario
from skyverse.numerics.tolerances import LEG_ALLOWANCE

MIN_RETURN_ALTITUDE = 5.0
"""Metres above home: no lower return altitude is chosen where there is room for it."""
ABOVE_FLIGHT = 0.2
"""Metres above the whole flight, its error included, of an altitude that is tried: altitudes are rounded to 0.1 m."""
ALTITUDES = 12
"""How many return altitudes are tried, from the lowest to the upper bound."""
LOW_ALTITUDES = 4
"""How many lower ones are tried where none of those will do: a UAV that is higher returns without a climb."""
REFINEMENTS = 3
"""How often the step below the first good altitude is halved."""
JOINED_SPANS = 1.0
"""Seconds: two times without a way home that are less apart are told as one."""
HALVINGS = 40
"""How often a leg's time is halved to find when the flight is at a place of it."""
RETURN_ALTITUDES = {"px4": (2 * ACCEPTANCE["px4"].radius, math.inf), "ardupilot": (0.3, 3000.0), "dji": (2.0, 1500.0)}
"""Metres above home: the least and the greatest return altitude that an autopilot keeps to: PX4 1.14 climbs at least to
twice its acceptance radius; the others are what files can name, `RTL_ALT` and `globalRTHHeight`."""


@dataclass(frozen=True, eq=False)
class Return:
    """How one UAV comes home by itself.

    Attributes
    ----------
    plan
        Its flight.
    way
        What checks its way home: at which altitude, to which places.
    lost
        (n, 2) seconds into the mission between which there is no way home, if it keeps its schedule.
    obstructions
        What is in the way in each of these times.
    highest
        What is in the way at the highest altitude that was tried, in the last of these times; ``None`` where that is
        the altitude at which it returns.
    proven
        Whether the way home at all other instants is proven.
    lines
        The lines that prove it.
    level
        z at which it returns from its last waypoint to the nearest destination, metres.
    landings
        (k, 3) metres: where it may land then, the nearest first; several where they are about equally near.
    """

    plan: FlightPlan
    way: WayHome
    lost: Floats
    obstructions: tuple[Obstruction | None, ...]
    highest: Obstruction | None
    proven: bool
    lines: ReturnLines
    level: float
    landings: Floats

    @property
    def landing(self) -> Floats:
        """(3,) metres: where it lands if it returns from its last waypoint to the nearest destination."""
        return np.asarray(self.landings[0])

    @property
    def altitude(self) -> float:
        """The return altitude, metres above home."""
        return self.way.altitude

    @property
    def rally(self) -> Floats:
        """(k, 3) metres: where it may land as well, if that is nearer than home."""
        return self.way.places[1:]

    @property
    def rally_points(self) -> Floats:
        """(k, 3) metres: the same as files have them, for ArduPilot at the altitude at which it returns there."""
        return rally_points(self.way.scenario, self.plan, self.rally, self.altitude)

    @property
    def everywhere(self) -> bool:
        """Whether its way home is proven at every instant of the flight."""
        return self.proven and not len(self.lost)

    @property
    def nowhere(self) -> bool:
        """Whether there is no way home at any instant of the flight."""
        return len(self.lost) == 1 and bool(self.lost[0][0] <= 0 and self.lost[0][1] >= self.plan.arrivals[-1])

    @property
    def ends_safely(self) -> bool:
        """Whether its way home from the last waypoint is proven."""
        end = float(self.plan.arrivals[-1])
        return self.proven and (not len(self.lost) or bool(self.lost[-1][1] < end))

    @property
    def reasons(self) -> list[Obstruction]:
        """All that is known to be in the way."""
        return [one for one in (*self.obstructions, self.highest) if one is not None]


def plan_return(
    scenario: Scenario, space: ReturnSpace, plan: FlightPlan, altitude: float | None = None
) -> Return | None:
    """Return how a UAV comes home, or ``None`` for an aeroplane, whose circles are not judged.

    The return altitude is the one that is asked for, metres above home, or else the first by `preference` at which
    there is a way home at every instant; if there is none, that with the shortest part of the flight without one, or
    any altitude, also a lower one, with rally points where the autopilot takes them.
    """
    if scenario.uavs[plan.route.uav].fixed_wing is not None:
        return None
    start = plan.route.points[0]
    base = destination(scenario, space, plan, np.array([*start[:2], plan.home[2]]), float(start[2]))
    below = plan.ending[0] if len(plan.ending) == 1 else plan.waypoints[-1]
    end = destination(scenario, space, plan, below, float(plan.waypoints[-1][2]))
    altitudes = _altitudes(scenario, plan) if altitude is None else [altitude]
    way, found = _best_altitude([WayHome(scenario, space, plan, [base], end, one) for one in altitudes])
    if len(found.lost.leg):
        lower = []
        if altitude is None:
            least = RETURN_ALTITUDES[plan.autopilot.name][0]
            low = np.linspace(least, min(altitudes), LOW_ALTITUDES, endpoint=False)
            lower = (np.floor(10 * low) / 10).tolist()
        choice = ReturnChoice(scenario, space, plan, base, end)
        way, found = choice.best([*altitudes, *lower], (way, found))
    last = plan.waypoints[-1]
    away = np.linalg.norm((way.places - last)[:, :2], axis=1)
    order = np.argsort(away)
    landings = way.places[order[way.taken(away[None], np.zeros(1))[0][order]]]
    level = max(float(last[2]), float(way.levels[order[0]]))
    spans = _spans(found.lost, way)
    lost = np.array([(begin, end) for begin, end, _ in spans]).reshape(-1, 2)
    met = tuple(obstruction(space, way, found.lost.of(parts)) for _, _, parts in spans)
    top = max(altitudes)
    highest = None
    if spans and top > way.altitude:
        highest = obstruction(space, way.at(top), found.lost.of(spans[-1][2]))
    return Return(plan, way, lost, met, highest, True, found.lines, level, landings)


def require_return_altitude(autopilot: Autopilot, altitude: float) -> None:
    """Raise `InputError` for a return altitude, metres above home, that an autopilot does not keep to."""
    least, most = RETURN_ALTITUDES[autopilot.name]
    if not (is_number(altitude) and least <= altitude <= most):
        until = f"to {most:g}" if most < math.inf else "on"
        raise InputError(
            f"expected metres above home from {least:g} {until} for {autopilot.title}, found {altitude!r}",
            field="return_altitude",
        )


def certified(scenario: Scenario, space: ReturnSpace, returns: Sequence[Return]) -> list[Return]:
    """Return the ways home with what the referee proves of them: of all at once, or else of each."""

    def proven(some: Sequence[Return]) -> bool:
        return space.proven([(scenario.uavs[one.plan.route.uav].tracking_error, one.lines) for one in some])

    if proven(returns):
        return list(returns)
    return [replace(one, proven=proven([one])) for one in returns]


def _best_altitude(ways: Sequence[WayHome]) -> tuple[WayHome, Found]:
    """Return the first of some ways home with one at every instant, lowered by a share of the steps, or else the best.

    Altitudes from which the way home is blocked at some samples of the flight are not searched, but for the best of
    them where all are.
    """
    best: tuple[WayHome, Found] | None = None
    blocked = []
    for one in ways:
        blocked.append(one.blocked_weight())
        if blocked[-1]:
            continue
        found = one.search()
        if best is None or lost_share(one, found) < lost_share(*best):
            best = one, found
        if not len(found.lost.leg):
            break
    if best is None:
        chosen = ways[blocked.index(min(blocked))]
        return chosen, chosen.search()
    kind, top = preference(best[0].plan, best[0].altitude)[0], best[0].altitude
    beneath = [one.altitude for one in ways if one.altitude < top and preference(one.plan, one.altitude)[0] == kind]
    below = max(beneath, default=top) if kind < 2 else top
    for _ in range(REFINEMENTS):
        middle = best[0].at(round((below + best[0].altitude) / 2, 1))
        if len(best[1].lost.leg) or not below < middle.altitude < best[0].altitude:
            break
        lower = middle.search(to_the_end=False) if not middle.blocked() else None
        if lower is None or len(lower.lost.leg):
            below = middle.altitude
        else:
            best = middle, lower
    return best


def _altitudes(scenario: Scenario, plan: FlightPlan) -> list[float]:
    """Return the return altitudes to try, metres above home, by `preference`."""
    home, terrain = float(plan.home[2]), scenario.terrain
    room = scenario.uavs[plan.route.uav].tracking_error.vertical
    top = scenario.bounds.max[2] - room
    low = min(max(float(plan.waypoints[0][2]), home + MIN_RETURN_ALTITUDE), top)
    flown = float(plan.waypoints[:, 2].max())
    above = flown + scenario.uavs[plan.route.uav].tracking_error.vertical + max(plan.route.deviations, default=0.0)
    levels = [*np.linspace(low, top, ALTITUDES), home + USUAL_ALTITUDE, flown, above + ABOVE_FLIGHT]
    if terrain is not None and scenario.max_height is not None:
        grounds = terrain.lowest_ground.height(plan.waypoints[:, :2])
        most = float(grounds.min()) + scenario.max_height - room - LEG_ALLOWANCE
        levels += np.linspace(low, most, ALTITUDES).tolist()
    least, most = RETURN_ALTITUDES[plan.autopilot.name]
    altitudes = np.unique(np.floor(10 * (np.clip(levels, low, top) - home)) / 10)
    able = [float(value) for value in altitudes if least <= value <= most] or [least]
    return sorted(able, key=lambda altitude: preference(plan, altitude))


def _spans(lost: Parts, way: WayHome) -> list[tuple[float, float, NDArray[np.intp]]]:
    """Return the seconds between which parts of a flight are flown, those that touch as one, with the parts of each.

    A return during the take-off is one from its end: what is lost there is lost from the beginning.
    """
    times = np.column_stack([_seconds(way, lost.leg, share) for share in (lost.begin, lost.end)])
    times[(lost.leg == 0) & (lost.begin == 0), 0] = 0.0
    told: list[tuple[float, float, list[int]]] = []
    for part in np.lexsort((times[:, 1], times[:, 0])).tolist():
        begin, end = times[part].tolist()
        if told and begin <= told[-1][1] + JOINED_SPANS:
            told[-1] = told[-1][0], max(told[-1][1], end), [*told[-1][2], part]
        else:
            told.append((begin, end, [part]))
    return [(begin, end, np.array(parts)) for begin, end, parts in told]


def _seconds(way: WayHome, leg: NDArray[np.intp], share: Floats) -> Floats:
    """Return when a flight is at shares (n,) of legs, seconds: it runs up and brakes where it stops."""
    arrivals, flight, legs = way.plan.arrivals, way.plan.predicted(), way.legs
    end = np.append(arrivals, arrivals[-1])[leg + 1]
    early, late = arrivals[leg], end
    start = legs.starts[leg]
    along = legs.ends[leg] - start
    for _ in range(HALVINGS):
        middle = (early + late) / 2
        before = ((flight.at(middle).position - start) * along).sum(axis=1) < share * (along**2).sum(axis=1)
        early, late = np.where(before, middle, early), np.where(before, late, middle)
    return np.where(share < 1.0, late, end)
