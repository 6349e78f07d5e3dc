"""UAVs and targets: places on the globe become points of the local frame."""

import math
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

import numpy as np
import shapely
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy, is_number
from skyverse.maps.assembly.bad_points import BadPoint, refuse_all
from skyverse.maps.assembly.options import GlobalPlaces
from skyverse.maps.assembly.terrain import GIVE_GROUND
from skyverse.maps.georeference.feature import MAX_WIDTH, SWAPPED, Feature, Rectangle, contains, require_on_globe
from skyverse.maps.readers.raster import OpenRaster
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea, GlobalPlace
from skyverse.model.frame import Origin
from skyverse.model.geodesy import to_local
from skyverse.model.shape_extent import roof_z
from skyverse.model.shapes import Prism, Terrain, Voxels


def named_places(places: GlobalPlaces, kind: str) -> dict[str, GlobalPlace]:
    """Return places by name, which is such as ``uav-1`` where none is given; refuse what is not a place."""
    given = places if isinstance(places, Mapping) else {f"{kind}-{k}": place for k, place in enumerate(places, 1)}
    for name, place in given.items():
        known = isinstance(place, list | tuple) and len(place) == 3 and all(map(is_number, place[:2]))
        if not known or not isinstance(place[2], AboveSea | AboveGround | AboveHome):
            raise InputError(
                f"{name}: expected latitude, longitude and an altitude such as AboveGround(60), found {place!r:.60}"
            )
        require_on_globe(name, *place[:2])
    return dict(given)


def flat_points(places: Sequence[GlobalPlace], origin: Origin) -> Floats:
    """Return local points (n, 3) of places, at the origin's altitude where theirs above the sea is not known."""
    rows = [
        (lat, lon, altitude.metres if isinstance(altitude, AboveSea) else origin.altitude)
        for lat, lon, altitude in places
    ]
    return to_local(origin, rows) if rows else np.empty((0, 3))


def refuse_off_map(places: Mapping[str, GlobalPlace], rasters: Sequence[OpenRaster]) -> None:
    """Raise `InputError` that names all places that are on none of the terrain's rasters."""

    def known(latitude: float, longitude: float) -> bool:
        return not rasters or any(raster.pixel(latitude, longitude) is not None for raster in rasters)

    sentences = []
    for name, (latitude, longitude, _) in places.items():
        if known(latitude, longitude):
            continue
        hint = SWAPPED if abs(longitude) <= 90 and known(longitude, latitude) else ""
        sentences.append(
            f"{name}: expected a place on {', '.join(raster.path for raster in rasters)}, found latitude {latitude:g}, "
            f"longitude {longitude:g}, which is outside{hint}"
        )
    refuse_all(sentences)


def refuse_one_swapped(places: Sequence[tuple[str, GlobalPlace]]) -> None:
    """Raise `InputError` for a named place that is near the others only with latitude and longitude swapped."""

    def near(latitude: float, longitude: float, others: Sequence[GlobalPlace]) -> bool:
        if not abs(latitude) <= 90:
            return False
        here = Origin(latitude=latitude, longitude=longitude, altitude=0.0)
        return bool((np.abs(flat_points(others, here)[:, :2]) <= MAX_WIDTH).all())

    names = []
    for k, (name, (latitude, longitude, _)) in enumerate(places):
        others = [place for j, (_, place) in enumerate(places) if j != k]
        if others and not near(latitude, longitude, others) and near(longitude, latitude, others):
            names.append(name)
    if names:
        raise InputError(
            f"{' or '.join(names)}: expected places within {MAX_WIDTH / 1000:g} km of one another, found one that is "
            f"farther away{SWAPPED}"
        )


def refuse_outside(
    names: Sequence[str], places: Sequence[GlobalPlace], origin: Origin, region: Rectangle, what: str
) -> None:
    """Raise `InputError` that names all places that are not over the region, which `what` names in the message."""
    sentences = []
    for name, place, point in zip(names, places, flat_points(places, origin), strict=True):
        if contains(region, point):
            continue
        latitude, longitude, altitude = place
        swapped = abs(longitude) <= 90 and contains(region, flat_points([(longitude, latitude, altitude)], origin)[0])
        hint = SWAPPED if swapped else ""
        sentences.append(
            f"{name}: expected a place in {what}; it ends {_distance(point, region)} from latitude {latitude:g}, "
            f"longitude {longitude:g}{hint}"
        )
    refuse_all(sentences)


def refuse_swapped(path: str, found: Sequence[Feature], origin: Origin, region: Rectangle) -> None:
    """Raise `InputError` for a file that lies over the region only if latitude and longitude are swapped."""
    corners = np.concatenate([feature.outline for feature in found])
    swapped = corners[np.abs(corners[:, 0]) <= 90]
    flat: list[GlobalPlace] = [(float(first), float(second), AboveSea(origin.altitude)) for first, second in swapped]
    if flat and any(contains(region, point) for point in flat_points(flat, origin)):
        raise InputError(
            f"{path}: nothing of it lies in the area, but would with latitude and longitude swapped; longitude comes "
            "first in files and areas, latitude in places"
        )


def _distance(point: Floats, region: Rectangle) -> str:
    """Return how far outside of a region a point is, in words."""
    away = np.maximum(0, np.maximum(np.array(region[:2]) - point[:2], point[:2] - np.array(region[2:])))
    metres = float(np.hypot(*away))
    return f"{metres:.0f} m" if metres < 10_000 else f"{metres / 1000:.0f} km"


def homes(starts: Mapping[str, GlobalPlace], rasters: Sequence[OpenRaster], geoid: float | None) -> dict[str, float]:
    """Return the altitude of the real ground below each start, metres above the sea; of several rasters, the highest.

    It is the ground of the rasters, not that of the scenario, which is raised. A start beside holes is left out.
    """
    if not (starts and rasters):
        return {}
    heights = highest_ground([place[:2] for place in starts.values()], rasters, geoid)
    return {name: height for name, height in zip(starts, heights.tolist(), strict=True) if not math.isnan(height)}


def highest_ground(places: ArrayLike, rasters: Sequence[OpenRaster], geoid: float | None) -> Floats:
    """Return the altitudes of the ground at latitudes and longitudes (n, 2), metres above the sea, (n,).

    Of several rasters the highest one counts; ``nan`` stands where there is none.
    """
    return np.asarray(
        np.fmax.reduce([raster.heights_at(places) - (geoid or 0.0) * raster.ellipsoidal for raster in rasters])
    )


def local_points(
    given: Mapping[str, GlobalPlace],
    starts: Mapping[str, GlobalPlace],
    origin: Origin,
    terrain: Terrain | None,
    homes: Mapping[str, float],
) -> dict[str, tuple[float, float, float]]:
    """Return the local points of places by name.

    Altitudes above home are counted from the real ground below a UAV's start; those of targets need an only UAV.

    Parameters
    ----------
    given
        The places.
    starts
        The places where UAVs start, by the UAVs' names.
    origin, terrain
        The local frame's origin, and the scenario's ground if it is known.
    homes
        z of UAVs' homes, as far as they are known.
    """
    points = {}
    for name, (latitude, longitude, altitude) in given.items():
        if isinstance(altitude, AboveHome):
            if name not in starts and len(starts) != 1:
                raise InputError(
                    f"{name}: an altitude above home, but there are {len(starts)} UAVs; give it as agl or amsl"
                )
            uav = name if name in starts else next(iter(starts))
            home = homes.get(uav)
            if home is None:
                home = _above_ground(name, starts[uav][0], starts[uav][1], 0.0, origin, terrain)[2]
            altitude = AboveSea(origin.altitude + home + altitude.metres)
        if isinstance(altitude, AboveGround):
            points[name] = _above_ground(name, latitude, longitude, altitude.metres, origin, terrain)
        else:
            x, y, z = to_local(origin, [latitude, longitude, altitude.metres])[0].tolist()
            points[name] = x, y, z
    return points


def _above_ground(
    name: str, latitude: float, longitude: float, metres: float, origin: Origin, terrain: Terrain | None
) -> tuple[float, float, float]:
    if terrain is None:
        raise InputError(
            f"{name}: an altitude above ground or home needs the ground, where it is not given as amsl",
            give=GIVE_GROUND,
        )
    x, y, _ = to_local(origin, [latitude, longitude, 0.0])[0].tolist()
    return x, y, float(terrain.height((x, y))) + metres


def low_points(
    points: Mapping[str, tuple[float, float, float]],
    terrain: Terrain | None,
    clearance: float,
    real: Mapping[str, float] = MappingProxyType({}),
) -> list[BadPoint]:
    """Return the points that are nearer to the ground than the clearance; none where the ground is not known.

    Parameters
    ----------
    points
        Local points by name.
    terrain
        The scenario's ground.
    clearance
        Metres.
    real
        z of the real ground below points, by name, where it is known; it counts as well.
    """
    found = []
    for name, (x, y, z) in points.items() if terrain is not None else ():
        assert terrain is not None
        ground = max(float(terrain.height((x, y))), real.get(name, -math.inf))
        if z < ground + clearance - 1e-6:
            below = f"{z - ground:.2f} m above" if z >= ground else f"{ground - z:.2f} m below"
            text = (
                f"expected a point at least {clearance:g} m above the ground, found it {below} the ground, "
                f"which is raised to what the terrain's cells reach; it needs {clearance - (z - ground):.2f} m more"
            )
            give = (Remedy("ground_clearance", None, "to fly lower"),)
            found.append(BadPoint(name, (x, y, z), text, give=give))
    return found


def points_above_ceiling(
    points: Mapping[str, tuple[float, float, float]], terrain: Terrain | None, most: float
) -> list[BadPoint]:
    """Return those points, given with their names, that are more than so many metres above the lowest ground."""
    if terrain is None:
        raise InputError("metres above ground need the ground", field="max_height", give=GIVE_GROUND)
    found, ground = [], terrain.lowest_ground
    for name, (x, y, z) in points.items():
        height = z - float(ground.height((x, y)))
        if height > most + 1e-6:
            text = f"expected a point at most {most:g} m above the ground, found it {height:.2f} m above"
            give = (Remedy("max_height", None, "to raise it"),)
            found.append(BadPoint(name, (x, y, z), text, give=give))
    return found


def points_inside(
    points: Iterable[tuple[str, tuple[float, float, float]]],
    solids: Sequence[Prism | Voxels],
    clearance: float,
    file: str,
    top: float,
) -> list[BadPoint]:
    """Return those points, given with their names, that lie in an obstacle of a file, or nearer than the clearance.

    An obstacle that ends above the `top` of the bounds, at which it is cut off, has no roof to fly over.
    """
    found = []
    for name, point in points:
        near = [solid for solid in solids if _is_near(solid, np.array(point), clearance)]
        if near:
            highest = max(near, key=lambda solid: roof_z(solid, point, clearance))
            called = f"the {highest.kind or 'obstacle'}" + (f" {highest.name!r:.60}" if highest.name else "")
            text = (
                f"expected a point {clearance:g} m or more from what must not be entered, found it in or near "
                f"{called} of {file}"
            )
            roof = roof_z(highest, point, clearance)
            if highest.closed_above:
                found.append(BadPoint(name, point, f"{text}, which nothing may fly over"))
            elif roof > top:
                found.append(BadPoint(name, point, f"{text}, which reaches above the bounds"))
            else:
                found.append(BadPoint(name, point, text, roof))
    return found


def _is_near(solid: Prism | Voxels, point: Floats, clearance: float) -> bool:
    if isinstance(solid, Voxels):
        first = np.array(solid.origin)
        low = np.maximum(np.floor((point - clearance - first) / solid.step + 1e-9), 0).astype(np.int64)
        high = np.maximum(np.ceil((point + clearance - first) / solid.step - 1e-9), 0).astype(np.int64)
        return bool(solid.occupied[tuple(slice(a, b) for a, b in zip(low, high, strict=True))].any())
    if not (solid.low - clearance < point[2] and (solid.closed_above or point[2] < solid.high + clearance)):
        return False
    corners = np.asarray(solid.vertices)
    if ((point[:2] < corners.min(axis=0) - clearance) | (point[:2] > corners.max(axis=0) + clearance)).any():
        return False
    outline, place = shapely.Polygon(solid.vertices, solid.holes), shapely.Point(point[:2])
    return bool(outline.distance(place) < clearance) if clearance else bool(outline.contains_properly(place))
