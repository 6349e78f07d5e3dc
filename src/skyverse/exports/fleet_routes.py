"""The waypoints of all UAVs of a mission, proven as an autopilot flies them, one by one and against each other."""

from collections import defaultdict
from dataclasses import replace
from typing import get_args

import numpy as np

from skyverse.errors import InputError, require_choice, require_flag, require_kind
from skyverse.exports.autopilots import AUTOPILOTS, AutopilotName, rates_of
from skyverse.exports.flight_plan import flight_plans, in_turn
from skyverse.exports.flights import flights_of
from skyverse.exports.global_positions import AltitudeReference, require_reference, with_origin
from skyverse.exports.landing import stands
from skyverse.exports.leg_space import LegSpace
from skyverse.exports.legs import LegChecker, refused
from skyverse.exports.requirements import (
    ExportOptions,
    require_homes,
    require_no_movers,
    require_plausible_homes,
    with_zones_always_active,
)
from skyverse.exports.route import Route, Takeoff
from skyverse.exports.route_search import route
from skyverse.exports.separation import fleet_apart
from skyverse.exports.speed_limits import with_limited_speeds, with_waypoints_at_zones
from skyverse.model.frame import Origin
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.model.verdict import Certificate
from skyverse.problem import Airspace
from skyverse.space.tracking_error import NO_ERROR

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
    through: bool = True,
) -> list[Route]:
    """Return the waypoints of every flight, proven as an autopilot flies them; see `export`.

    A UAV has one flight, or one for each of its sorties, in their order.

    Parameters
    ----------
    mission, altitude, origin, radius, takeoff
        As for `export`.
    stops
        Whether the UAV stops at every waypoint, and so cuts no corner.
    autopilot
        What flies them, ``"px4"``, ``"ardupilot"`` or ``"dji"``: PX4 turns to the first leg before its take-off ends.
    through
        Whether it may fly through the ends and bends of strips along which photos are taken, or stops there.

    Raises
    ------
    InputError
        As for `export`.
    """
    require_kind(mission, Mission, "mission")
    ExportOptions(altitude=altitude, origin=origin, radius=radius, takeoff=takeoff, autopilot=autopilot)
    require_flag(stops, "stops")
    require_no_movers(mission.scenario, "waypoints")
    mission = with_zones_always_active(mission, "waypoints")
    scenario = with_origin(mission, origin, "waypoints")
    require_reference(scenario, altitude, get_args(AltitudeReference), "waypoints")
    if altitude == "home":
        uavs = enumerate(zip(mission.trajectories, scenario.uavs, strict=True))
        require_homes(scenario, [k for k, (flight, uav) in uavs if flight is not None and uav.fixed_wing is None])
    require_plausible_homes(scenario)
    checkers = leg_checkers(mission, scenario, altitude)
    flying: AutopilotName = "ardupilot" if altitude == "agl" else autopilot  # PX4 takes no altitudes above ground
    flights = list(flights_of(mission))
    if not flights:
        raise InputError("expected a mission with a trajectory to export, found none")
    rises = _takeoffs(scenario, [flight.uav for flight in flights], takeoff, flying)

    def search(k: int) -> Route:
        flight = flights[k]
        found = route(checkers[flight.uav], flight, radius=radius, takeoff=rises[k], stops=stops, through=through)
        if altitude == "agl":
            return found
        rates = rates_of(scenario.uavs[flight.uav], AUTOPILOTS[flying])
        return with_waypoints_at_zones(scenario, found, flight.trajectory, rates)

    found = [search(k) for k in range(len(flights))]
    own = [checkers[flight.uav] for flight in flights]
    for _ in range(MAX_CERTIFICATES):
        unproven = refused(own, [one.polyline for one in found])
        if not unproven:
            return found
        for k in unproven:
            found[k] = search(k)
    names = ", ".join(found[k].name(scenario) for k in sorted(unproven))
    raise InputError(f"{names}: straight legs between waypoints could not be proven; fly them as trajectories")


def leg_checkers(mission: Mission, scenario: Scenario, altitude: AltitudeReference) -> list[LegChecker]:
    """Return what checks the legs of each UAV; UAVs that do not stray from their routes share one."""
    airspace: Airspace | None = None
    visited: dict[int, list[int]] = defaultdict(list)
    for flight in flights_of(mission):
        visited[flight.uav] += [stay.target for stay in flight.stays]
    space = LegSpace(scenario, altitude)
    exact = LegChecker(space)
    found = []
    for uav, vehicle in enumerate(scenario.uavs):
        error, target = vehicle.tracking_error, mission.assignment[uav]
        if error == NO_ERROR:
            found.append(exact)
            continue
        airspace = airspace or Airspace(scenario)
        ends = (
            vehicle.start,
            *(scenario.targets[one].position for one in visited[uav]),
            scenario.end_place(uav, target),
        )
        places = dict.fromkeys(place for place in ends if place is not None)
        bases = [np.array(place) for place in places if vehicle.fixed_wing is None]
        tops = [airspace.of(uav).lifted(uav, tuple(base)) for base in bases]
        lifts = tuple((base, top) for base, top in zip(bases, tops, strict=True) if top[2] > base[2])
        found.append(LegChecker(space, error, lifts))
    return found


def _takeoffs(scenario: Scenario, uavs: list[int], height: float, autopilot: AutopilotName) -> list[Takeoff]:
    """Return the take-offs of UAVs to a height above their homes, metres; an aeroplane is in flight at its start."""
    made = []
    for uav, stand in zip(uavs, stands(scenario, uavs), strict=True):
        risen = scenario.uavs[uav].start[2] - float(stand[2])
        flies = scenario.uavs[uav].fixed_wing is not None
        made.append(Takeoff(autopilot, 0.0 if flies else max(height - risen, 0.0), 0.0 if flies else risen))
    return made


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
    require_kind(mission, Mission, "mission")
    require_choice(autopilot, AUTOPILOTS, "autopilot")
    scenario = mission.scenario
    homes = stands(scenario, [one.uav for one in flown])
    plans = [with_limited_speeds(scenario, one) for one in flight_plans(scenario, flown, AUTOPILOTS[autopilot], homes)]
    plans = [replace(one, ending=one.home[None]) if one.route.to_home else one for one in plans]
    return fleet_apart(scenario, in_turn(scenario, plans)).certificate(scenario)
