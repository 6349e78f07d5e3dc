"""Other people's missions: read from files and written back with what was changed; the suffix tells the format."""

from codecs import BOM_UTF8
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from skyverse.atomic import whole_file
from skyverse.documents.limits import read_bytes
from skyverse.errors import InputError, path_of, require_choice, require_file, require_kind
from skyverse.model.altitude import REFERENCES
from skyverse.model.frame import require_geoid
from skyverse.model.waypoints import Waypoints
from skyverse.orders.dji_files import kmz_content, read_kmz
from skyverse.orders.litchi_files import litchi_content, read_litchi
from skyverse.orders.map_routes import read_route, route_content
from skyverse.orders.mavlink_files import plan_content, read_plan, read_wpl, wpl_content
from skyverse.orders.places import Given


class _Format(NamedTuple):
    """How files of one format are read, and written with changes."""

    read: Callable[[bytes, str, Given], Waypoints]
    content: Callable[[Waypoints, Waypoints], bytes]


FORMATS = {
    ".plan": _Format(read_plan, plan_content),
    ".waypoints": _Format(read_wpl, wpl_content),
    ".txt": _Format(read_wpl, wpl_content),
    ".kmz": _Format(read_kmz, kmz_content),
    ".csv": _Format(read_litchi, litchi_content),
    ".kml": _Format(read_route, route_content),
    ".gpx": _Format(read_route, route_content),
}
MAX_ORDERS = 100_000
"""Orders that a file may have at most; autopilots take some thousands."""


def read_waypoints(path: str | Path, *, altitude: str | None = None, geoid: float | None = None) -> Waypoints:
    """Read the mission of one vehicle as its autopilot is told it.

    Parameters
    ----------
    path
        ``.plan`` (QGroundControl), ``.waypoints``, ``.txt`` (QGC WPL 110, 120), ``.kmz`` (DJI's waylines, or a map),
        ``.csv`` (Litchi), ``.kml`` or ``.gpx``.
    altitude
        What altitudes are counted from where the file does not say it, as of GPX: ``"amsl"`` (mean sea level),
        ``"home"`` (the place of take-off) or ``"agl"`` (the ground below).
    geoid
        How far mean sea level lies above the WGS84 ellipsoid there, metres, for DJI's heights above the ellipsoid.

    Raises
    ------
    InputError
        If it cannot be read; the message names file, item and field.
    """
    path = path_of(path)
    require_file(path)
    form = _format(path)
    if altitude is not None:
        require_choice(altitude, REFERENCES, "altitude")
    if geoid is not None:
        require_geoid(geoid)
    content, given = read_bytes(path), Given(altitude, geoid)
    found = replace(form.read(content, str(path), given), told=given, stored=content)
    if len(found.orders) > MAX_ORDERS:
        raise InputError(f"{path}: expected at most {MAX_ORDERS:,} items, found {len(found.orders):,}")
    return found


def write_waypoints(waypoints: Waypoints, path: str | Path) -> None:
    """Write a mission as the file that it was read from, with what its orders have changed, and nothing else.

    Parameters
    ----------
    waypoints
        What `read_waypoints` returned, with other places of orders, or with waypoints added.
    path
        The file; its suffix is that of the file that was read.

    Raises
    ------
    InputError
        If the suffix is another one, or the file cannot be written.
    """
    require_kind(waypoints, Waypoints, "waypoints")
    path = path_of(path)
    require_same_format(Path(waypoints.name), path)
    with whole_file(path) as beside:
        beside.write_bytes(rewritten(waypoints).stored)


def rewritten(waypoints: Waypoints) -> Waypoints:
    """Return a mission as it is read once it is written: unchanged, or with what its orders have changed."""
    form, given = _format(Path(waypoints.name)), Given(*waypoints.told)
    before = form.read(waypoints.stored, waypoints.name, given)
    same = (before.orders, before.home) == (waypoints.orders, waypoints.home)
    if same and (waypoints.autopilot != "dji" or before.return_altitude == waypoints.return_altitude):
        return waypoints
    content = BOM_UTF8 * waypoints.stored.startswith(BOM_UTF8) + form.content(waypoints, before)
    return replace(form.read(content, waypoints.name, given), told=given, stored=content)


def require_same_format(source: Path, path: Path) -> None:
    """Raise `InputError` where the format of a file is not that of the file that was read."""
    if _format(path) is not _format(source):
        raise InputError(f"{path}: expected a suffix as that of {source}, since it is written as it was read")


def _format(path: Path) -> _Format:
    name = path.name.lower()
    found = next((form for suffix, form in FORMATS.items() if name.endswith(suffix)), None)
    if found is None:
        raise InputError(
            f"{path}: expected a file ending in {', '.join(FORMATS)}, found {path.suffix or 'no ending'!r}"
        )
    return found
