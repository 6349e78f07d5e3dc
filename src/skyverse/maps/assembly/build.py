"""Maps in, a scenario out: terrain, buildings and zones of the user's own, cropped, and brought to local metres."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import ValidationError

from skyverse.errors import InputError
from skyverse.maps.assembly import extent, frame
from skyverse.maps.assembly.licence import licence_of, licensed
from skyverse.maps.assembly.obstacles import bounded, placed, prisms, refuse_inside, slimmed
from skyverse.maps.assembly.places import (
    Places,
    homes,
    local_points,
    named,
    refuse_low,
    refuse_off_map,
    refuse_outside,
    refuse_swapped,
)
from skyverse.maps.assembly.region import Area, checked
from skyverse.maps.assembly.terrain import flat_ground, height_of, read_terrain
from skyverse.maps.georeference.choices import Choices, Reading
from skyverse.maps.georeference.feature import Feature
from skyverse.maps.readers import aerial
from skyverse.maps.readers.raster import Raster, Rectangle, opened
from skyverse.model.altitude import AboveSea, Altitude
from skyverse.model.scenario import (
    Bounds,
    Frame,
    Lattice,
    Objective,
    Origin,
    Scenario,
    Source,
    Target,
    require_geoid,
)
from skyverse.model.shapes import Prism, Terrain, Voxels
from skyverse.model.uav import UAV


@dataclass(frozen=True)
class Note:
    """What was done with a file, in words.

    Attributes
    ----------
    file
        Its path, or ``""`` for what is of no single file.
    text
        What was done.
    """

    file: str
    text: str


UNSAID = "heights without a unit taken as metres; --terrain-unit ft takes them as feet"


def _silent(_: Note) -> None:
    pass


def build_scenario(
    name: str,
    *,
    terrain: Sequence[Raster | str | Path] = (),
    buildings: Sequence[str | Path] = (),
    zones: Sequence[str | Path] = (),
    soft_zones: Sequence[tuple[str | Path, float]] = (),
    voxels: Sequence[str | Path] = (),
    uavs: Places = (),
    targets: Places = (),
    origin: Origin | None = None,
    area: tuple[float, float, float, float] | None = None,
    margin: float | None = None,
    ceiling: Altitude | None = None,
    ground: AboveSea | None = None,
    clearance: float = 2.0,
    ground_clearance: float | None = None,
    lattice_step: float | None = None,
    terrain_step: float | None = None,
    voxel_size: float | None = None,
    fill_nodata: float | Literal["nearest"] | None = None,
    band: tuple[float, float] | None = None,
    band_weight: float = 0.1,
    tolerance: float = 0.5,
    reading: Reading | None = None,
    licences: Mapping[str, str] | None = None,
    geoid: float | None = None,
    on_note: Callable[[Note], object] = _silent,
) -> Scenario:
    """Build a scenario of maps.

    Everything is made no smaller than its file has it: the ground is raised to its highest points, outlines grow.

    Parameters
    ----------
    name
        Of the scenario.
    terrain
        Rasters of ground heights: whatever rasterio reads.
    buildings, zones
        Files of what must not be entered: GeoJSON, KML, Shapefile, GeoPackage, CityJSON, OpenStreetMap.
    soft_zones
        Files of what may be flown through, and the risk of a metre flown inside, where no field ``risk`` says it.
    voxels
        Point clouds that say where on Earth they lie, .las or .laz, taken from the air: what is below a point counts as
        occupied. Points of noise are left out, those of the ground where there is a terrain.
    uavs, targets
        Latitude, longitude (WGS84 degrees) and altitude of each, in order or by name. A UAV's home is the ground
        below its start as the terrain's files have it, before it is raised.
    origin
        Of the local frame; by default the middle of the area, at its lowest ground.
    area
        West, south, east, north, degrees. By default what lies within `margin` of UAVs and targets, or, without any,
        all that the terrain or the buildings cover.
    margin
        Metres.
    ceiling
        How high the bounds reach, above the sea or above the highest ground; by default 30 m above the highest of
        ground, buildings, UAVs and targets.
    ground
        Level ground at this altitude, where there is no terrain.
    clearance
        From obstacles, metres.
    ground_clearance
        Above ground, metres; as `clearance` when left out.
    lattice_step
        Metres; the shortest of 1, 2, 5, 10 ... that makes at most two million nodes when left out.
    terrain_step
        Between heights, metres; about that of the finest raster when left out.
    voxel_size
        Of point clouds, metres; 2 or more, for no more than eight million voxels, when left out.
    fill_nodata
        What stands for the ground where rasters have none: metres above mean sea level, or the nearest height. Such
        holes are refused when left out.
    band, band_weight
        Metres above ground that paths should keep to, and the price of a metre flown a metre outside.
    tolerance
        By how much outlines may grow to lose corners, metres.
    reading
        How files of buildings, zones and points are to be read where they leave it open.
    licences
        By file as given (or its name, where only one has it), where a file does not say its licence itself.
    geoid
        How far mean sea level lies above the WGS84 ellipsoid there, metres, where it is known.
    on_note
        Called with each thing done, as it is done.

    Returns
    -------
    Scenario

    Raises
    ------
    InputError
        If something cannot be used; the message names file, feature or UAV, what was expected and found.
    """
    _refuse_numbers(0.0, clearance=clearance, ground_clearance=ground_clearance, margin=margin, tolerance=tolerance)
    _refuse_numbers(1e-3, lattice_step=lattice_step, terrain_step=terrain_step, band_weight=band_weight)
    _refuse_numbers(-1000.0, fill_nodata=None if fill_nodata == "nearest" else fill_nodata)
    if geoid is not None:
        require_geoid(geoid)
    rasters = [raster if isinstance(raster, Raster) else Raster(raster) for raster in terrain]
    starts, goals = named(uavs, "uav"), named(targets, "target")
    places = [*starts.values(), *goals.values()]
    chosen = reading or Reading()
    read = _read(buildings, zones, soft_zones, chosen, on_note)
    clouds = [_cloud(Path(path), chosen, on_note) for path in voxels]
    outlines = [*(feature.outline for _, found in read for feature in found), *(cloud.outline for cloud in clouds)]
    corners = np.concatenate([np.empty((0, 2)), *outlines])
    if rasters and ground is not None:
        raise InputError("--ground: expected it without a terrain, found both; the terrain says where the ground is")
    if origin is not None and geoid is not None:
        if origin.geoid not in (None, geoid):
            raise InputError(f"--geoid: expected that of the origin, {origin.geoid:g}, found {geoid:g}")
        origin = origin.model_copy(update={"geoid": geoid})
    with ExitStack() as stack:
        files = [stack.enter_context(opened(raster)) for raster in rasters]
        for file in files:
            for said in (file.doubt, "" if file.says_unit else UNSAID):
                if said:
                    on_note(Note(file.path, said))
        for some in (starts, goals):
            refuse_off_map(some, files)
        bounds = None if area is None else Area(*area)
        if bounds is not None:
            refuse_off_map({"the middle of --area": (*bounds.middle, AboveSea(0))}, files)
        level = origin or frame.middle(bounds, places, files, corners, geoid)
        if origin is not None:
            frame.refuse_far(origin, frame.middle(bounds, places, files, corners, geoid))
        region = frame.kept(bounds, margin, places, files, corners, level, lambda *told: on_note(Note(*told)))
        refuse_outside([*starts, *goals], places, level, region, "the area")
        sources = [
            (
                Path(file.path),
                Source(file=Path(file.path).name, gives="terrain", licence=file.licence, crs=file.name),
            )
            for file in files
        ]
        ground_at = homes(starts, files, level.geoid)
    relief = _relief(rasters, ground, level, region, terrain_step, fill_nodata, ground_clearance, on_note)
    zero, relief = (level, relief) if origin is not None or relief is None else _lowered(level, relief)
    reach = 2 * clearance + 10.0
    cut = [placed(found, zero, region, relief, reach) for _, found in read]
    solids = {cloud.path: _voxels(cloud, zero, region, reach, relief, voxel_size, on_note) for cloud in clouds}
    starting, ending = (local_points(some, starts, zero, relief, ground_at) for some in (starts, goals))
    standing = {name: _z(zero, starting[name], altitude) for name, altitude in ground_at.items()}
    above = clearance if ground_clearance is None else ground_clearance
    refuse_low(starting, relief, above, standing)
    refuse_low(ending, relief, above)
    points = [*starting.values(), *ending.values()]
    floor, highest = extent.heights(relief, cut, [one for some in solids.values() for one in some], points)
    top = extent.ceiling(ceiling, band, zero, region, relief, floor, highest)
    for ends in (starting, ending):
        extent.refuse_high(ends, top)
    obstacles: list[Prism | Voxels] = []
    soft: list[Prism] = []
    for cloud in clouds:
        for ends in (starting, ending):
            refuse_inside(ends, solids[cloud.path], clearance, cloud.path.name)
        obstacles += solids[cloud.path]
        sources.append((cloud.path, Source(file=cloud.path.name, gives="voxels", crs=cloud.name)))
    for (path, found), one in zip(read, cut, strict=True):
        made, counts = prisms(slimmed(bounded(one, floor, top, reach), tolerance))
        on_note(Note(str(path), _told(len(found), len(made), counts)))
        if found and not made:
            refuse_swapped(path, found, zero, region)
            on_note(Note(str(path), "nothing of it lies in the area"))
        hard = [prism for prism in made if prism.risk is None]
        for ends in (starting, ending):
            refuse_inside(ends, hard, clearance, Path(path).name)
        obstacles += hard
        soft += [prism for prism in made if prism.risk is not None]
        gives = "buildings" if path in map(str, buildings) else "zones"
        where = Path(path)
        sources.append((where, Source(file=where.name, gives=gives, licence=licence_of(where))))
    box = Bounds(min=(region[0], region[1], floor), max=(region[2], region[3], top))
    try:
        return Scenario(
            name=name,
            bounds=box,
            obstacles=tuple(obstacles),
            zones=tuple(soft),
            terrain=relief,
            clearance=clearance,
            lattice=Lattice(step=extent.lattice(box, lattice_step)),
            objective=Objective(unit="metres", altitude=extent.band(band, band_weight, relief)),
            uavs=tuple(UAV(name=uav, start=point, home=standing.get(uav)) for uav, point in starting.items()),
            targets=tuple(Target(name=target, position=point) for target, point in ending.items()),
            frame=Frame(origin=zero),
            sources=tuple(licensed(sources, licences or {})),
        )
    except ValidationError as error:
        raise InputError(f"{name}: {error.errors()[0]['msg'].removeprefix('Value error, ')}") from None


def _refuse_numbers(least: float, **numbers: float | None) -> None:
    for name, value in numbers.items():
        if value is not None and not least <= value <= 1e6:
            raise InputError(f"--{name.replace('_', '-')}: expected a number from {least:g} on, found {value:g}")


Read = list[tuple[str, list[Feature]]]
"""Files and what is in them."""


def _read(
    buildings: Sequence[str | Path],
    zones: Sequence[str | Path],
    soft_zones: Sequence[tuple[str | Path, float]],
    reading: Reading,
    on_note: Callable[[Note], object],
) -> Read:
    from skyverse.maps.readers.vector import read_features

    asked: list[tuple[str, str | None, float | None]] = [(str(path), "building", None) for path in buildings]
    asked += [(str(path), None, None) for path in zones]
    asked += [(str(path), None, risk) for path, risk in soft_zones]
    read = []
    for path, kind, risk in asked:
        if risk is not None and not (math.isfinite(risk) and risk > 0):
            raise InputError(f"{path}: expected a risk above 0, found {risk:g}")
        told: list[str] = []
        found = read_features(path, Choices(**vars(reading), kind=kind, risk=risk, tell=told.append))
        _tell(path, told, on_note)
        read.append((path, found))
    return read


def _tell(path: str, told: list[str], on_note: Callable[[Note], object]) -> None:
    for sentence in told[:MOST_TOLD]:
        on_note(Note(path, sentence.removeprefix(f"{path}: ")))
    if len(told) > MOST_TOLD:
        on_note(Note(path, f"and {len(told) - MOST_TOLD} more like these"))


MOST_TOLD = 5


def _cloud(path: Path, reading: Reading, on_note: Callable[[Note], object]) -> aerial.Cloud:
    told: list[str] = []
    cloud = aerial.opened(path, Choices(**vars(reading), tell=told.append))
    _tell(str(path), told, on_note)
    return cloud


def _voxels(
    cloud: aerial.Cloud,
    zero: Origin,
    region: Rectangle,
    reach: float,
    relief: Terrain | None,
    size: float | None,
    on_note: Callable[[Note], object],
) -> list[Voxels]:
    solid, counts = aerial.voxels(cloud, zero, region, reach, relief, size)
    if solid is None:
        on_note(Note(str(cloud.path), "nothing of it stands in the area"))
        return []
    left = "".join(f", {counts[what]:,} {what} left out" for what in aerial.LEFT_OUT if counts[what])
    on_note(
        Note(
            str(cloud.path),
            f"{counts['kept']:,} points{left}; {counts['columns']:,} columns of voxels of {solid.step[0]:g} m, "
            "occupied from the highest point down, as what is below was not seen",
        )
    )
    return [solid]


def _relief(
    rasters: list[Raster],
    ground: AboveSea | None,
    level: Origin,
    region: Rectangle,
    step: float | None,
    fill: float | Literal["nearest"] | None,
    clearance: float | None,
    on_note: Callable[[Note], object],
) -> Terrain | None:
    checked(region, "the area")
    if not rasters:
        return None if ground is None else flat_ground(level, region, ground.metres, clearance)
    relief, raised = read_terrain(rasters, level, region, step=step, fill=fill, clearance=clearance)
    nx, ny = relief.heights.shape
    for raster in rasters:
        on_note(Note(str(raster.path), f"read over {region[2] - region[0]:g} m by {region[3] - region[1]:g} m"))
    on_note(
        Note(
            "",
            f"ground of {nx} x {ny} heights, {raised.step:.3g} m apart; {raised.share:.0%} of them raised, by "
            f"{raised.mean:.2f} m on average and {raised.most:.2f} m at most, so that no height of a file stands out",
        )
    )
    if raised.filled:
        on_note(Note("", f"{raised.filled:.2%} of the ground had no data, and was filled"))
    return relief


def _lowered(level: Origin, relief: Terrain) -> tuple[Origin, Terrain]:
    """Put the frame's zero at the lowest ground, whole metres: only z changes."""
    down = float(np.floor(relief.heights.min()))
    frame = level.model_copy(update={"altitude": level.altitude + down})
    return frame, Terrain(
        origin=relief.origin, step=relief.step, heights=relief.heights - down, clearance=relief.clearance
    )


def _z(frame: Origin, point: tuple[float, float, float], altitude: float) -> float:
    """Return z of an altitude above mean sea level over or below a point."""
    x, y, z = (np.array([value]) for value in (*point[:2], altitude))
    return float(height_of(frame, x, y, z)[0])


def _told(features: int, made: int, counts: Counter[str]) -> str:
    more = "".join(f", {number:,} {what}" for what, number in counts.items() if number)
    return f"{features:,} outlines, {made:,} prisms{more}"
