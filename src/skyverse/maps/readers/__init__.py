"""Buildings and zones from files: GeoJSON, KML, Shapefile, GeoPackage, FlatGeobuf, CityJSON, OpenStreetMap."""

import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import shapely

from skyverse.errors import InputError, Remedy, Sentence, require_file
from skyverse.extras import require_libraries
from skyverse.maps.georeference.feature import Feature
from skyverse.maps.georeference.reading import Choices
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
    require_libraries(str(path), "pyproj", *(("pyogrio",) if suffix in (*_GDAL_SUFFIXES, ".pbf") else ()))
    try:
        with warnings.catch_warnings():  # shapely warns of coordinates that are refused later
            warnings.simplefilter("ignore", RuntimeWarning)
            found = _reader(suffix)(path, choices)
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


def _reader(suffix: str) -> Callable[[Path, Choices], list[Feature]]:
    """Return the reader of files with a suffix; the libraries of the others are not loaded."""
    from skyverse.maps.readers import kml, osm

    readers = {
        **dict.fromkeys((".osm", ".pbf"), osm.buildings),
        **dict.fromkeys((".kml", ".kmz"), kml.features),
        **dict.fromkeys((".geojson", ".json"), _json),
        **dict.fromkeys(_GDAL_SUFFIXES, _tables),
    }
    return readers[suffix]


def _tables(path: Path, choices: Choices) -> list[Feature]:
    from skyverse.maps.readers import vector_tables

    return vector_tables.features(path, choices)


def _json(path: Path, choices: Choices) -> list[Feature]:
    """Read GeoJSON, ED-269, ED-318 or CityJSON, as the file itself says."""
    from skyverse.maps.readers import cityjson, geojson

    document = geojson.load(path)
    if isinstance(document, dict) and document.get("type") == "CityJSON":
        return cityjson.buildings(document, path, choices)
    return geojson.features(document, path, choices)
