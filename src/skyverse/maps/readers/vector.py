"""Buildings and zones from files: GeoJSON, KML, Shapefile, GeoPackage, FlatGeobuf, CityJSON, OpenStreetMap."""

import warnings
from collections import Counter
from dataclasses import replace
from pathlib import Path

from skyverse.errors import InputError
from skyverse.maps.georeference.choices import Choices
from skyverse.maps.georeference.extra import needs
from skyverse.maps.georeference.feature import Feature

_TABLES = (".shp", ".gpkg", ".fgb")
SUFFIXES = (".geojson", ".json", ".kml", ".kmz", *_TABLES, ".osm", ".pbf")


def read_features(path: Path | str, choices: Choices | None = None) -> list[Feature]:
    """Read the buildings or zones of a file, told by its suffix (one of `SUFFIXES`).

    Whether a ``.json`` is GeoJSON, ED-269 or CityJSON, it says itself.

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
    given = choices or Choices()
    choices = replace(given, tell=told.append, tally=Counter())
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        hint = "; --voxels takes point clouds" if suffix in (".las", ".laz") else ""
        known = ", ".join(SUFFIXES)
        raise InputError(f"{path}: expected a file of buildings or zones ({known}), found {suffix!r}{hint}")
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
        given.tell(sentence)
    return found


def _read(path: Path, suffix: str, choices: Choices) -> list[Feature]:
    from skyverse.maps.readers.outlines import WGS84
    from skyverse.maps.readers.record import features

    if suffix in (".osm", ".pbf"):
        from skyverse.maps.readers import osm

        return osm.buildings(path, choices)
    if suffix in (".kml", ".kmz"):
        from skyverse.maps.readers import kml

        return features(kml.records(path), WGS84, str(path), choices)
    if suffix in _TABLES:
        from skyverse.maps.readers import gdal

        layers = list(gdal.layers(path, choices))
        if not layers:
            raise InputError(f"{path}: expected polygons of zones or buildings, found none")
        return [feature for records, crs in layers for feature in features(records, crs, str(path), choices)]
    from skyverse.maps.readers import cityjson, geojson

    document = geojson.load(path)
    if isinstance(document, dict) and document.get("type") == "CityJSON":
        return cityjson.buildings(document, path, choices)
    return features(*geojson.records(document, path), str(path), choices)
