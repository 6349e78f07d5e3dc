"""What a file says of one zone or building, before it is judged."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pyproj
import shapely
from shapely.geometry.base import BaseGeometry

from skyverse.errors import InputError
from skyverse.maps.georeference.choices import Choices
from skyverse.maps.georeference.feature import Feature
from skyverse.maps.georeference.limits import Properties, finite, limits, printable
from skyverse.maps.readers.heights import HEIGHT, building
from skyverse.maps.readers.outlines import EDGE, densified, polygons, to_globe
from skyverse.maps.readers.radius import radius
from skyverse.model.altitude import AboveGround, AboveSea, Altitude

ZONE = "no-fly zone"
FREE = "NO_RESTRICTION"


@dataclass(frozen=True, eq=False)
class Record:
    """A geometry and its fields.

    Attributes
    ----------
    geometry
        In its file's coordinates; ``None`` where there is none.
    fields
        By name.
    where
        File and feature.
    z
        What the third coordinate is counted from, if the file says so.
    sheet
        Whether it is a sheet at that height, rather than a body from the ground up to it.
    """

    geometry: BaseGeometry | None
    fields: dict[str, Any]
    where: str
    z: Literal["agl", "amsl"] | None = None
    sheet: bool = False


def features(records: list[Record], crs: pyproj.CRS, file: str, choices: Choices) -> list[Feature]:
    """Return what records say as features.

    Raises
    ------
    InputError
        If one cannot be used, or none is left.
    """
    present = []
    for record in records:
        if record.geometry is None or record.geometry.is_empty:
            choices.tell(f"{record.where}: left out, it has no geometry")
        else:
            present.append(record)
    geometries = np.empty(len(present), dtype=object)
    geometries[:] = [record.geometry for record in present]
    moved = to_globe(geometries, crs, file, lambda k: present[k].where, choices.tell)
    found = [feature for record, place in zip(present, moved, strict=True) for feature in _of(record, place, choices)]
    if not found:
        raise InputError(f"{file}: expected polygons of zones or buildings, found none")
    return found


def _of(record: Record, geometry: BaseGeometry, choices: Choices) -> Iterator[Feature]:
    properties, where = Properties(record.fields), record.where
    if properties.get("restriction") == FREE and choices.kind is None:
        choices.tell(f"{where}: left out, it restricts nothing")
        return
    kind = choices.kind or _kind(properties)
    parts = polygons(
        geometry,
        where,
        choices.tell,
        radius=radius(properties, where, choices),
        buffer=choices.buffer,
        lenient=kind == "building",
    )
    low, high = _ends(record, geometry, properties, kind, choices)
    name = _name(properties)
    risk = _risk(properties, where, choices)
    for part in (densified(part, EDGE) for part in parts):
        outline = np.array(part.exterior.coords)[:-1, :2]
        holes = tuple(np.array(ring.coords)[:-1, :2] for ring in part.interiors)
        yield Feature(outline, holes, low, high, kind, name, where, risk)


def _kind(properties: Properties) -> str:
    for _, said in properties.of("building", "buildingpart"):
        if said not in ("no", "0", 0, False):
            return "building"
    return properties.text("kind", "restriction", "zonetype", "category", "type") or ZONE


def _name(properties: Properties) -> str | None:
    name = properties.get("name")
    if isinstance(name, list) and name and isinstance(name[0], dict):  # one per language
        name = name[0].get("text")
    if isinstance(name, str) and name.strip():
        return printable(name)
    return properties.text("title", "identifier", "ident", "id")


def _risk(properties: Properties, where: str, choices: Choices) -> float | None:
    value = properties.get("risk")
    if value is None:
        return choices.risk
    if choices.risk is None:
        choices.tally["with a field 'risk' must not be entered all the same; --soft-zones lets them be"] += 1
        return None
    try:
        risk = float(value) if isinstance(value, str) else value
    except ValueError:
        risk = value
    if isinstance(risk, bool) or not isinstance(risk, int | float) or not (0 < risk < 1e12):
        raise InputError(f"{where}: 'risk': expected a number above zero, found {printable(repr(value)):.40}")
    return float(risk)


def _ends(
    record: Record, geometry: BaseGeometry, properties: Properties, kind: str, choices: Choices
) -> tuple[Altitude | None, Altitude | None]:
    tall = any(True for _ in properties.of(*HEIGHT)) or (
        choices.height_field is not None and properties.get(choices.height_field) is not None
    )
    if kind == "building" and (tall or properties.get("building:levels") is not None):
        return building(properties, record.where, choices)
    low, high, said = limits(properties, record.where, choices)
    if said:
        if high is None and tall:
            raise InputError(f"{record.where}: expected an upper limit beside the lower one, found a height")
        return low, high
    if tall:
        return building(properties, record.where, choices)
    top = _top(record, geometry, choices)
    if top is None and kind == "building":
        return building(properties, record.where, choices)
    if top is None:
        what = "shut" if choices.risk is None else "risky"
        choices.tally[f"zones name no limits: {what} from the ground up"] += 1
        unread = properties.unread("alt", "height", "limit", "upper", "lower", "ceiling", "floor")
        if unread is not None:
            choices.tally[f"of them have a field {printable(unread)!r}, which is not read as a limit"] += 1
    return None, top


def _top(record: Record, geometry: BaseGeometry, choices: Choices) -> Altitude | None:
    """Return the altitude of the highest corner, if the corners have any."""
    if not geometry.has_z:
        return None
    z = shapely.get_coordinates(geometry, include_z=True)[:, 2]
    z = z[~np.isnan(z)]
    if not z.any():
        return None
    frame = record.z or choices.altitudes
    if record.sheet:
        raise InputError(
            f"{record.where}: expected a body, found a sheet at {z.max():g} m; extrude it, or give it limits"
        )
    if frame is None:
        raise InputError(
            f"{record.where}: its corners' altitude {z.max():g} could be above ground or above mean sea level, as the "
            "file does not say; --altitudes agl or --altitudes amsl decides"
        )
    highest = finite(float(z.max()), f"{record.where}: altitude")
    return (AboveGround if frame == "agl" else AboveSea)(highest)
