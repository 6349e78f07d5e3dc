"""Formats of maps: KML for Google Earth, GeoJSON (RFC 7946), GPX 1.1, and a table of latitudes and longitudes (CSV)."""

import csv
import io
import json
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple
from xml.etree import ElementTree as ET

import numpy as np

from skyverse._typing import Floats
from skyverse.draw import footprint
from skyverse.exports.global_positions import AltitudeReference, geoid_of, global_positions, origin_of, targets_on_globe
from skyverse.exports.sampled_formats import EPOCH, SampledTrajectory, clock
from skyverse.model.geodesy import to_wgs84
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import Box, Cylinder, Prism, Shape, Sphere


def add_texts(parent: ET.Element, prefix: str = "", /, **texts: str) -> None:
    """Append elements that contain texts, without the characters that XML cannot contain.

    Parameters
    ----------
    parent
        The element to which they are appended.
    prefix
        What stands before their names, such as ``"gx:"``.
    texts
        The texts by the elements' names.
    """
    for tag, text in texts.items():
        ET.SubElement(parent, prefix + tag).text = "".join(
            c for c in text if c in "\t\n" or ("\x20" <= c <= "\ud7ff") or "\ue000" <= c <= "\ufffd" or c > "\uffff"
        )


def document_text(root: ET.Element) -> str:
    """Return an indented XML document."""
    ET.indent(root, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


CIRCLE_CORNERS = 32
"""The number of corners of the polygon that stands for a circle."""


class Outline(NamedTuple):
    """The outline of a shape, seen from above.

    Attributes
    ----------
    name, kind
        As in the scenario; a shape without a name gets one from its kind and number.
    top, bottom
        (n, 3) latitude, longitude, metres above mean sea level; counter-clockwise, without repeating the first corner.
    holes
        (k, 3) each, as `top`, but clockwise.
    """

    name: str
    kind: str
    top: Floats
    bottom: Floats
    holes: tuple[Floats, ...]


def outlines(scenario: Scenario, shapes: Sequence[Shape]) -> Iterator[Outline]:
    """Yield the outlines of shapes; voxels have none."""
    origin = origin_of(scenario)
    for number, shape in enumerate(shapes, 1):
        if not isinstance(shape, Box | Cylinder | Prism | Sphere):
            continue
        (low, high), (ring, *holes) = extent(shape), footprint(shape, CIRCLE_CORNERS)
        top, bottom, *inner = (
            to_wgs84(origin, np.column_stack([edge, np.full(len(edge), z)]))
            for edge, z in [(ring, high[2]), (ring, low[2]), *((hole, high[2]) for hole in holes)]
        )
        yield Outline(shape.name or f"{shape.kind or 'shape'} {number}", shape.kind or "", top, bottom, tuple(inner))


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


def geojson_text(scenario: Scenario, flights: list[SampledTrajectory], _: AltitudeReference = "amsl") -> str:
    """Return a ``.geojson`` text, whose heights are above the ellipsoid, as the standard requires."""
    geoid = geoid_of(scenario, "GeoJSON")
    features = []
    for flight in flights:
        at = global_positions(scenario, flight.uav, flight.position, "amsl")
        rows = np.column_stack([at.longitude, at.latitude, at.altitude + geoid])
        properties = {
            "kind": "path",
            "name": flight.name,
            "times": np.round(flight.seconds, 6).tolist(),
            "altitudes": np.round(at.altitude, 4).tolist(),
            "altitude_frame": "amsl",
        }
        features.append(_feature(_line(rows), properties))
    for name, (latitude, longitude, altitude) in targets_on_globe(scenario, "amsl"):
        point = {"type": "Point", "coordinates": _rounded([[longitude, latitude, altitude + geoid]])[0]}
        features.append(_feature(point, {"kind": "target", "name": name}))
    for noun, shapes in (("obstacle", scenario.obstacles), ("zone", scenario.zones)):
        for outline in outlines(scenario, shapes):
            rings = [_rounded(np.column_stack([r[:, 1], r[:, 0]])) for r in (outline.top, *outline.holes)]
            properties = {
                "kind": outline.kind or noun,
                "name": outline.name,
                "forbidden": noun == "obstacle",
                "low": round(float(outline.bottom[:, 2].mean()), 4),
                "high": round(float(outline.top[:, 2].mean()), 4),
                "altitude_frame": "amsl",
            }
            features.append(_feature({"type": "Polygon", "coordinates": [[*r, r[0]] for r in rings]}, properties))
    return json.dumps({"type": "FeatureCollection", "features": features}, allow_nan=False) + "\n"


def _feature(geometry: dict[str, Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "geometry": geometry, "properties": properties}


def _line(rows: Floats) -> dict[str, Any]:
    """Return a line through (n, 3) longitudes, latitudes and heights, cut where it crosses the antimeridian."""
    jumps = np.flatnonzero(np.abs(np.diff(rows[:, 0])) > 180)
    if not len(jumps):
        return {"type": "LineString", "coordinates": _rounded(rows)}
    parts, begin = [], rows[:0]
    first = 0
    for k in jumps.tolist():
        side = 180.0 if rows[k, 0] > 0 else -180.0
        ahead = rows[k + 1] + [2 * side, 0.0, 0.0]
        share = (side - rows[k, 0]) / (ahead[0] - rows[k, 0])
        edge = rows[k] + share * (ahead - rows[k])
        parts.append(np.concatenate([begin, rows[first : k + 1], edge[None]]))
        begin, first = (edge * [-1.0, 1.0, 1.0])[None], k + 1
    parts.append(np.concatenate([begin, rows[first:]]))
    return {"type": "MultiLineString", "coordinates": [_rounded(part) for part in parts]}


def _rounded(rows: Floats | list[list[float]]) -> list[list[float]]:
    return [[round(float(v), 9 if k < 2 else 4) for k, v in enumerate(row)] for row in rows]


GPX = "http://www.topografix.com/GPX/1/1"


def gpx_text(scenario: Scenario, flights: list[SampledTrajectory], _: AltitudeReference = "amsl") -> str:
    """Return a ``.gpx`` document."""
    root = ET.Element("gpx", {"xmlns": GPX, "version": "1.1", "creator": "skyverse"})
    head = ET.SubElement(root, "metadata")
    said = f"Second 0 of the mission is written as {clock(0.0)}: it has no date of its own."
    add_texts(head, name=scenario.name, desc=said, time=EPOCH.strftime("%Y-%m-%dT%H:%M:%SZ"))
    for name, place in targets_on_globe(scenario, "amsl"):
        _point(root, "wpt", place, **({"name": name} if name else {}))
    for flight in flights:
        track = ET.SubElement(root, "trk")
        add_texts(track, name=flight.name)
        segment = ET.SubElement(track, "trkseg")
        at = global_positions(scenario, flight.uav, flight.position, "amsl")
        for place, seconds in zip(at.rows, flight.seconds.tolist(), strict=True):
            _point(segment, "trkpt", place, time=clock(seconds))
    return document_text(root)


def _point(parent: ET.Element, tag: str, place: tuple[float, float, float], **texts: str) -> None:
    latitude, longitude, up = place
    point = ET.SubElement(parent, tag, {"lat": f"{latitude:.9f}", "lon": f"{longitude:.9f}"})
    add_texts(point, ele=f"{up:.4f}", **texts)


def geo_csv_text(scenario: Scenario, flights: list[SampledTrajectory], reference: AltitudeReference) -> str:
    """Return a ``.geo.csv`` text."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["uav", "t", "latitude", "longitude", f"altitude_{reference}_m", "x", "y", "z"])
    for flight in flights:
        at = global_positions(scenario, flight.uav, flight.position, reference)
        table = np.column_stack([flight.seconds, at.latitude, at.longitude, at.altitude, flight.position])
        for t, latitude, longitude, up, *local in table.tolist():
            row = [f"{t:.6f}", f"{latitude:.9f}", f"{longitude:.9f}", f"{up:.4f}", *(f"{v:.4f}" for v in local)]
            writer.writerow([flight.name, *row])
    return out.getvalue()
