"""The speed limits of zones, kept by the speeds that exported waypoints command.

A leg that may lead into a zone is commanded slowly. An autopilot changes to a new speed at the beginning of a leg, so a
leg before it is commanded no faster than the way that is left to the zone allows it to brake. Waypoints are added where
legs come near zones and leave them, so that no leg is slow for long.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.exports.autopilots import AutopilotRates
from skyverse.exports.flight_plan import MIN_SPEED, SPEED_TOLERANCE, FlightPlan
from skyverse.exports.route import Route
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.space.speed_zones import SpeedZone, make_speed_zones

BRAKING_SHARE = 0.5
"""The share of an autopilot's acceleration with which it is counted to brake for a zone, since its jerk is limited."""
BRAKING_STEPS = (1.0, 0.35, 0.1)
"""Where waypoints are added before a zone, as shares of the way to brake: at each, a lower speed is commanded."""
MIN_PART = 2.0
"""Metres from other waypoints at which none is added, as a multiple of the acceptance radius and at least 1 m."""
SAMPLES = 2000
"""Instants of a trajectory at which is looked when it passes a waypoint that is added."""


def zones_of(scenario: Scenario, uav: int) -> tuple[SpeedZone, ...]:
    """Return the zones with a speed limit that a UAV cannot ignore, with its tracking error."""
    vehicle = scenario.uavs[uav]
    zones = make_speed_zones(scenario, vehicle.tracking_error)
    return tuple(zone for zone in zones if zone.max_speed < vehicle.max_speed * (1 + SPEED_TOLERANCE))


def with_waypoints_at_zones(scenario: Scenario, route: Route, trajectory: Trajectory, rates: AutopilotRates) -> Route:
    """Return a route with waypoints where the UAV has to brake for a zone, and where it has left it."""
    zones = zones_of(scenario, route.uav)
    if not zones or scenario.uavs[route.uav].fixed_wing is not None:
        return route
    points, fast = route.waypoints, scenario.uavs[route.uav].max_speed
    near = MIN_PART * max(route.radius, 0.5)
    added = []
    for k, (a, b) in enumerate(pairwise(points)):
        length = math.dist(b, a)
        for zone in zones:
            inside = zone.stretch(a, b, _reach(route, k)) if length else None
            if inside is not None:
                excess = ((1 + SPEED_TOLERANCE) * fast) ** 2 - zone.max_speed**2
                before = inside[0] * length - route.radius
                braking = min(excess / (2 * _braking(rates, b - a)), before / 2)
                ends = [before - share * braking for share in BRAKING_STEPS] + [inside[1] * length + route.radius]
                added += [k + along / length for along in ends if near < along < length - near]
    kept: list[float] = []
    for place in sorted(added):
        leg = math.dist(points[int(place) + 1], points[int(place)])
        if not kept or int(kept[-1]) != int(place) or (place - kept[-1]) * leg > near:
            kept.append(place)
    return _with_waypoints(route, trajectory, kept) if kept else route


def _with_waypoints(route: Route, trajectory: Trajectory, places: Sequence[float]) -> Route:
    """Return a route with more waypoints, at which the UAV does not stop, at places k + u on the legs."""
    points, first = route.waypoints, int(bool(route.takeoff))
    legs = np.array(places).astype(np.int64)
    shares = (np.array(places) - legs)[:, None]
    more = (1.0 - shares) * points[legs] + shares * points[legs + 1]
    instants = np.linspace(trajectory.start, trajectory.end, SAMPLES)
    flown = trajectory.at(instants).position
    times = []
    for leg, place in zip(legs, more, strict=True):
        begin, end = route.waypoint_times[leg : leg + 2]
        stopped = float(route.holds[: leg + first + 1].sum())  # what the UAV waits until then comes on top
        during = (instants > begin - stopped) & (instants < end - stopped)
        nearest = instants[during][np.argmin(np.linalg.norm(flown[during] - place, axis=1))] if during.any() else begin
        times.append(float(np.clip(nearest + stopped, begin, end)))
    at = legs + first + 1
    return replace(
        route,
        points=np.insert(route.points, at, more, axis=0),
        times=np.insert(route.times, at, times),
        radii=np.insert(route.radii, at, route.radius),
        holds=np.insert(route.holds, at, 0.0),
        deviations=np.insert(route.deviations, legs, route.deviations[legs]),
        over_ground=np.insert(route.over_ground, legs, route.over_ground[legs]),
        targets=np.insert(route.targets, at, -1),
        runs=tuple(run.moved(at - first) for run in route.runs),
    )


def _reach(route: Route, leg: int) -> float:
    """Return how far a UAV may be from a leg, metres, its tracking error aside."""
    return route.radius + float(route.deviations[leg])


def with_limited_speeds(scenario: Scenario, plan: FlightPlan) -> FlightPlan:
    """Return a flight plan whose speeds keep the speed limits of zones, or raise `InputError` where none can."""
    route, name = plan.route, scenario.uavs[plan.route.uav].name
    zones = zones_of(scenario, route.uav)
    if not zones:
        return plan
    if scenario.uavs[route.uav].fixed_wing is not None:
        _require_slow_aeroplane(plan, zones, name)
        return plan
    points, stops = route.waypoints, plan.full_stops
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    speeds = plan.speeds.copy()
    for k, (a, b) in enumerate(pairwise(points)):
        for zone in zones:
            inside = zone.stretch(a, b, _reach(route, k)) if lengths[k] else None
            if inside is None:
                continue
            leads = f"{name}: leg {k + 1} leads through"
            speeds[k] = min(speeds[k], _commanded(plan, a, b, zone, zone.max_speed, leads))
            left = inside[0] * lengths[k] - route.radius  # from where the leg before may end
            square = zone.max_speed**2
            for j in range(k - 1, -1, -1):
                if stops[j + 1]:
                    break
                square += 2 * _braking(plan.rates, points[j + 2] - points[j + 1]) * max(left, 0.0)
                leads = f"{name}: leg {j + 1} leads to"
                limit = math.sqrt(square)
                speeds[j] = min(speeds[j], _commanded(plan, points[j], points[j + 1], zone, limit, leads))
                left = lengths[j] - 2 * route.radius  # a leg may end that early, and begin that far beside its waypoint
    rise = [(plan.home, points[0], "take-off")]
    for a, b, noun in rise + [(*ends, "end") for ends in pairwise([points[-1], *plan.ending])]:
        for zone in zones:
            if zone.crossed(a, b, route.radius):
                _require_commandable(plan, a, b, zone, zone.max_speed, f"{name}: its {noun} leads through")
    return replace(plan, speeds=np.floor(1000 * speeds) / 1000, top_speed=_return_speed(plan, zones))


def _require_slow_aeroplane(plan: FlightPlan, zones: Sequence[SpeedZone], name: str) -> None:
    """Raise `InputError` where an aeroplane flies faster through a zone than it may, since it keeps its airspeed."""
    for k, (a, b) in enumerate(pairwise(plan.waypoints)):
        for zone in zones:
            fast = _speed_over_ground(plan, a, b, zone.max_speed) < plan.speeds[k]
            if fast and zone.stretch(a, b, _reach(plan.route, k)) is not None:
                raise InputError(f"{name}: its waypoints lead into a zone whose speed limit an aeroplane cannot keep")


def _braking(rates: AutopilotRates, way: Floats) -> float:
    """Return with what acceleration, m/s^2, an autopilot is counted to brake for a zone on a leg."""
    length, up = math.hypot(*way), abs(float(way[2]))
    vertical = rates.vertical_acceleration * length / up if up else math.inf
    return BRAKING_SHARE * min(rates.acceleration, vertical)


def _commanded(plan: FlightPlan, a: Floats, b: Floats, zone: SpeedZone, limit: float, leads: str) -> float:
    """Return the speed, m/s, to command on a leg so that it is flown no faster than a limit, as a zone demands.

    The commanded speed may be that over ground, and the autopilot may exceed it by its tolerance. On a steep leg the
    rate of climb may keep the UAV slower. Raises `InputError` where no speed that may be commanded is slow enough.
    """
    _require_commandable(plan, a, b, zone, limit, leads)
    return _speed_over_ground(plan, a, b, limit)


def _require_commandable(plan: FlightPlan, a: Floats, b: Floats, zone: SpeedZone, limit: float, leads: str) -> None:
    """Raise `InputError` where no speed that may be commanded keeps a leg as slow as a zone demands."""
    if _speed_over_ground(plan, a, b, limit) >= MIN_SPEED:
        return
    if limit / (1 + SPEED_TOLERANCE) < MIN_SPEED and (a[:2] != b[:2]).any():
        why = f"no speed below {MIN_SPEED:g} m/s is commanded; raise the zone's max_speed"
    else:
        rate = _vertical_rate(plan, b - a)
        why = f"it climbs and descends at up to {rate:g} m/s; lower the UAV's max_climb and max_descent"
    raise InputError(
        f"{leads} a zone whose speed limit of {zone.max_speed:g} m/s it cannot keep "
        f"with {SPEED_TOLERANCE:.0%} in hand, since autopilots may be faster than told: {why}"
    )


def _speed_over_ground(plan: FlightPlan, a: Floats, b: Floats, limit: float) -> float:
    """Return the speed over ground at which a leg is flown no faster than a limit, m/s, by whatever tolerance."""
    way = b - a
    length, level, up = math.hypot(*way), float(np.hypot(way[0], way[1])), abs(float(way[2]))
    if not length or (up and (1 + SPEED_TOLERANCE) * _vertical_rate(plan, way) * length / up <= limit):
        return math.inf
    return limit * level / length / (1 + SPEED_TOLERANCE)


def _vertical_rate(plan: FlightPlan, way: Floats) -> float:
    """Return how fast an autopilot climbs on a leg that leads up, or descends on one that leads down, m/s."""
    return max(plan.rates.climb, plan.rates.takeoff) if way[2] > 0 else plan.rates.descent


def _return_speed(plan: FlightPlan, zones: Sequence[SpeedZone]) -> float:
    """Return how fast a UAV returns, m/s: by whatever way, no faster than the lowest speed limit of the zones."""
    return max(min([plan.top_speed, *(zone.max_speed / (1 + SPEED_TOLERANCE) for zone in zones)]), MIN_SPEED)


def may_return_too_fast(scenario: Scenario, plan: FlightPlan) -> bool:
    """Tell whether a UAV may exceed a zone's speed limit when it returns: DJI's aircraft, or where it climbs."""
    slowest = min((zone.max_speed for zone in zones_of(scenario, plan.route.uav)), default=math.inf)
    fastest = (1 + SPEED_TOLERANCE) * max(plan.rates.climb, plan.rates.descent, MIN_SPEED)
    return slowest < math.inf and (plan.autopilot.name == "dji" or fastest > slowest)
