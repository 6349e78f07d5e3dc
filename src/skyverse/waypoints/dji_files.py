"""DJI's waylines (WPML 1.0.0 to 1.0.6): a ``.kmz`` with the waylines that the drone flies, and the app's template."""

import io
import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from typing import NamedTuple
from xml.etree.ElementTree import Element

from skyverse.documents.kmz import repacked, unpacked
from skyverse.errors import InputError, Remedy, shown
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea, Altitude
from skyverse.model.waypoints import Order, OrderKind, Waypoints
from skyverse.waypoints.map_routes import kml_content, read_kml
from skyverse.waypoints.places import Given, Step, parse_number, parse_place, steps, written
from skyverse.waypoints.xml_text import XmlText, child

HEIGHT_MODES: dict[str, type[Altitude]] = {
    "relativeToStartPoint": AboveHome,
    "EGM96": AboveSea,
    "WGS84": AboveSea,
    "realTimeFollowSurface": AboveGround,
    "aboveGroundLevel": AboveGround,
}
"""What heights count from; those of ``WGS84`` are above the ellipsoid, and are taken down to the sea."""
_K = OrderKind
ACTIONS = {
    "hover": _K.DELAY,
    "rotateYaw": _K.HEADING,
    **dict.fromkeys(("gimbalRotate", "gimbalEvenlyRotate", "gimbalAngleLock", "gimbalAngleUnlock"), _K.GIMBAL),
    **dict.fromkeys(("takePhoto", "startRecord", "stopRecord", "zoom", "focus", "setFocusType"), _K.CAMERA),
    **dict.fromkeys(("orientedShoot", "accurateShoot", "panoShot"), _K.CAMERA),
    **dict.fromkeys(("startContinuousShooting", "stopContinuousShooting"), _K.CAMERA),
    **dict.fromkeys(("startTimeLapse", "stopTimeLapse"), _K.CAMERA),
}
"""The kinds of actions; all others are passed on."""
MOMENT = 0.1
"""Seconds for which a drone that stops at a waypoint is taken to stay there."""


class _Part(NamedTuple):
    """One of the XML files: its document, the folder of its wayline, and that one's waypoints."""

    document: XmlText
    folder: Element
    marks: list[Element]
    executed: bool


def read_kmz(content: bytes, name: str, given: Given) -> Waypoints:
    """Return the orders of a ``.kmz``: of DJI's waylines, or else of the template, or else of the KML file in it."""
    files = _files(content, name)
    kml = [inner for inner in files if not _is_dji(inner)]
    if kml:
        return replace(read_kml(files[kml[0]], name, given), stored=content)
    parts = {inner: _part(text, f"{name}: {inner}") for inner, text in files.items()}
    part = next((one for one in parts.values() if one is not None and one.executed), None)
    part = part or next((one for one in parts.values() if one is not None), None)
    if part is None:
        raise InputError(f"{name}: expected waylines, or a template with waypoints, found none")
    template = next((one for one in parts.values() if one is not None and not one.executed), None)
    config = next((one for one in map(_config, parts.values()) if child(one, "takeOffRefPoint")), _config(part))
    reader = _WaylineReader(part, template, name, given)
    home = None
    if (child(config, "takeOffRefPoint") or "0,0,0").split(",")[:2] != ["0", "0"]:
        row = ((child(config, "takeOffRefPoint") or "") + ",,").split(",")
        latitude, longitude, altitude = parse_place(row, AboveSea, f"{name}: 'takeOffRefPoint'")
        geoid = reader.geoid(0)
        home = latitude, longitude, None if geoid is None else altitude.metres - geoid
    back = child(_config(part), "globalRTHHeight")
    return Waypoints(
        name,
        tuple(replace(order, item=k) for k, order in enumerate(reader.orders())),
        home,
        reader.number(_config(part), "globalTransitionalSpeed") or reader.number(part.folder, "autoFlightSpeed"),
        "dji",
        return_altitude=None if back is None else parse_number(back, f"{name}: 'globalRTHHeight'", 0.0),
        altitude=given.altitude,
        geoid=given.geoid,
        stored=content,
    )


def _is_dji(inner: str) -> bool:
    return inner.lower().rpartition("/")[2] in ("waylines.wpml", "template.kml")


def _files(content: bytes, name: str) -> dict[str, bytes]:
    """Return DJI's files in an archive, or else its KML file."""

    def choose(names: list[str]) -> list[str]:
        dji = sorted(filter(_is_dji, names))
        kml = [inner for inner in names if inner.lower().endswith(".kml")]
        if not kml and not dji:
            raise InputError(f"{name}: expected wpmz/waylines.wpml or a .kml file inside, found none")
        return dji or (["doc.kml"] if "doc.kml" in kml else kml[:1])

    return unpacked(io.BytesIO(content), name, choose)


def _part(text: bytes, where: str) -> _Part | None:
    """Return what a file tells of its wayline, ``None`` for a template without waypoints."""
    document = XmlText(text, where)
    executed = where.lower().endswith(".wpml")
    folders = [one for one in document.root.iter("Folder") if one.find("Placemark") is not None]
    if not executed and any((child(one, "templateType") or "waypoint") != "waypoint" for one in folders):
        return None
    if len(folders) > 1:
        raise InputError(f"{where}: expected one wayline, found {len(folders)}, which are flown one after the other")
    if executed and not folders:
        raise InputError(f"{where}: expected a wayline with waypoints, found none")
    if not folders or next(document.root.iter("missionConfig"), None) is None:
        return None
    marks = folders[0].findall("Placemark")
    for k, mark in enumerate(marks):
        if child(mark, "index") != str(k):
            raise InputError(f"{where}: waypoint {k + 1}: 'index': expected {k}, found {shown(child(mark, 'index'))}")
    return _Part(document, folders[0], marks, executed)


def _config(part: _Part | None) -> Element:
    return Element("missionConfig") if part is None else next(part.document.root.iter("missionConfig"))


class _WaylineReader:
    """Reads the orders of a wayline, or of a template."""

    def __init__(self, part: _Part, template: _Part | None, name: str, given: Given) -> None:
        self._part, self._name, self._given = part, name, given
        modes = "waylineCoordinateSysParam/heightMode"
        self._mode = child(part.folder, "executeHeightMode") or child(part.folder, modes)
        if self._mode not in HEIGHT_MODES:
            raise InputError(f"{name}: height mode: expected {', '.join(HEIGHT_MODES)}, found {shown(self._mode)}")
        pairs = template is not None and child(template.folder, modes) == "EGM96"
        self._pairs = (
            template.marks if template is not None and pairs and len(template.marks) == len(part.marks) else []
        )

    def geoid(self, k: int) -> float | None:
        """Return how far the sea lies above the ellipsoid, as given, or by the two heights of a template's waypoint."""
        if self._given.geoid is not None or not self._pairs:
            return self._given.geoid
        heights = [self.number(self._pairs[k], tag) for tag in ("ellipsoidHeight", "height")]
        ellipsoid, sea = heights
        return None if ellipsoid is None or sea is None or ellipsoid == sea else ellipsoid - sea  # some copy them

    def number(self, parent: Element, path: str, least: float = -math.inf) -> float | None:
        """Return the number that an element within another has, ``None`` where there is none."""
        text = child(parent, path)
        return None if not text else parse_number(text, f"{self._name}: {path.rpartition('/')[2]!r}", least)

    def orders(self) -> Iterator[Order]:
        """Yield what the drone is told, from the take-off on."""
        config, marks = _config(self._part), self._part.marks
        rise = self.number(config, "takeOffSecurityHeight", 0.0)
        if rise is not None:
            mode = child(config, "flyToWaylineMode") or ""
            yield Order(0, OrderKind.TAKEOFF, mode, place=(math.nan, math.nan, AboveHome(rise)))
        actions = self._actions()
        first = None
        for k, mark in enumerate(marks):
            order = self._waypoint(mark, k)
            first = first or order
            yield order
            yield from actions[k]
        finish, last = child(config, "finishAction") or "noAction", len(marks)
        if finish == "goHome":
            yield Order(last, OrderKind.RETURN, finish)
        elif finish == "autoLand":
            yield Order(last, OrderKind.LAND, finish, place=(math.nan, math.nan, AboveHome(0.0)))
        elif finish == "gotoFirstWaypoint" and first is not None:
            yield Order(last, OrderKind.WAYPOINT, finish, place=first.place, seconds=MOMENT)
        elif finish != "noAction":
            yield Order(last, OrderKind.OTHER, finish)

    def _own(self, mark: Element, flag: str, path: str, common: str) -> str | None:
        """Return what a waypoint has itself, or, where it says so or has nothing, what all have in common."""
        own = child(mark, path)
        return child(self._part.folder, common) if own is None or child(mark, flag) == "1" else own

    def _waypoint(self, mark: Element, k: int) -> Order:
        where = f"{self._name}: waypoint {k + 1}"
        tag = "executeHeight" if self._part.executed else "ellipsoidHeight" if self._mode == "WGS84" else "height"
        height = self._own(mark, "useGlobalHeight", tag, "globalHeight")
        row = ((child(mark, "Point/coordinates") or "") + ",").split(",")
        place = parse_place((row[1], row[0], height), HEIGHT_MODES[str(self._mode)], where)
        if self._mode == "WGS84":
            geoid = self.geoid(k)
            if geoid is None:
                said = f"{self._name}: has heights above the ellipsoid"
                raise InputError(said, give=[Remedy("geoid", None, "for how far mean sea level lies above it there")])
            place = (*place[:2], AboveSea(place[2].metres - geoid))
        turn = self._own(mark, "useGlobalTurnParam", "waypointTurnParam/waypointTurnMode", "globalWaypointTurnMode")
        straight = (child(mark, "useStraightLine") or child(self._part.folder, "globalUseStraightLine")) == "1"
        stops, early = (turn or "").startswith("toPointAndStop"), turn == "coordinateTurn"
        passes = early or (straight and turn == "toPointAndPassWithContinuityCurvature")
        radius = self.number(mark, "waypointTurnParam/waypointTurnDampingDist", 0.0) if passes else None
        curved = not (early or straight or turn == "toPointAndStopWithDiscontinuityCurvature")
        speed = self._own(mark, "useGlobalSpeed", "waypointSpeed", "autoFlightSpeed")
        turned = child(mark, "waypointHeadingParam/waypointHeadingMode") == "smoothTransition"
        return Order(
            k + 1,
            OrderKind.WAYPOINT,
            turn or "waypoint",
            place=place,
            radius=radius,
            seconds=MOMENT if stops else 0.0,
            speed=None if not speed else parse_number(speed, f"{where}: 'waypointSpeed'", 0.0) or None,
            heading=self.number(mark, "waypointHeadingParam/waypointHeadingAngle") if turned else None,
            curved=curved,
        )

    def _actions(self) -> dict[int, list[Order]]:
        """Return the orders of all groups of actions, by the index of the waypoint after which they come."""
        found: dict[int, list[Order]] = defaultdict(list)
        for group in chain.from_iterable(mark.iter("actionGroup") for mark in self._part.marks):
            first, last = (self._index(group, f"actionGroup{which}Index") for which in ("Start", "End"))
            trigger = child(group, "actionTrigger/actionTriggerType")
            every = self.number(group, "actionTrigger/actionTriggerParam", 0.0)
            if trigger == "multipleTiming" and every is not None:
                every *= self.number(self._part.marks[first], "waypointSpeed", 0.0) or math.nan
            spacing = every if trigger in ("multipleTiming", "multipleDistance") and every and every == every else None
            for action in group.iter("action"):
                name = child(action, "actionActuatorFunc") or ""
                kind = ACTIONS.get(name, OrderKind.OTHER)
                hover = self.number(action, "actionActuatorFuncParam/hoverTime", 0.0) if name == "hover" else None
                yaw = self.number(action, "actionActuatorFuncParam/aircraftHeading") if name == "rotateYaw" else None
                apart = spacing if kind is OrderKind.CAMERA else None
                found[first].append(Order(first + 1, kind, name, seconds=hover or 0.0, heading=yaw, spacing=apart))
                if apart is not None:
                    found[last].append(Order(last + 1, kind, name, spacing=0.0))
        return found

    def _index(self, group: Element, tag: str) -> int:
        index = self.number(group, tag)
        if index is None or index not in range(len(self._part.marks)):
            raise InputError(
                f"{self._name}: {tag!r}: expected the index of a waypoint, found {shown(child(group, tag))}"
            )
        return int(index)


def kmz_content(waypoints: Waypoints) -> bytes:
    """Return the archive that was read with the places of orders put into waylines and template."""
    name = waypoints.name
    files = _files(waypoints.stored, name)
    (kml, text), *_ = files.items()
    if not _is_dji(kml):
        return repacked(waypoints.stored, name, {kml: kml_content(replace(waypoints, stored=text))})
    before = read_kmz(waypoints.stored, name, Given(waypoints.altitude, waypoints.geoid))
    ends = ("gotoFirstWaypoint",)
    places = [k for k, one in enumerate(before.orders) if one.kind is OrderKind.WAYPOINT and one.name not in ends]
    made = list(steps(before, waypoints, places))
    changed = {}
    for inner, content in files.items():
        part = _part(content, f"{name}: {inner}")
        if part is not None and len(part.marks) == len(places):
            changed[inner] = _changed(part, made)
    return repacked(waypoints.stored, name, changed)


def _changed(part: _Part, made: list[Step]) -> bytes:
    document, marks = part.document, part.marks
    index = {step.source: k for k, step in enumerate(made) if not step.new}
    for k, step in enumerate(made):
        mark = marks[step.source]
        if not step.new:
            if k != step.source:
                document.set_text(_only(mark, "index"), str(k))
            if step.moved:
                _put(document, mark, step, part.folder)
            for tag in ("actionGroupStartIndex", "actionGroupEndIndex"):
                for leaf in mark.iter(tag):
                    if index[int(leaf.text or 0)] != int(leaf.text or 0):
                        document.set_text(leaf, str(index[int(leaf.text or 0)]))
            continue
        fragment = XmlText(document.source(mark), "waypoint")
        fragment.set_text(_only(fragment.root, "index"), str(k))
        _put(fragment, fragment.root, step, part.folder)
        for group in fragment.root.findall("actionGroup"):
            fragment.remove(group)
        document.insert(mark, fragment.changed(), before=k < index[0])
    return document.changed()


def _put(document: XmlText, mark: Element, step: Step, folder: Element) -> None:
    """Move a waypoint of a document: its place, and all its heights by as much."""
    latitude, longitude, _ = step.place
    point = _only(mark, "Point/coordinates")
    rest = (point.text or "").strip().split(",")[2:]
    document.set_text(point, ",".join([written(longitude), written(latitude), *rest]))
    common = child(mark, "useGlobalHeight") == "1"
    for tag in ("executeHeight", "height", "ellipsoidHeight"):
        leaf = mark.find(tag)
        former = child(folder, "globalHeight") if common and tag == "height" else child(mark, tag)
        if leaf is not None and step.rise:
            document.set_text(leaf, written(float(former or 0.0) + step.rise, 4))
    if common and step.rise and mark.find("height") is not None:
        document.set_text(_only(mark, "useGlobalHeight"), "0")


def _only(parent: Element, path: str) -> Element:
    found = parent.find(path)
    assert found is not None
    return found
