"""GPX 1.1: a track for each UAV, with elevations above mean sea level and times after an arbitrary date."""

from xml.etree import ElementTree as ET

from skyverse.exports.global_positions import global_positions, targets_on_globe
from skyverse.exports.sampling import EPOCH, SampledTrajectory, clock
from skyverse.exports.xml_text import add_texts, document_text
from skyverse.model.scenario import Scenario

GPX = "http://www.topografix.com/GPX/1/1"


def gpx_text(scenario: Scenario, flights: list[SampledTrajectory]) -> str:
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
