"""DJI's waylines (WPML 1.0.2): a .kmz with a template for the editor and waylines for the drone."""

from xml.etree import ElementTree as ET

import numpy as np

from skyverse.exports.global_positions import GlobalPositions, geoid_of, global_positions, origin_of
from skyverse.exports.map_formats import KML, add_texts, document_text
from skyverse.exports.mavlink_formats import FlightFile, wanted_heading
from skyverse.model.geodesy import to_wgs84
from skyverse.orders.dji_files import STOP
from skyverse.orders.places import written

WPML = "http://www.dji.com/wpmz/1.0.2"
TEMPLATE_HEIGHTS = {"amsl": "EGM96", "home": "relativeToStartPoint", "agl": "realTimeFollowSurface"}
EXECUTE_HEIGHTS = {"amsl": "WGS84", "home": "relativeToStartPoint", "agl": "realTimeFollowSurface"}
FINISH_ACTIONS = {"loiter": "noAction", "land": "autoLand", "rtl": "goHome"}
DJI_DRONE, DJI_PAYLOAD = ("77", "0"), ("66", "0")
"""A Mavic 3E and its camera; DJI's app lets the pilot choose another drone."""


def wpml_parts(file: FlightFile) -> dict[str, str]:
    """Return the texts of the files in the archive, by name, for a part of a plan's waypoints."""
    if file.part[-1] != len(file.plan.waypoints) - 1:
        file = file._replace(end="loiter")  # until the pilot starts the next part
    return {"wpmz/template.kml": _template(file), "wpmz/waylines.wpml": _waylines(file)}


def part_speeds(file: FlightFile) -> list[float]:
    """Return the speed after each waypoint of a part, m/s; after the last it is that before it."""
    speeds = file.plan.speeds[file.part[0] : file.part[-1]].tolist()
    return [*speeds, speeds[-1]]


def stay_at(file: FlightFile, k: int) -> float:
    """Return how long a UAV stays at waypoint k of a file, seconds: at the first until it departs, and at targets."""
    of_plan = file.part[k]
    if of_plan == 0:
        return file.plan.hover
    route, begins = file.plan.route, k == 0  # a part begins where the one before has stayed
    return 0.0 if begins or route.waypoint_targets[of_plan] < 0 else float(route.waypoint_holds[of_plan])


def part_positions(file: FlightFile) -> GlobalPositions:
    """Return where the waypoints of a part are on the globe."""
    return global_positions(file.scenario, file.plan.route.uav, file.plan.waypoints[file.part], file.reference)


def _document(file: FlightFile, *, executed: bool) -> tuple[ET.Element, ET.Element]:
    """Return a document with its settings, and the folder of its waypoints."""
    root = ET.Element("kml", {"xmlns": KML, "xmlns:wpml": WPML})
    document = ET.SubElement(root, "Document")
    if not executed:
        _add(document, author="skyverse", createTime="0", updateTime="0")
    _config(document, file, executed=executed)
    return root, ET.SubElement(document, "Folder")


def _config(document: ET.Element, file: FlightFile, *, executed: bool) -> None:
    config = ET.SubElement(document, "wpml:missionConfig")
    _add(config, flyToWaylineMode="safely", finishAction=FINISH_ACTIONS[file.end])
    home = file.back is not None and file.back.everywhere
    _add(config, exitOnRCLost="executeLostAction", executeRCLostAction="goBack" if home else "hover")
    rise = float(file.plan.waypoints[0][2] - file.plan.home[2])
    _add(config, takeOffSecurityHeight=rise, globalTransitionalSpeed=part_speeds(file)[0])
    if executed and file.back is not None:
        _add(config, globalRTHHeight=file.back.altitude)
    drone = ET.SubElement(config, "wpml:droneInfo")
    _add(drone, droneEnumValue=DJI_DRONE[0], droneSubEnumValue=DJI_DRONE[1])
    payload = ET.SubElement(config, "wpml:payloadInfo")
    _add(payload, payloadEnumValue=DJI_PAYLOAD[0], payloadSubEnumValue=DJI_PAYLOAD[1], payloadPositionIndex="0")


def _template(file: FlightFile) -> str:
    reference, speeds, at = file.reference, part_speeds(file), part_positions(file)
    root, folder = _document(file, executed=False)
    _add(folder, templateType="waypoint", templateId="0")
    system = ET.SubElement(folder, "wpml:waylineCoordinateSysParam")
    _add(system, coordinateMode="WGS84", heightMode=TEMPLATE_HEIGHTS[reference], positioningType="GPS")
    _add(folder, autoFlightSpeed=max(speeds), gimbalPitchMode="manual")
    _add(folder, globalHeight=at.altitude[0])
    _add_heading(folder, "globalWaypointHeadingParam", file)
    _add(folder, globalWaypointTurnMode=STOP, globalUseStraightLine="1")
    geoid = origin_of(file.scenario).geoid
    # DJI reads these only with heights above the sea
    above_ellipsoid = at.altitude if geoid is None else at.sea + geoid
    for k, speed in enumerate(speeds):
        mark = _placemark(folder, float(at.longitude[k]), float(at.latitude[k]), k)
        _add(mark, ellipsoidHeight=above_ellipsoid[k], height=at.altitude[k])
        _add(mark, useGlobalHeight="0", useGlobalSpeed="0", waypointSpeed=speed)
        _add(mark, useGlobalHeadingParam="1", useGlobalTurnParam="1")
    return document_text(root)


def _add_heading(parent: ET.Element, name: str, file: FlightFile, wanted: float | None = None) -> None:
    """Tell where the nose points: along the legs, in one direction, at a place, or where a target wants it.

    At a place DJI aims the nose and not the camera. `fixed` would keep whichever heading the aircraft has; between
    waypoints of the same angle `smoothTransition` keeps that angle.
    """
    heading, vehicle = ET.SubElement(parent, f"wpml:{name}"), file.scenario.uavs[file.plan.route.uav]
    aim = vehicle.heading if wanted is None else wanted
    if aim is not None:
        angle = (aim + 180.0) % 360.0 - 180.0
        _add(heading, waypointHeadingMode="smoothTransition", waypointHeadingAngle=angle)
        if name == "waypointHeadingParam":
            _add(heading, waypointHeadingAngleEnable="1")
        _add(heading, waypointHeadingPathMode="followBadArc")
        return
    if vehicle.look_at is None:
        _add(heading, waypointHeadingMode="followWayline", waypointHeadingPathMode="followBadArc")
        return
    latitude, longitude, _ = to_wgs84(origin_of(file.scenario), np.array([vehicle.look_at]))[0].tolist()
    _add(heading, waypointHeadingMode="towardPOI", waypointPoiPoint=f"{latitude:.9f},{longitude:.9f},0.000000")
    _add(heading, waypointHeadingPathMode="followBadArc", waypointHeadingPoiIndex="0")


def _waylines(file: FlightFile) -> str:
    reference, speeds, at = file.reference, part_speeds(file), part_positions(file)
    root, folder = _document(file, executed=True)
    _add(folder, templateId="0", executeHeightMode=EXECUTE_HEIGHTS[reference], waylineId="0")
    _add(folder, autoFlightSpeed=max(speeds))
    heights = at.altitude + (geoid_of(file.scenario, "waylines") if reference == "amsl" else 0.0)
    for k, speed in enumerate(speeds):
        mark = _placemark(folder, float(at.longitude[k]), float(at.latitude[k]), k)
        _add(mark, executeHeight=heights[k], waypointSpeed=speed)
        _add_heading(mark, "waypointHeadingParam", file, wanted_heading(file.scenario, file.plan, file.part[k]))
        turn = ET.SubElement(mark, "wpml:waypointTurnParam")
        _add(turn, waypointTurnMode=STOP, waypointTurnDampingDist="0")
        _add(mark, useStraightLine="1")
        if stay := stay_at(file, k):
            _hover(mark, k, stay)
    return document_text(root)


def _hover(mark: ET.Element, k: int, seconds: float) -> None:
    """Add a hover at waypoint k of a file."""
    group = ET.SubElement(mark, "wpml:actionGroup")
    number = str(k)
    _add(group, actionGroupId=number, actionGroupStartIndex=number, actionGroupEndIndex=number)
    _add(group, actionGroupMode="sequence")
    _add(ET.SubElement(group, "wpml:actionTrigger"), actionTriggerType="reachPoint")
    action = ET.SubElement(group, "wpml:action")
    _add(action, actionId="0", actionActuatorFunc="hover")
    _add(ET.SubElement(action, "wpml:actionActuatorFuncParam"), hoverTime=seconds)


def _placemark(folder: ET.Element, longitude: float, latitude: float, index: int) -> ET.Element:
    mark = ET.SubElement(folder, "Placemark")
    ET.SubElement(ET.SubElement(mark, "Point"), "coordinates").text = f"{longitude:.10f},{latitude:.10f}"
    _add(mark, index=str(index))
    return mark


def _add(parent: ET.Element, **values: str | float) -> None:
    texts = {tag: value if isinstance(value, str) else written(value, 4) for tag, value in values.items()}
    add_texts(parent, "wpml:", **texts)
