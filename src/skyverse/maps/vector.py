"""Buildings and zones from files: GeoJSON, KML, Shapefile, GeoPackage, FlatGeobuf, CityJSON, OpenStreetMap."""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Literal

from skyverse.errors import InputError
from skyverse.maps.choices import Choices
from skyverse.maps.extra import needs
from skyverse.maps.feature import Feature

_TABLES = (".shp", ".gpkg", ".fgb")
SUFFIXES = (".geojson", ".json", ".kml", ".kmz", *_TABLES, ".osm", ".pbf")


def _silent(_: str) -> None:
    pass


def read_features(
    path: Path | str,
    *,
    kind: str | None = None,
    altitudes: Literal["agl", "amsl"] | None = None,
    height: float | None = None,
    height_field: str | None = None,
    buffer: float | None = None,
    crs: str | None = None,
    lod: str | None = None,
    risk: float | None = None,
    unit: Literal["m", "ft"] | None = None,
    tell: Callable[[str], object] = _silent,
) -> list[Feature]:
    """Read the buildings or zones of a file, told by its suffix (one of `SUFFIXES`).

    Parameters
    ----------
    path
        The file. Whether a ``.json`` is GeoJSON, ED-269 or CityJSON, it says itself.
    kind
        What all its features are; ``"building"`` ones stand on the ground and need a height. ``None`` for what the
        file says.
    altitudes
        What bare altitudes are counted from: ``"agl"``, the ground, or ``"amsl"``, mean sea level.
    height
        Of buildings that no usable height is given of, metres.
    height_field
        The field that holds the height above ground, where it is none of the usual ones.
    buffer
        How far around lines and points is forbidden, metres.
    crs
        The coordinates of a file that does not say, such as ``"EPSG:2056"``.
    lod
        The level of detail taken from CityJSON, such as ``"1"``; ``None`` for each building's highest.
    risk
        Of a metre inside, where a feature's field ``risk`` does not say it; ``None`` for what must not be entered,
        whatever such a field says.
    unit
        Of limits of zones without one, ``"m"`` or ``"ft"``; metres, and told, when left out.
    tell
        Is called with a sentence for all that was repaired or left out.

    Returns
    -------
    list of Feature
        Outlines are longitude and latitude (WGS84); across the antimeridian longitudes go on beyond 180.

    Raises
    ------
    InputError
        If the file, or one of its features, cannot be used; the message says which and why.
    """
    path = Path(path)
    told: list[str] = []
    choices = Choices(kind, altitudes, height, height_field, buffer, crs, lod, risk, unit, told.append)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"{path}: expected a file of buildings or zones ({', '.join(SUFFIXES)}), found {suffix!r}")
    if not path.is_file():
        raise InputError(f"{path}: there is no such file")
    needs(str(path), "shapely", "pyproj", *(("pyogrio",) if suffix in (*_TABLES, ".pbf") else ()))
    import shapely

    try:
        with warnings.catch_warnings():  # shapely's, of numbers that are refused later
            warnings.simplefilter("ignore", RuntimeWarning)
            found = _read(path, suffix, choices)
    except (shapely.errors.ShapelyError, RecursionError, MemoryError) as error:
        raise InputError(f"{path}: its geometries cannot be used: {error}") from None
    for sentence in (*(f"{path}: {number:,} {what}" for what, number in choices.tally.items()), *told):
        tell(sentence)
    return found


def _read(path: Path, suffix: str, choices: Choices) -> list[Feature]:
    from skyverse.maps.outlines import WGS84
    from skyverse.maps.record import features

    if suffix in (".osm", ".pbf"):
        from skyverse.maps import osm

        return osm.buildings(path, choices)
    if suffix in (".kml", ".kmz"):
        from skyverse.maps import kml

        return features(kml.records(path), WGS84, str(path), choices)
    if suffix in _TABLES:
        from skyverse.maps import gdal

        layers = list(gdal.layers(path, choices))
        if not layers:
            raise InputError(f"{path}: expected polygons of zones or buildings, found none")
        return [feature for records, crs in layers for feature in features(records, crs, str(path), choices)]
    from skyverse.maps import cityjson, geojson

    document = geojson.load(path)
    if isinstance(document, dict) and document.get("type") == "CityJSON":
        return cityjson.buildings(document, path, choices)
    return features(*geojson.records(document, path), str(path), choices)
