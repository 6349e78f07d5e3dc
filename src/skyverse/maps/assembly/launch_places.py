"""Where UAVs of surveys start: at places that a user gives, and beside what is surveyed."""

import math
from collections.abc import Sequence
from contextlib import ExitStack

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy, Sentence, did_you_mean, shown
from skyverse.maps.assembly.build import outdoor_limits
from skyverse.maps.assembly.options import BuildOptions, Note
from skyverse.maps.assembly.places import highest_ground
from skyverse.maps.georeference.reading import Raster
from skyverse.maps.readers.raster import open_raster
from skyverse.model.caution import Caution
from skyverse.model.geodesy import to_local, to_wgs84
from skyverse.model.scenario import Scenario, with_fitting_lattice
from skyverse.model.shapes import Prism
from skyverse.model.short_lines import counted, listed
from skyverse.model.survey import Survey
from skyverse.model.uav import UAV, kept_ellipsoid, with_limits
from skyverse.space.ground_starts import can_rise, lowest_starts
from skyverse.space.tracking_error import STEEPEST, landing_slope
from skyverse.space.world import World

BESIDE = 10.0
"""Metres from what is surveyed at which UAVs start by default."""
LEAST_APART = 5.0
"""Metres between the places of two UAVs at least, so that people can walk between them."""
SEPARATIONS = 3.0
"""And as many separations: as far as UAVs that come home at the same time from all sides pass each other."""
NEAR = 100.0
"""Metres from the place nearest to the middle within which level places are looked for."""
TRIED = 4000
"""Places at most that are tried for starts."""


def with_launches(
    world: Scenario, options: BuildOptions, surveys: Sequence[Survey], places: Sequence[tuple[float, float]], uavs: int
) -> Scenario:
    """Return a scenario with surveys, and UAVs that start and land beside what is surveyed.

    Parameters
    ----------
    world
        A scenario without UAVs, which was built with `options`; it has an origin and a terrain.
    options
        They say what UAVs can do, and which files know the ground below them.
    surveys
        What is to be seen.
    places
        Latitude and longitude, degrees, where UAVs start, in their order; others start beside the last of these, or,
        where there is none, beside what is surveyed, at the free place nearest to its middle.
    uavs
        How many there are.

    Raises
    ------
    InputError
        If a structure is not there, or there are not so many free places.
    """
    origin = world.frame.origin
    assert origin is not None
    known = {one.name for one in world.obstacles if one.name}
    for name in (name for survey in surveys for name in survey.structures if name not in known):
        hint = did_you_mean(name, known)
        raise InputError(f"there is no building of the name {shown(name)}{hint}", field="structure")
    like = with_limits(UAV(start=(0.0, 0.0, 0.0), end="home"), outdoor_limits(options))
    around, apart = (
        World(world, like.tracking_error),
        max(LEAST_APART, math.ceil(SEPARATIONS * kept_ellipsoid(like, like)[0])),
    )
    rows = [(latitude, longitude, origin.altitude) for latitude, longitude in places[:uavs]]
    chosen = to_local(origin, rows)[:, :2] if rows else np.empty((0, 2))
    tried = _around(chosen[-1], apart) if len(chosen) else _beside(_seen(world, surveys), apart)
    for place in _level_first(around, tried[_can_start(around, tried)]) if len(chosen) < uavs else ():
        if not len(chosen) or (len(chosen) < uavs and np.hypot(*(chosen - place).T).min() >= apart - 1e-3):
            chosen = np.vstack([chosen, place])
    if len(chosen) < uavs:
        expected = (
            f"expected places {apart:g} m apart beside what is to be seen, for {counted(uavs, 'UAV')} to start at"
        )
        found = f"found {len(chosen)} that are over known ground, clear of zones and obstacles"
        which = "inside the fence, also above what is to be seen" if options.fences else "of a free one"
        give = [] if places else [Remedy("launch", None, f"(latitude,longitude) {which}")]
        raise InputError(f"{expected}, {found}", field="launch", give=give)
    steep = [k for k, slope in enumerate(_slopes(around, chosen), 1) if slope > STEEPEST]
    if steep and like.fixed_wing is None:
        said = f"{Caution.WARNING}: the ground at the start of {listed([f'uav-{k}' for k in steep])} is steeper than "
        said += f"{STEEPEST:g} degrees, and no level place was found near"
        options.on_note(Note("", Sentence(said, give=[Remedy("launch", None, "(latitude,longitude) of level ones")])))
    starts = lowest_starts(around, chosen)
    homes = _homes(options, to_wgs84(origin, starts)) - origin.altitude
    fleet = [
        like.model_copy(update={"name": f"uav-{k}", "start": tuple(at), "home": None if math.isnan(home) else home})
        for k, (at, home) in enumerate(zip(starts.tolist(), homes.tolist(), strict=True), 1)
    ]
    return with_fitting_lattice(Scenario.model_validate(dict(world) | {"uavs": fleet, "surveys": tuple(surveys)}))


def _can_start(around: World, places: Floats) -> NDArray[np.bool_]:
    """Tell for each of (n, 2) places whether a UAV may stray from its start there and on its way up from the ground."""
    return np.asarray(can_rise(around, places) & around.free(lowest_starts(around, places)))


def _slopes(around: World, places: Floats) -> Floats:
    """Return by how many degrees the ground slopes at most where UAVs land, (n,)."""
    terrain = around.scenario.terrain
    return np.array([0.0 if terrain is None else landing_slope(terrain, place, around.error) for place in places])


def _level_first(around: World, places: Floats) -> Floats:
    """Return places (n, 2) in their order, but those first that are level and near the first of these."""
    level = np.hypot(*(places - places[:1]).T) <= NEAR
    level[level] = _slopes(around, places[level]) <= STEEPEST
    first = places[np.argmax(level)] if level.any() else places[:1]
    return places[np.lexsort((np.hypot(*(places - first).T), ~level))]


def _around(place: Floats, apart: float) -> Floats:
    """Return places (n, 2) on a square grid about a place, the nearest first."""
    i, j = np.mgrid[-20:21, -20:21].reshape(2, -1)[:, np.argsort(np.hypot(*np.mgrid[-20:21, -20:21].reshape(2, -1)))]
    return place + apart * np.column_stack([i, j])


def _beside(seen: BaseGeometry, apart: float) -> Floats:
    """Return places (n, 2) beside what is surveyed: the one nearest to its middle first, then those nearest to that."""
    line = seen.buffer(BESIDE).boundary
    step = max(apart / 2.0, line.length / TRIED)
    places = shapely.get_coordinates(shapely.line_interpolate_point(line, np.arange(0.0, line.length, step)))
    first = places[np.hypot(*(places - shapely.get_coordinates(seen.centroid)).T).argmin()]
    return places[np.argsort(np.hypot(*(places - first).T), kind="stable")]


def _seen(world: Scenario, surveys: Sequence[Survey]) -> BaseGeometry:
    """Return all that surveys see, seen from above and without holes, metres."""
    parts = [shapely.Polygon(part.vertices) for survey in surveys for part in survey.area]
    parts += [shapely.LineString(survey.line).buffer(survey.width / 2) for survey in surveys if survey.width]
    parts += [shapely.MultiPoint([corner[:2] for facet in survey.facets for corner in facet]) for survey in surveys]
    named = {name for survey in surveys for name in survey.structures}
    parts += [shapely.Polygon(one.vertices) for one in world.obstacles if isinstance(one, Prism) and one.name in named]
    return shapely.union_all(parts)


def _homes(options: BuildOptions, places: Floats) -> Floats:
    """Return the altitude of the real ground below places (n, 3), latitude first, metres above the sea, (n,)."""
    rasters = [raster if isinstance(raster, Raster) else Raster(raster) for raster in options.terrain]
    if not rasters:
        return np.full(len(places), math.nan)
    with ExitStack() as stack:
        files = [stack.enter_context(open_raster(raster)) for raster in rasters]
        return highest_ground(places[:, :2], files, options.geoid)
