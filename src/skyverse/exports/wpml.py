"""DJI's waylines (WPML 1.0.2): a .kmz with a template for the editor and waylines for the drone."""

from xml.etree import ElementTree as ET

import numpy as np

from skyverse.exports.camera_items import interval, spacing
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
PASS = "toPointAndPassWithContinuityCurvature"
Params = dict[str, str | float]
GIMBAL: Params = {
    "payloadPositionIndex": "0",
    "gimbalHeadingYawBase": "aircraft",
    "gimbalRotateMode": "absoluteAngle",
    **{"gimbalRollRotateEnable": "0", "gimbalRollRotateAngle": "0"},
    **{"gimbalYawRotateEnable": "0", "gimbalYawRotateAngle": "0"},
    **{"gimbalRotateTimeEnable": "0", "gimbalRotateTime": "0"},
}
"""What a turn of the gimbal has beside its pitch."""
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
    stays = route.waypoint_targets[of_plan] >= 0 or any(run.standing_at(of_plan) for run in route.runs)
    return 0.0 if begins or not stays else float(route.waypoint_holds[of_plan])


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
        mode, damping = _turn(file, k)
        _add(mark, useGlobalHeadingParam="1", useGlobalTurnParam=str(int(mode == STOP)))
        if mode != STOP:
            turn = ET.SubElement(mark, "wpml:waypointTurnParam")
            _add(turn, waypointTurnMode=mode, waypointTurnDampingDist=damping)
            _add(mark, useStraightLine="1")
        _add_camera(mark, file, k)
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
        turn, (mode, damping) = ET.SubElement(mark, "wpml:waypointTurnParam"), _turn(file, k)
        _add(turn, waypointTurnMode=mode, waypointTurnDampingDist=damping)
        _add(mark, useStraightLine="1")
        if stay := stay_at(file, k):
            _action(mark, k, (k, k), "hover", {"hoverTime": stay})
        _add_camera(mark, file, k)
    return document_text(root)


def _turn(file: FlightFile, k: int) -> tuple[str, str | float]:
    """Return how waypoint k of a file is passed, and within which distance: strips at once, else with a stop.

    How DJI's aircraft turn is not published: its turns are taken to stay within that distance, as other autopilots' do.
    """
    number, points = file.part[k], file.plan.waypoints
    if file.plan.full_stops[number] or k in (0, len(file.part) - 1):
        return STOP, "0"
    inside = any(run.on <= number < run.off for run in file.plan.route.runs)
    shortest = float(np.linalg.norm(np.diff(points[number - 1 : number + 2], axis=0), axis=1).min())
    damping = min(float(file.plan.route.waypoint_radii[number]), 0.45 * shortest)
    return PASS if inside else "coordinateTurn", damping


def _add_camera(mark: ET.Element, file: FlightFile, k: int) -> None:
    """Add what the camera does at waypoint k of a file: it turns before a run, and takes the photos of one."""
    runs, part = file.plan.route.runs, file.part
    first = len(part)  # numbers of groups after those of hovers
    for n, run in enumerate(runs):
        if run.on not in part or run.off not in part:
            continue
        on, off = run.on - part[0], run.off - part[0]
        before = [one for one in runs[:n] if one.on in part and one.off in part]
        turns = not before or before[-1].pitch != run.pitch
        if turns and k == (max(on - 1, 0) if on < off else on):
            angle: Params = {"gimbalPitchRotateEnable": "1", "gimbalPitchRotateAngle": run.pitch}
            _action(mark, first + 3 * n, (k, k), "gimbalRotate", GIMBAL | angle)
        photo: Params = {"payloadPositionIndex": "0", "useGlobalPayloadLensIndex": "0"}
        if k == on < off:
            by_time = run.trigger == "time"
            step = interval(file.plan, run) if by_time else spacing(file.plan, run)
            trigger = ("multipleTiming" if by_time else "multipleDistance", step)
            _action(mark, first + 3 * n + 1, (on, off), "takePhoto", photo, trigger)
        if run.standing_at(part[k]):
            _action(mark, first + 3 * n + 2, (k, k), "takePhoto", photo)


def _action(
    mark: ET.Element,
    number: int,
    span: tuple[int, int],
    name: str,
    params: Params,
    trigger: tuple[str, float] | None = None,
) -> None:
    """Add a group with one action, between two waypoints of a file; without a trigger at the first of them."""
    group = ET.SubElement(mark, "wpml:actionGroup")
    _add(group, actionGroupId=str(number), actionGroupStartIndex=str(span[0]), actionGroupEndIndex=str(span[1]))
    _add(group, actionGroupMode="sequence")
    kind = ET.SubElement(group, "wpml:actionTrigger")
    _add(kind, actionTriggerType="reachPoint" if trigger is None else trigger[0])
    if trigger is not None:
        _add(kind, actionTriggerParam=trigger[1])
    action = ET.SubElement(group, "wpml:action")
    _add(action, actionId="0", actionActuatorFunc=name)
    _add(ET.SubElement(action, "wpml:actionActuatorFuncParam"), **params)


def _placemark(folder: ET.Element, longitude: float, latitude: float, index: int) -> ET.Element:
    mark = ET.SubElement(folder, "Placemark")
    ET.SubElement(ET.SubElement(mark, "Point"), "coordinates").text = f"{longitude:.10f},{latitude:.10f}"
    _add(mark, index=str(index))
    return mark


def _add(parent: ET.Element, **values: str | float) -> None:
    texts = {tag: value if isinstance(value, str) else written(value, 4) for tag, value in values.items()}
    add_texts(parent, "wpml:", **texts)
