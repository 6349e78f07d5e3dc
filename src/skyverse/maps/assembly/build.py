"""A scenario from the user's own maps: terrain, buildings, zones and points, cropped and brought to local metres."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy, Sentence, require_kind
from skyverse.maps.assembly import frame, inputs
from skyverse.maps.assembly.bad_points import BadPoint, Point, refuse_bad_points
from skyverse.maps.assembly.fences import fence_around
from skyverse.maps.assembly.frame import Area, require_size
from skyverse.maps.assembly.obstacles import BEYOND, BURIED, local_features, prisms, simplified, within_bounds
from skyverse.maps.assembly.options import BuildOptions, Note
from skyverse.maps.assembly.places import (
    homes,
    local_points,
    low_points,
    named_places,
    points_above_ceiling,
    points_inside,
    refuse_off_map,
    refuse_one_swapped,
    refuse_outside,
    refuse_swapped,
)
from skyverse.maps.assembly.terrain import level_ground, read_terrain
from skyverse.maps.georeference.feature import Rectangle
from skyverse.maps.georeference.reading import Raster
from skyverse.maps.readers.aerial_point_cloud import AerialCloud
from skyverse.maps.readers.raster import open_raster
from skyverse.model.altitude import AboveGround, AboveSea, GlobalPlace
from skyverse.model.caution import NO_UNIT, Caution, stands_out
from skyverse.model.frame import Frame, Origin
from skyverse.model.quantities import derived
from skyverse.model.scenario import Bounds, Lattice, Objective, Scenario, Source, Target, upright_step
from skyverse.model.shapes import FENCE, Prism, Terrain, Voxels
from skyverse.model.short_lines import counted, listed
from skyverse.model.uav import UAV, with_limits
from skyverse.model.vehicle_profiles import VEHICLE_PROFILES, FleetLimits

FARTHEST = 30_000.0
"""Metres between what a scenario is built around, at most: surveys and the places where UAVs start."""
OUTDOOR = FleetLimits(max_speed=5.0, max_climb=3.0, max_descent=1.5, separation=5.0, tracking_error=(1.6, 3.0))
"""Limits of outdoor flight, where none are given.

The speeds are those at which PX4 flies missions unless it is told otherwise (MPC_XY_CRUISE, MPC_Z_V_AUTO_UP and
MPC_Z_V_AUTO_DN). The separation is ten times the default for rooms. The tracking error is twice the standard deviations
of the position of a standard GNSS module, such as u-blox M8, that PX4's documentation gives as typical: eph 0.8 m and
epv 1.5 m, in "Using PX4's Navigation Filter (EKF2)", section "GNSS Performance Requirements"
(docs.px4.io/main/en/advanced_config/tuning_the_ecl_ekf). Wind is not in it.
"""


def build_scenario(options: BuildOptions) -> Scenario:
    """Build a scenario from maps.

    Nothing becomes smaller than its file has it: the ground is raised to its highest points, and outlines grow.

    Parameters
    ----------
    options
        The files, the places, and how they are used.

    Returns
    -------
    Scenario

    Raises
    ------
    InputError
        If something cannot be used; the message names file, feature or UAV, what was expected and what was found.
    """
    require_kind(options, BuildOptions, "options")
    told: list[Note] = []
    options = replace(options, on_note=_kept_too(options.on_note, told))
    starts, goals = named_places(options.uavs, "uav"), named_places(options.targets, "target")
    files, clouds = inputs.read_feature_files(options), inputs.open_clouds(options)
    around = [file for file in files if file.gives == FENCE] or files
    outlines = [feature.outline for file in around for feature in file.features]
    outlines += [] if options.fences else [one.outline for one in clouds]
    site = _survey(options, starts, goals, np.concatenate([np.empty((0, 2)), *outlines]))
    ends = _ends(options, site, starts, goals)
    contents = _contents(options, site, ends, files, clouds)
    built = _assembled(options, site, ends, contents, told)
    on_ground = [k for k, place in enumerate(starts.values()) if _is_on_ground(place)]
    if on_ground and not (ends.bad or contents.bad):
        from skyverse.space.ground_starts import risen  # it compiles kernels, which nothing else here needs

        built = risen(built, on_ground, lambda said: options.on_note(Note("", said)))
    altitudes = [altitude for _, _, altitude in (*starts.values(), *goals.values())]
    given = dict(zip((point for _, point in ends.all), altitudes, strict=True))
    refuse_bad_points([*ends.bad, *contents.bad], built, given)
    if goals and not starts:
        said = f"{Caution.WARNING}: {counted(len(goals), 'target')}, and no UAV that flies there"
        options.on_note(Note("", Sentence(said, give=[Remedy("uavs")])))
    return built


def _kept_too(on_note: Callable[[Note], object], told: list[Note]) -> Callable[[Note], object]:
    """Return what passes notes on, and keeps them."""

    def kept(note: Note) -> None:
        told.append(note)
        on_note(note)

    return kept


def _with_cautions(path: Path, source: Source, told: Sequence[Note]) -> tuple[Path, Source]:
    """Return a source with what was told of its file that a pilot must heed, without what to give as it is read."""
    texts = [note.text for note in told if note.file and Path(note.file) == path and stands_out(note.text)]
    cautions = dict.fromkeys(text.text if isinstance(text, Sentence) else text for text in texts)
    return path, source.model_copy(update={"cautions": tuple(cautions)})


def _closed_above(zones: list[Prism], options: BuildOptions, top: float, path: str) -> list[Prism]:
    """Return zones that nothing may fly over if that is asked for; otherwise tell how many may be flown over."""
    if options.zones_closed_above:
        return [zone.model_copy(update={"closed_above": True}) for zone in zones]
    low = sum(zone.high + options.clearance < top for zone in zones)
    if low:
        ends = "zone ends" if low == 1 else "zones end"
        text = f"{low:,} {ends} below the top of the bounds, and may be flown over"
        give = [Remedy("zones_closed_above", True, "to forbid it")]
        options.on_note(Note(path, Sentence(text, give=give), heed=True))
    return zones


def outdoor_limits(options: BuildOptions) -> FleetLimits:
    """Return the limits of the UAVs, those of outdoor flight where neither they nor a vehicle are given, and tell."""
    given = {field.name: getattr(options, field.name) for field in fields(FleetLimits)}
    if options.vehicle is not None:
        profile = VEHICLE_PROFILES.get(options.vehicle)
        if profile is not None and options.tracking_error is None:
            aside, up = (profile.limits["tracking_error"][key] for key in ("horizontal", "vertical"))
            strays = f"{aside:g} m horizontally and {up:g} m vertically in calm air"
            told = f"UAVs may stray {strays}, by the profile {options.vehicle!r}"
            give = [Remedy("tracking_error", None, "for those in wind")]
            options.on_note(Note("", Sentence(told, give=give), heed=True))
        return FleetLimits(**given)
    limits = replace(OUTDOOR, **{name: value for name, value in given.items() if value is not None})
    assert limits.tracking_error is not None
    aside, up = limits.tracking_error
    told = (
        f"UAVs fly {limits.max_speed:g} m/s at most, climb at {limits.max_climb:g} m/s, descend at "
        f"{limits.max_descent:g} m/s and keep {limits.separation:g} m apart, by default as PX4 flies missions "
        f"outdoors, and may stray {aside:g} m horizontally and {up:g} m vertically, by default twice a GPS receiver's "
        "standard deviation"
    )
    options.on_note(Note("", Sentence(told, give=[Remedy("vehicle", "camera", "for the limits of a vehicle")])))
    return limits


@dataclass(frozen=True)
class _Site:
    """Where a scenario lies.

    Attributes
    ----------
    origin
        The local frame's origin: at the lowest ground, or at sea level where that is not known, unless the user says.
    region
        The part of the frame that the scenario holds.
    ground
        The ground over the region, if it is known.
    homes
        z of the ground below UAVs' starts, as far as the terrain's files know it.
    sources
        The terrain's files and what they say of themselves.
    """

    origin: Origin
    region: Rectangle
    ground: Terrain | None
    homes: dict[str, float]
    sources: list[tuple[Path, Source]]


@dataclass(frozen=True)
class _Ends:
    """Where UAVs start and what they fly to, local points by name, and which of these cannot be where they are."""

    starts: dict[str, Point]
    targets: dict[str, Point]
    bad: list[BadPoint]

    @property
    def all(self) -> list[tuple[str, Point]]:
        """All of them, UAVs' starts first."""
        return [*self.starts.items(), *self.targets.items()]


@dataclass(frozen=True)
class _Contents:
    """What stands in a scenario and where that comes from, its bounds, and the points that cannot be where they are."""

    bounds: Bounds
    obstacles: tuple[Prism | Voxels, ...]
    zones: tuple[Prism, ...]
    sources: list[tuple[Path, Source]]
    bad: list[BadPoint]


def _survey(
    options: BuildOptions, starts: Mapping[str, GlobalPlace], goals: Mapping[str, GlobalPlace], corners: Floats
) -> _Site:
    """Find out where a scenario lies: from its area, places, fence, rasters, or what stands in it.

    The last one, or the fence where there is one, has the corners (n, 2).
    """
    origin, on_note, margin = options.origin, options.on_note, options.margin
    rasters = [raster if isinstance(raster, Raster) else Raster(raster) for raster in options.terrain]
    if rasters and options.ground is not None:
        raise InputError(
            "expected it without a terrain, found both; the terrain says where the ground is", field="ground"
        )
    if origin is not None and options.geoid is not None:
        if origin.geoid not in (None, options.geoid):
            raise InputError(f"expected that of the origin, {origin.geoid:g}, found {options.geoid:g}", field="geoid")
        origin = origin.model_copy(update={"geoid": options.geoid})
    seen = _around(options)
    places: list[GlobalPlace] = [*starts.values(), *goals.values(), *(place for _, place in seen)]
    with ExitStack() as stack:
        files = [stack.enter_context(open_raster(raster)) for raster in rasters]
        for file in files:
            for said in filter(None, (file.doubt, "" if file.says_unit else NO_UNIT)):
                on_note(Note(file.path, said))
        for some in (starts, goals, *(dict([one]) for one in seen)):
            refuse_off_map(some, files)
        area = None if options.area is None else Area(*options.area)
        if area is None:
            refuse_one_swapped([*starts.items(), *goals.items()])
        fenced = bool(options.fences) and area is None and not places
        known = [] if fenced else files
        margin = 0.0 if fenced and margin is None else margin
        if area is not None:
            refuse_off_map({"the middle of the area": (*area.middle, AboveSea(0))}, files)
        middle = frame.middle_of(area, places, known, corners, options.geoid)
        level = origin or middle
        if origin is not None:
            frame.refuse_far(origin, middle)
        region = frame.region_of(area, margin, places, known, corners, level, lambda *told: on_note(Note(*told)))
        filled = f", the rectangle along east and north that {files[0].path} fills" if files and area is None else ""
        refuse_outside([*starts, *goals], [*starts.values(), *goals.values()], level, region, f"the area{filled}")
        for name, place in seen:
            refuse_outside([name], [place], level, region, f"the area{filled}")
        sources = [
            (Path(file.path), Source(file=Path(file.path).name, gives="terrain", licence=file.licence, crs=file.name))
            for file in files
        ]
        altitudes = homes(starts, files, level.geoid)
    ground = _ground(options, rasters, level, region)
    if origin is None and ground is not None:
        level, ground = _lowered(level, ground)
    return _Site(level, region, ground, {name: at - level.altitude for name, at in altitudes.items()}, sources)


def _around(options: BuildOptions) -> list[tuple[str, GlobalPlace]]:
    """Return the outermost corners of what a scenario is built around, each with the name of its file."""
    if not options.around:
        return []
    import pyproj

    from skyverse.maps.readers.areas import corners_of

    crs = None if options.reading is None else options.reading.crs
    found: list[tuple[str, GlobalPlace]] = []
    for one in options.around:
        if isinstance(one, tuple):
            found += named_places({f"{one[0]:g},{one[1]:g}": (*one, AboveSea(0.0))}, "place").items()
        else:
            found += [(str(one), (float(y), float(x), AboveSea(0.0))) for x, y in corners_of(one, crs)]
    (first, (latitude, longitude, _)), middle = found[0], pyproj.Geod(ellps="WGS84")
    for name, (y, x, _) in found:
        away = middle.inv(longitude, latitude, x, y)[2]
        if away > FARTHEST:
            expected = f"expected all within {FARTHEST / 1000:g} km of one another"
            raise InputError(f"{name}: {expected}, found it {away / 1000:,.0f} km from {first}")
    return found


def _ground(options: BuildOptions, rasters: list[Raster], origin: Origin, region: Rectangle) -> Terrain | None:
    """Return the ground over the region, if it is known, and tell how it differs from the rasters."""
    require_size(region, "the area")
    if not rasters:
        ground = options.ground
        return None if ground is None else level_ground(origin, region, ground.metres, options.ground_clearance)
    step, fill, clearance = options.terrain_step, options.fill_nodata, options.ground_clearance
    relief, changes = read_terrain(rasters, origin, region, step=step, fill=fill, clearance=clearance)
    nx, ny = relief.heights.shape
    for raster in rasters:
        size = f"{region[2] - region[0]:g} m by {region[3] - region[1]:g} m"
        options.on_note(Note(str(raster.path), f"read over {size}"))
    made = (
        f"ground of {nx} x {ny} heights, {changes.step:.3g} m apart; {changes.share:.0%} of them raised, by "
        f"{changes.mean:.2f} m on average and {changes.most:.2f} m at most, so that no height of a file stands out"
    )
    options.on_note(Note("", made))
    if options.max_height is not None:
        most = options.max_height.metres
        counted = (
            f"the ceiling above ground is counted from a surface that no height of a file is below, "
            f"{changes.mean_lowered:.2f} m below this ground on average and {changes.most_lowered:.2f} m at most"
        )
        options.on_note(Note("", counted))
        assert relief.lowest is not None
        closed = float((relief.lowest + most < relief.heights + clearance).mean())
        if closed:
            text = (
                f"over {closed:.2%} of the ground no height is below the ceiling and {clearance:g} m above the ground"
            )
            options.on_note(Note("", text, heed=True))
    if changes.filled:
        options.on_note(Note("", f"{changes.filled:.2%} of the ground had no data, and was filled", heed=True))
    return relief


def _lowered(level: Origin, relief: Terrain) -> tuple[Origin, Terrain]:
    """Move the frame's zero to the lowest ground, in whole metres: only z changes."""
    down = float(np.floor(relief.heights.min()))
    lowered = level.model_copy(update={"altitude": level.altitude + down})
    lowest = None if relief.lowest is None else relief.lowest - down
    return lowered, relief.model_copy(update={"heights": relief.heights - down, "lowest": lowest})


def _ends(
    options: BuildOptions, site: _Site, starts: Mapping[str, GlobalPlace], goals: Mapping[str, GlobalPlace]
) -> _Ends:
    """Bring starts and targets into the local frame."""
    clearance = options.ground_clearance
    flown = {
        name: (*place[:2], AboveGround(clearance)) if _is_on_ground(place) else place for name, place in starts.items()
    }
    starting = local_points(flown, starts, site.origin, site.ground, site.homes)
    ending = local_points(goals, starts, site.origin, site.ground, site.homes)
    bad = [*low_points(starting, site.ground, clearance, site.homes), *low_points(ending, site.ground, clearance)]
    return _Ends(starting, ending, bad)


def _is_on_ground(place: GlobalPlace) -> bool:
    """Tell whether a place is on the ground, from which a UAV rises to its start."""
    return not isinstance(place[2], AboveSea) and place[2].metres == 0.0


def _contents(
    options: BuildOptions, site: _Site, ends: _Ends, files: list[inputs.FeatureFile], clouds: list[AerialCloud]
) -> _Contents:
    """Bring buildings, zones and voxels into the local frame, within bounds that hold what UAVs could reach."""
    reach, most = 2 * options.clearance + 10.0, options.max_height
    fences, files = ([file for file in files if (file.gives == FENCE) is kind] for kind in (True, False))
    local = [local_features(file.features, site.origin, site.region, site.ground, reach) for file in files]
    solids = [inputs.voxels_of(cloud, site.origin, site.region, reach, site.ground, options) for cloud in clouds]
    points = [point for _, point in ends.all]
    floor, highest = frame.heights(site.ground, local, [one for some in solids for one in some], points)
    top = frame.ceiling(options.ceiling or most, options.band, site.origin, site.ground, floor, highest)
    bad = frame.high_points(ends.all, top) if most is None or options.ceiling is not None else []
    if most is not None:
        bad += points_above_ceiling(dict(ends.all), site.ground, most.metres)
    obstacles: list[Prism | Voxels] = []
    soft: list[Prism] = []
    sources = list(site.sources)
    for cloud, voxels in zip(clouds, solids, strict=True):
        bad += points_inside(ends.all, voxels, options.clearance, cloud.path.name, top)
        obstacles += voxels
        sources.append((cloud.path, Source(file=cloud.path.name, gives="voxels", crs=cloud.name)))
    for file, features in zip(files, local, strict=True):
        made, counts = prisms(simplified(within_bounds(features, floor, top, reach), options.tolerance))
        options.on_note(Note(file.path, _summary(len(file.features), len(made), counts)))
        with inputs.told_of(file.path, options.on_note) as tell:
            for said in features.heeded:
                tell(said)
        if file.features and not made:
            less = listed([f"{counts[what]:,} {what}" for what in (BURIED, BEYOND) if counts[what]])
            if not less:
                refuse_swapped(file.path, file.features, site.origin, site.region)
            nothing = f"closes anything there: {less}" if less else "lies in the area"
            options.on_note(Note(file.path, f"{Caution.WARNING}: nothing of it {nothing}"))
        hard = [prism for prism in made if prism.risk is None and prism.active is None]
        if file.gives == "zones":
            hard = _closed_above(hard, options, top, file.path)
        bad += points_inside(ends.all, hard, options.clearance, Path(file.path).name, top)
        obstacles += hard
        timed = [prism for prism in made if prism.active is not None]
        soft += [prism for prism in made if prism.risk is not None]
        soft += [derived(one, high=top + reach) for one in timed] if options.zones_closed_above else timed
    x0, y0, x1, y1 = site.region
    bounds = Bounds(min=(x0, y0, floor), max=(x1, y1, top))
    if fences:
        areas, names = [area for file in fences for area in file.features], listed([Path(f.path).name for f in fences])
        fence = fence_around(areas, site.origin, bounds, reach=reach, tolerance=options.tolerance)
        options.on_note(Note("", f"UAVs stay inside the fence of {names}: {counted(len(areas), 'area')}"))
        bad += fence.points_outside(ends.all, options.clearance, names)
        obstacles += fence.prisms
    for file in (*files, *fences):
        path = Path(file.path)
        sources.append((path, Source(file=path.name, gives=file.gives, licence=inputs.licence_of(path))))
    return _Contents(bounds, tuple(obstacles), tuple(soft), sources, bad)


def _assembled(options: BuildOptions, site: _Site, ends: _Ends, contents: _Contents, told: Sequence[Note]) -> Scenario:
    """Return the scenario of all that was found, with the cautions that were told of its files."""
    limits, most = outdoor_limits(options) if ends.starts else FleetLimits(), options.max_height
    too_low = {one.name for one in (*ends.bad, *contents.bad)}  # whose homes may be above their starts
    built = Scenario(
        name=options.name,
        bounds=contents.bounds,
        obstacles=contents.obstacles,
        zones=contents.zones,
        terrain=site.ground,
        clearance=options.clearance,
        max_height=None if most is None else most.metres,
        lattice=Lattice(step=frame.lattice_step(contents.bounds, options.lattice_step)),
        objective=Objective(
            unit="metres", altitude=frame.altitude_band(options.band, options.band_weight, site.ground)
        ),
        uavs=tuple(
            with_limits(UAV(name=uav, start=at, home=None if uav in too_low else site.homes.get(uav)), limits)
            for uav, at in ends.starts.items()
        ),
        targets=tuple(Target(name=target, position=point) for target, point in ends.targets.items()),
        frame=Frame(origin=site.origin),
        sources=tuple(
            inputs.licensed([_with_cautions(*one, told) for one in contents.sources], options.licences or {})
        ),
    )
    if options.lattice_step is not None:
        return built
    step = frame.lattice_step(contents.bounds, None, upright_step(built))
    return built.model_copy(update={"lattice": Lattice(step=step)})


def _summary(features: int, made: int, counts: Counter[str]) -> str:
    more = "".join(f", {number:,} {what}" for what, number in counts.items() if number)
    return f"{counted(features, 'outline')}, {counted(made, 'prism')}{more}"
