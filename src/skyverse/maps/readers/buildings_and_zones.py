"""Buildings and zones from files: GeoJSON, KML, Shapefile, GeoPackage, FlatGeobuf, CityJSON, OpenStreetMap."""

import warnings
from collections import Counter
from dataclasses import replace
from pathlib import Path

from skyverse.errors import InputError, Remedy, Sentence, require_file
from skyverse.maps.georeference.choices import Choices
from skyverse.maps.georeference.feature import Feature
from skyverse.maps.georeference.libraries import require_libraries
from skyverse.model.caution import Caution

_GDAL_SUFFIXES = (".shp", ".gpkg", ".fgb")
FEATURE_SUFFIXES = (".geojson", ".json", ".kml", ".kmz", *_GDAL_SUFFIXES, ".osm", ".pbf")


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
    require_libraries(str(path), "shapely", "pyproj", *(("pyogrio",) if suffix in (*_GDAL_SUFFIXES, ".pbf") else ()))
    import shapely

    try:
        with warnings.catch_warnings():  # shapely warns of coordinates that are refused later
            warnings.simplefilter("ignore", RuntimeWarning)
            found = _read(path, suffix, choices)
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


def _read(path: Path, suffix: str, choices: Choices) -> list[Feature]:
    """Read a file by the reader of its format; the libraries of the others are not loaded."""
    from skyverse.maps.readers.coordinate_systems import WGS84
    from skyverse.maps.readers.record_to_feature import features_of

    if suffix in (".osm", ".pbf"):
        from skyverse.maps.readers import osm

        return osm.buildings(path, choices)
    if suffix in (".kml", ".kmz"):
        from skyverse.maps.readers import kml

        return features_of(kml.records(path), WGS84, str(path), choices)
    if suffix in _GDAL_SUFFIXES:
        from skyverse.maps.readers import vector_tables

        layers = list(vector_tables.layers(path, choices))
        if not layers:
            raise InputError(f"{path}: expected polygons of zones or buildings, found none")
        return [feature for records, crs in layers for feature in features_of(records, crs, str(path), choices)]
    from skyverse.maps.readers import cityjson, geojson

    document = geojson.load(path)
    if isinstance(document, dict) and document.get("type") == "CityJSON":
        return cityjson.buildings(document, path, choices)
    return features_of(*geojson.records(document, path), str(path), choices)
