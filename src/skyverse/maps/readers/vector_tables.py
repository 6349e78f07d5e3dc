"""Tables of geometries that GDAL reads: Shapefile, GeoPackage, FlatGeobuf, OpenStreetMap's binary files."""

import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pyogrio
import pyproj
import shapely
from shapely.geometry.base import BaseGeometry

from skyverse.errors import InputError, printable
from skyverse.maps.georeference.coordinate_systems import named_crs
from skyverse.maps.georeference.reading import GIVE_CRS, Choices
from skyverse.maps.readers.record_to_feature import GeometryRecord

_FIRST_BYTES = {".shp": b"\x00\x00\x27\x0a", ".gpkg": b"SQLite format 3\x00", ".fgb": b"fgb\x03fgb"}
"""How files begin; GDAL goes by the content, and would read another format under the same suffix."""


def layers(path: Path, choices: Choices) -> Iterator[tuple[list[GeometryRecord], pyproj.CRS]]:
    """Yield the records of each layer of a file, and the layer's coordinate system."""
    _require_format(path)
    names = [str(name) for name, kind in _tried(path, lambda: pyogrio.list_layers(path)) if kind is not None]
    if not names:
        raise InputError(f"{path}: expected a layer of polygons, found none; it may be cut off")
    for name in names:
        meta, rows = table(path, name, choices)
        where = f"{path}: layer {name!r}, feature" if len(names) > 1 else f"{path}: feature"
        records = [
            GeometryRecord(shape, fields, f"{where} {n}", metric=False) for n, (shape, fields) in enumerate(rows, 1)
        ]
        if records:
            yield records, _system(meta["crs"], path, choices)


def table(
    path: Path, layer: str, choices: Choices, **options: str
) -> tuple[dict[str, Any], list[tuple[BaseGeometry | None, dict[str, Any]]]]:
    """Return what GDAL says of a layer, and its rows: geometry and fields.

    Raises
    ------
    InputError
        If GDAL cannot read it.
    """
    with warnings.catch_warnings(record=True) as doubts:
        warnings.simplefilter("always")
        meta, _, shapes, columns = _tried(
            path, lambda: pyogrio.raw.read(path, layer=layer, datetime_as_string=True, **options)
        )
    for doubt in doubts:
        said = printable(str(doubt.message))
        if said.startswith("Non closed ring"):
            choices.count("with an outline that does not close, closed from end to beginning")
        else:
            choices.tell(f"{path}: {said}")
    if shapes is None:
        return meta, []
    geometries = _tried(path, lambda: shapely.from_wkb(shapes, on_invalid="fix"))
    for n, (shape, geometry) in enumerate(zip(shapes, geometries, strict=True), 1):
        if shape is not None and geometry is None:
            raise InputError(f"{path}: feature {n}: its geometry cannot be read")
    names = [str(name) for name in meta["fields"]]
    values = [column.tolist() for column in columns]
    fields = zip(*values, strict=True) if values else ((),) * len(geometries)
    return meta, [(shape, dict(zip(names, row, strict=True))) for shape, row in zip(geometries, fields, strict=True)]


def _require_format(path: Path) -> None:
    """Refuse a file of another format, and a Shapefile that is cut off, of which GDAL reads the beginning."""
    suffix = path.suffix.lower()
    with path.open("rb") as stream:
        head = stream.read(100)
    if not head.startswith(_FIRST_BYTES[suffix]):
        raise InputError(f"{path}: expected a {suffix} file, found something else")
    size, needed = path.stat().st_size, 2 * int.from_bytes(head[24:28], "big")
    if suffix == ".shp" and size < needed:
        raise InputError(f"{path}: expected {needed} bytes, found {size}; it is cut off")


def _tried(path: Path, read: Callable[[], Any]) -> Any:
    try:
        return read()
    except Exception as error:  # pyogrio does not document which errors a broken file raises
        reason = printable(str(error)).removeprefix(f"{path}: ")
        raise InputError(f"{path}: cannot be read, it is cut off or damaged: {reason:.120}") from None


def _system(said: str | None, path: Path, choices: Choices) -> pyproj.CRS:
    name = said or choices.crs
    if name is None:
        beside = " (a .prj file beside it)" if path.suffix.lower() == ".shp" else ""
        raise InputError(f"{path}: expected its coordinate system{beside}, found none", give=[GIVE_CRS])
    return named_crs(name, str(path))
