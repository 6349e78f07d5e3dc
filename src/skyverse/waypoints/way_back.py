"""The way back along a mission: what PX4 flies with ``RTL_TYPE`` 2 and Copter as SmartRTL, judged as legs and corners.

PX4 leads a vehicle along the line of its leg to the waypoint before, and so on to home; where the mission ends with a
landing it flies on to that. It stops nowhere, so that corners are cut also where the mission stops. Copter follows
where it has been, off that by its tracking error once more and by what SmartRTL leaves out.
"""

import math
from dataclasses import replace

import numpy as np

from skyverse.exports.autopilots import AutopilotName
from skyverse.exports.way_home_space import strayed
from skyverse.model.flight_settings import FlightSettings
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.waypoints import Order, OrderKind
from skyverse.waypoints.defaults import DEFAULTS
from skyverse.waypoints.flown import FlownMission, lifts_over
from skyverse.waypoints.mission_judge import MissionJudge

SMART_ACCURACY = 2.0
"""Metres that SmartRTL may be off where the vehicle has been: `SRTL_ACCURACY`, by which it leaves out places."""


def why_not_back(flown: FlownMission) -> str | None:
    """Return why an autopilot does not return along a mission, in words that follow "since", or ``None``."""
    name = flown.plan.autopilot.name
    if name == "dji":
        return "a DJI aircraft returns straight home only"
    if len(flown.lifts) > 1:
        return "it lands on the way"
    if name == "px4" and any(order.kind is OrderKind.JUMP for order in flown.waypoints.orders):
        return "PX4 passes over jumps on its way back"
    return None


def flown_back(flown: FlownMission, scenario: Scenario) -> tuple[MissionJudge, FlownMission]:
    """Return a mission with what the way back along it may be off its legs and corners, and what judges that.

    A return is an emergency, and as high as it must be.
    """
    route, uav = flown.plan.route, flown.plan.route.uav
    vehicle = scenario.uavs[uav]
    error = vehicle.tracking_error
    if flown.plan.autopilot.name == "ardupilot":
        error = strayed(error, error.horizontal + SMART_ACCURACY, error.vertical + SMART_ACCURACY)
    uavs = (*scenario.uavs[:uav], derived(vehicle, tracking_error=error), *scenario.uavs[uav + 1 :])
    wide = derived(scenario, max_height=None, uavs=uavs)
    lifts = tuple(lifts_over(wide, uav, [base for base, _ in flown.lifts]))
    turns = [_radius_of_stop(visit.order, flown.plan.autopilot.name) * (visit.hold > 0) for visit in flown.visits]
    radii = np.maximum(route.radii, np.r_[np.zeros(len(route.radii) - len(turns)), turns])
    back = replace(route, radii=radii, holds=np.zeros_like(route.holds), lifts=lifts)
    return MissionJudge(wide, error, lifts), replace(flown, plan=replace(flown.plan, route=back), lifts=lifts)


def _radius_of_stop(order: Order, autopilot: AutopilotName) -> float:
    """Return the radius within which a vehicle turns that does not stop at an order, metres."""
    own = order.radius if order.kind is OrderKind.WAYPOINT else None
    return math.hypot(own or FlightSettings.radius, DEFAULTS[autopilot].altitude_radius)
