"""One UAV's flight from the side: how high it is, and what is below and above, over the way that it has come."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.kinds import Kind
from skyverse.draw.relief import along
from skyverse.draw.solids import span
from skyverse.draw.track import Track
from skyverse.model.scenario import Scenario


@dataclass(frozen=True, eq=False)
class Crossing:
    """A shape that a path flies over, under or through: its low and high, (k, 2) z in metres, at `distance` (k,)."""

    kind: int
    name: str
    distance: Floats
    levels: Floats


@dataclass(frozen=True, eq=False)
class Profile:
    """A path from the side.

    Attributes
    ----------
    distance
        (n,) metres over the map from the start.
    points
        (n, 3) metres: the path at these distances, as flown, or as planned where nothing flies.
    ground
        (n,) z in metres below; ``None`` where there is no terrain.
    clearance
        Metres above ground that nothing flies below.
    band
        z (n, 2) between which it pays to stay; ``None`` where nothing is said.
    crossings
        The obstacles and zones below, above and around it.
    """

    distance: Floats
    points: Floats
    ground: Floats | None
    clearance: float
    band: Floats | None
    crossings: tuple[Crossing, ...]


def profile(track: Track, scenario: Scenario, kinds: Sequence[Kind], most: int) -> Profile:
    """Return the profile of a track, in some `most` points; its distance is empty where there is no path."""
    line = track.positions if len(track.positions) else track.path
    terrain = scenario.terrain
    length = float(np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1).sum())
    points = along([line], max(length / most, 1e-9))
    distance = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1))])[: len(points)]
    below = None if terrain is None else terrain.height(points[:, :2])
    return Profile(
        distance=distance,
        points=points,
        ground=below,
        clearance=scenario.ground_clearance,
        band=_band(scenario, below, len(points)),
        crossings=_crossings(distance, points, kinds) if len(points) else (),
    )


def _band(scenario: Scenario, below: Floats | None, count: int) -> Floats | None:
    band = scenario.objective.altitude
    if band is None:
        return None
    zero = below if band.above == "ground" and below is not None else np.zeros(count)
    return np.column_stack([zero + band.low, zero + band.high])


def _crossings(distance: Floats, points: Floats, kinds: Sequence[Kind]) -> tuple[Crossing, ...]:
    pieces = [piece[:, :2] for piece in np.array_split(points, min(64, len(points)))]
    low, high = (np.array([edge(piece, axis=0) for piece in pieces]) for edge in (np.min, np.max))
    found = []
    for number, kind in enumerate(kinds):
        first, last = kind.extents[:, None, 0, :2], kind.extents[:, None, 1, :2]
        near = np.any(np.all((first <= high) & (low <= last), axis=2), axis=1)
        for shape in (kind.shapes[k] for k in np.flatnonzero(near)):
            levels = span(shape, points[:, :2])
            inside = np.flatnonzero(np.isfinite(levels[:, 0]))
            runs = np.split(inside, np.flatnonzero(np.diff(inside) > 1) + 1) if len(inside) else []
            found += [Crossing(number, shape.name or kind.name, distance[run], levels[run]) for run in runs]
    return tuple(found)
