"""DJI's waylines (WPML 1.0.2): a .kmz with a template for the editor and waylines for the drone."""

from xml.etree import ElementTree as ET

import numpy as np

from skyverse.exports.global_positions import GlobalPositions, geoid_of, global_positions, origin_of
from skyverse.exports.map_formats import KML, add_texts, document_text
from skyverse.exports.mavlink_formats import FlightFile
from skyverse.model.geodesy import to_wgs84

WPML = "http://www.dji.com/wpmz/1.0.2"
TEMPLATE_HEIGHTS = {"amsl": "EGM96", "home": "relativeToStartPoint", "agl": "realTimeFollowSurface"}
EXECUTE_HEIGHTS = {"amsl": "WGS84", "home": "relativeToStartPoint", "agl": "realTimeFollowSurface"}
FINISH_ACTIONS = {"loiter": "noAction", "land": "autoLand", "rtl": "goHome"}
STOP_AT_WAYPOINT = "toPointAndStopWithDiscontinuityCurvature"
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


def part_positions(file: FlightFile) -> GlobalPositions:
    """Return where the waypoints of a part are on the globe."""
    return global_positions(file.scenario, file.plan.route.uav, file.plan.waypoints[file.part], file.reference)


def _document() -> tuple[ET.Element, ET.Element]:
    root = ET.Element("kml", {"xmlns": KML, "xmlns:wpml": WPML})
    return root, ET.SubElement(root, "Document")


def _config(document: ET.Element, file: FlightFile, *, executed: bool) -> None:
    config = ET.SubElement(document, "wpml:missionConfig")
    _add(config, flyToWaylineMode="safely", finishAction=FINISH_ACTIONS[file.end])
    home = file.back is not None and file.back.everywhere
    _add(config, exitOnRCLost="executeLostAction", executeRCLostAction="goBack" if home else "hover")
    rise = float(file.plan.waypoints[0][2] - file.plan.home[2])
    _add(config, takeOffSecurityHeight=_number(rise), globalTransitionalSpeed=_number(part_speeds(file)[0]))
    if executed and file.back is not None:
        _add(config, globalRTHHeight=_number(file.back.altitude))
    drone = ET.SubElement(config, "wpml:droneInfo")
    _add(drone, droneEnumValue=DJI_DRONE[0], droneSubEnumValue=DJI_DRONE[1])
    payload = ET.SubElement(config, "wpml:payloadInfo")
    _add(payload, payloadEnumValue=DJI_PAYLOAD[0], payloadSubEnumValue=DJI_PAYLOAD[1], payloadPositionIndex="0")


def _template(file: FlightFile) -> str:
    scenario, reference = file.scenario, file.reference
    root, document = _document()
    _add(document, author="skyverse", createTime="0", updateTime="0")
    _config(document, file, executed=False)
    folder = ET.SubElement(document, "Folder")
    _add(folder, templateType="waypoint", templateId="0")
    system = ET.SubElement(folder, "wpml:waylineCoordinateSysParam")
    _add(system, coordinateMode="WGS84", heightMode=TEMPLATE_HEIGHTS[reference], positioningType="GPS")
    speeds = part_speeds(file)
    at = part_positions(file)
    _add(folder, autoFlightSpeed=_number(max(speeds)), gimbalPitchMode="manual")
    _add(folder, globalHeight=_number(float(at.altitude[0])))
    _add_heading(folder, "globalWaypointHeadingParam", file)
    _add(folder, globalWaypointTurnMode=STOP_AT_WAYPOINT, globalUseStraightLine="1")
    geoid = origin_of(scenario).geoid
    # DJI reads these only with heights above the sea
    above_ellipsoid = at.altitude if geoid is None else at.sea + geoid
    for k, speed in enumerate(speeds):
        mark = _placemark(folder, float(at.longitude[k]), float(at.latitude[k]), k)
        _add(mark, ellipsoidHeight=_number(float(above_ellipsoid[k])), height=_number(float(at.altitude[k])))
        _add(mark, useGlobalHeight="0", useGlobalSpeed="0", waypointSpeed=_number(speed))
        _add(mark, useGlobalHeadingParam="1", useGlobalTurnParam="1")
    return document_text(root)


def _add_heading(parent: ET.Element, name: str, file: FlightFile) -> None:
    """Tell where the nose points: along the legs, in one direction, or at a place.

    At a place DJI aims the nose and not the camera. `fixed` would keep whichever heading the aircraft has; between
    waypoints of the same angle `smoothTransition` keeps that angle.
    """
    heading, vehicle = ET.SubElement(parent, f"wpml:{name}"), file.scenario.uavs[file.plan.route.uav]
    if vehicle.heading is not None:
        angle = (vehicle.heading + 180.0) % 360.0 - 180.0
        _add(heading, waypointHeadingMode="smoothTransition", waypointHeadingAngle=_number(angle))
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
    scenario, reference = file.scenario, file.reference
    root, document = _document()
    _config(document, file, executed=True)
    folder = ET.SubElement(document, "Folder")
    speeds = part_speeds(file)
    _add(folder, templateId="0", executeHeightMode=EXECUTE_HEIGHTS[reference], waylineId="0")
    _add(folder, autoFlightSpeed=_number(max(speeds)))
    at = part_positions(file)
    heights = at.altitude + (geoid_of(scenario, "waylines") if reference == "amsl" else 0.0)
    for k, speed in enumerate(speeds):
        mark = _placemark(folder, float(at.longitude[k]), float(at.latitude[k]), k)
        _add(mark, executeHeight=_number(float(heights[k])), waypointSpeed=_number(speed))
        _add_heading(mark, "waypointHeadingParam", file)
        turn = ET.SubElement(mark, "wpml:waypointTurnParam")
        _add(turn, waypointTurnMode=STOP_AT_WAYPOINT, waypointTurnDampingDist="0")
        _add(mark, useStraightLine="1")
        if k == file.part[0] == 0 and file.plan.hover > 0:
            _hover(mark, file.plan.hover)
    return document_text(root)


def _hover(mark: ET.Element, seconds: float) -> None:
    """Add a hover at the first waypoint, for a UAV that departs later than the mission begins."""
    group = ET.SubElement(mark, "wpml:actionGroup")
    _add(group, actionGroupId="0", actionGroupStartIndex="0", actionGroupEndIndex="0", actionGroupMode="sequence")
    _add(ET.SubElement(group, "wpml:actionTrigger"), actionTriggerType="reachPoint")
    action = ET.SubElement(group, "wpml:action")
    _add(action, actionId="0", actionActuatorFunc="hover")
    _add(ET.SubElement(action, "wpml:actionActuatorFuncParam"), hoverTime=_number(seconds))


def _placemark(folder: ET.Element, longitude: float, latitude: float, index: int) -> ET.Element:
    mark = ET.SubElement(folder, "Placemark")
    ET.SubElement(ET.SubElement(mark, "Point"), "coordinates").text = f"{longitude:.10f},{latitude:.10f}"
    _add(mark, index=str(index))
    return mark


def _add(parent: ET.Element, **values: str) -> None:
    add_texts(parent, "wpml:", **values)


def _number(value: float) -> str:
    return f"{value:.4f}".rstrip("0").rstrip(".")
