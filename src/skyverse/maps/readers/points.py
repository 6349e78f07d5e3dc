"""Points from files, such as targets: places by name, whose altitudes say what they are counted from."""

import re
from pathlib import Path
from typing import Any

from shapely import Point

from skyverse.errors import InputError, Remedy, printable, require_kind, shown
from skyverse.maps.georeference.feature import Fields, require_on_globe
from skyverse.maps.readers.areas import read_records
from skyverse.maps.readers.record_to_feature import GeometryRecord
from skyverse.model.altitude import REFERENCES, Altitude, GlobalPlace, parse_altitude

NAMES = ("name", "id", "label", "title")
UNITS = dict.fromkeys(("m", "meter", "meters", "metre", "metres"), "m") | dict.fromkeys(("ft", "foot", "feet"), "ft")
ALTITUDES = {"altitude", "alt", "ele", "elevation", "height", "amsl", "msl", "agl"}
"""Words of which the name of a field that holds an altitude has one at least; others in it are units, and ``home``."""

GIVE_ALTITUDE = (Remedy("altitude", "60 m agl", "for that of all"),)


def read_points(path: str | Path, *, altitude: str | None = None, crs: str | None = None) -> dict[str, GlobalPlace]:
    """Read the points of a file as places by name, for the `targets` or the `uavs` of `BuildOptions`.

    Parameters
    ----------
    path
        KML, KMZ, GeoJSON, Shapefile, GeoPackage or FlatGeobuf, whose areas and lines do not count; GPX, its waypoints,
        or the points of its routes if it has none; or CSV, a table with columns such as ``name``, ``latitude``,
        ``longitude`` and ``altitude_agl_m``.
    altitude
        That of all points, such as ``"60 m agl"``, in place of those in the file. Or, such as ``"amsl"`` or ``"ft
        agl"``, what the file's are counted from, and in, where it does not say so: KML says it by its altitudeMode, a
        field by its name or by its values (``60 m agl``); KML, GPX and GeoJSON count in metres.
    crs
        The coordinate system of a file that does not say it, such as ``"EPSG:2056"``.

    Returns
    -------
    dict of str to tuple
        Latitude and longitude, degrees, and altitude; a point without a name is called ``point-1``, as the first.

    Raises
    ------
    InputError
        If the file holds no point, two have one name or one place, or an altitude is missing or does not say what it is
        counted from, or in.
    """
    if altitude is not None:
        require_kind(altitude, str, "altitude")
    whole = parse_altitude(altitude) if altitude is not None and re.match(r"\s*[-+.\d]", altitude) else None
    found: dict[str, GlobalPlace] = {}
    for number, (point, record) in enumerate(read_records(path, crs, Point), 1):
        require_on_globe(record.where, point.y, point.x)
        place = point.y, point.x, whole or _altitude(point, record, (altitude or "").lower().split())
        name = printable(str(next((value for _, value in Fields(record.fields).of(*NAMES)), f"point-{number}")))
        twin = next((other for other, there in found.items() if other == name or there == place), None)
        if twin is not None:
            what = "name" if twin == name else f"place than that of {shown(twin)}"
            raise InputError(f"{record.where}: expected another {what}, found {shown(name)} there again")
        found[name] = place
    return found


def _altitude(point: Any, record: GeometryRecord, given: list[str]) -> Altitude:
    """Return the altitude of a point: its own, or else that of the only field that holds one."""
    said = {name: value for name, value in record.fields.items() if isinstance(value, str | int | float)}
    named = [(name, re.findall("[a-z]+", name.lower()), value) for name, value in said.items()]
    held = [one for one in named if ALTITUDES & {*one[1]} and {*one[1]} <= {*ALTITUDES, *UNITS, "home"}]
    if point.has_z:
        held = [("altitude", ["m"] * record.metric + [record.z or ""], f"{point.z:.12g}")]
    if len(held) != 1:
        found = f"{len(held) or 'none'} among {', '.join(said) or 'no fields'}"
        raise InputError(f"{record.where}: expected one altitude, found {found}", give=GIVE_ALTITUDE)
    ((name, words, value),) = held
    text = str(value).strip()
    if re.fullmatch(r"[-+.\de]+", text):
        known = [*words, *given]
        unit = next((UNITS[word] for word in known if word in UNITS), "")
        text = f"{text} {unit} {next((word for word in known if word in (*REFERENCES, 'msl')), '')}"
    try:
        return parse_altitude(text)
    except InputError as error:
        raise InputError(f"{record.where}: {name}: {error}", give=GIVE_ALTITUDE) from None
