"""Point clouds taken from the air that say where on Earth they lie, as voxels of the local frame.

From the air nobody has seen what is below a point, so that it counts as occupied.

Source: ASPRS LAS 1.4 R15, table 17, for the classes of points.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from skyverse._typing import Floats, Ints
from skyverse.errors import InputError, Remedy, require_file
from skyverse.extras import require_libraries
from skyverse.maps.georeference.feature import Rectangle
from skyverse.maps.georeference.reading import GIVE_AMSL, GIVE_CRS, Choices
from skyverse.maps.readers import voxel_grid
from skyverse.maps.readers.raster_tiles import GIVE_GEOID
from skyverse.maps.readers.voxel_grid import POINTS_AT_A_TIME
from skyverse.model.altitude import FOOT
from skyverse.model.frame import Origin
from skyverse.model.geodesy import to_local
from skyverse.model.shapes import Terrain, Voxels

if TYPE_CHECKING:
    from pyproj import CRS


DEFAULT_AERIAL_VOXEL_SIZE = 2.0
"""Metres; doubled until there are no more than `voxel_grid.MAX_VOXELS`."""
_GROUND_CLASS, _NOISE_CLASSES = 2, (7, 18)
WHY_LEFT_OUT = ("of the ground", "of noise", "outside")


@dataclass(frozen=True, eq=False)
class AerialCloud:
    """A file of points that says where on Earth they lie.

    Attributes
    ----------
    path
        The file.
    name
        The coordinate system's name.
    globe
        The transformer of x and y to longitude and latitude.
    metres
        The metres in a unit of z.
    ellipsoidal
        Whether z is counted from the WGS84 ellipsoid.
    count
        How many points there are.
    low, high
        The least and the greatest x, y and z (3,) by the file's header.
    outline
        (n, 2) longitude and latitude of a line around all points.
    """

    path: Path
    name: str
    globe: Any
    metres: float
    ellipsoidal: bool
    count: int
    low: Floats
    high: Floats
    outline: Floats


def aerial_cloud(path: Path, choices: Choices) -> AerialCloud:
    """Return what a .las or .laz file says of where on Earth its points lie.

    Raises
    ------
    InputError
        If it cannot be read, or does not say where its points lie or what their altitudes are counted from.
    """
    if path.suffix.lower() not in (".las", ".laz"):
        raise InputError(f"{path}: expected a point cloud (.las, .laz), found {path.suffix!r}")
    require_file(path)
    require_libraries(path.name, "laspy", "lazrs", "pyproj")
    from skyverse.maps.georeference.coordinate_systems import to_globe, transformer_to_globe

    with voxel_grid.open_las(path) as file:
        header = file.header
        said, keys = voxel_grid.coordinate_system(header), _keys(header)
        low, high = np.array(header.mins, dtype=np.float64), np.array(header.maxs, dtype=np.float64)
    if not header.point_count:
        raise InputError(f"{path}: expected points, found none")
    if not (np.isfinite([low, high]).all() and (low <= high).all()):
        raise InputError(f"{path}: expected the range of its coordinates in its header, found {low} to {high}")
    crs, metres, ellipsoidal = _system(path, said, keys, choices)
    box = np.array([shapely.box(*low[:2], *(high[:2] + 1e-9))], dtype=object)
    outline = to_globe(box, crs, str(path), lambda _: str(path), choices.tell)[0]
    middle = (low + high) / 2
    transformer, _ = transformer_to_globe(crs, float(middle[0]), float(middle[1]), str(path))
    around = shapely.get_coordinates(outline)
    name = ":".join(crs.to_authority() or [crs.name])
    return AerialCloud(path, name, transformer, metres, ellipsoidal, header.point_count, low, high, around)


def _keys(header: Any) -> dict[int, int]:
    """Return the GeoTIFF keys of a header; laspy itself reads only the horizontal ones."""
    records = [*header.vlrs, *(header.evlrs or [])]
    return {
        key.id: key.value_offset
        for record in records
        if record.user_id == "LASF_Projection"
        for key in getattr(record, "geo_keys", ())
        if key.tiff_tag_location == 0
    }


def _system(path: Path, said: "CRS | None", keys: dict[int, int], choices: Choices) -> tuple["CRS", float, bool]:
    """Return the horizontal coordinate system, the metres in a unit of z, and whether z is above the ellipsoid."""
    import pyproj

    from skyverse.maps.georeference.coordinate_systems import named_crs, unit_of_heights

    if said is None and choices.crs is None:
        raise InputError(f"{path}: expected its coordinate system, found none", give=[GIVE_CRS])
    crs = named_crs(str(choices.crs), str(path)) if said is None else said
    vertical = unit_of_heights(crs, str(path))
    if vertical is None and 1024 <= keys.get(4096, 0) <= 32766:
        try:
            vertical = unit_of_heights(pyproj.CRS.from_epsg(keys[4096]), str(path))
        except pyproj.exceptions.CRSError:
            raise InputError(f"{path}: expected a vertical coordinate system, found EPSG:{keys[4096]}") from None
    flat = crs.to_2d()
    if not (flat.is_geographic or flat.is_projected):
        raise InputError(f"{path}: its coordinate system, {crs.name!r}, does not lie on Earth")
    if vertical is not None:
        return flat, *vertical
    if choices.altitudes != "amsl":
        raise InputError(f"{path}: {crs.name} says nothing of altitudes", give=[GIVE_AMSL])
    if choices.unit is None and flat.is_projected and flat.axis_info[0].unit_conversion_factor != 1:
        units = [Remedy("Reading.unit", "m"), Remedy("Reading.unit", "ft", "for its altitudes")]
        raise InputError(f"{path}: {crs.name} is not in metres", give=units)
    return flat, FOOT if choices.unit == "ft" else 1.0, False


def aerial_voxels(
    cloud: AerialCloud,
    origin: Origin,
    region: Rectangle,
    reach: float,
    terrain: Terrain | None,
    size: float | None = None,
) -> tuple[Voxels | None, Counter[str]]:
    """Return the voxels that hold a point or are below one, down to the lowest ground.

    Points of noise are left out, and those of the ground where there is a terrain.

    Parameters
    ----------
    cloud
        The points.
    origin
        The local frame's origin.
    region, reach
        Points are kept within `reach` metres of this region, local metres.
    terrain
        The ground, if it is known.
    size
        How long a voxel is, metres; `DEFAULT_AERIAL_VOXEL_SIZE` or longer when left out.

    Returns
    -------
    tuple
        The voxels, ``None`` where none is occupied, and how many points were kept or left out, and why.
    """
    voxel_grid.require_voxel_size(size)
    if cloud.ellipsoidal and origin.geoid is None:
        raise InputError(f"{cloud.path}: its altitudes are counted from the ellipsoid", give=[GIVE_GEOID])
    low, high = _extent(cloud, origin, region, reach, terrain)
    length = DEFAULT_AERIAL_VOXEL_SIZE if size is None else size
    if not (low <= high).all():
        return None, Counter({"outside": cloud.count})
    while size is None and np.prod((high - low) // length + 2) > voxel_grid.MAX_VOXELS:
        length *= 2
    first = np.floor(low / length).astype(np.int64)
    nx, ny, nz = (int(n) for n in np.floor(high / length).astype(np.int64) - first + 1)
    voxel_grid.require_voxel_count(cloud.path, (nx, ny, nz))
    top = np.full((nx, ny), -1)
    counts: Counter[str] = Counter()
    for points, code in _points(cloud, origin):
        noise = np.isin(code, _NOISE_CLASSES)
        ground = (code == _GROUND_CLASS) & (terrain is not None)
        inside = ((points >= low) & (points <= high))[:, :2].all(axis=1)
        kept = inside & ~noise & ~ground
        for what, these in (
            ("kept", kept), ("outside", ~inside), ("of noise", inside & noise), ("of the ground", inside & ground)
        ):  # fmt: skip
            counts[what] += int(these.sum())
        i, j, k = (np.floor(points[kept] / length).astype(np.int64) - first).T
        np.maximum.at(top, (i, j), np.minimum(k, nz - 1))
    occupied = np.arange(nz) <= top[:, :, None]
    if not occupied.any():
        return None, counts
    counts["columns"] = int((top >= 0).sum())
    start, occupied = voxel_grid.trimmed(first, occupied)
    made = voxel_grid.voxels_of_grid(start, length, occupied)
    return made.model_copy(update={"name": cloud.path.stem, "kind": "point cloud"}), counts


def _extent(
    cloud: AerialCloud, origin: Origin, region: Rectangle, reach: float, terrain: Terrain | None
) -> tuple[Floats, Floats]:
    """Return the corners of the box in the local frame that the cloud and the region with its surroundings share."""
    least, most = (_altitudes(cloud, origin, end[2:3])[0] for end in (cloud.low, cloud.high))
    places = to_local(origin, np.column_stack([cloud.outline[:, ::-1], np.full(len(cloud.outline), least)]))
    low, high = places.min(axis=0), places.max(axis=0)
    low[:2] = np.maximum(low[:2] - 1.0, np.array(region[:2]) - reach)
    high[:2] = np.minimum(high[:2] + 1.0, np.array(region[2:]) + reach)
    if terrain is not None:
        low[2] = float(terrain.heights.min())
    high[2] = most - origin.altitude + 1.0
    return low, high


def _altitudes(cloud: AerialCloud, origin: Origin, z: Floats) -> Floats:
    """Return altitudes above mean sea level (n,), metres, of z as the file has it."""
    return z * cloud.metres - (origin.geoid or 0.0) * cloud.ellipsoidal


def _points(cloud: AerialCloud, origin: Origin) -> Iterator[tuple[Floats, Ints]]:
    """Yield points (n, 3) of the local frame and their classes (n,), some at a time."""
    with voxel_grid.open_las(cloud.path) as file:
        for chunk in file.chunk_iterator(POINTS_AT_A_TIME):
            x, y, z = (np.asarray(axis, dtype=np.float64) for axis in (chunk.x, chunk.y, chunk.z))
            at = np.column_stack([x, y, z])
            grain = 1e-6 + np.array(file.header.scales)
            if not ((at >= cloud.low - grain) & (at <= cloud.high + grain)).all():
                raise InputError(f"{cloud.path}: expected points in the range that its header says, found others")
            code = np.asarray(chunk.classification).astype(np.int64)
            code[np.asarray(chunk.withheld, dtype=bool)] = _NOISE_CLASSES[0]
            longitude, latitude = cloud.globe.transform(x, y)
            yield to_local(origin, np.column_stack([latitude, longitude, _altitudes(cloud, origin, z)])), code
