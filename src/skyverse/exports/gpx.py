"""GPX 1.1: a track for each UAV, with elevations above mean sea level and times after an arbitrary date."""

from xml.etree import ElementTree as ET

import numpy as np

from skyverse.exports.global_positions import global_positions
from skyverse.exports.sampling import EPOCH, SampledTrajectory, clock
from skyverse.exports.xml_text import add_text, document_text
from skyverse.model.scenario import Scenario

GPX = "http://www.topografix.com/GPX/1/1"


def gpx_text(scenario: Scenario, flights: list[SampledTrajectory]) -> str:
    """Return a ``.gpx`` document."""
    root = ET.Element("gpx", {"xmlns": GPX, "version": "1.1", "creator": "skyverse"})
    head = ET.SubElement(root, "metadata")
    add_text(head, "name", scenario.name)
    add_text(head, "desc", f"Second 0 of the mission is written as {clock(0.0)}: it has no date of its own.")
    add_text(head, "time", EPOCH.strftime("%Y-%m-%dT%H:%M:%SZ"))
    for target in scenario.targets:
        at = global_positions(scenario, 0, np.array([target.position]), "amsl")
        _point(root, "wpt", float(at.latitude[0]), float(at.longitude[0]), float(at.altitude[0]), None, target.name)
    for flight in flights:
        track = ET.SubElement(root, "trk")
        add_text(track, "name", flight.name)
        segment = ET.SubElement(track, "trkseg")
        at = global_positions(scenario, flight.uav, flight.position, "amsl")
        for row in zip(*(v.tolist() for v in (at.latitude, at.longitude, at.altitude, flight.seconds)), strict=True):
            _point(segment, "trkpt", *row)
    return document_text(root)


def _point(
    parent: ET.Element, tag: str, latitude: float, longitude: float, up: float, seconds: float | None, name: str = ""
) -> None:
    point = ET.SubElement(parent, tag, {"lat": f"{latitude:.9f}", "lon": f"{longitude:.9f}"})
    add_text(point, "ele", f"{up:.4f}")
    if seconds is not None:
        add_text(point, "time", clock(seconds))
    if name:
        add_text(point, "name", name)
