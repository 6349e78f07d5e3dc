"""Whether exported flights keep their separation, and how: in space, by timing with some tolerance, or on schedule."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import combinations
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.autopilots import AutopilotRates, stop_acceptance
from skyverse.exports.flight_plan import SPEED_TOLERANCE, FlightPlan
from skyverse.model.caution import Caution
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import TimedPath, Trajectory
from skyverse.model.verdict import Certificate, Verdict, Violation
from skyverse.numerics.tolerances import MIN_LEG_DURATION, SAME_PLACE
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.separation import judge_separation
from skyverse.referee.timed_paths import KeptDistance, paths_apart


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
    early = plan.begin + plan.delay
    late = early + takeoff_lag(plan.rates, tolerance)
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
        reach = 0.0 if plan.full_stops[k] else float(route.waypoint_radii[k]) if plan.corners_proven else np.inf
        swift, slow = leg_seconds(a, b, float(speed), plan.rates, tolerance)
        length = math.dist(b, a)
        least = swift * max(length - turned, 0.0) / length if length else 0.0
        braking = min(braking_seconds(a, b, float(speed), plan.rates, tolerance), slow)
        off = float(route.deviations[k - 1])
        made.add(a, b, early, early + least, late + braking, late + slow, turned + off, off)
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


def leg_seconds(
    a: Floats, b: Floats, speed: float, rates: AutopilotRates, tolerance: TimingTolerance
) -> tuple[float, float]:
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


def braking_seconds(a: Floats, b: Floats, speed: float, rates: AutopilotRates, tolerance: TimingTolerance) -> float:
    """Return the most seconds that a UAV loses on a leg from rest to rest, because it has to gain speed and to brake.

    At a higher speed it loses more, but less than it wins by that speed.
    """
    way = np.abs(b - a)
    level, up, length = float(np.hypot(*way[:2])), float(way[2]), math.hypot(*way)
    if length <= SAME_PLACE:
        return 0.0
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


def takeoff_lag(rates: AutopilotRates, tolerance: TimingTolerance) -> float:
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


MAX_NAMED = 6
"""Pairs of UAVs named in one sentence; of more it says only how many."""


class Apart(Enum):
    """How two UAVs keep their separation when their autopilots fly what was exported; the surest first."""

    SPACE = "apart in space, whatever the timing"
    TIMING = "apart by timing"
    SCHEDULE = "apart only on schedule"
    CLOSE = "too close"


@dataclass(frozen=True)
class FleetApart:
    """How each two UAVs of a fleet keep their separation.

    Attributes
    ----------
    pairs
        What is proven of each two UAVs, by their indices, the lower first.
    tolerance
        What `Apart.TIMING` allows for.
    violations
        Where UAVs are too close even on schedule.
    turns
        Whether the corners of an aeroplane are not proven.
    """

    pairs: dict[tuple[int, int], Apart]
    tolerance: TimingTolerance
    violations: tuple[Violation, ...]
    turns: bool = False

    def of(self, kind: Apart) -> list[tuple[int, int]]:
        """Return the pairs of which this, and nothing better, is proven."""
        return [pair for pair, found in self.pairs.items() if found is kind]

    def only(self, kind: Apart) -> bool:
        """Tell whether this is proven of every pair."""
        return all(found is kind for found in self.pairs.values())

    def certificate(self, scenario: Scenario) -> Certificate:
        """Return what is proven of the fleet as one certificate: proven only if no pair depends on the schedule."""
        said = " ".join(text for _, text in self.sentences(scenario)) or "There are no two UAVs."
        if self.of(Apart.CLOSE):
            if not self.violations:
                return Certificate(Verdict.REFUTED, said)
            worst = self.violations[0]
            return Certificate(Verdict.REFUTED, worst.message, worst.time, worst.position)
        return Certificate(Verdict.UNDECIDED if self.of(Apart.SCHEDULE) else Verdict.PROVEN, said)

    def sentences(self, scenario: Scenario) -> list[tuple[Apart, str]]:
        """Return what is proven, a sentence for each kind that there is."""
        at = self.tolerance.sentence()
        turns = f", and only if aeroplanes turn where expected, which is {Caution.NOT} proven" if self.turns else ""
        words = {
            Apart.SPACE: "keep their separation whatever the timing: their paths are apart in space",
            Apart.TIMING: f"keep their separation by timing, {at}, if they start at the same time",
            Apart.SCHEDULE: f"keep their separation only on schedule, {Caution.NOT} {at}{turns}",
            Apart.CLOSE: "come too close even on schedule, or where one circles or waits",
        }
        return [
            (kind, f"{named_pairs(scenario, self.of(kind))} {said}.") for kind, said in words.items() if self.of(kind)
        ]


def fleet_apart(scenario: Scenario, plans: Sequence[FlightPlan]) -> FleetApart:
    """Judge each two UAVs that fly exported plans.

    Separation is counted with the tracking errors of both UAVs. Of the pairs whose paths are not apart in space, the
    referee judges whether they are apart at all times that the tolerance allows, and at last on schedule. An
    aeroplane may then be anywhere on the circles that it may fly at its end.
    """
    tolerance = tolerance_for(plans)
    paths = [timed_path(scenario, plan, tolerance) for plan in plans]
    boxes = [path_box(path) for path in paths]
    pairs: dict[tuple[int, int], Apart] = {}
    for i, j in combinations(range(len(plans)), 2):
        pair = plans[i].route.uav, plans[j].route.uav
        if pair[0] == pair[1]:  # the sorties of one UAV
            continue
        keep, kind = kept_distance(scenario, *pair), Apart.SCHEDULE
        if beyond(boxes[i], boxes[j], keep) or paths_apart(paths[i], paths[j], keep, timed=False):
            kind = Apart.SPACE
        elif paths_apart(paths[i], paths[j], keep, timed=True):
            kind = Apart.TIMING
        pairs[pair] = max(pairs.get(pair, kind), kind, key=list(Apart).index)
    doubtful = [pair for pair, kind in pairs.items() if kind is Apart.SCHEDULE]
    violations = _on_schedule(scenario, plans, doubtful)
    waits = {plan.route.uav for plan in plans if plan.breaks}
    for pair in doubtful:
        close = any(set(pair) == set(violation.uavs) for violation in violations) or waits & set(pair)
        own, others = ([plan for plan in plans if plan.route.uav == uav] for uav in pair)
        if close or any(_circles_meet(scenario, one, other) for one in own for other in others):
            pairs[pair] = Apart.CLOSE
    return FleetApart(pairs, tolerance, violations, any(not plan.corners_proven for plan in plans))


def kept_distance(scenario: Scenario, first: int, second: int) -> KeptDistance:
    """Return what two UAVs must keep: of their separations the larger ones, and both tracking errors."""
    a, b = scenario.uavs[first], scenario.uavs[second]
    across, above = (max(pair) for pair in zip(a.ellipsoid, b.ellipsoid, strict=True))
    errors = a.tracking_error, b.tracking_error
    level, upright = sum(error.horizontal for error in errors), sum(error.vertical for error in errors)
    return KeptDistance(across, above, level, upright)


def _on_schedule(
    scenario: Scenario, plans: Sequence[FlightPlan], pairs: list[tuple[int, int]]
) -> tuple[Violation, ...]:
    """Return where UAVs of some pairs come too close if all fly exactly as predicted."""
    asked = {uav for pair in pairs for uav in pair}
    curves: list[PolynomialCurve | None] = [None] * len(scenario.uavs)
    uavs = list(scenario.uavs)
    for plan in plans:
        if plan.route.uav in asked:
            curves[plan.route.uav] = _after(curves[plan.route.uav], plan.predicted())
            start = tuple(float(value) for value in plan.home)
            uavs[plan.route.uav] = derived(uavs[plan.route.uav], start=start, home=None)
    standing = derived(scenario, uavs=tuple(uavs))
    unknown = {uav for uav, curve in enumerate(curves) if curve is None}
    found = judge_separation(standing, [None] * len(uavs), curves, unknown).violations
    return tuple(violation for violation in found if any(set(pair) == set(violation.uavs) for pair in pairs))


def _after(before: PolynomialCurve | None, flight: Trajectory) -> PolynomialCurve:
    """Return a flight after those of earlier sorties and a stand between them."""
    if before is None:
        return PolynomialCurve(flight.knots, flight.coefficients)
    stand = np.zeros((1, *flight.coefficients.shape[1:]))
    stand[0, 0] = flight.coefficients[0, 0]
    rows, count = (before.pieces, stand, flight.coefficients), int(flight.start > before.knots[-1])
    return PolynomialCurve(
        np.r_[before.knots, flight.knots[1 - count :]], np.concatenate([rows[0], rows[1][:count], rows[2]])
    )


def _circles_meet(scenario: Scenario, first: FlightPlan, second: FlightPlan) -> bool:
    """Tell whether two UAVs may come too close on schedule while one, an aeroplane, circles at its end."""
    keep = kept_distance(scenario, first.route.uav, second.route.uav)
    for plan, other in ((first, second), (second, first)):
        if not circle_reach(scenario, plan.route.uav):
            continue
        own = scheduled_path(scenario, plan)
        circle = TimedPath(own.starts[-1:], own.ends[-1:], own.earliest[-1:], own.latest[-1:], own.deviation[-1:])
        if not paths_apart(circle, scheduled_path(scenario, other), keep, timed=True):
            return True
    return False


def path_box(path: TimedPath) -> tuple[Floats, Floats]:
    """Return the least and the greatest corner, (3,) metres each, of the box around a path, deviations counted."""
    off = path.deviation.max(axis=1)[:, None]
    low, high = np.minimum(path.starts, path.ends) - off, np.maximum(path.starts, path.ends) + off
    return low.min(axis=0), high.max(axis=0)


def beyond(first: tuple[Floats, Floats], second: tuple[Floats, Floats], keep: KeptDistance) -> bool:
    """Tell whether boxes about two paths are farther apart than the separation."""
    level, upright = keep.across + keep.error_across, keep.above + keep.error_above
    gap = np.maximum(first[0] - second[1], second[0] - first[1])
    return bool((gap > [level, level, upright]).any())


def named_pairs(scenario: Scenario, pairs: list[tuple[int, int]]) -> str:
    """Return the names of pairs of UAVs, or only how many they are."""
    if len(pairs) > MAX_NAMED:
        return f"{len(pairs)} pairs of UAVs"
    names = [" and ".join(scenario.uavs[uav].name for uav in pair) for pair in pairs]
    return "; ".join(names)


def few(words: Sequence[str], most: int) -> str:
    """Return at most so many words, and how many more there are."""
    more = f" and {len(words) - most} more" if len(words) > most else ""
    return ", ".join(words[:most]) + more
