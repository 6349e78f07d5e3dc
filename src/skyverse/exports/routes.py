"""The waypoints of all UAVs of a mission, proven as an autopilot flies them, one by one and against each other."""

from functools import partial
from typing import get_args

import numpy as np

from skyverse.errors import InputError, require_kind
from skyverse.exports.autopilot_leg_clearance import LegChecker
from skyverse.exports.autopilots import AUTOPILOTS, AutopilotName, rates_of
from skyverse.exports.flight_plan import flight_plans
from skyverse.exports.global_positions import AltitudeReference, require_reference, with_origin
from skyverse.exports.landing import stand
from skyverse.exports.leg_certificate import LegCertificate, require_homes
from skyverse.exports.requirements import (
    require_no_movers,
    require_plausible_homes,
    require_radius_and_takeoff,
    with_zones_always_active,
)
from skyverse.exports.route import Route, Takeoff, route
from skyverse.exports.separation import fleet_apart
from skyverse.exports.speed_limits import with_limited_speeds, with_waypoints_at_zones
from skyverse.model.frame import Origin
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Certificate
from skyverse.problem import Airspace
from skyverse.space.tube import NO_ERROR

MAX_CERTIFICATES = 8
"""Attempts to have routes proven; each but the first follows a search for those that were refused."""


def routes(
    mission: Mission,
    *,
    altitude: AltitudeReference = "amsl",
    origin: Origin | None = None,
    radius: float = 2.0,
    takeoff: float = 3.0,
    stops: bool = False,
    autopilot: AutopilotName = "px4",
) -> list[Route]:
    """Return the waypoints of every UAV that flies, proven as an autopilot flies them; see `export`.

    Parameters
    ----------
    mission, altitude, origin, radius, takeoff
        As for `export`.
    stops
        Whether the UAV stops at every waypoint, and so cuts no corner.
    autopilot
        What flies them, ``"px4"``, ``"ardupilot"`` or ``"dji"``: PX4 turns to the first leg before its take-off ends.

    Raises
    ------
    InputError
        As for `export`.
    """
    require_kind(mission, Mission, "mission")
    require_no_movers(mission.scenario, "waypoints")
    mission = with_zones_always_active(mission, "waypoints")
    scenario = with_origin(mission, origin, "waypoints")
    require_reference(scenario, altitude, get_args(AltitudeReference), "waypoints")
    if altitude == "home":
        flown = [k for k, trajectory in enumerate(mission.trajectories) if trajectory is not None]
        require_homes(scenario, [k for k in flown if scenario.uavs[k].fixed_wing is None])
    require_radius_and_takeoff(radius, takeoff)
    require_plausible_homes(scenario)
    certificates = leg_certificates(mission, scenario, altitude)
    flying: AutopilotName = "ardupilot" if altitude == "agl" else autopilot  # PX4 takes no altitudes above ground
    search = [
        partial(
            _route_with_zones,
            certificates[k],
            k,
            trajectory,
            radius=radius,
            takeoff=_takeoff(scenario, k, takeoff, flying),
            stops=stops,
        )
        for k, trajectory in enumerate(mission.trajectories)
        if trajectory is not None
    ]
    if not search:
        raise InputError("expected a mission with a trajectory to export, found none")
    found = [search_one() for search_one in search]
    for _ in range(MAX_CERTIFICATES):
        refused = _refused(certificates, found)
        if not refused:
            return found
        found = [search[k]() if k in refused else one for k, one in enumerate(found)]
    names = ", ".join(scenario.uavs[found[k].uav].name for k in sorted(refused))
    raise InputError(f"{names}: straight legs between waypoints could not be proven; fly them as trajectories")


def _route_with_zones(
    certificate: LegCertificate, uav: int, trajectory: Trajectory, *, radius: float, takeoff: Takeoff, stops: bool
) -> Route:
    """Return a UAV's waypoints with those at zones, except where legs follow the ground; see `route`."""
    found = route(certificate, uav, trajectory, radius=radius, takeoff=takeoff, stops=stops)
    scenario = certificate.legs.scenario
    if certificate.legs.reference == "agl":
        return found
    rates = rates_of(scenario.uavs[uav], AUTOPILOTS[takeoff.autopilot])
    return with_waypoints_at_zones(scenario, found, trajectory, rates)


def leg_certificates(mission: Mission, scenario: Scenario, altitude: AltitudeReference) -> list[LegCertificate]:
    """Return what proves the legs of each UAV; UAVs that do not stray from their routes share one certificate."""
    airspace: Airspace | None = None
    exact = LegCertificate(LegChecker(scenario, altitude))
    found = []
    for uav, vehicle in enumerate(scenario.uavs):
        error, target = vehicle.tracking_error, mission.assignment[uav]
        if error == NO_ERROR:
            found.append(exact)
            continue
        airspace = airspace or Airspace(scenario)
        places = [vehicle.start] + ([] if target is None else [scenario.targets[target].position])
        bases = [np.array(place) for place in places if vehicle.fixed_wing is None]
        tops = [airspace.of(uav).lifted(uav, tuple(base)) for base in bases]
        lifts = tuple((base, top) for base, top in zip(bases, tops, strict=True) if top[2] > base[2])
        checker = LegChecker(scenario, altitude, error, lifts, exact.legs.worlds)
        found.append(LegCertificate(checker, exact.worlds))
    return found


def _refused(certificates: list[LegCertificate], found: list[Route]) -> set[int]:
    """Return which of some routes are not proven."""
    refused = set()
    for certificate in {id(one): one for one in certificates}.values():
        own = [k for k, one in enumerate(found) if certificates[one.uav] is certificate]
        refused |= {own[k] for k in certificate.refused([found[k].polyline for k in own])}
    return refused


def _takeoff(scenario: Scenario, uav: int, height: float, autopilot: AutopilotName) -> Takeoff:
    """Return a UAV's take-off to a height above its home, metres; an aeroplane is in flight at its start."""
    vehicle = scenario.uavs[uav]
    if vehicle.fixed_wing is not None:
        return Takeoff(autopilot, 0.0, 0.0)
    risen = vehicle.start[2] - float(stand(scenario, uav)[2])
    return Takeoff(autopilot, max(height - risen, 0.0), risen)


def routes_apart(mission: Mission, flown: list[Route], *, autopilot: AutopilotName = "px4") -> Certificate:
    """Return a certificate on whether UAVs keep their separation as their autopilots fly the waypoints.

    Parameters
    ----------
    mission
        The mission.
    flown
        The routes of the mission, from `routes`.
    autopilot
        What flies them: ``"px4"``, ``"ardupilot"`` or ``"dji"``.

    Returns
    -------
    Certificate
        Proven if all pairs of UAVs are apart in space or by timing, at climbs and descents of 1 to 5 m/s, at speeds
        up to 10 % off, and if they rise at once or up to 1 s later than planned; undecided if some are apart only on
        schedule; refuted if some come too close even then. Its sentence says it pair by pair.
    """
    scenario = mission.scenario
    homes = [stand(scenario, one.uav) for one in flown]
    plans = flight_plans(scenario, flown, AUTOPILOTS[autopilot], homes)
    return fleet_apart(scenario, [with_limited_speeds(scenario, plan) for plan in plans]).certificate(scenario)
