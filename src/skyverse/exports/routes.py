"""The waypoints of all UAVs of a mission, proven as an autopilot flies them, one by one and against each other."""

import math
from dataclasses import replace
from typing import get_args

import numpy as np

from skyverse.errors import InputError
from skyverse.exports.autopilot_leg_clearance import require_home
from skyverse.exports.global_positions import AltitudeReference, home, require_reference, with_origin
from skyverse.exports.route import Route, route
from skyverse.model.mission import Mission
from skyverse.model.scenario import Origin, Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Certificate
from skyverse.referee import certify


def routes(
    mission: Mission,
    *,
    altitude: AltitudeReference = "amsl",
    origin: Origin | None = None,
    radius: float = 2.0,
    takeoff: float = 3.0,
    stops: bool = False,
) -> list[Route]:
    """Return the waypoints of every UAV that flies, proven as an autopilot flies them; see `export`.

    Parameters
    ----------
    mission, altitude, origin, radius, takeoff
        As for `export`.
    stops
        Whether the UAV stops at every waypoint, and so cuts no corner.

    Raises
    ------
    InputError
        As for `export`.
    """
    scenario = with_origin(mission, origin, "waypoints")
    require_reference(scenario, altitude, get_args(AltitudeReference), "waypoints")
    if altitude == "home":
        for k, trajectory in enumerate(mission.trajectories):
            if trajectory is not None and scenario.uavs[k].fixed_wing is None:
                require_home(scenario, k)
    for noun, value, least, most in (("radius", radius, 0.05, 1000.0), ("takeoff", takeoff, 0.0, math.inf)):
        if not (math.isfinite(value) and least <= value <= most):
            until = f"to {most:g}" if most < math.inf else "on"
            raise InputError(f"expected metres from {least:g} {until}, found {value!r}", field=noun)
    found = [
        route(scenario, k, trajectory, altitude, radius=radius, takeoff=_climb(scenario, k, takeoff), stops=stops)
        for k, trajectory in enumerate(mission.trajectories)
        if trajectory is not None
    ]
    if not found:
        raise InputError("expected a mission with a trajectory to export, found none")
    return found


def _climb(scenario: Scenario, uav: int, takeoff: float) -> float:
    """Return how many metres a UAV has to climb from its start; 0 for an aeroplane, which is in flight there."""
    vehicle = scenario.uavs[uav]
    return 0.0 if vehicle.fixed_wing else max(takeoff - (vehicle.start[2] - float(home(scenario, uav)[2])), 0.0)


def routes_apart(mission: Mission, flown: list[Route]) -> Certificate:
    """Return the referee's certificate on whether UAVs that fly straight between waypoints, on schedule, stay apart.

    Autopilots keep speeds rather than schedules; the proof holds only as far as they also keep the schedule.

    Parameters
    ----------
    mission
        The mission.
    flown
        The routes of the mission, from `routes`.
    """
    trajectories: list[Trajectory | None] = [None] * len(mission.scenario.uavs)
    for one in flown:
        stays = one.holds > 0
        times = np.sort(np.r_[one.times, (one.times + one.holds)[stays]])
        points = np.repeat(one.points, 1 + stays, axis=0)
        pace = np.diff(points, axis=0) / np.diff(times)[:, None]
        trajectories[one.uav] = Trajectory(times, np.stack([points[:-1], pace], axis=1))
    return certify(mission.scenario, replace(mission, trajectories=tuple(trajectories))).apart
