"""Buildings and zones from files: GeoJSON, KML, Shapefile, GeoPackage, FlatGeobuf, CityJSON, OpenStreetMap."""

import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import shapely

from skyverse.errors import InputError, Remedy, Sentence, require_file
from skyverse.extras import require_libraries
from skyverse.maps.georeference.feature import Feature
from skyverse.maps.georeference.reading import Choices
from skyverse.model.caution import Caution

if TYPE_CHECKING:
    from pyproj import CRS

    from skyverse.maps.readers.record_to_feature import GeometryRecord

_JSON_SUFFIXES, _OSM_SUFFIXES, _GDAL_SUFFIXES = (".geojson", ".json"), (".osm", ".pbf"), (".shp", ".gpkg", ".fgb")
_LAYERS = {
    **dict.fromkeys(_JSON_SUFFIXES, "geojson"),
    **dict.fromkeys((".kml", ".kmz"), "kml"),
    **dict.fromkeys(_GDAL_SUFFIXES, "vector_tables"),
}
"""By suffix, the reader whose `layers` gives the geometries of such a file; the libraries of others are not loaded."""
LAYER_SUFFIXES = tuple(_LAYERS)
FEATURE_SUFFIXES = (*LAYER_SUFFIXES, *_OSM_SUFFIXES)
_POINTS = dict.fromkeys((".csv", ".gpx"), "point_files")
AREA_SUFFIXES = (*LAYER_SUFFIXES, *_POINTS)
"""Of files that areas, lines or points are read from."""


def read_features(path: Path | str, choices: Choices | None = None) -> list[Feature]:
    """Read the buildings or zones of a file; its suffix, one of `FEATURE_SUFFIXES`, tells the format.

    A ``.json`` file says itself whether it is GeoJSON, ED-269 or CityJSON.

    Returns
    -------
    list of Feature
        Outlines are WGS84 longitude and latitude; across the antimeridian, longitudes continue beyond 180.

    Raises
    ------
    InputError
        If the file or one of its features cannot be used; the message says which and why.
    """
    path = Path(path)
    told: list[str] = []
    given = choices or Choices()
    choices = replace(given, tell=told.append, tally=Counter())
    suffix = path.suffix.lower()
    if suffix not in FEATURE_SUFFIXES:
        known = ", ".join(FEATURE_SUFFIXES)
        raise InputError(
            f"{path}: expected a file of buildings or zones ({known}), found {suffix!r}",
            give=[Remedy("voxels", None, "for point clouds")] if suffix in (".las", ".laz") else (),
        )
    require_file(path)
    try:
        with warnings.catch_warnings():  # shapely warns of coordinates that are refused later
            warnings.simplefilter("ignore", RuntimeWarning)
            found = _features(path, choices)
    except (shapely.errors.ShapelyError, RecursionError, MemoryError) as error:
        raise InputError(f"{path}: its geometries cannot be used: {error}") from None
    warning = f"{Caution.WARNING}: "
    for sentence, number in choices.tally.items():
        said = sentence.text.removeprefix(warning)
        begins = "" if said == sentence.text else warning
        given.tell(Sentence(f"{path}: {begins}{number:,} {said}", give=sentence.give))
    for one in told:
        given.tell(one)
    return found


def _require_readers(path: Path) -> None:
    by_gdal = path.suffix.lower() in (*_GDAL_SUFFIXES, ".pbf")
    require_libraries(str(path), "pyproj", *(("pyogrio",) if by_gdal else ()))


def read_layers(path: Path, choices: Choices) -> "Iterator[tuple[list[GeometryRecord], CRS]]":
    """Yield the geometries of each layer of a file, whose suffix is one of `AREA_SUFFIXES`, and what they count in."""
    _require_readers(path)
    yield from import_module(f"{__name__}.{(_LAYERS | _POINTS)[path.suffix.lower()]}").layers(path, choices)


def _features(path: Path, choices: Choices) -> list[Feature]:
    """Read buildings or zones of any format; of JSON, the file itself says whether it is CityJSON."""
    _require_readers(path)
    from skyverse.maps.readers import cityjson, geojson, osm
    from skyverse.maps.readers.record_to_feature import features_of

    suffix = path.suffix.lower()
    if suffix in _OSM_SUFFIXES:
        return osm.buildings(path, choices)
    if suffix in _JSON_SUFFIXES:
        document = geojson.load(path)
        if isinstance(document, dict) and document.get("type") == "CityJSON":
            return cityjson.buildings(document, path, choices)
        found = [geojson.records(document, path)]
    else:
        found = list(read_layers(path, choices))
    if not found:
        raise InputError(f"{path}: expected polygons of zones or buildings, found none")
    return [feature for records, crs in found for feature in features_of(records, crs, str(path), choices)]
