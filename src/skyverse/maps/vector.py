"""Buildings and zones from files: GeoJSON, KML, Shapefile, GeoPackage, FlatGeobuf, CityJSON, OpenStreetMap."""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from skyverse.errors import InputError
from skyverse.maps.choices import Choices
from skyverse.maps.extra import needs
from skyverse.maps.feature import Feature

if TYPE_CHECKING:
    import pyproj

    from skyverse.maps.record import Record

_TABLES = {".shp": b"\x00\x00\x27\x0a", ".gpkg": b"SQLite format 3\x00", ".fgb": b"fgb\x03fgb"}
"""Files that GDAL reads, and how they begin, so that it takes them for nothing else."""
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
    choices = Choices(kind, altitudes, height, height_field, buffer, crs, lod, tell)
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
            return _read(path, suffix, choices)
    except (shapely.errors.ShapelyError, RecursionError, MemoryError) as error:
        raise InputError(f"{path}: its geometries cannot be used: {error}") from None


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
        return [
            feature for records, crs in _layers(path, choices) for feature in features(records, crs, str(path), choices)
        ]
    from skyverse.maps import cityjson, geojson

    document = geojson.load(path)
    if isinstance(document, dict) and document.get("type") == "CityJSON":
        return cityjson.buildings(document, path, choices)
    return features(*geojson.records(document, path), str(path), choices)


def _layers(path: Path, choices: Choices) -> "list[tuple[list[Record], pyproj.CRS]]":
    """Return the records of each layer of a file that GDAL reads, and its coordinate system."""
    import pyogrio
    import shapely
    from pyogrio.errors import DataLayerError, DataSourceError, FeatureError, FieldError, GeometryError

    with path.open("rb") as stream:
        if not stream.read(16).startswith(_TABLES[path.suffix.lower()]):
            raise InputError(f"{path}: expected a {path.suffix.lower()} file, found something else")
    found = []
    try:
        layers = [str(name) for name, geometry in pyogrio.list_layers(path) if geometry is not None]
        for layer in layers:
            meta, _, shapes, columns = pyogrio.raw.read(path, layer=layer, datetime_as_string=True)
            where = f"{path}: layer {layer!r}, feature" if len(layers) > 1 else f"{path}: feature"
            found.append((_rows(meta, shapes, columns, where), _system(meta["crs"], path, choices)))
    except (DataSourceError, DataLayerError, FeatureError, FieldError, GeometryError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: cannot be read: {_first(error)}") from None
    except shapely.errors.GEOSException as error:
        raise InputError(f"{path}: a geometry cannot be read: {_first(error)}") from None
    if not found:
        raise InputError(f"{path}: expected a layer of polygons, found none")
    return found


def _first(error: Exception) -> str:
    from skyverse.maps.limits import printable

    return printable(str(error))


def _rows(meta: dict[str, Any], shapes: Any, columns: Any, where: str) -> "list[Record]":
    import shapely

    from skyverse.maps.record import Record

    if shapes is None:
        return []
    geometries = shapely.from_wkb(shapes, on_invalid="fix")
    for n, (shape, geometry) in enumerate(zip(shapes, geometries, strict=True), 1):
        if shape is not None and geometry is None:
            raise InputError(f"{where} {n}: its geometry cannot be read")
    names = [str(name) for name in meta["fields"]]
    values = [column.tolist() for column in columns]
    return [
        Record(geometry, {name: column[n] for name, column in zip(names, values, strict=True)}, f"{where} {n + 1}")
        for n, geometry in enumerate(geometries)
    ]


def _system(said: str | None, path: Path, choices: Choices) -> "pyproj.CRS":
    from skyverse.maps.outlines import named_crs

    name = said or choices.crs
    if name is None:
        beside = " (a .prj file beside it)" if path.suffix.lower() == ".shp" else ""
        raise InputError(f"{path}: expected its coordinate system{beside}, found none; --crs EPSG:... gives it")
    return named_crs(name, str(path))
