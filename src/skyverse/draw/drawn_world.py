"""The world of a mission as pictures show it: extent, shapes by kind, ground, proportions, and the first view."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.ground_relief import Relief, along, cleared, relief
from skyverse.draw.photo_views import drawn_surveys
from skyverse.draw.shape_geometry import drawn_fence
from skyverse.draw.shape_kinds import MAX_EDGED_SHAPES, ShapeKind, shapes_by_kind
from skyverse.draw.track import DrawnTrack
from skyverse.model.geodesy import to_wgs84
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import Box, Terrain

MAX_MAP_HEIGHTS = 700
"""The largest number of heights along each side of the map."""
MIN_MAP_MARGIN = 10.0
"""Metres: the least margin around a mission."""
MAP_MARGIN = 0.12
"""The margin around the contents of a map, as a share of their width."""
HIGHEST_CEILING = 0.5
"""A ceiling that is higher above ground than this share of the map's longer side is cut off in pictures."""
_STRETCHED = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0)


@dataclass(frozen=True, eq=False)
class DrawnWorld:
    """What a picture shows besides the fleet.

    Attributes
    ----------
    low, high
        (3,) metres: the corners of the picture, which contains the bounds, starts and targets. With a terrain it begins
        at the ground's lowest place. Where it is `mapped`, parts with only air and bare ground are cut off.
    kinds
        The obstacles and zones, by kind.
    relief
        The ground; ``None`` without a terrain.
    mapped
        Whether the world is more than a few boxes without a kind, a speed limit or active times, or has movers, so that
        a page also shows a map and profiles.
    stretch
        The factor by which heights are drawn larger than other lengths.
    """

    low: Floats
    high: Floats
    kinds: tuple[ShapeKind, ...]
    relief: Relief | None
    mapped: bool
    stretch: float


@dataclass(frozen=True, eq=False)
class Overhead:
    """A map: the ground, and, where the frame has an origin, latitudes and longitudes, (n, n, 2).

    Degrees are given on a square grid that covers the map; bilinear interpolation is a few centimetres off in 10 km.
    """

    relief: Relief | None
    degrees: Floats | None


def world(scenario: Scenario, tracks: Sequence[DrawnTrack]) -> DrawnWorld:
    """Return the world of `scenario`; of too many shapes, those near the tracks are drawn."""
    lines = [line for track in tracks for line in (track.path, track.positions)]
    plain = scenario.terrain is None and scenario.frame.origin is None
    filling = (*scenario.obstacles, *scenario.zones)
    named = any((shape.kind, shape.max_speed, shape.active) != (None, None, None) for shape in filling)
    many = len(filling) > MAX_EDGED_SHAPES
    boxes = all(isinstance(shape, Box) for shape in scenario.obstacles)
    mapped = bool(not plain or named or many or not boxes or scenario.movers or scenario.surveys)
    ends = [*(track.start for track in tracks), *(target.position for target in scenario.targets)]
    low, high = np.min([scenario.bounds.min, *ends], axis=0), np.max([scenario.bounds.max, *ends], axis=0)
    if mapped:
        end = max((float(track.times[-1]) for track in tracks if len(track.times)), default=0.0)
        seen = [ring for survey in drawn_surveys(scenario) for ring in survey.outlines]
        ways = [mover.at(np.linspace(0.0, end, 100)) for mover in scenario.movers]
        low, high = _peopled(
            low, high, [*lines, *seen, *ways, *(np.array(extent(shape)) for shape in filling), np.array(ends)]
        )
    ground, stretch = None, 1.0
    if scenario.terrain is not None:
        ground = relief(scenario.terrain, low, high)
        spacing = min(np.diff(ground.x).min(), np.diff(ground.y).min()) / 2
        spacing = max(spacing, np.ptp(ground.x) / 2000)
        ground = cleared(ground, scenario.terrain, along(lines, float(spacing)))
        lowest = min([ground.z.min(), *(place[2] for place in ends)])
        highest = ground.z.max()
        if scenario.max_height is not None and scenario.max_height < HIGHEST_CEILING * max(high[:2] - low[:2]):
            highest += scenario.max_height
        low[2], high[2] = lowest, max(high[2], highest)
        flat = max(high[:2] - low[:2]) / (high[2] - low[2])
        stretch = max(factor for factor in _STRETCHED if factor <= max(1.0, flat / 4))
    base = low[2] if ground is None else float(ground.z.max())
    obstacles = [drawn_fence(one, low, high, base) for one in scenario.obstacles]
    found = shapes_by_kind(obstacles, scenario.zones, lines)
    return DrawnWorld(low, high, found, ground, mapped, stretch)


def _peopled(low: Floats, high: Floats, things: Sequence[Floats]) -> tuple[Floats, Floats]:
    """Return the part of the bounds that contains more than air and bare ground, with a margin."""
    points = np.concatenate([np.empty((0, 3)), *(thing.reshape(-1, 3) for thing in things)])
    if not len(points):
        return low, high
    first, last = points.min(axis=0), points.max(axis=0)
    margin = max(MAP_MARGIN * max(*(last - first)[:2], (last - first)[2] / 2), MIN_MAP_MARGIN)
    first, last = np.clip([first - margin, last + margin], low, high)
    return np.append(first[:2], low[2]), last


def overhead(scenario: Scenario, world: DrawnWorld) -> Overhead:
    """Return the ground and the degrees of a map, which lie below footprints and paths."""
    ground = None if scenario.terrain is None else relief(scenario.terrain, world.low, world.high, MAX_MAP_HEIGHTS)
    degrees = None
    if scenario.frame.origin is not None:
        x, y = (np.linspace(world.low[axis], world.high[axis], 9) for axis in range(2))
        at = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        up = np.zeros(len(at)) if ground is None else np.full(len(at), ground.z.mean())
        degrees = to_wgs84(scenario.frame.origin, np.column_stack([at, up]))[:, :2].reshape(9, 9, 2)
    return Overhead(ground, degrees)


FROM_THE_SOUTH = (0.36, -0.8)
"""The direction, east and north, in which the eye of the page's overview lies."""
RISE = 0.45
"""How far the eye rises on the way of `FROM_THE_SOUTH`, at least."""
TURNS = np.radians([0, 45, -45, 90, -90, 135, -135, 180])
"""The turns of that direction that are tried, counterclockwise; the first is preferred."""
MUCH_BETTER = 0.05
"""The share of the flight that must be seen in addition for another direction to be taken."""
PLACES, STEPS = 60, 200
"""Places of each flight, and places on the line of sight from each, at which it is asked what is seen."""


def first_view(world: DrawnWorld, tracks: Sequence[DrawnTrack], terrain: Terrain | None) -> tuple[float, float]:
    """Return the direction, east and north, from which most of the flights and ends is seen above the ground."""
    if terrain is None:
        return FROM_THE_SOUTH
    lines = [track.positions if len(track.positions) else track.path for track in tracks]
    lines += [np.array([place for place in (track.start, track.target) if place is not None]) for track in tracks]
    places = np.concatenate([line[:: max(1, len(line) // PLACES)] for line in lines] or [np.empty((0, 3))])
    if not len(places):
        return FROM_THE_SOUTH
    east, north = FROM_THE_SOUTH
    ways = [(east * np.cos(t) - north * np.sin(t), east * np.sin(t) + north * np.cos(t)) for t in TURNS]
    seen = [seen_share(world, terrain, places, (x, y, RISE / world.stretch)) for x, y in ways]
    best = ways[int(np.argmax(np.array(seen) > max(seen) - MUCH_BETTER))]
    return float(best[0]), float(best[1])


def seen_share(world: DrawnWorld, terrain: Terrain, places: Floats, way: tuple[float, float, float]) -> float:
    """Return which share of places (n, 3) no drawn ground hides from an eye far away in a direction."""
    low, high = world.low, world.high
    ahead = np.array(way)
    longest = float(np.hypot(*(high - low)[:2]) / np.hypot(*ahead[:2]))
    sight = places[:, None] + np.linspace(0.0, longest, STEPS + 1)[1:, None] * ahead
    drawn = ((sight >= low) & (sight <= high)).all(axis=2)
    inside = np.clip(sight[..., :2], low[:2], high[:2]).reshape(-1, 2)
    hidden = drawn & (terrain.height(inside).reshape(drawn.shape) > sight[..., 2])
    return float(1.0 - hidden.any(axis=1).mean())
