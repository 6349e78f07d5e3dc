"""What a file says of a zone or building, and how that becomes features: outlines on the globe with altitudes."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pyproj
import shapely
from shapely.geometry.base import BaseGeometry

from skyverse.errors import InputError, Remedy, printable, shown
from skyverse.maps.georeference.active_times import GIVE_DATE, active_times, said_times
from skyverse.maps.georeference.altitude_limits import (
    GIVE_ALTITUDES,
    GIVE_UNIT,
    METRES_PER_LIMIT_UNIT,
    altitude_limits,
    from_the_ground,
    permitted_height,
)
from skyverse.maps.georeference.coordinate_systems import to_globe, unit_of_heights
from skyverse.maps.georeference.feature import ABOVE_PERMITTED, LIMITS, RADII, TIMES, Feature, Fields, number_of, plain
from skyverse.maps.georeference.reading import Choices, instant_of
from skyverse.maps.readers.dimensions import HEIGHT_FIELDS, building_limits, circle_radius
from skyverse.maps.readers.polygons import MAX_EDGE_DEGREES, area_features, outline_and_holes, polygons
from skyverse.model.altitude import AboveGround, AboveSea, Altitude
from skyverse.model.caution import Caution
from skyverse.model.shapes import FENCE, NO_FLY_ZONE, Spans
from skyverse.model.short_lines import listed

NO_RESTRICTION = "norestriction"
"""The plain name of what ED-269's field ``restriction`` and ED-318's ``type`` say of a zone that restricts nothing.

Their other values close a zone: ``PROHIBITED``, and ``REQ_AUTHORISATION`` (``REQ_AUTHORIZATION``) and ``CONDITIONAL``,
which let enter whoever has an authorisation or meets conditions; neither is known here.
"""


@dataclass(frozen=True, eq=False)
class GeometryRecord:
    """A geometry and its fields, as a file has them.

    Attributes
    ----------
    geometry
        In the file's coordinates; ``None`` where there is none.
    fields
        The fields' values by name.
    where
        File and feature, for messages.
    z
        What the third coordinate is counted from, if the file says so.
    sheet
        Whether it is a sheet at that height, rather than a body from the ground up to it.
    metric
        Whether the format has altitudes in metres beside degrees.
    """

    geometry: BaseGeometry | None
    fields: dict[str, Any]
    where: str
    z: Literal["agl", "amsl"] | None = None
    sheet: bool = False
    metric: bool = True


def features_of(records: list[GeometryRecord], crs: pyproj.CRS, file: str, choices: Choices) -> list[Feature]:
    """Return the features that records describe.

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
    geometries = np.array([record.geometry for record in present], dtype=object)
    moved = to_globe(geometries, crs, file, lambda k: present[k].where, choices.tell)
    found = [
        feature
        for record, place in zip(present, moved, strict=True)
        for feature in _features(record, place, crs, choices)
    ]
    if not found:
        raise InputError(f"{file}: expected polygons of zones or buildings, found none")
    return found


def _features(record: GeometryRecord, geometry: BaseGeometry, crs: pyproj.CRS, choices: Choices) -> Iterator[Feature]:
    fields, where = Fields(record.fields), record.where
    said = [plain(value) for _, value in fields.of("restriction", "type") if isinstance(value, str)]
    if NO_RESTRICTION in said and choices.kind is None:
        named = ", ".join(filter(None, (_name(fields), fields.text("message"))))
        choices.tell(f"{where}: left out, it restricts nothing{named and f': {named}'}")
        return
    kind = choices.kind or _kind(fields)
    risk = None if choices.kind == FENCE else _risk(fields, where, choices)
    active = None if kind == "building" else _active(fields, where, risk, choices)
    if choices.kind == FENCE:
        radius = _radius(fields, geometry, where, choices)
        yield from area_features(geometry, where, tell=choices.tell, radius=radius, buffer=choices.buffer)
        return
    parts = polygons(
        geometry,
        where,
        choices.tell,
        radius=_radius(fields, geometry, where, choices),
        buffer=choices.buffer,
        lenient=kind == "building",
    )
    low, high = _limits(record, geometry, crs, fields, kind, choices)
    name, solid, timed = _name(fields), kind == "building", bool(said_times(fields))
    if not solid:
        choices.count_unread(fields.unread(LIMITS), "a limit")
        choices.count_unread(fields.unread(TIMES), "a time")
    for part in shapely.segmentize(parts, MAX_EDGE_DEGREES):
        yield Feature(*outline_and_holes(part), low, high, kind, solid, name, where, risk, active, timed)


def _radius(fields: Fields, geometry: BaseGeometry, where: str, choices: Choices) -> float | None:
    """Return the radius of a point, ``None`` where its file gives none, and tell which fields look like one."""
    radius, unread = circle_radius(fields, where, choices), fields.unread(RADII)
    give = [Remedy("Reading.radius_field", name) for name in unread]
    needed = radius is None and geometry.geom_type not in ("Polygon", "MultiPolygon")
    if needed and unread and choices.buffer is None:
        said = listed([f"{printable(name)!r} ({shown(value)})" for name, value in unread.items()])
        found = f"a {geometry.geom_type.lower()}, and {said}, not read as one"
        raise InputError(
            f"{where}: expected a polygon or a radius, found {found}",
            give=[*give, Remedy("Reading.buffer", None, "for those that have none")],
        )
    choices.count_unread(unread, "a radius", *give, begins=f"{Caution.WARNING}: " if needed else "")
    return radius


def _active(fields: Fields, where: str, risk: float | None, choices: Choices) -> Spans | None:
    """Return when a zone is active, ``None`` for always, and tell; only what must not be entered has such times."""
    times, begin = said_times(fields), instant_of(choices.date)
    if not times:
        return None
    if begin is None or choices.kind is not None or risk is not None:
        give = () if begin else (GIVE_DATE,)
        first = printable(next(iter(times)))
        choices.count(f"{Caution.WARNING}: with times ({first!r}), which are ignored: active at all times", *give)
        return None
    active = active_times(times, where, begin)
    if active is None:
        choices.count(f"with times: active on all of the day from {choices.date} on")
    else:
        choices.count("active at times" if active else f"not active within a day of {choices.date}: left out")
    return active


def _kind(fields: Fields) -> str:
    for _, said in fields.of("building", "buildingpart"):
        if said not in ("no", "0", 0, False):
            return "building"
    return fields.text("kind", "restriction", "zonetype", "category", "type") or NO_FLY_ZONE


def _name(fields: Fields) -> str | None:
    name = fields.get("name")
    if isinstance(name, list) and name and isinstance(name[0], dict):  # ED-318: one name a language
        name = name[0].get("text")
    if isinstance(name, str) and name.strip():
        return printable(name)
    return fields.text("title", "identifier", "ident", "id")


def _risk(fields: Fields, where: str, choices: Choices) -> float | None:
    value = fields.get("risk")
    if value is None:
        return choices.risk
    if choices.risk is None:
        choices.count(
            "with a field 'risk' must not be entered all the same", Remedy("soft_zones", None, "to let them be entered")
        )
        return None
    try:
        risk = float(value) if isinstance(value, str) else value
    except ValueError:
        risk = value
    if isinstance(risk, bool) or not isinstance(risk, int | float) or not (0 < risk < 1e12):
        raise InputError(f"{where}: 'risk': expected a number above zero, found {shown(value)}")
    return float(risk)


def _limits(
    record: GeometryRecord, geometry: BaseGeometry, crs: pyproj.CRS, fields: Fields, kind: str, choices: Choices
) -> tuple[Altitude | None, Altitude | None]:
    """Return the altitudes at which a record begins and ends, from its limits, its height or its corners."""
    if kind == ABOVE_PERMITTED:
        return permitted_height(fields, record.where, choices), None
    has_height = any(True for _ in fields.of(*HEIGHT_FIELDS)) or (
        choices.height_field is not None and fields.get(choices.height_field) is not None
    )
    if kind == "building" and (has_height or fields.get("building:levels") is not None):
        return building_limits(fields, record.where, choices)
    low, high, has_limits = altitude_limits(fields, record.where, choices)
    if has_limits:
        if high is None and has_height:
            raise InputError(f"{record.where}: expected an upper limit beside the lower one, found a height")
        return low, high
    if has_height:
        return building_limits(fields, record.where, choices)
    top = _highest_corner(record, geometry, crs, choices)
    if top is None and kind == "building":
        return building_limits(fields, record.where, choices)
    if top is None:
        what = "shut" if choices.risk is None else "risky"
        choices.count(f"without limits: {what} from the ground up")
    return from_the_ground(None, top, choices)


def _highest_corner(
    record: GeometryRecord, geometry: BaseGeometry, crs: pyproj.CRS, choices: Choices
) -> Altitude | None:
    """Return the altitude of the highest corner, if the corners have altitudes."""
    if not geometry.has_z:
        return None
    z = shapely.get_coordinates(geometry, include_z=True)[:, 2]
    z = z[~np.isnan(z)]
    if not z.any():
        return None
    unit, of_crs = _unit_and_reference_of_z(record, crs, choices)
    reference = record.z or choices.altitudes or of_crs
    if record.sheet:
        raise InputError(
            f"{record.where}: expected a body, found a sheet at {z.max():g} m; extrude it, or give it limits"
        )
    if reference is None:
        raise InputError(
            f"{record.where}: its corners' altitude {z.max():g} could be above ground or above mean sea level, as the "
            "file does not say",
            give=GIVE_ALTITUDES,
        )
    highest = number_of(float(z.max()), f"{record.where}: altitude") * unit
    return (AboveGround if reference == "agl" else AboveSea)(highest)


def _unit_and_reference_of_z(
    record: GeometryRecord, crs: pyproj.CRS, choices: Choices
) -> tuple[float, Literal["amsl"] | None]:
    """Return the metres in a unit of the corners' altitudes, and what their coordinate system counts them from."""
    vertical = unit_of_heights(crs, record.where)
    if vertical is not None:
        unit, above_ellipsoid = vertical
        if above_ellipsoid:
            raise InputError(
                f"{record.where}: expected corners above ground or mean sea level, but altitudes in {crs.name} are "
                "ellipsoidal; convert them, or give limits as fields"
            )
        return unit, "amsl"
    if record.metric and crs.is_geographic:
        return 1.0, None
    if choices.unit is not None:
        return METRES_PER_LIMIT_UNIT[choices.unit], None
    if crs.is_projected and crs.axis_info[0].unit_conversion_factor == 1:
        return 1.0, None
    raise InputError(f"{record.where}: its corners' altitudes have no unit, as {crs.name} has none", give=GIVE_UNIT)
