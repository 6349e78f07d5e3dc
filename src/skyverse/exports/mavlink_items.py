"""A flight plan as the commands of a MAVLink mission, which ``.plan`` and ``.waypoints`` files contain."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Literal

import numpy as np

from skyverse.exports.autopilots import corner_acceptance, stop_acceptance
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.global_positions import AltitudeReference, global_positions
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea, Altitude
from skyverse.model.scenario import Scenario

End = Literal["loiter", "land", "rtl"]
MAVLINK_FRAMES: dict[type[Altitude], int] = {AboveSea: 0, AboveHome: 3, AboveGround: 10}
"""MAV_FRAME_GLOBAL, MAV_FRAME_GLOBAL_RELATIVE_ALT, MAV_FRAME_GLOBAL_TERRAIN_ALT."""
MISSION_FRAME = 2
"""MAV_FRAME_MISSION."""
ROI_LOCATION = 3.0
"""MAV_ROI_LOCATION."""


class Command(IntEnum):
    """Numbers of MAV_CMD."""

    WAYPOINT = 16
    LOITER = 17
    RETURN = 20
    LAND = 21
    TAKEOFF = 22
    DELAY = 93
    SPEED = 178
    LOOK_AT = 195
    REGION_OF_INTEREST = 201


@dataclass(frozen=True)
class MissionItem:
    """One command: its frame and seven numbers, of which the last three may be latitude, longitude and altitude.

    ``None`` leaves a number, such as the heading, to the autopilot.
    """

    command: Command
    frame: int
    numbers: tuple[float | None, ...]


def mission_items(scenario: Scenario, plan: FlightPlan, reference: AltitudeReference, end: End) -> list[MissionItem]:
    """Return the commands of a mission: wait, take off, fly each leg at its speed, then loiter, land or return.

    A UAV that looks at a place is told so after the take-off: PX4 by MAV_CMD_DO_SET_ROI_LOCATION, and ArduPilot, which
    refuses that in a mission before 4.7, by MAV_CMD_DO_SET_ROI.
    """
    route = plan.route
    wing = scenario.uavs[route.uav].fixed_wing
    at = global_positions(scenario, route.uav, route.waypoints, reference)
    where, frame = at.rows, MAVLINK_FRAMES[at.kind]
    made = []

    def add(command: Command, frame: int, *numbers: float | None) -> None:
        made.append(MissionItem(command, frame, numbers))

    if plan.delay > 0:
        add(Command.DELAY, MISSION_FRAME, plan.delay, -1.0, -1.0, -1.0, 0.0, 0.0, 0.0)
    pitch = wing.climb if wing is not None else 0.0
    add(Command.TAKEOFF, frame, pitch, 0.0, 0.0, None, *where[0])
    look_at = scenario.uavs[route.uav].look_at
    if look_at is not None:
        (place,) = global_positions(scenario, route.uav, np.array([look_at]), reference).rows
        if plan.autopilot.name == "ardupilot":
            add(Command.REGION_OF_INTEREST, frame, ROI_LOCATION, 0.0, 0.0, 0.0, *place)
        else:
            add(Command.LOOK_AT, frame, 0.0, 0.0, 0.0, 0.0, *place)
    said, radius = 0.0, route.radius if wing is not None else corner_acceptance(plan.autopilot, route.radius).radius
    for k, speed in enumerate(plan.speeds.tolist(), 1):
        if speed != said:
            kind = 0.0 if wing is not None else 1.0  # airspeed for an aeroplane, ground speed otherwise
            add(Command.SPEED, MISSION_FRAME, kind, speed, -1.0, 0.0, 0.0, 0.0, 0.0)
            said = speed
        hold, near = round(float(route.waypoint_holds[k]), 3), radius
        if hold > 0 and wing is None:
            near = stop_acceptance(plan.autopilot, plan.rates, route.radius, speed)
        add(Command.WAYPOINT, frame, hold, near, 0.0, None, *where[k])
    if end == "land":
        (below,) = global_positions(scenario, route.uav, plan.ending[-1:], "home", plan.home).rows
        add(Command.LAND, MAVLINK_FRAMES[AboveHome], 0.0, 0.0, 0.0, None, *below)
    elif end == "rtl":
        add(Command.RETURN, MISSION_FRAME, *(0.0 for _ in range(7)))
    else:
        around = wing.turn_radius if wing is not None else 0.0
        yaw = 0.0 if plan.autopilot.name == "ardupilot" else None  # ArduPilot needs a number here
        add(Command.LOITER, frame, 0.0, 0.0, around, yaw, *where[-1])
    return made
