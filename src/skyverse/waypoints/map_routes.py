"""Routes on maps, KML and GPX: one line of places, or KML's points in order; read, and written with changes."""

import re
from collections.abc import Iterator
from typing import NamedTuple
from xml.etree.ElementTree import Element

from skyverse.errors import InputError, Remedy, shown
from skyverse.model.altitude import AboveGround, AboveSea, Altitude
from skyverse.model.waypoints import Order, OrderKind, Waypoints
from skyverse.waypoints.places import REFERENCES, Given, Step, parse_place, steps, written
from skyverse.waypoints.xml_text import XmlText, child

_NOT_OF_THE_MODE = {"absolute": AboveSea, "relativeToGround": AboveGround, "clampToGround": None}


def read_kml(content: bytes, name: str, given: Given) -> Waypoints:
    """Return the places of the only line of a KML file as waypoints, or of its points if it has no line."""
    marks = _kml_marks(XmlText(content, name).root, name)
    rows = [(mark, text) for mark in marks for text in (child(mark.shape, "coordinates") or "").split()]
    orders = []
    for k, (mark, text) in enumerate(rows):
        where = f"{name}: {mark.shape.tag}, place {k + 1}"
        numbers = text.split(",")
        if len(numbers) != 3:
            raise InputError(f"{where}: expected longitude,latitude,altitude, found {shown(text)}")
        place = parse_place((numbers[1], numbers[0], numbers[2]), _kml_reference(mark.shape, name, given), where)
        orders.append(Order(k + 1, OrderKind.WAYPOINT, mark.name or mark.shape.tag, k, place))
    return Waypoints(name, tuple(orders), stored=content, altitude=given.altitude, geoid=given.geoid)


class _Mark(NamedTuple):
    """A line or a point, with the placemark that holds it alone, or else itself, and the placemark's name."""

    shape: Element
    holder: Element
    name: str


def _kml_marks(root: Element, name: str) -> list[_Mark]:
    """Return the only line, or else all points."""
    found = {
        tag: [
            _Mark(shape, mark if len(list(mark.iter(tag))) == 1 else shape, child(mark, "name") or "")
            for mark in root.iter("Placemark")
            for shape in mark.iter(tag)
        ]
        for tag in ("LineString", "Point")
    }
    lines = found["LineString"]
    if len(lines) > 1:
        raise InputError(f"{name}: expected one line, found {len(lines)}: {shown([line.name for line in lines], 120)}")
    marks = lines or found["Point"]
    if not marks:
        raise InputError(f"{name}: expected a line or points, found none")
    return marks


def _kml_reference(shape: Element, name: str, given: Given) -> type[Altitude]:
    mode = child(shape, "altitudeMode") or "clampToGround"
    if mode not in _NOT_OF_THE_MODE:
        raise InputError(f"{name}: 'altitudeMode': expected {', '.join(_NOT_OF_THE_MODE)}, found {shown(mode)}")
    return _NOT_OF_THE_MODE[mode] or _told(f"{name}: has no altitudes, since its altitudeMode is {mode}", given)


def _told(said: str, given: Given) -> type[Altitude]:
    if given.altitude is None:
        raise InputError(said, give=[Remedy("altitude", None, "(amsl, home or agl) for what its numbers count from")])
    return REFERENCES[given.altitude]


def kml_content(waypoints: Waypoints) -> bytes:
    """Return the KML file that was read with the places of orders put in."""
    document, name = XmlText(waypoints.stored, waypoints.name), waypoints.name
    marks = _kml_marks(document.root, name)
    made = list(_steps(read_kml(waypoints.stored, name, Given(waypoints.altitude, waypoints.geoid)), waypoints))
    if marks[0].shape.tag == "Point":
        for step in made:
            mark = marks[step.source].holder
            fragment = XmlText(document.source(mark), name) if step.new else document
            point = next(fragment.root.iter("Point")) if step.new else marks[step.source].shape
            if step.new or step.moved:
                fragment.set_text(_coordinates(point), _kml_place(step))
            if step.new:
                document.insert(mark, fragment.changed(), before=_ahead(made, step))
        return document.changed()
    line = _coordinates(marks[0].shape)
    texts = re.findall(r"\s*\S+", line.text or "")
    blank = re.match(r"\s*", texts[-1])
    assert blank is not None
    rows = [
        (blank[0] or " ") + _kml_place(step)
        if step.new
        else re.sub(r"\S+", _kml_place(step), texts[step.source])
        if step.moved
        else texts[step.source]
        for step in made
    ]
    document.set_text(line, "".join(rows) + (line.text or "")[len("".join(texts)) :])
    return document.changed()


def _steps(before: Waypoints, after: Waypoints) -> Iterator[Step]:
    return steps(before, after, range(len(before.orders)))


def _ahead(made: list[Step], step: Step) -> bool:
    """Tell whether a place that is added comes before all places of the file."""
    return next(one for one in made if not one.new or one is step) is step


def _coordinates(shape: Element) -> Element:
    found = shape.find("coordinates")
    assert found is not None
    return found


def _kml_place(step: Step) -> str:
    latitude, longitude, altitude = step.place
    return f"{written(longitude)},{written(latitude)},{written(altitude.metres, 4)}"


def read_gpx(content: bytes, name: str, given: Given) -> Waypoints:
    """Return the points of the only route or track of a GPX file as waypoints."""
    points = _gpx_points(XmlText(content, name).root, name)
    kind = _told(f"{name}: does not say what its elevations are counted from", given)
    orders = []
    for k, point in enumerate(points):
        row = (point.get("lat"), point.get("lon"), child(point, "ele"))
        place = parse_place(row, kind, f"{name}: point {k + 1}")
        orders.append(Order(k + 1, OrderKind.WAYPOINT, child(point, "name") or point.tag, k, place))
    return Waypoints(name, tuple(orders), stored=content, altitude=given.altitude, geoid=given.geoid)


def _gpx_points(root: Element, name: str) -> list[Element]:
    if root.tag != "gpx":
        raise InputError(f"{name}: expected a GPX file, whose first element is gpx, found {shown(root.tag)}")
    lines = [*root.findall("rte"), *root.findall("trk")]
    if len(lines) != 1:
        names = f": {shown([child(line, 'name') or '' for line in lines], 120)}" if lines else ""
        raise InputError(f"{name}: expected one route or track, found {len(lines)}{names}")
    points = [*lines[0].iter("rtept"), *lines[0].iter("trkpt")]
    if not points:
        raise InputError(f"{name}: expected a route or track with points, found none")
    return points


def gpx_content(waypoints: Waypoints) -> bytes:
    """Return the GPX file that was read with the places of orders put in."""
    document, name = XmlText(waypoints.stored, waypoints.name), waypoints.name
    points = _gpx_points(document.root, name)
    made = list(_steps(read_gpx(waypoints.stored, name, Given(waypoints.altitude, waypoints.geoid)), waypoints))
    for step in made:
        point = points[step.source]
        fragment = XmlText(document.source(point), name) if step.new else document
        target = fragment.root if step.new else point
        if step.new or step.moved:
            latitude, longitude, altitude = step.place
            fragment.set_attribute(target, "lat", written(latitude))
            fragment.set_attribute(target, "lon", written(longitude))
            fragment.set_text(next(target.iter("ele")), written(altitude.metres, 4))
        if step.new:
            document.insert(point, fragment.changed(), before=_ahead(made, step))
    return document.changed()
