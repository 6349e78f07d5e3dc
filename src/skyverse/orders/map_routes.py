"""Routes on maps, KML and GPX: one line of places, or KML's points in order; read, and written with changes."""

from collections.abc import Iterator
from typing import NamedTuple
from xml.etree.ElementTree import Element

from skyverse.errors import InputError, Remedy, shown
from skyverse.model.altitude import REFERENCES, AboveGround, AboveSea, Altitude
from skyverse.model.waypoints import Order, OrderKind, Waypoints
from skyverse.orders.places import Given, Step, parse_place, steps, written
from skyverse.orders.xml_places import arrange, each, local_name, root_of, set_text, text, written_root

ALTITUDE_MODES = {"absolute": AboveSea, "relativeToGround": AboveGround, "clampToGround": None}


class _Mark(NamedTuple):
    """A line or a point, with the placemark that holds it alone, or else itself, and its name."""

    shape: Element
    holder: Element
    name: str


def _marks(root: Element, name: str) -> list[_Mark]:
    """Return the points of the only route or track of GPX, and of KML the only line, or else all points."""
    if local_name(root) == "gpx":
        what, whole, lines = "route or track", "a route or track with points", [*each(root, "rte"), *each(root, "trk")]
        places = [place for line in lines for tag in ("rtept", "trkpt") for place in each(line, tag)]
        found = [_Mark(place, place, text(place, "name") or place.tag) for place in places]
        names = [text(line, "name") for line in lines]
    else:
        what, whole = "line", "a line or points"
        shapes, points = (
            [
                _Mark(shape, mark if len(each(mark, tag)) == 1 else shape, text(mark, "name") or "place")
                for mark in each(root, "Placemark")
                for shape in each(mark, tag)
            ]
            for tag in ("LineString", "Point")
        )
        found, names = shapes or points, [line.name for line in shapes]
    if len(names) > 1:
        raise InputError(f"{name}: expected one {what}, found {len(names)}: {shown(names, 120)}")
    if not found:
        raise InputError(f"{name}: expected {whole}, found none")
    return found


def read_route(content: bytes, name: str, given: Given) -> Waypoints:
    """Return the places of the only line of a KML or GPX file as waypoints, or of KML's points if it has no line."""
    orders: list[Order] = []
    for mark in _marks(root_of(content, name), name):
        kind, rows = _places(mark.shape, name, given)
        for row in rows:
            place = parse_place(row, kind, f"{name}: place {len(orders) + 1}")
            orders.append(Order(len(orders) + 1, OrderKind.WAYPOINT, mark.name, len(orders), place))
    return Waypoints(name, tuple(orders))


def _places(shape: Element, name: str, given: Given) -> tuple[type[Altitude], Iterator[tuple[str | None, ...]]]:
    """Return what altitudes are counted from, and the latitude, longitude and altitude of each place as texts."""
    kind, said = None, "does not say what its elevations are counted from"
    rows = iter([(shape.get("lat"), shape.get("lon"), text(shape, "ele"))])
    if "lat" not in shape.attrib:
        mode = text(shape, "altitudeMode") or "clampToGround"
        if mode not in ALTITUDE_MODES:
            raise InputError(f"{name}: 'altitudeMode': expected {', '.join(ALTITUDE_MODES)}, found {shown(mode)}")
        kind, said = ALTITUDE_MODES[mode], f"has no altitudes, since its altitudeMode is {mode}"
        parts = ([*row.split(","), "", ""] for row in text(shape, "coordinates").split())
        rows = ((latitude, longitude, altitude) for longitude, latitude, altitude, *_ in parts)
    if kind is None and given.altitude is None:
        remedy = Remedy("altitude", None, "(amsl, home or agl) for what its numbers count from")
        raise InputError(f"{name}: {said}", give=[remedy])
    return kind or REFERENCES[given.altitude or ""], rows


def route_content(waypoints: Waypoints, before: Waypoints) -> bytes:
    """Return the KML or GPX file that was read with the places of orders put in."""
    root = root_of(waypoints.stored, waypoints.name)
    marks = _marks(root, waypoints.name)
    made = list(steps(before, waypoints, range(len(before.orders))))

    def put(holder: Element, step: Step) -> None:
        if step.moved and "lat" in holder.attrib:
            latitude, longitude, altitude = step.place
            holder.attrib.update(lat=written(latitude), lon=written(longitude))
            set_text(holder, "ele", written(altitude.metres, 4))
        elif step.moved:
            set_text(each(holder, "Point")[0], "coordinates", _coordinates(step))

    if local_name(marks[0].shape) == "LineString":
        line = text(marks[0].shape, "coordinates")
        rows = line.split()
        rows = [_coordinates(step) if step.moved else rows[step.source] for step in made]
        set_text(marks[0].shape, "coordinates", ("\n" if "\n" in line else " ").join(rows))
    else:
        arrange(root, [mark.holder for mark in marks], made, put)
    return written_root(root)


def _coordinates(step: Step) -> str:
    latitude, longitude, altitude = step.place
    return f"{written(longitude)},{written(latitude)},{written(altitude.metres, 4)}"
