"""From where the 3-D view is first seen: from the south, unless a mountain hides the flight from there."""

from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.drawn_world import DrawnWorld
from skyverse.draw.track import Track
from skyverse.model.shapes import Terrain

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


def first_view(world: DrawnWorld, tracks: Sequence[Track], terrain: Terrain | None) -> tuple[float, float]:
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
