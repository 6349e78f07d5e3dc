"""The photo lines of structures: layers before their walls, circles around them, and viewpoints for what is left."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import shapely

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.model.coverage import CoverageGap
from skyverse.model.pad import ground_height
from skyverse.model.scenario import Scenario
from skyverse.model.survey import Survey
from skyverse.model.timed_shapes import temporary_zones, with_zones_active
from skyverse.space.world import World
from skyverse.survey.facets import Facets, StructureOutline, facets_of, heading_of, outlines
from skyverse.survey.flying import flying, greatest_error
from skyverse.survey.lines import PhotoLine, SurveyLines
from skyverse.survey.viewpoints import few_views
from skyverse.survey.views import OFF_WALL, Look, Sights, look_of

IN_FRAME = 6.0
"""Facets across the shorter side of a photo without errors; an odd number of them, five, fit with usual errors."""
LEAST_SIDES, MOST_SIDES = 8, 18
"""Sides of the polygon that is flown for a circle."""
LEAST_HALF = 0.05
"""Metres of a wall that a photo shows for certain to either side of its middle, at least."""
SAMPLES = 50
"""Places before a facet at which it is asked what hides it."""
PARTS_OF_STEP = 4
"""Parts of a step between photos that are asked for singly whether they are clear."""


class WallFrame(NamedTuple):
    """What a photo of a wall is certain to show of it.

    Attributes
    ----------
    distance
        Metres from the camera to the wall.
    half
        Metres to either side at all heights.
    low, high
        Metres above the camera from which and up to which.
    """

    distance: float
    half: float
    low: float
    high: float


def structure_lines(scenario: Scenario, number: int) -> SurveyLines:
    """Plan the lines along which photos of structures are taken.

    Parameters
    ----------
    scenario
        The space, and the survey.
    number
        The survey's index, whose pattern is ``"facade"``, ``"viewpoints"`` or ``"orbit"``.

    Returns
    -------
    SurveyLines
        All clear of everything for the UAVs that fly it. Facets that layers and circles do not show have viewpoints.

    Raises
    ------
    InputError
        If the distance to the walls is less than what must be kept from them, the camera looks too steeply, or facets
        lie in free air, where nothing keeps UAVs away from them.
    """
    survey = scenario.surveys[number]
    uavs = flying(scenario, survey)
    error = greatest_error(uavs)
    look = look_of(survey, error)
    kept, field = scenario.clearance + error.horizontal, "height" if survey.gsd is None else "gsd"
    if look.distance < kept:
        raise InputError(
            f"expected photos from a distance of {kept:.3g} m or more, the clearance and the tracking error, found "
            f"{max(look.distance, 0.0):.3g} m, which the errors leave",
            field=field,
        )
    as_closed = with_zones_active(scenario, temporary_zones(scenario))
    world, sights = World(as_closed, error), Sights(scenario, survey, look)
    _require_inside(world, survey)
    frame = frame_of(look, 0.0 if survey.pattern == "viewpoints" else survey.pitch, field)
    facets = facets_of(scenario, survey, 2.0 * look.distance * min(look.wide, look.high) / IN_FRAME)
    facets = facets.chosen(~sights.inside_structures(facets))
    lines: list[PhotoLine] = []
    if survey.pattern != "viewpoints":
        lines = [one for one in _layers(scenario, survey, frame, world) if len(sights.seen(_views(one), facets)[0])]
    views = np.concatenate([np.zeros((0, 5)), *map(_views, lines)])
    shown = np.isin(np.arange(len(facets)), sights.seen(views, facets)[1])
    more, found = few_views(world, sights, facets.chosen(~shown), survey.gimbal)
    fastest = max(uav.max_speed for uav in uavs)
    lines += [PhotoLine(number, view[None, :3], 0.0, fastest, float(view[4]), float(view[3])) for view in more]
    lines = [replace(one, survey=number, speed=min(one.speed, fastest)) for one in lines]
    shown[~shown] = found
    return SurveyLines(tuple(lines), tuple(_unseen(number, world, sights, facets.chosen(~shown))))


def _require_inside(world: World, survey: Survey) -> None:
    """Refuse facets that no obstacle holds: they are what is seen, and obstacles are what is kept from."""
    if not survey.facets:
        return
    shares = np.array([*np.eye(3), *(1.0 - np.eye(3)) / 2.0, (1.0 / 3.0,) * 3])  # corners, middles of sides, the middle
    places = np.einsum("ij,njk->nik", shares, np.array(survey.facets))
    outside = world.distance(places.reshape(-1, 3)).reshape(len(places), -1).max(axis=1)
    worst = int(outside.argmax())
    if outside[worst] > OFF_WALL:
        raise InputError(
            f"expected facets in obstacles of the scenario, which UAVs keep away from, such as the voxels of their "
            f"mesh, found one that is {outside[worst]:.3g} m outside of all",
            field=f"facets[{worst}]",
        )


def _views(line: PhotoLine) -> Floats:
    """Return the views (m, 5) of a straight line's photos."""
    count = round(math.hypot(*(line.path[-1] - line.path[0])[:2]) / line.every) + 1 if line.every > 0 else 1
    places = np.linspace(line.path[0], line.path[-1], count)
    return np.column_stack([places, np.tile([line.heading or 0.0, line.pitch], (count, 1))])


def frame_of(look: Look, pitch: float, field: str) -> WallFrame:
    """Return what is certain to be shown of a wall by a photo whose camera looks at it with a pitch, degrees.

    See `views` for the planes of a picture's sides; a sight is at most as long as that on a corner at the depth.
    """
    c, s = math.cos(math.radians(pitch)), math.sin(math.radians(pitch))
    if c - look.high * abs(s) <= 0.1:
        raise InputError(
            f"expected a camera that sees walls before it, found a pitch of {pitch:g} degrees", field="gimbal"
        )
    distance = look.distance * (c - look.high * abs(s))
    lost = look.turn * (look.distance * look.corner + look.off) + look.off
    side = lost * math.hypot(1.0, look.high)
    high = (distance * (look.high * c + s) - side) / (c - look.high * s)
    low = -(distance * (look.high * c - s) - side) / (c + look.high * s)
    nearest = min(distance * c + low * s, distance * c + high * s)
    half = look.wide * nearest - lost * math.hypot(1.0, look.wide)
    if half <= LEAST_HALF or high - low <= 2.0 * LEAST_HALF:
        raise InputError(
            f"expected photos that show something for certain, found that the tracking error and the camera's leave "
            f"nothing of them at a distance of {distance:.3g} m",
            field=field,
        )
    return WallFrame(distance, half, low, high)


@dataclass(frozen=True, eq=False)
class _Run:
    """A straight way before a wall, or on a circle: from `a` to `b` (2,), where it looks, and from where to where."""

    a: Floats
    b: Floats
    heading: float
    low: float
    high: float


def _layers(scenario: Scenario, survey: Survey, frame: WallFrame, world: World) -> Iterator[PhotoLine]:
    """Yield the lines of layers before walls, or of circles."""
    front, beside = (1.0 - share / 100.0 for share in survey.overlap)
    step = 2.0 * frame.half * front
    for outline in outlines(scenario, survey):
        runs = _sides(outline, frame) if survey.pattern == "facade" else _circle(outline, frame, step)
        for run in runs:
            for z in _heights(scenario, world, run, frame, beside):
                yield from _pieces(world, run, z, step, survey)


def _sides(outline: StructureOutline, frame: WallFrame) -> Iterator[_Run]:
    """Yield the ways before the sides of an outline."""
    for ring in outline.rings:
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            along = (b - a) / math.hypot(*(b - a))
            out = np.array([along[1], -along[0]])
            places = a + frame.distance * out, b + frame.distance * out
            yield _Run(*places, heading_of(-out), outline.low, outline.high)


def _circle(outline: StructureOutline, frame: WallFrame, step: float) -> Iterator[_Run]:
    """Yield the sides of a polygon in the circle around an outline, at a distance."""
    corners = shapely.MultiPoint(outline.rings[0])
    centre = shapely.get_coordinates(shapely.minimum_bounding_circle(corners).centroid)[0]
    radius = shapely.minimum_bounding_radius(corners) + frame.distance
    sides = min(max(math.ceil(2.0 * math.pi * radius / step), LEAST_SIDES), MOST_SIDES)
    turn = 2.0 * math.pi * np.arange(sides) / sides
    ring = centre + radius * np.column_stack([np.sin(turn), np.cos(turn)])
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        yield _Run(a, b, heading_of(centre - 0.5 * (a + b)), outline.low, outline.high)


def _heights(scenario: Scenario, world: World, run: _Run, frame: WallFrame, beside: float) -> Floats:
    """Return the heights of the layers that show a wall, as low and as high as may be flown."""
    places = np.linspace(run.a, run.b, 9)
    floor = max(float(world.space.low[2]), *(world.least_height([*place, 0.0]) for place in places))
    low, high = max(run.low, scenario.bounds.min[2], float(ground_height(scenario, places).min())), run.high
    first, last = max(low - frame.low, floor), min(high - frame.high, float(world.space.high[2]))
    tall = frame.high - frame.low
    if first >= last:
        return np.array([min(max(0.5 * (low + high - frame.low - frame.high), floor), float(world.space.high[2]))])
    return np.linspace(first, last, 1 + math.ceil((last - first) / (tall * beside)))


def _pieces(world: World, run: _Run, z: float, step: float, survey: Survey) -> Iterator[PhotoLine]:
    """Yield the clear pieces of a way at a height as lines, with photos in the middle of equal parts of the way."""
    length = math.hypot(*(run.b - run.a))
    parts = max(1, math.ceil(length / step))
    every = length / parts
    shares = np.linspace(0.5 / parts, 1.0 - 0.5 / parts, (parts - 1) * PARTS_OF_STEP + 1)
    places = np.column_stack([run.a + shares[:, None] * (run.b - run.a), np.full(len(shares), z)])
    clear = world.free(places)
    joined = world.segments_free(places[:-1], places[1:])
    first = 0
    while first < len(places):
        last = first
        while last + 1 < len(places) and clear[first] and joined[last]:
            last += 1
        if clear[first]:
            whole = max(math.ceil((last - first) / PARTS_OF_STEP), 0)
            path = places[[first, last]] if last > first else places[[first]]
            each = every * (last - first) / PARTS_OF_STEP / whole if whole else 0.0
            speed = each / survey.camera.min_interval if whole else math.inf
            yield PhotoLine(0, path, each, speed, survey.pitch, run.heading)
        first = last + 1


def _unseen(number: int, world: World, sights: Sights, facets: Facets) -> Iterator[CoverageGap]:
    """Yield the facets that nothing shows, with why; those of one wall and reason together."""
    why = np.array([_why(world, sights, *one) for one in zip(facets.centre, facets.normal, strict=True)], dtype=object)
    for wall, reason in dict.fromkeys(zip(facets.wall.tolist(), why.tolist(), strict=True)):
        part = facets.corners[(facets.wall == wall) & (why == reason)]
        normal, origin = facets.normal[facets.wall == wall][0], part[0, 0]
        u = (part[0, 1] - origin) / math.sqrt(((part[0, 1] - origin) ** 2).sum())
        basis = np.array([u, np.cross(normal, u)])
        flat = np.einsum("nki,ji->nkj", part - origin, basis)
        whole = shapely.union_all(shapely.polygons(flat), grid_size=OFF_WALL)
        for piece in shapely.get_parts(whole):
            ring = shapely.get_coordinates(piece.exterior.simplify(OFF_WALL))[:-1]
            places = origin + np.einsum("nj,ji->ni", ring, basis)
            yield CoverageGap(number, tuple(tuple(place.tolist()) for place in places), float(piece.area), reason)


def _why(world: World, sights: Sights, centre: Floats, normal: Floats) -> str:
    """Say why a facet is not seen: what hides it from straight before it, or why nothing may be flown there."""
    distance = sights.look.distance
    for way in np.linspace(2.0 * OFF_WALL, distance, SAMPLES):
        hiding = sights.world.blocker(centre + way * normal, -sights.world.space.clearance)
        if hiding is not None:
            return f"hidden by {_called(sights.world, hiding)}"
    place = centre + distance * normal
    near = world.blocker(place)
    if near is not None:
        return f"too near {_called(world, near)} to be flown before"
    if place[2] < max(world.least_height(place), world.space.low[2]):
        return "too near the ground to be flown before"
    return "hidden by its structure" if world.free(place)[0] else "out of the bounds to be flown before"


def _called(world: World, number: int) -> str:
    name = world.scenario.obstacles[number].name
    return repr(name) if name else "an obstacle"
