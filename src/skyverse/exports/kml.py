"""KML for Google Earth: paths with walls down to the ground, timed tracks, targets, obstacles and zones."""

from xml.etree import ElementTree as ET

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.global_positions import AltitudeReference, GlobalPositions, global_positions
from skyverse.exports.sampling import SampledTrajectory, clock
from skyverse.exports.shape_outlines import Outline, outlines
from skyverse.exports.xml_text import add_text, document_text
from skyverse.model.scenario import Scenario

KML = "http://www.opengis.net/kml/2.2"
GX = "http://www.google.com/kml/ext/2.2"
KML_COLOURS = ("ff2f8bff", "ffd0a020", "ff50c850", "ffc050c0", "ff3030e0", "ffc0c020")
"""Colours of UAVs, as alpha, blue, green and red in hexadecimal digits."""
KML_ALTITUDE_MODES: dict[str, str] = {"amsl": "absolute", "agl": "relativeToGround"}


def kml_text(scenario: Scenario, flights: list[SampledTrajectory], reference: AltitudeReference) -> str:
    """Return a ``.kml`` document."""
    root = ET.Element("kml", {"xmlns": KML, "xmlns:gx": GX})
    document = ET.SubElement(root, "Document")
    add_text(document, "name", scenario.name)
    add_text(document, "description", scenario.description)
    _area_style(document, "obstacle", "b0808080")
    _area_style(document, "zone", "60007fff")
    for flight in flights:
        _line_style(document, f"uav-{flight.uav}", KML_COLOURS[flight.uav % len(KML_COLOURS)])
    paths, tracks = _folder(document, "Paths"), _folder(document, "Tracks")
    for flight in flights:
        at = global_positions(scenario, flight.uav, flight.position, reference)
        _path(paths, flight, at, KML_ALTITUDE_MODES[reference])
        _track(tracks, flight, at, KML_ALTITUDE_MODES[reference])
    targets = _folder(document, "Targets")
    for target in scenario.targets:
        at = global_positions(scenario, 0, np.array([target.position]), reference)
        point = ET.SubElement(_placemark(targets, target.name), "Point")
        add_text(point, "altitudeMode", KML_ALTITUDE_MODES[reference])
        add_text(point, "coordinates", coordinates(at))
    for noun, shapes in (("Obstacles", scenario.obstacles), ("Zones", scenario.zones)):
        folder = _folder(document, noun)
        for outline in outlines(scenario, shapes):
            _area(folder, outline, noun.lower().removesuffix("s"))
    return document_text(root)


def _path(folder: ET.Element, flight: SampledTrajectory, at: GlobalPositions, mode: str) -> None:
    mark = _placemark(folder, flight.name, f"uav-{flight.uav}")
    line = ET.SubElement(mark, "LineString")
    add_text(line, "extrude", "1")
    add_text(line, "altitudeMode", mode)
    add_text(line, "coordinates", coordinates(at))


def _track(folder: ET.Element, flight: SampledTrajectory, at: GlobalPositions, mode: str) -> None:
    track = ET.SubElement(_placemark(folder, flight.name, f"uav-{flight.uav}"), "gx:Track")
    add_text(track, "altitudeMode", mode)
    for seconds in flight.seconds.tolist():
        add_text(track, "when", clock(seconds))
    for row in coordinates(at).split():
        add_text(track, "gx:coord", row.replace(",", " "))


def _area(folder: ET.Element, outline: Outline, style: str) -> None:
    mark = _placemark(folder, outline.name, style)
    polygon = ET.SubElement(mark, "Polygon")
    add_text(polygon, "extrude", "1")
    add_text(polygon, "altitudeMode", "absolute")
    for noun, ring in [("outerBoundaryIs", outline.top), *(("innerBoundaryIs", hole) for hole in outline.holes)]:
        line = ET.SubElement(ET.SubElement(polygon, noun), "LinearRing")
        closed: Floats = np.concatenate([ring, ring[:1]])
        add_text(line, "coordinates", " ".join(f"{y:.9f},{x:.9f},{z:.4f}" for x, y, z in closed))


def coordinates(at: GlobalPositions) -> str:
    """Return global positions as text: longitude,latitude,altitude of each."""
    rows = zip(at.longitude.tolist(), at.latitude.tolist(), at.altitude.tolist(), strict=True)
    return " ".join(f"{x:.9f},{y:.9f},{z:.4f}" for x, y, z in rows)


def _folder(parent: ET.Element, name: str) -> ET.Element:
    folder = ET.SubElement(parent, "Folder")
    add_text(folder, "name", name)
    return folder


def _placemark(parent: ET.Element, name: str, style: str | None = None) -> ET.Element:
    mark = ET.SubElement(parent, "Placemark")
    add_text(mark, "name", name)
    if style is not None:
        add_text(mark, "styleUrl", f"#{style}")
    return mark


def _line_style(document: ET.Element, name: str, colour: str) -> None:
    style = ET.SubElement(document, "Style", {"id": name})
    line = ET.SubElement(style, "LineStyle")
    add_text(line, "color", colour)
    add_text(line, "width", "3")
    add_text(ET.SubElement(style, "PolyStyle"), "color", "40" + colour[2:])


def _area_style(document: ET.Element, name: str, colour: str) -> None:
    style = ET.SubElement(document, "Style", {"id": name})
    add_text(ET.SubElement(style, "PolyStyle"), "color", colour)
