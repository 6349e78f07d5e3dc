"""Photos that were taken, from files: tables of EXIF data as exiftool writes them, our own, and geo.txt."""

import math
import re
from pathlib import Path
from typing import Literal, NamedTuple, get_args

import numpy as np
import shapely

from skyverse.documents.limits import read_bytes, text_of
from skyverse.errors import InputError, parse_number, path_of, require_choice, require_file, require_kind, shown
from skyverse.maps.georeference.coordinate_systems import named_crs, to_globe
from skyverse.maps.georeference.feature import plain, require_on_globe
from skyverse.maps.readers.areas import local_places
from skyverse.maps.readers.track_files import Reference, named_table
from skyverse.model.frame import Origin
from skyverse.model.photos import Photos

_COLUMNS = {
    "latitude": ("gpslatitude", "latitude", "lat"),
    "longitude": ("gpslongitude", "longitude", "lon"),
    "altitude": (
        "absolutealtitude",
        "gpsaltitude",
        "altitudeamsl",
        "altitudeamslm",
        "altitudeellipsoid",
        "altitude",
        "alt",
    ),
    "heading": ("gimbalyawdegree", "heading", "headingdeg", "yaw"),
    "pitch": ("gimbalpitchdegree", "pitch", "pitchdeg"),
    "roll": ("gimbalrolldegree", "roll", "rolldeg"),
}
"""The plain names of columns, the best first; exiftool puts the group of a tag before its name, with a colon."""
_NAMES = ("filename", "sourcefile", "id")
_DEGREES = re.compile(r"([\d.]+)\s*(?:deg|°)\s*([\d.]+)\s*'\s*([\d.]+)\s*\"\s*([NSEW]?)")
_METRES = re.compile(r"([+-]?[\d.]+)\s*m?\s*((?:above|below) sea level)?", re.IGNORECASE)
_UTM = re.compile(r"WGS ?84 UTM (\d{1,2})([NS])", re.IGNORECASE)


class _Shot(NamedTuple):
    """A photo as a file has it: degrees, metres of altitude, and degrees of its camera; NaN for what is not said."""

    where: str
    name: str
    latitude: float
    longitude: float
    altitude: float
    heading: float
    pitch: float
    roll: float


def read_photos(
    path: str | Path, origin: Origin, *, altitude: Reference | None = None, pitch: float | None = None
) -> Photos:
    """Read where photos were taken, and how the camera was turned.

    Parameters
    ----------
    path
        ``.csv``: a table of EXIF and XMP data as exiftool writes it, with GPSLatitude, GPSLongitude, AbsoluteAltitude
        or GPSAltitude, GimbalYawDegree, GimbalPitchDegree and perhaps GimbalRollDegree; or one with latitude,
        longitude, altitude, heading, pitch and perhaps roll. ``.txt``: the geo.txt of OpenDroneMap, whose pitch is
        counted from straight down.
    origin
        Where the zero of the scenario's frame lies.
    altitude
        What altitudes are counted from, ``"amsl"`` or ``"ellipsoid"``, which needs the origin's geoid. When left out,
        they are above mean sea level, unless the file says otherwise.
    pitch
        Degrees above the horizon at which the camera looked, -90 straight down, of photos that do not say it.

    Raises
    ------
    InputError
        If the file is none of these, or a photo has no place, altitude, heading or pitch; the message names file, line
        and column.
    """
    path = path_of(path)
    require_kind(origin, Origin, "origin")
    if altitude is not None:
        require_choice(altitude, get_args(Reference), "altitude")
    suffix = path.suffix.lower()
    if suffix not in (".csv", ".txt"):
        raise InputError(f"{path}: expected photos ending in .csv or .txt, found {path.suffix or 'no ending'!r}")
    require_file(path)
    shots, said = _of_table(path) if suffix == ".csv" else _of_geo_text(path)
    if altitude is None and said is None:
        hint = "RtkFlag is set, and altitudes of RTK are counted from the ellipsoid or from the sea, as it was set up"
        raise InputError(f"{path}: expected word what altitudes are counted from, found none: {hint}; give altitude")
    numbers = np.array([shot[2:] for shot in shots])
    if pitch is not None:
        numbers[:, 4] = np.where(np.isnan(numbers[:, 4]), pitch, numbers[:, 4])
    for column, name in ((3, "heading"), (4, "pitch")):
        missing = np.flatnonzero(np.isnan(numbers[:, column]))
        if len(missing):
            more = "; give pitch" if name == "pitch" else ""
            raise InputError(f"{shots[missing[0]].where}: expected the camera's {name}, found none{more}")
    for shot in shots:
        require_on_globe(shot.where, shot.latitude, shot.longitude)
        local_places(np.array([[shot.longitude, shot.latitude]]), origin, shot.where)
    if (altitude or said) == "ellipsoid":
        if origin.geoid is None:
            raise InputError(f"{path}: its altitudes are counted from the ellipsoid, but the origin has no geoid")
        numbers[:, 2] -= origin.geoid
    places = local_places(numbers[:, 1::-1], origin, str(path))
    count, none = len(shots), np.full(len(shots), -1)
    position = np.column_stack([places, numbers[:, 2] - origin.altitude])
    angles = numbers[:, 3] % 360.0, numbers[:, 4], np.nan_to_num(numbers[:, 5])
    return Photos(position, *angles, np.full(count, math.nan), none, none, np.array([shot.name for shot in shots]))


def _of_table(path: Path) -> tuple[list[_Shot], Reference | None]:
    """Return the photos of a table, and what their altitudes are counted from, if the file says it."""
    names, rows = named_table(path)
    known = [plain(name.rpartition(":")[2]) for name in names]
    found = {what: next((known.index(one) for one in some if one in known), None) for what, some in _COLUMNS.items()}
    for what in ("latitude", "longitude", "altitude"):
        if found[what] is None:
            expected = f"a column {' or '.join(_COLUMNS[what])}"
            raise InputError(f"{path}: {what}: expected {expected}, found {shown(', '.join(names), 100)}")

    def said(name: str, row: list[str]) -> str:
        return row[known.index(name)].strip() if name in known else ""

    shots, fixed, called = [], False, next((name for name in _NAMES if name in known), "")
    for line, row in rows.items():
        numbers: dict[str, float] = {}
        for what, k in found.items():
            text = "" if k is None or row[k].strip() == "-" else row[k].strip()
            where = f"{path}: line {line}: {names[k or 0]}"
            if what in ("latitude", "longitude"):
                numbers[what] = _angle(text, said(f"gps{what}ref", row), where)
            elif what == "altitude":
                numbers[what] = _metres(text, said("gpsaltituderef", row), where)
            else:
                numbers[what] = parse_number(text, where) if text else math.nan
        fixed |= said("rtkflag", row) not in ("", "-", "0")
        where = f"{path}: line {line}"
        shots.append(_Shot(where, said(called, row) or where, **numbers))
    named = known[found["altitude"] or 0]
    if named == "altitudeellipsoid":
        return shots, "ellipsoid"
    return shots, None if fixed and not named.startswith("altitudeamsl") else "amsl"


def _angle(text: str, side: str, where: str) -> float:
    """Return degrees of a latitude or longitude, as a number or as degrees, minutes and seconds."""
    match = _DEGREES.fullmatch(text)
    if match is None:
        degrees = parse_number(text or None, where)
        return -degrees if side[:1].upper() in ("S", "W") and degrees > 0 else degrees
    degrees, minutes, seconds = (parse_number(part, where) for part in match.groups()[:3])
    return (-1 if (match[4] or side[:1].upper()) in ("S", "W") else 1) * (degrees + minutes / 60 + seconds / 3600)


def _metres(text: str, reference: str, where: str) -> float:
    """Return an altitude, as a number or in exiftool's words."""
    match = _METRES.fullmatch(text)
    metres = parse_number(text if match is None else match[1], where)
    below = reference.lower().startswith(("1", "below")) or (
        match is not None and (match[2] or "")[:5].lower() == "below"
    )
    return -metres if below and metres > 0 else metres


def _of_geo_text(path: Path) -> tuple[list[_Shot], Literal["amsl"]]:
    """Return the photos of a geo.txt; angles that are all 0 stand for angles that are not known."""
    lines = [line.split() for line in text_of(read_bytes(path), path).splitlines()]
    rows = [(f"{path}: line {k}", words) for k, words in enumerate(lines, 1) if words]
    if len(rows) < 2:
        raise InputError(f"{path}: expected a coordinate system and photos, found {len(rows)} lines that hold anything")
    system = " ".join(rows.pop(0)[1])
    utm = _UTM.fullmatch(system)
    crs = named_crs(
        system if utm is None else f"EPSG:{326 if utm[2].upper() == 'N' else 327}{int(utm[1]):02d}", str(path)
    )
    shots = []
    for where, words in rows:
        if len(words) < 4:
            raise InputError(f"{where}: expected a name, x, y and z, found {shown(' '.join(words), 60)}")
        x, y, z, *more = (parse_number(word, where) for word in words[1:7])
        turned = [more[0], more[1] - 90.0, more[2]] if len(more) == 3 and any(more) else [math.nan] * 3
        shots.append(_Shot(where, words[0], y, x, z, *turned))
    names = [one.where for one in shots]
    places = shapely.points([(one.longitude, one.latitude) for one in shots])
    moved = shapely.get_coordinates(to_globe(places, crs, str(path), names.__getitem__, lambda doubt: None))
    return [one._replace(longitude=x, latitude=y) for one, (x, y) in zip(shots, moved.tolist(), strict=True)], "amsl"
