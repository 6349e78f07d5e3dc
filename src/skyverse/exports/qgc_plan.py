"""QGroundControl's ``.plan``: the mission and a geofence around it."""

import json
from itertools import pairwise

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.shape_geometry import footprint
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.global_positions import AltitudeReference, global_positions, home_on_globe, origin_of
from skyverse.exports.leg_deviation import leg_deviation
from skyverse.exports.mavlink_items import MISSION_FRAME, End, MissionItem, mission_items
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea, Altitude
from skyverse.model.geodesy import to_wgs84
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Box, Cylinder, Prism

QGC_ALTITUDE_MODES: dict[type[Altitude], int] = {AboveHome: 1, AboveSea: 2, AboveGround: 4}
"""QGroundControl's numbers for the references of altitudes."""
MAX_OFF_FENCE = 0.5
"""Metres that an edge of the fence, which is straight in degrees, may be off the edge on the map."""
FIRMWARE = {"px4": 12, "ardupilot": 3}
"""MAV_AUTOPILOT_PX4, MAV_AUTOPILOT_ARDUPILOTMEGA."""


def plan_text(
    scenario: Scenario,
    flight: FlightPlan,
    reference: AltitudeReference,
    end: End,
    fence: dict[str, object],
) -> str:
    """Return a ``.plan`` file with a geofence, which is that of `geofence`."""
    route = flight.route
    vehicle = scenario.uavs[route.uav]
    mode = QGC_ALTITUDE_MODES[global_positions(scenario, route.uav, route.points[:1], reference).kind]
    position = home_on_globe(scenario, route.uav)
    wing = vehicle.fixed_wing
    speed = wing.speed if wing is not None else float(np.median(flight.speeds))
    mission = {
        "cruiseSpeed": wing.speed if wing is not None else vehicle.max_speed,
        "firmwareType": FIRMWARE[flight.autopilot.name],
        "globalPlanAltitudeMode": mode,
        "hoverSpeed": speed,
        "items": [_item(k, item, mode) for k, item in enumerate(mission_items(scenario, flight, reference, end), 1)],
        "plannedHomePosition": position,
        "vehicleType": 2 if wing is None else 1,
        "version": 2,
    }
    plan = {
        "fileType": "Plan",
        "geoFence": fence,
        "groundStation": "QGroundControl",
        "mission": mission,
        "rallyPoints": {"points": [], "version": 2},
        "version": 1,
    }
    return json.dumps(plan, indent=4) + "\n"


def _item(number: int, item: MissionItem, mode: int) -> dict[str, object]:
    made: dict[str, object] = {
        "autoContinue": True,
        "command": int(item.command),
        "doJumpId": number,
        "frame": item.frame,
        "params": list(item.numbers),
        "type": "SimpleItem",
    }
    if item.frame != MISSION_FRAME:
        own = 1 if item.frame == 3 else mode
        made |= {"Altitude": item.numbers[-1], "AltitudeMode": own, "AMSLAltAboveTerrain": None}
    return made


def geofence(scenario: Scenario) -> dict[str, object]:
    """Return the geofence: the bounds as the area to stay in, and obstacles as areas to stay out of.

    A geofence has no floor and no ceiling, so it contains only obstacles without free space above or below; nothing may
    fly above those that are closed above.
    """
    (x0, y0, z0), (x1, y1, z1) = scenario.bounds.min, scenario.bounds.max
    ring = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    rings, circles = [ring], []
    room = scenario.clearance
    for shape in scenario.obstacles:
        if not isinstance(shape, Box | Cylinder | Prism) or (isinstance(shape, Prism) and shape.holes):
            continue
        low, high = (shape.min[2], shape.max[2]) if isinstance(shape, Box) else (shape.low, shape.high)
        if low - room > z0 or (high + room < z1 and not shape.closed_above):
            continue
        if isinstance(shape, Cylinder):
            ((latitude, longitude),) = _corners(scenario, np.array([shape.centre]))
            circle = {"center": [latitude, longitude], "radius": shape.radius}
            circles.append({"circle": circle, "inclusion": False, "version": 1})
        else:
            rings.append(np.array(shape.vertices) if isinstance(shape, Prism) else footprint(shape)[0])
    rings = [_with_straight_edges(scenario, ring) for ring in rings]
    corners = _corners(scenario, np.concatenate(rings))
    ends = np.cumsum([len(ring) for ring in rings]).tolist()
    polygons = [
        {"inclusion": first == 0, "polygon": corners[first:last], "version": 1} for first, last in pairwise([0, *ends])
    ]
    return {"circles": circles, "polygons": polygons, "version": 2}


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
