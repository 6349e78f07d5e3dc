"""Routes on maps, KML and GPX: one line of places, or KML's points in order; read, and written with changes."""

from typing import NamedTuple
from xml.etree.ElementTree import Element

from skyverse.errors import InputError, Remedy, shown
from skyverse.model.altitude import AboveGround, AboveSea, Altitude
from skyverse.model.waypoints import Order, OrderKind, Waypoints
from skyverse.orders.places import REFERENCES, Given, Step, parse_place, steps, written
from skyverse.orders.xml_places import arrange, each, root_of, set_text, text, written_root

ALTITUDE_MODES = {"absolute": AboveSea, "relativeToGround": AboveGround, "clampToGround": None}


class _Mark(NamedTuple):
    """A line or a point, with the placemark that holds it alone, or else itself, and the placemark's name."""

    shape: Element
    holder: Element
    name: str


def _told(said: str, given: Given) -> type[Altitude]:
    if given.altitude is None:
        raise InputError(said, give=[Remedy("altitude", None, "(amsl, home or agl) for what its numbers count from")])
    return REFERENCES[given.altitude]


def _kml_marks(root: Element, name: str) -> list[_Mark]:
    """Return the only line, or else all points."""
    lines, points = (
        [
            _Mark(shape, mark if len(each(mark, tag)) == 1 else shape, text(mark, "name"))
            for mark in each(root, "Placemark")
            for shape in each(mark, tag)
        ]
        for tag in ("LineString", "Point")
    )
    if len(lines) > 1:
        raise InputError(f"{name}: expected one line, found {len(lines)}: {shown([line.name for line in lines], 120)}")
    if not (lines or points):
        raise InputError(f"{name}: expected a line or points, found none")
    return lines or points


def read_kml(content: bytes, name: str, given: Given) -> Waypoints:
    """Return the places of the only line of a KML file as waypoints, or of its points if it has no line."""
    orders: list[Order] = []
    for mark in _kml_marks(root_of(content, name), name):
        mode = text(mark.shape, "altitudeMode") or "clampToGround"
        if mode not in ALTITUDE_MODES:
            raise InputError(f"{name}: 'altitudeMode': expected {', '.join(ALTITUDE_MODES)}, found {shown(mode)}")
        kind = ALTITUDE_MODES[mode] or _told(f"{name}: has no altitudes, since its altitudeMode is {mode}", given)
        for row in text(mark.shape, "coordinates").split():
            longitude, latitude, altitude, *_ = [*row.split(","), *[""] * 3]
            where = f"{name}: place {len(orders) + 1}"
            place = parse_place((latitude, longitude, altitude), kind, where)
            orders.append(Order(len(orders) + 1, OrderKind.WAYPOINT, mark.name or "place", len(orders), place))
    return Waypoints(name, tuple(orders))


def kml_content(waypoints: Waypoints, before: Waypoints) -> bytes:
    """Return the KML file that was read with the places of orders put in."""
    root = root_of(waypoints.stored, waypoints.name)
    marks = _kml_marks(root, waypoints.name)
    made = list(steps(before, waypoints, range(len(before.orders))))
    if len(marks) == len(before.orders) > 1:

        def put(holder: Element, step: Step) -> None:
            if step.moved:
                set_text(each(holder, "Point")[0], "coordinates", _coordinates(step))

        arrange(root, [mark.holder for mark in marks], made, put)
        return written_root(root)
    line = text(marks[0].shape, "coordinates")
    rows = line.split()
    rows = [_coordinates(step) if step.moved else rows[step.source] for step in made]
    set_text(marks[0].shape, "coordinates", ("\n" if "\n" in line else " ").join(rows))
    return written_root(root)


def _coordinates(step: Step) -> str:
    latitude, longitude, altitude = step.place
    return f"{written(longitude)},{written(latitude)},{written(altitude.metres, 4)}"


def read_gpx(content: bytes, name: str, given: Given) -> Waypoints:
    """Return the points of the only route or track of a GPX file as waypoints."""
    kind: type[Altitude] | None = None
    orders: list[Order] = []
    for k, point in enumerate(_gpx_points(root_of(content, name), name)):
        kind = kind or _told(f"{name}: does not say what its elevations are counted from", given)
        row = (point.get("lat"), point.get("lon"), text(point, "ele"))
        place = parse_place(row, kind, f"{name}: point {k + 1}")
        orders.append(Order(k + 1, OrderKind.WAYPOINT, text(point, "name") or point.tag, k, place))
    return Waypoints(name, tuple(orders))


def _gpx_points(root: Element, name: str) -> list[Element]:
    if root.tag.rpartition(":")[2] != "gpx":
        raise InputError(f"{name}: expected a GPX file, whose first element is gpx, found {shown(root.tag)}")
    lines = [*each(root, "rte"), *each(root, "trk")]
    if len(lines) != 1:
        names = shown([text(line, "name") for line in lines], 120)
        raise InputError(f"{name}: expected one route or track, found {len(lines)}: {names}")
    points = [*each(lines[0], "rtept"), *each(lines[0], "trkpt")]
    if not points:
        raise InputError(f"{name}: expected a route or track with points, found none")
    return points


def gpx_content(waypoints: Waypoints, before: Waypoints) -> bytes:
    """Return the GPX file that was read with the places of orders put in."""
    root = root_of(waypoints.stored, waypoints.name)

    def put(point: Element, step: Step) -> None:
        if step.moved:
            latitude, longitude, altitude = step.place
            point.attrib.update(lat=written(latitude), lon=written(longitude))
            set_text(point, "ele", written(altitude.metres, 4))

    made = list(steps(before, waypoints, range(len(before.orders))))
    arrange(root, _gpx_points(root, waypoints.name), made, put)
    return written_root(root)
