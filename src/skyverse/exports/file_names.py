"""The files of an export: which formats there are, and what the files of several UAVs are called."""

import re
import zipfile
from pathlib import Path

from skyverse.atomic import whole_file
from skyverse.errors import InputError
from skyverse.exports.global_positions import AltitudeReference

ROUTE_SUFFIXES = (".plan", ".waypoints", ".wpml.kmz")
MAP_SUFFIXES = (".kml", ".kmz", ".geojson", ".gpx", ".geo.csv")
ROBOT_SUFFIXES = (".path.json", ".path.yaml", ".trajectory.json", ".trajectory.yaml")
SHOW_SUFFIX = ".skybrush.zip"
OWN_SUFFIXES = (".waypoints.csv", ".csv", ".json")
EXPORT_SUFFIXES = (*ROUTE_SUFFIXES, *MAP_SUFFIXES, *ROBOT_SUFFIXES, SHOW_SUFFIX, *OWN_SUFFIXES)
ALTITUDE_REFERENCES: dict[str, tuple[AltitudeReference, ...]] = {
    **dict.fromkeys(ROUTE_SUFFIXES, ("amsl", "home", "agl")),
    **dict.fromkeys(MAP_SUFFIXES, ("amsl",)),
    **dict.fromkeys((".kml", ".kmz"), ("amsl", "agl")),
    ".geo.csv": ("amsl", "home", "agl"),
}


def export_suffix(path: Path) -> str:
    """Return which of `EXPORT_SUFFIXES` a path has, or raise `InputError`."""
    name = path.name.lower()
    for suffix in sorted(EXPORT_SUFFIXES, key=len, reverse=True):
        if name.endswith(suffix) and len(name) > len(suffix):
            return suffix
    found = path.suffix or "no suffix"
    raise InputError(f"{path}: a mission is written as {', '.join(EXPORT_SUFFIXES)}, not as {found!r}")


def file_for_each(path: Path, suffix: str, names: list[str]) -> list[Path]:
    """Return a path for each of the named UAVs: `path` itself where there is only one."""
    if len(names) == 1:
        return [path]
    stem, ending = path.name[: -len(suffix)], path.name[-len(suffix) :]
    return [path.with_name(f"{stem}-{name}{ending}") for name in file_stems(names)]


def file_stems(names: list[str]) -> list[str]:
    """Return a file name for each UAV, without suffix; all are different, and valid on every system."""
    made: list[str] = []
    for number, name in enumerate(names, 1):
        safe = re.sub(r"[^A-Za-z0-9_.-]+", "_", name).strip("._-")[:60] or f"uav-{number}"
        taken = {one.lower() for one in made}
        made.append(safe if safe.lower() not in taken else f"{safe}-{number}")
    return made


def write_zip(path: Path, parts: dict[str, str]) -> None:
    """Write an archive of texts, given by their names in it; equal texts give equal bytes."""
    with whole_file(path) as beside, zipfile.ZipFile(beside, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in parts.items():
            archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), text, zipfile.ZIP_DEFLATED)
