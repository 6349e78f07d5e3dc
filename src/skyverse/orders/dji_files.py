"""DJI's waylines (WPML 1.0.0 to 1.0.6): a ``.kmz`` with the waylines that the drone flies, and the app's template."""

import io
import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from xml.etree.ElementTree import Element

from skyverse.documents.kmz import repacked, unpacked
from skyverse.errors import InputError, Remedy, parse_number, shown
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea, Altitude, GlobalPlace
from skyverse.model.waypoints import Order, OrderKind, Waypoints
from skyverse.orders.map_routes import read_route, route_content
from skyverse.orders.places import Given, Step, parse_place, steps, written
from skyverse.orders.xml_places import arrange, each, find, local_name, root_of, set_text, text, written_root

HEIGHT_MODES: dict[str, type[Altitude]] = {
    **{"relativeToStartPoint": AboveHome, "EGM96": AboveSea, "WGS84": AboveSea},
    **{"realTimeFollowSurface": AboveGround, "aboveGroundLevel": AboveGround},
}
"""What heights count from; those of ``WGS84`` are above the ellipsoid, and are taken down to the sea."""
_K = OrderKind
ACTIONS = {
    **{"hover": _K.DELAY, "rotateYaw": _K.HEADING, "gimbalRotate": _K.GIMBAL, "gimbalEvenlyRotate": _K.GIMBAL},
    **dict.fromkeys(("takePhoto", "startRecord", "stopRecord", "zoom", "focus", "setFocusType"), _K.CAMERA),
    **dict.fromkeys(("orientedShoot", "accurateShoot", "panoShot", "startContinuousShooting"), _K.CAMERA),
    **dict.fromkeys(("stopContinuousShooting", "recordPointCloud", "customDirName"), _K.CAMERA),
}
"""The kinds of actions; all others may lead anywhere."""
FINISH_ACTIONS = {"goHome": _K.RETURN, "autoLand": _K.LAND, "gotoFirstWaypoint": _K.WAYPOINT}
STOP = "toPointAndStopWithDiscontinuityCurvature"
MOMENT = 0.001
"""Seconds for which a drone that stops at a waypoint is taken to stay there."""
BEFORE = -1
"""The index of a waypoint before the first, after which the actions of a wayline's start come."""


class _Wayline:
    """A wayline, or a template's: the root of its file, which `where` names, its settings, and its waypoints."""

    geoid: float | None = None
    """How far the sea lies above the ellipsoid there, as given."""
    pairs: Sequence[Element] = ()
    """The waypoints of a template that tell how far, by two heights of each."""

    def __init__(self, root: Element, config: Element, folder: Element, where: str) -> None:
        self.root, self.config, self.folder, self.where = root, config, folder, where
        self.executed, self.marks = where.endswith(".wpml"), each(folder, "Placemark")
        self.common = {local_name(one): (one.text or "").strip() for one in folder}
        self.mode = self.common.get("executeHeightMode") or text(folder, "waylineCoordinateSysParam/heightMode")

    def number(self, parent: Element, path: str, least: float = -math.inf) -> float | None:
        """Return the number that an element within another has, ``None`` where there is none."""
        found = text(parent, path)
        return parse_number(found, f"{self.where}: {path.rpartition('/')[2]!r}", least) if found else None

    def geoid_at(self, k: int) -> float | None:
        """Return how far the sea lies above the ellipsoid, as given, or by the two heights of a template's waypoint."""
        if self.geoid is not None or not self.pairs:
            return self.geoid
        ellipsoid, sea = (self.number(self.pairs[k], tag) for tag in ("ellipsoidHeight", "height"))
        return None if ellipsoid is None or sea is None or ellipsoid == sea else ellipsoid - sea  # some copy them

    def orders(self) -> Iterator[Order]:
        """Yield what the drone is told, from the take-off on."""
        config, last = self.config, len(self.marks)
        rise, actions = self.number(config, "takeOffSecurityHeight", 0.0), self._actions()
        if rise is not None:
            place = (math.nan, math.nan, AboveHome(rise))
            yield Order(0, OrderKind.TAKEOFF, text(config, "flyToWaylineMode"), place=place)
        yield from actions[BEFORE]
        for k, mark in enumerate(self.marks):
            yield self._waypoint(mark, k)
            yield from actions[k]
        finish = text(config, "finishAction") or "noAction"
        ends = {"autoLand": (math.nan, math.nan, AboveHome(0.0)), "gotoFirstWaypoint": self._place(self.marks[0], 0)}
        if finish != "noAction":
            yield Order(last, FINISH_ACTIONS.get(finish, OrderKind.OTHER), finish, place=ends.get(finish))

    def _own(self, mark: Element, flag: str, path: str, common: str) -> str:
        """Return what a waypoint has itself, or, where it says so or has nothing, what all have in common."""
        return ("" if text(mark, flag) == "1" else text(mark, path)) or self.common.get(common, "")

    def _place(self, mark: Element, k: int) -> GlobalPlace:
        tag = "executeHeight" if self.executed else "ellipsoidHeight" if self.mode == "WGS84" else "height"
        longitude, latitude, *_ = [*text(mark, "Point/coordinates").split(","), ""]
        row = (latitude, longitude, self._own(mark, "useGlobalHeight", tag, "globalHeight"))
        place = parse_place(row, HEIGHT_MODES[self.mode], f"{self.where}: waypoint {k + 1}")
        if self.mode != "WGS84":
            return place
        geoid = self.geoid_at(k)
        if geoid is None:
            said = f"{self.where}: has heights above the ellipsoid"
            raise InputError(said, give=[Remedy("geoid", None, "for how far mean sea level lies above it there")])
        return *place[:2], AboveSea(place[2].metres - geoid)

    def _waypoint(self, mark: Element, k: int) -> Order:
        turn = self._own(mark, "useGlobalTurnParam", "waypointTurnParam/waypointTurnMode", "globalWaypointTurnMode")
        straight = self._own(mark, "", "useStraightLine", "globalUseStraightLine") == "1" or turn == "coordinateTurn"
        damped = turn in ("coordinateTurn", "toPointAndPassWithContinuityCurvature") and straight
        speed = self._own(mark, "useGlobalSpeed", "waypointSpeed", "autoFlightSpeed")
        turned = text(mark, "waypointHeadingParam/waypointHeadingMode") == "smoothTransition"
        return Order(
            k + 1,
            OrderKind.WAYPOINT,
            turn or "waypoint",
            place=self._place(mark, k),
            radius=self.number(mark, "waypointTurnParam/waypointTurnDampingDist", 0.0) if damped else None,
            seconds=MOMENT if turn.startswith("toPointAndStop") else 0.0,
            speed=(parse_number(speed, f"{self.where}: waypoint {k + 1}: speed", 0.0) or None) if speed else None,
            heading=self.number(mark, "waypointHeadingParam/waypointHeadingAngle") if turned else None,
            curved=not (straight or turn == STOP),
        )

    def _actions(self) -> dict[int, list[Order]]:
        """Return the orders of all groups of actions, by the index of the waypoint after which they come."""
        found: dict[int, list[Order]] = defaultdict(list)
        for group in [*each(self.folder, "startActionGroup"), *each(self.folder, "actionGroup")]:
            first, last = BEFORE, BEFORE
            if not group.tag.endswith("startActionGroup"):
                tags, most = ("actionGroupStartIndex", "actionGroupEndIndex"), len(self.marks) - 1
                first, last = (int(parse_number(text(group, tag), f"{self.where}: {tag!r}", 0, most)) for tag in tags)
            trigger = text(group, "actionTrigger/actionTriggerType")
            spacing = self.number(group, "actionTrigger/actionTriggerParam", 0.0)
            if trigger == "multipleTiming":
                speed = self.number(self.marks[first], "waypointSpeed", 0.0)
                spacing = spacing * speed if spacing and speed else None
            for action in each(group, "action"):
                name = text(action, "actionActuatorFunc")
                kind, params = ACTIONS.get(name, OrderKind.OTHER), "actionActuatorFuncParam/"
                hover = self.number(action, params + "hoverTime", 0.0) if name == "hover" else None
                yaw = self.number(action, params + "aircraftHeading") if name == "rotateYaw" else None
                apart = spacing if trigger.startswith("multiple") and kind is OrderKind.CAMERA else None
                found[first].append(Order(first + 1, kind, name, seconds=hover or 0.0, heading=yaw, spacing=apart))
                if apart is not None:
                    found[last].append(Order(last + 1, kind, name, spacing=0.0))
        return found


def _is_dji(inner: str) -> bool:
    return inner.rpartition("/")[2] in ("waylines.wpml", "template.kml")


def _files(content: bytes, name: str) -> dict[str, bytes]:
    """Return DJI's files in an archive, or else its KML file."""

    def choose(names: list[str]) -> list[str]:
        kml = sorted((one for one in names if one.lower().endswith(".kml")), key=lambda one: one != "doc.kml")
        return sorted(filter(_is_dji, names), reverse=True) or kml[:1]

    found = unpacked(io.BytesIO(content), name, choose)
    if not found:
        raise InputError(f"{name}: expected wpmz/waylines.wpml or a .kml file inside, found none")
    return found


def _wayline(content: bytes, where: str) -> _Wayline | None:
    """Return the wayline of a file, ``None`` of a template without waypoints."""
    root, executed = root_of(content, where), where.endswith(".wpml")
    folders = [one for one in each(root, "Folder") if find(one, "Placemark") is not None]
    if not executed and any((text(one, "templateType") or "waypoint") != "waypoint" for one in folders):
        return None
    if len(folders) > 1 or (executed and not folders):
        raise InputError(f"{where}: expected one wayline with waypoints, found {len(folders)}")
    configs = each(root, "missionConfig")
    if not folders or not configs:
        return None
    line = _Wayline(root, configs[0], folders[0], where)
    for k, mark in enumerate(line.marks):
        if text(mark, "index") != str(k):
            raise InputError(f"{where}: waypoint {k + 1}: 'index': expected {k}, found {shown(text(mark, 'index'))}")
    return line


def read_kmz(content: bytes, name: str, given: Given) -> Waypoints:
    """Return the orders of a ``.kmz``: of DJI's waylines, or else of the template, or else of the KML file in it."""
    files = _files(content, name)
    if not any(map(_is_dji, files)):
        return read_route(next(iter(files.values())), name, given)
    lines = [one for inner, part in files.items() if (one := _wayline(part, f"{name}: {inner}")) is not None]
    if not lines:
        raise InputError(f"{name}: expected waylines, or a template with waypoints; save it anew in DJI Pilot 2")
    line, template = lines[0], lines[-1]
    if line.mode not in HEIGHT_MODES:
        raise InputError(f"{name}: height mode: expected {', '.join(HEIGHT_MODES)}, found {shown(line.mode)}")
    line.geoid = given.geoid
    if template.mode == "EGM96" and len(template.marks) == len(line.marks):
        line.pairs = template.marks
    home = None
    start = next(filter(None, (text(one.config, "takeOffRefPoint") for one in lines)), "0,0")
    latitude, longitude, height = parse_place([*start.split(","), "0", "0"], AboveSea, f"{name}: 'takeOffRefPoint'")
    if latitude or longitude:
        geoid = line.geoid_at(0)
        home = latitude, longitude, None if geoid is None else height.metres - geoid
    orders = tuple(replace(order, item=k) for k, order in enumerate(line.orders()))
    common = line.number(line.folder, "autoFlightSpeed", 0.0)
    speed, back = (line.number(line.config, tag, 0.0) for tag in ("globalTransitionalSpeed", "globalRTHHeight"))
    return Waypoints(name, orders, home, speed or common or None, "dji", return_altitude=back)


def kmz_content(waypoints: Waypoints, before: Waypoints) -> bytes:
    """Return the archive that was read with the places of orders put into waylines and template."""
    name = waypoints.name
    files = _files(waypoints.stored, name)
    if not any(map(_is_dji, files)):
        parts = {inner: route_content(replace(waypoints, stored=part), before) for inner, part in files.items()}
        return repacked(waypoints.stored, name, parts)
    lines = {inner: _wayline(part, f"{name}: {inner}") for inner, part in files.items()}
    count = next(len(one.marks) for one in lines.values() if one is not None)
    places = [k for k, one in enumerate(before.orders) if one.kind is OrderKind.WAYPOINT][:count]
    made = list(steps(before, waypoints, places))
    rise = waypoints.orders[0].place if waypoints.orders[0].kind is OrderKind.TAKEOFF else None
    settings = {"takeOffSecurityHeight": rise and rise[2].metres, "globalRTHHeight": waypoints.return_altitude}
    parts = {}
    for inner, line in lines.items():
        if line is not None and len(line.marks) == count:
            for tag, metres in settings.items():
                if metres is not None:
                    if find(line.config, tag) is None:
                        line.config.append(Element(line.config.tag.replace("missionConfig", tag)))
                    set_text(line.config, tag, written(metres, 4))
            parts[inner] = _changed(line, made)
    return repacked(waypoints.stored, name, parts)


def _changed(line: _Wayline, made: list[Step]) -> bytes:
    """Return a file with its waypoints moved and added, and all indices counted anew."""
    numbers = {str(step.source): str(k) for k, step in enumerate(made) if not step.new}

    def put(mark: Element, step: Step) -> None:
        if step.stops:
            set_text(mark, "waypointTurnParam/waypointTurnMode", STOP)
            set_text(mark, "useStraightLine", "1")
            set_text(mark, "useGlobalTurnParam", str(int(find(mark, "waypointTurnParam") is None)))
        if step.stops or step.turns is not None:
            set_text(mark, "waypointTurnParam/waypointTurnDampingDist", written(step.turns or 0.0, 2))
        if not step.moved:
            return
        latitude, longitude, _ = step.place
        rest = text(mark, "Point/coordinates").split(",")[2:]
        set_text(mark, "Point/coordinates", ",".join([written(longitude), written(latitude), *rest]))
        common = text(mark, "useGlobalHeight") == "1"
        for tag in ("executeHeight", "height", "ellipsoidHeight") if step.rise else ():
            former = line.common.get("globalHeight") if common and tag == "height" else text(mark, tag)
            metres = parse_number(former or "0", f"{line.where}: {tag!r}") + step.rise
            set_text(mark, tag, written(metres, 4))
        if common and step.rise and find(mark, "height") is not None:
            set_text(mark, "useGlobalHeight", "0")

    for k, (mark, step) in enumerate(zip(arrange(line.root, line.marks, made, put), made, strict=True)):
        set_text(mark, "index", str(k))
        for group in each(mark, "actionGroup"):
            if step.new:
                mark.remove(group)
            for tag in ("actionGroupStartIndex", "actionGroupEndIndex"):
                set_text(group, tag, numbers.get(text(group, tag), text(group, tag)))
    return written_root(line.root)
