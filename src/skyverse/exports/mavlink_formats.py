"""Missions of MAVLink commands, as QGroundControl (``.plan``) and Mission Planner (QGC WPL 110) read them."""

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely

from skyverse._typing import Floats
from skyverse.draw import footprint
from skyverse.errors import InputError
from skyverse.exports.autopilots import End, corner_acceptance, stop_acceptance
from skyverse.exports.camera_items import CameraOrders, camera_off
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.global_positions import AltitudeReference, global_positions, home_on_globe, origin_of
from skyverse.exports.leg_geometry import leg_deviation
from skyverse.exports.photo_strips import photo_heading
from skyverse.exports.survey_item import items_with_survey
from skyverse.exports.way_home import WayHome
from skyverse.model.altitude import AboveHome, AboveSea
from skyverse.model.arrays import arctan2
from skyverse.model.geodesy import to_wgs84
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Box, Cylinder, Prism
from skyverse.orders.mavlink_files import FIRMWARES, QGC_ALTITUDE_MODES, WPL, plan_item, wpl_row
from skyverse.orders.mavlink_items import MISSION_FRAME, Command, StoredItem, frame_of

ROI_LOCATION = 3.0
"""MAV_ROI_LOCATION."""


class FlightFile(NamedTuple):
    """What one file for an autopilot is written of.

    Attributes
    ----------
    scenario, plan
        The scenario, and the flight plan.
    part
        The waypoints of the plan that the file has.
    reference, end
        What altitudes are counted from, and what the UAV does at its last waypoint.
    back
        Its way home, ``None`` for an aeroplane.
    fence
        The geofence of the scenario.
    survey_item
        Whether a ``.plan`` has its photos in QGroundControl's own survey item.
    """

    scenario: Scenario
    plan: FlightPlan
    part: range
    reference: AltitudeReference
    end: End
    back: WayHome | None
    fence: dict[str, object]
    survey_item: bool = False


def mission_items(file: FlightFile) -> list[StoredItem]:
    """Return the commands of a mission: wait, take off, fly each leg at its speed, then loiter, land or return.

    A UAV that looks at a place is told so after the take-off: PX4 by MAV_CMD_DO_SET_ROI_LOCATION, and ArduPilot, which
    refuses that in a mission before 4.7, by MAV_CMD_DO_SET_ROI. A fixed heading is that of each place, which ArduPilot
    passes over: it is told on its way to the first waypoint, after the speed, which would wait until it has turned, and
    on that to a target that wants another. ArduPilot turns along the legs again after that target.
    """
    scenario, plan, _, reference, end, *_ = file
    route = plan.route
    vehicle = scenario.uavs[route.uav]
    wing, look_at, yaw = vehicle.fixed_wing, vehicle.look_at, vehicle.heading
    at = global_positions(scenario, route.uav, route.waypoints, reference)
    where, frame = at.rows, frame_of(at.kind)
    made = []

    def add(command: Command, frame: int, *numbers: float | None) -> None:
        made.append(StoredItem(command, frame, tuple(math.nan if one is None else one for one in numbers)))

    if plan.delay > 0:
        add(Command.DELAY, MISSION_FRAME, plan.delay, -1.0, -1.0, -1.0, 0.0, 0.0, 0.0)
    pitch = wing.climb if wing is not None else 0.0
    add(Command.TAKEOFF, frame, pitch, 0.0, 0.0, None, *where[0])
    if look_at is not None:
        (place,) = global_positions(scenario, route.uav, np.array([look_at]), reference).rows
        if plan.autopilot.name == "ardupilot":
            add(Command.REGION_OF_INTEREST, frame, ROI_LOCATION, 0.0, 0.0, 0.0, *place)
        else:
            add(Command.LOOK_AT, frame, 0.0, 0.0, 0.0, 0.0, *place)
    made += camera_off(plan)
    camera = CameraOrders(plan)
    if plan.hover > 0:
        stop = corner_acceptance(plan.autopilot, route.radius).radius
        add(Command.WAYPOINT, frame, plan.hover, stop, 0.0, wanted_heading(scenario, plan, 0), *where[0])
    made += camera.after(0)
    said, radius = 0.0, route.radius if wing is not None else corner_acceptance(plan.autopilot, route.radius).radius
    for k, speed in enumerate(plan.speeds.tolist(), 1):
        made += camera.before(k)
        if speed != said:
            kind = 0.0 if wing is not None else 1.0  # airspeed for an aeroplane, ground speed otherwise
            add(Command.SPEED, MISSION_FRAME, kind, speed, -1.0, 0.0, 0.0, 0.0, 0.0)
            said = speed
        hold, near = round(float(route.waypoint_holds[k]), 3), radius
        if hold > 0 and wing is None:
            near = stop_acceptance(plan.autopilot, plan.rates, route.radius, speed)
        aim = yaw if (wanted := wanted_heading(scenario, plan, k)) is None else wanted
        if aim is not None and (k == 1 or wanted is not None) and plan.autopilot.name == "ardupilot":
            if made[-1].command != Command.SPEED:  # Copter forgets a heading that is told before it sets off
                add(Command.SPEED, MISSION_FRAME, 1.0, speed, -1.0, 0.0, 0.0, 0.0, 0.0)
            add(Command.YAW, MISSION_FRAME, aim, vehicle.max_yaw_rate, 0.0, 0.0, 0.0, 0.0, 0.0)
        add(Command.WAYPOINT, frame, hold, near, 0.0, aim, *where[k])
        made += camera.after(k)
    if route.runs and len(made) + 1 > plan.autopilot.max_waypoints:
        raise InputError(
            f"{route.name(scenario)}: its photos take {len(made) + 1} items, and {plan.autopilot.title} takes "
            f"{plan.autopilot.max_waypoints}; plan with smaller batteries or more UAVs, for more sorties"
        )
    if end == "land":
        (below,) = global_positions(scenario, route.uav, plan.ending[-1:], "home", plan.home).rows
        add(Command.LAND, frame_of(AboveHome), 0.0, 0.0, 0.0, yaw, *below)
    elif end == "rtl":
        add(Command.RETURN, MISSION_FRAME, *(0.0 for _ in range(7)))
    else:
        around = wing.turn_radius if wing is not None else 0.0
        if yaw is None and plan.autopilot.name == "ardupilot":
            yaw = 0.0  # it needs a number here
        add(Command.LOITER, frame, 0.0, 0.0, around, yaw, *where[-1])
    return made


def wanted_heading(scenario: Scenario, plan: FlightPlan, k: int) -> float | None:
    """Return where target or photos at waypoint k want the nose, degrees clockwise from north; ``None`` if neither."""
    visited = int(plan.route.waypoint_targets[k])
    target = scenario.targets[visited] if visited >= 0 else None
    if target is None:
        return photo_heading(plan.route.runs, k)
    if target.look_at is None:
        return target.heading
    east, north = np.subtract(target.look_at, target.position)[:2]
    return float(np.degrees(arctan2(east, north)) % 360.0)


LEAST_AREA = 1.0
"""Square metres that a part between obstacles must have to be one that a UAV can be in."""
MAX_OFF_FENCE = 0.5
"""Metres that an edge of the fence, which is straight in degrees, may be off the edge on the map."""


def plan_text(file: FlightFile) -> str:
    """Return a ``.plan`` file with a geofence."""
    scenario, flight, reference = file.scenario, file.plan, file.reference
    route = flight.route
    vehicle = scenario.uavs[route.uav]
    mode = QGC_ALTITUDE_MODES[global_positions(scenario, route.uav, route.points[:1], reference).kind]
    position = home_on_globe(scenario, route.uav)
    wing = vehicle.fixed_wing
    speed = wing.speed if wing is not None else float(np.median(flight.speeds))
    items = [plan_item(item, k) for k, item in enumerate(mission_items(file), 1)]
    if file.survey_item and route.runs:
        items = items_with_survey(mission_items(file), scenario, flight, reference)
    mission = {
        "cruiseSpeed": wing.speed if wing is not None else vehicle.max_speed,
        "firmwareType": next(number for number, name in FIRMWARES.items() if name == flight.autopilot.name),
        "globalPlanAltitudeMode": mode,
        "hoverSpeed": speed,
        "items": items,
        "plannedHomePosition": position,
        "vehicleType": 2 if wing is None else 1,
        "version": 2,
    }
    plan = {
        "fileType": "Plan",
        "geoFence": file.fence,
        "groundStation": "QGroundControl",
        "mission": mission,
        "rallyPoints": {"points": [], "version": 2},
        "version": 1,
    }
    return json.dumps(plan, indent=4) + "\n"


def geofence(scenario: Scenario) -> dict[str, object]:
    """Return the geofence: the bounds, or what a fence leaves of them, to stay in, and obstacles to stay out of.

    A geofence has no floor and no ceiling, so it contains only obstacles without free space above or below; nothing may
    fly above those that are closed above. It has one area to stay in: of several, the vehicle would have to be in
    all for ArduPilot, unless FENCE_OPTIONS says otherwise, and for PX4 as it is today, but in any for older PX4.
    """
    (x0, y0, z0), (x1, y1, z1) = scenario.bounds.min, scenario.bounds.max
    rings, circles = list[Floats](), []
    holed = list[Prism]()
    room = scenario.clearance
    for shape in scenario.obstacles:
        if not isinstance(shape, Box | Cylinder | Prism):
            continue
        low, high = (shape.min[2], shape.max[2]) if isinstance(shape, Box) else (shape.low, shape.high)
        if low - room > z0 or (high + room < z1 and not shape.closed_above):
            continue
        if isinstance(shape, Prism) and shape.holes:
            holed.append(shape)
        elif isinstance(shape, Cylinder):
            ((latitude, longitude),) = _corners(scenario, np.array([shape.centre]))
            circle = {"center": [latitude, longitude], "radius": shape.radius}
            circles.append({"circle": circle, "inclusion": False, "version": 1})
        else:
            rings.append(np.array(shape.vertices) if isinstance(shape, Prism) else footprint(shape)[0])
    frame = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    rings = [*(_without_holes(holed, frame) if holed else [frame]), *rings]
    rings = [_with_straight_edges(scenario, ring) for ring in rings]
    corners = _corners(scenario, np.concatenate(rings))
    ends = np.cumsum([len(ring) for ring in rings]).tolist()
    polygons = [
        {"inclusion": first == 0, "polygon": corners[first:last], "version": 1} for first, last in pairwise([0, *ends])
    ]
    return {"circles": circles, "polygons": polygons, "version": 2}


def _without_holes(prisms: Sequence[Prism], frame: Floats) -> list[Floats]:
    """Return an area to stay in and areas to stay out of, rings (n, 2) without holes, for prisms that have holes.

    Where the prisms leave one part of the frame, that is the area to stay in, without what it surrounds. Otherwise it
    is the frame, and the prisms are cut along y through each of their holes.
    """
    whole = shapely.Polygon(frame)
    (x0, y0), (x1, y1) = frame.min(axis=0).tolist(), frame.max(axis=0).tolist()
    solid = whole.intersection(shapely.union_all([shapely.Polygon(one.vertices, one.holes) for one in prisms]))
    left = [part for part in shapely.get_parts(whole.difference(solid)) if part.area > LEAST_AREA]
    if len(left) == 1:
        return [shapely.get_coordinates(ring)[:-1] for ring in (left[0].exterior, *left[0].interiors)]
    holes = [hole for part in shapely.get_parts(solid) for hole in getattr(part, "interiors", ())]
    cuts = sorted({x0, x1, *(shapely.Polygon(hole).representative_point().x for hole in holes)})
    strips = [shapely.get_parts(solid.intersection(shapely.box(a, y0, b, y1))) for a, b in pairwise(cuts)]
    parts = [part for strip in strips for part in strip if part.area > 0]
    return [frame, *(shapely.get_coordinates(part.exterior)[:-1] for part in parts)]


def _corners(scenario: Scenario, ring: Floats) -> list[list[float]]:
    """Return [latitude, longitude] of each place (x, y), (n, 2) metres."""
    return to_wgs84(origin_of(scenario), np.column_stack([ring, np.zeros(len(ring))]))[:, :2].tolist()


def _with_straight_edges(scenario: Scenario, ring: Floats) -> Floats:
    """Return a ring, (n, 2) metres, with more corners, so that its edges in degrees are nearly those on the map."""
    edges = np.roll(ring, -1, axis=0) - ring
    off = leg_deviation(scenario, np.linalg.norm(edges, axis=1))
    parts = np.ceil(np.sqrt(np.maximum(off / MAX_OFF_FENCE, 1.0))).astype(int)
    pairs = zip(ring, edges, parts.tolist(), strict=True)
    return np.concatenate([at + np.arange(count)[:, None] / count * edge for at, edge, count in pairs])


def waypoints_text(file: FlightFile) -> str:
    """Return a ``.waypoints`` file: line 0 is home, above mean sea level."""
    home = (0.0, 0.0, 0.0, 0.0, *home_on_globe(file.scenario, file.plan.route.uav))
    items = [StoredItem(Command.WAYPOINT, frame_of(AboveSea), home)]
    for item in mission_items(file):
        # NaN leaves the heading to the autopilot, as 0 is north; but for loiter ArduPilot accepts only numbers
        free = 0.0 if item.command == Command.LOITER else math.nan
        items.append(replace(item, numbers=tuple(free if math.isnan(one) else one for one in item.numbers)))
    return "\n".join([WPL, *("\t".join(wpl_row(item, k)) for k, item in enumerate(items))]) + "\n"
