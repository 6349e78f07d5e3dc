"""Recorded tracks as GPX 1.0 and 1.1: points with latitude, longitude, elevation and time."""

from pathlib import Path
from xml.etree.ElementTree import Element

from skyverse.documents.xml import read_tree
from skyverse.errors import InputError, did_you_mean, shown, unreadable
from skyverse.maps.readers.track_fixes import Fixes, number, time


def fixes(path: Path, vehicle: str | None) -> Fixes:
    """Return the fixes of the only track in a file, or of one that is named; its segments follow one another.

    Elevations are in metres, by the format; it does not say what they are counted from.

    Raises
    ------
    InputError
        If the file is no GPX, a point has no elevation or time, or there are several tracks and none is named.
    """
    with unreadable(path), path.open("rb") as stream:
        root = read_tree(stream, path)
    if root.tag != "gpx":
        raise InputError(f"{path}: expected a GPX file, whose first element is gpx, found {shown(root.tag)}")
    tracks = root.findall("trk")
    if vehicle is not None:
        names = [_text(track, "name") or "" for track in tracks]
        tracks = [track for track, name in zip(tracks, names, strict=True) if name == vehicle.strip()]
        if not tracks:
            raise InputError(f"{path}: name: there is no track {shown(vehicle)}{did_you_mean(vehicle, names)}")
    if len(tracks) != 1:
        raise InputError(
            f"{path}: expected one track, found {len(tracks)}" + ("; give vehicle, the name of one" if tracks else "")
        )
    points = list(tracks[0].iter("trkpt"))
    if not points:
        raise InputError(f"{path}: expected a track with points, found none")
    times, places = [], []
    for k, point in enumerate(points, 1):
        where = f"{path}: point {k}"
        latitude, longitude = (number(point.get(name), f"{where}: {name}") for name in ("lat", "lon"))
        places.append((latitude, longitude, number(_given(point, "ele", where), f"{where}: ele")))
        times.append(time(_given(point, "time", where), f"{where}: time")[0])
    first = min(time(each.text, f"{path}: time")[0] for each in root.iterfind("trk/trkseg/trkpt/time"))
    return Fixes(
        lines=list(range(1, len(points) + 1)),
        line="point",
        times=times,
        dated=True,
        first=first,
        places=places,
        in_degrees=True,
        reference=None,
        unit="m",
        heights="ele",
        errors=[],
    )


def _text(element: Element, name: str) -> str | None:
    found = element.find(name)
    return None if found is None else (found.text or "").strip()


def _given(point: Element, name: str, where: str) -> str:
    found = _text(point, name)
    if found is None:
        raise InputError(f"{where}: {name}: is missing")
    return found
