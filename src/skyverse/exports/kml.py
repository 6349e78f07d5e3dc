"""KML for Google Earth: paths with walls down to the ground, timed tracks, targets, obstacles and zones."""

from collections.abc import Iterable
from xml.etree import ElementTree as ET

from skyverse.exports.global_positions import AltitudeReference, global_positions, targets_on_globe
from skyverse.exports.sampling import SampledTrajectory, clock
from skyverse.exports.shape_outlines import Outline, outlines
from skyverse.exports.xml_text import add_texts, document_text
from skyverse.model.scenario import Scenario

KML = "http://www.opengis.net/kml/2.2"
GX = "http://www.google.com/kml/ext/2.2"
KML_COLOURS = ("ff2f8bff", "ffd0a020", "ff50c850", "ffc050c0", "ff3030e0", "ffc0c020")
"""Colours of UAVs, as alpha, blue, green and red in hexadecimal digits."""
KML_ALTITUDE_MODES: dict[str, str] = {"amsl": "absolute", "agl": "relativeToGround"}


def kml_text(scenario: Scenario, flights: list[SampledTrajectory], reference: AltitudeReference) -> str:
    """Return a ``.kml`` document."""
    root, mode = ET.Element("kml", {"xmlns": KML, "xmlns:gx": GX}), KML_ALTITUDE_MODES[reference]
    document = ET.SubElement(root, "Document")
    add_texts(document, name=scenario.name, description=scenario.description)
    _area_style(document, "obstacle", "b0808080")
    _area_style(document, "zone", "60007fff")
    for flight in flights:
        _line_style(document, f"uav-{flight.uav}", KML_COLOURS[flight.uav % len(KML_COLOURS)])
    paths, tracks = _folder(document, "Paths"), _folder(document, "Tracks")
    for flight in flights:
        at = global_positions(scenario, flight.uav, flight.position, reference)
        places = [coordinates(place) for place in at.rows]
        line = ET.SubElement(_placemark(paths, flight.name, f"uav-{flight.uav}"), "LineString")
        add_texts(line, extrude="1", altitudeMode=mode, coordinates=" ".join(places))
        track = ET.SubElement(_placemark(tracks, flight.name, f"uav-{flight.uav}"), "gx:Track")
        add_texts(track, altitudeMode=mode)
        for seconds in flight.seconds.tolist():
            add_texts(track, when=clock(seconds))
        for text in places:
            add_texts(track, "gx:", coord=text.replace(",", " "))
    targets = _folder(document, "Targets")
    for name, place in targets_on_globe(scenario, reference):
        add_texts(ET.SubElement(_placemark(targets, name), "Point"), altitudeMode=mode, coordinates=coordinates(place))
    for noun, shapes in (("Obstacles", scenario.obstacles), ("Zones", scenario.zones)):
        folder = _folder(document, noun)
        for outline in outlines(scenario, shapes):
            _area(folder, outline, noun.lower().removesuffix("s"))
    return document_text(root)


def _area(folder: ET.Element, outline: Outline, style: str) -> None:
    polygon = ET.SubElement(_placemark(folder, outline.name, style), "Polygon")
    add_texts(polygon, extrude="1", altitudeMode="absolute")
    for noun, ring in [("outerBoundaryIs", outline.top), *(("innerBoundaryIs", hole) for hole in outline.holes)]:
        line = ET.SubElement(ET.SubElement(polygon, noun), "LinearRing")
        add_texts(line, coordinates=" ".join(map(coordinates, [*ring, ring[0]])))


def coordinates(place: Iterable[float]) -> str:
    """Return latitude, longitude and altitude as KML writes them: longitude,latitude,altitude."""
    latitude, longitude, altitude = place
    return f"{longitude:.9f},{latitude:.9f},{altitude:.4f}"


def _folder(parent: ET.Element, name: str) -> ET.Element:
    folder = ET.SubElement(parent, "Folder")
    add_texts(folder, name=name)
    return folder


def _placemark(parent: ET.Element, name: str, style: str | None = None) -> ET.Element:
    mark = ET.SubElement(parent, "Placemark")
    add_texts(mark, name=name, **({} if style is None else {"styleUrl": f"#{style}"}))
    return mark


def _line_style(document: ET.Element, name: str, colour: str) -> None:
    style = ET.SubElement(document, "Style", {"id": name})
    add_texts(ET.SubElement(style, "LineStyle"), color=colour, width="3")
    add_texts(ET.SubElement(style, "PolyStyle"), color="40" + colour[2:])


def _area_style(document: ET.Element, name: str, colour: str) -> None:
    style = ET.SubElement(document, "Style", {"id": name})
    add_texts(ET.SubElement(style, "PolyStyle"), color=colour)
