"""When a UAV may be where, if its autopilot climbs and flies faster or slower than the flight plan expects."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.autopilots import Rates, stop_acceptance
from skyverse.exports.flight_plan import SPEED_TOLERANCE, FlightPlan
from skyverse.model.scenario import Scenario
from skyverse.model.timed_path import TimedPath
from skyverse.numerics.tolerances import MIN_LEG_DURATION


class TimingTolerance(NamedTuple):
    """How far an autopilot may be off its flight plan.

    Attributes
    ----------
    slowest_climb, fastest_climb
        m/s: of take-offs, and up and down on legs.
    speed
        The share by which its speed may be off the commanded one.
    takeoff
        Seconds by which the UAV may rise later after the command to take off than planned; it may also rise at once.
    """

    slowest_climb: float = 1.0
    fastest_climb: float = 5.0
    speed: float = SPEED_TOLERANCE
    takeoff: float = 1.0

    def sentence(self) -> str:
        """Return in words what is allowed."""
        return (
            f"at {self.slowest_climb:g} to {self.fastest_climb:g} m/s up and down, {self.speed:.0%} off any speed and "
            f"take-offs up to {self.takeoff:g} s late"
        )


USUAL_TOLERANCE = TimingTolerance()
"""What an export allows for."""


def tolerance_for(plans: Sequence[FlightPlan]) -> TimingTolerance:
    """Return the usual tolerance, wider where a UAV climbs or descends slower or faster than that by its flight plan.

    The rates of flight plans may be off by the same share as speeds.
    """
    usual = USUAL_TOLERANCE
    rates = [rate for plan in plans for rate in plan.rates[:3] if np.isfinite(rate)]
    slowest = min([usual.slowest_climb, *((1 - usual.speed) * rate for rate in rates)])
    fastest = max([usual.fastest_climb, *((1 + usual.speed) * rate for rate in rates)])
    return usual._replace(slowest_climb=slowest, fastest_climb=fastest)


def timed_path(scenario: Scenario, plan: FlightPlan, tolerance: TimingTolerance) -> TimedPath:
    """Return the path of a flight plan with the earliest and the latest time at which the UAV may be where.

    At the earliest it takes off at once, cuts every corner and nowhere slows down; at the latest it rises late, flies
    to every waypoint and stops. From the end of a file that is not the last of its UAV it may leave at any later time.
    How far an aeroplane is off a corner is not known where its autopilot turns at a distance of its own.
    """
    route, waypoints, holds = plan.route, plan.waypoints, plan.route.waypoint_holds
    wing = scenario.uavs[route.uav].fixed_wing
    made = _Pieces()
    early, late = plan.delay, plan.delay + takeoff_lag(plan.rates, tolerance)
    made.add(plan.home, plan.home, 0.0, 0.0, 0.0, late)
    height = math.dist(waypoints[0], plan.home)
    swift, slow = height / tolerance.fastest_climb, height / tolerance.slowest_climb
    made.add(plan.home, waypoints[0], early, early + swift, late, late + slow)
    turned = min(plan.takeoff_cut, height)
    early, late = early + swift - turned / tolerance.fastest_climb, late + slow
    made.add(waypoints[0], waypoints[0], early, early + plan.hover, late, late + plan.hover)
    early, late = early + plan.hover, late + plan.hover
    for k, speed in enumerate(plan.speeds, 1):
        a, b = waypoints[k - 1], waypoints[k]
        reach = 0.0 if plan.full_stops[k] else route.radius if plan.corners_proven else np.inf
        swift, slow = leg_seconds(a, b, float(speed), plan.rates, tolerance)
        length = math.dist(b, a)
        least = swift * max(length - turned, 0.0) / length if length else 0.0
        braking = min(braking_seconds(a, b, float(speed), plan.rates, tolerance), slow)
        beside = float(route.deviations[k - 1])
        made.add(a, b, early, early + least, late + braking, late + slow, turned + beside, beside)
        soon = reach
        if holds[k] > 0 and plan.autopilot.name == "px4" and wing is None:
            soon = stop_acceptance(plan.autopilot, plan.rates, route.radius, float(speed))
        early += swift * max(length - turned - soon, 0.0) / length if length else 0.0
        late += slow
        if k in plan.breaks:
            late = np.inf
        if holds[k] > 0 or k in plan.breaks:
            made.add(b, b, early, early + float(holds[k]), late, late + float(holds[k]), reach)
            early, late = early + float(holds[k]), late + float(holds[k])
        turned = reach
    at, error = waypoints[-1], scenario.uavs[route.uav].tracking_error
    for left, to in zip(range(len(plan.ending))[::-1], plan.ending, strict=True):
        swift, slow = leg_seconds(at, to, plan.top_speed, plan.rates, tolerance)
        # it returns from wherever it is, and descends to a place that it knows
        off = math.hypot(error.horizontal, error.vertical) if left else 0.0
        made.add(at, to, early, early + swift, late, np.inf, off, off)
        at, early, late = to, early + swift, np.inf
    circle = circle_reach(scenario, route.uav)
    early -= circle / (plan.top_speed * (1 + tolerance.speed))  # it may leave its last leg for the circle that early
    made.add(at, at, early, early, np.inf, np.inf, circle, circle)
    return made.path()


def scheduled_path(scenario: Scenario, plan: FlightPlan) -> TimedPath:
    """Return the path of a flight plan that is flown exactly as predicted; its last piece is the stay at its end.

    Where the UAV gains or loses speed, it may be anywhere on that piece while it flies it.
    """
    flight = plan.predicted()
    knots, places = flight.knots, flight.at(flight.knots).position
    made = _Pieces()
    made.add(places[0], places[0], 0.0, 0.0, knots[0], knots[0])
    for k, terms in enumerate(flight.coefficients):
        begin, end, even = knots[k], knots[k + 1], not terms[2].any()
        made.add(places[k], places[k + 1], begin, end if even else begin, begin if even else end, end)
    circle = circle_reach(scenario, plan.route.uav)
    since = knots[-1] - circle / plan.top_speed
    made.add(places[-1], places[-1], since, since, np.inf, np.inf, circle, circle)
    return made.path()


def circle_reach(scenario: Scenario, uav: int) -> float:
    """Return how far from its last waypoint an aeroplane may be that circles there, metres; 0 for others, which stay.

    It may turn at that waypoint or around it, so that it is within twice its turn radius.
    """
    wing = scenario.uavs[uav].fixed_wing
    return 0.0 if wing is None else 2 * wing.turn_radius


def leg_seconds(a: Floats, b: Floats, speed: float, rates: Rates, tolerance: TimingTolerance) -> tuple[float, float]:
    """Return the least and the most seconds that a leg can take.

    Autopilots differ in whether the commanded speed is that over ground or that along the leg, so the least time counts
    the former and the most the latter, with a full stop at both ends. An aeroplane, whose rates are infinite, climbs as
    fast as it flies.
    """
    way = b - a
    level, up, length = float(np.hypot(*way[:2])), abs(float(way[2])), math.hypot(*way)
    swift, slow = level / (speed * (1 + tolerance.speed)), length / (speed * (1 - tolerance.speed))
    if np.isfinite(rates.climb):
        swift, slow = max(swift, up / tolerance.fastest_climb), max(slow, up / tolerance.slowest_climb)
    return max(swift, MIN_LEG_DURATION), slow + braking_seconds(a, b, speed, rates, tolerance)


def braking_seconds(a: Floats, b: Floats, speed: float, rates: Rates, tolerance: TimingTolerance) -> float:
    """Return the most seconds that a UAV loses on a leg from rest to rest, because it has to gain speed and to brake.

    At a higher speed it loses more, but less than it wins by that speed.
    """
    way = np.abs(b - a)
    level, up, length = float(np.hypot(*way[:2])), float(way[2]), math.hypot(*way)
    lost = _lost_seconds(speed * (1 + tolerance.speed), rates.acceleration, rates.jerk)
    if not up or not np.isfinite(rates.vertical_acceleration):
        return lost
    least = min(speed * (1 - tolerance.speed), tolerance.slowest_climb * length / up)
    upright = rates.vertical_acceleration * length / up
    along = min(rates.acceleration * length / level, upright) if level else upright
    return max(lost, _lost_seconds(least, along, rates.jerk))


def _lost_seconds(speed: float, acceleration: float, jerk: float) -> float:
    """Return the seconds lost by gaining a speed and losing it again, against flying at that speed all along."""
    if not np.isfinite(acceleration):
        return 0.0
    if speed * jerk < acceleration**2:
        return 2 * float(np.sqrt(speed / jerk))
    return speed / acceleration + acceleration / jerk


def takeoff_lag(rates: Rates, tolerance: TimingTolerance) -> float:
    """Return the most seconds that a take-off takes longer than its climb alone, at the slowest climb rate.

    An aeroplane, whose rates are infinite, is in flight when its mission begins.
    """
    if not np.isfinite(rates.climb):
        return 0.0
    return rates.startup + tolerance.takeoff + tolerance.slowest_climb / rates.takeoff_acceleration


class _Pieces:
    """The pieces of a timed path, one added after another."""

    def __init__(self) -> None:
        self.rows: list[tuple[Floats, Floats, tuple[float, ...]]] = []

    def add(self, a: Floats, b: Floats, *numbers: float) -> None:
        """Add a piece: the earliest times at both ends, the latest, and how far it may be off at the start and end."""
        self.rows.append((a, b, (*numbers, 0.0, 0.0)[:6]))

    def path(self) -> TimedPath:
        """Return what was added."""
        starts, ends, numbers = (np.array(column) for column in zip(*self.rows, strict=True))
        return TimedPath(starts, ends, numbers[:, :2], numbers[:, 2:4], numbers[:, 4:])
