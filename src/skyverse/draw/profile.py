"""The altitude profile of one UAV: its height, and the ground and shapes below and above, over distance flown."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.draw.ground_relief import along
from skyverse.draw.shape_geometry import footprint, grown, span
from skyverse.draw.shape_kinds import ShapeKind
from skyverse.draw.track import DrawnTrack
from skyverse.model.mover import Mover
from skyverse.model.scenario import Scenario


@dataclass(frozen=True, eq=False)
class Crossing:
    """A shape that a path flies over, under or through: least and greatest z, (k, 2) metres, at `distance`, (k,).

    `kind` is the number of its kind in the drawn world, -1 for a mover.
    """

    kind: int
    name: str
    distance: Floats
    levels: Floats


@dataclass(frozen=True, eq=False)
class Profile:
    """The profile of a path.

    Attributes
    ----------
    distance
        (n,) metres from the start, measured on the map.
    times
        (n,) seconds into the mission; ``None`` where there is no trajectory.
    points
        (n, 3) metres: the trajectory at these distances, or the path where there is no trajectory.
    ground
        (n,) z of the ground below, metres; ``None`` without a terrain.
    lowest
        (n,) z of the ground from which the ceiling is counted, nowhere above `ground`; ``None`` where that is `ground`.
    clearance
        Metres above ground that paths must keep.
    ceiling
        (n,) z above which UAVs may not fly, metres; ``None`` without a ceiling above ground.
    band
        (n, 2) lowest and highest z of the objective's altitude band; ``None`` where it has none.
    crossings
        The obstacles and zones below, above and around the path.
    movers
        The movers that are below or above the UAV when it is there, with their doubt.
    """

    distance: Floats
    times: Floats | None
    points: Floats
    ground: Floats | None
    lowest: Floats | None
    clearance: float
    ceiling: Floats | None
    band: Floats | None
    crossings: tuple[Crossing, ...]
    movers: tuple[Crossing, ...] = ()


def profile(track: DrawnTrack, scenario: Scenario, kinds: Sequence[ShapeKind], most: int) -> Profile:
    """Return the profile of a track in about `most` points; its `distance` is empty where there is no path."""
    flies = len(track.positions) > 0
    line = np.column_stack([track.positions, track.times]) if flies else track.path
    terrain = scenario.terrain
    length = float(np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1).sum())
    found = along([line], max(length / most, 1e-9))
    points = found[:, :3]
    distance = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1))])[: len(points)]
    below = None if terrain is None else terrain.height(points[:, :2])
    times = found[:, 3] if flies and len(found) else None
    return Profile(
        distance=distance,
        times=times,
        points=points,
        ground=below,
        lowest=None if terrain is None or terrain.lowest is None else terrain.lowest_ground.height(points[:, :2]),
        clearance=scenario.ground_clearance,
        ceiling=_ceiling(scenario, points),
        band=_band(scenario, below, len(points)),
        crossings=_crossings(distance, points, kinds) if len(points) else (),
        movers=() if times is None else tuple(_movers(distance, times, points, scenario.movers)),
    )


def _ceiling(scenario: Scenario, points: Floats) -> Floats | None:
    if scenario.terrain is None or scenario.max_height is None:
        return None
    return scenario.terrain.lowest_ground.height(points[:, :2]) + scenario.max_height


def _band(scenario: Scenario, below: Floats | None, count: int) -> Floats | None:
    band = scenario.objective.altitude
    if band is None:
        return None
    zero = below if band.above == "ground" and below is not None else np.zeros(count)
    return np.column_stack([zero + band.low, zero + band.high])


def _crossings(distance: Floats, points: Floats, kinds: Sequence[ShapeKind]) -> tuple[Crossing, ...]:
    pieces = [piece[:, :2] for piece in np.array_split(points, min(64, len(points)))]
    low, high = (np.array([edge(piece, axis=0) for piece in pieces]) for edge in (np.min, np.max))
    found = []
    for number, kind in enumerate(kinds):
        first, last = kind.extents[:, None, 0, :2], kind.extents[:, None, 1, :2]
        near = np.any(np.all((first <= high) & (low <= last), axis=2), axis=1)
        for shape in (kind.shapes[k] for k in np.flatnonzero(near)):
            levels = span(shape, points[:, :2])
            found += [Crossing(number, shape.name or kind.name, distance[run], levels[run]) for run in _runs(levels)]
    return tuple(found)


def _movers(distance: Floats, times: Floats, points: Floats, movers: Sequence[Mover]) -> Iterator[Crossing]:
    """Yield where a UAV is above, below or within a mover at the instant at which it is there."""
    for mover in movers:
        places, doubt = mover.at(times), mover.doubt.at(times)
        levels, aside = np.full((len(points), 2), np.nan), (points - places)[:, :2]
        reaches = np.linalg.norm(footprint(grown(mover, float(doubt.max())))[0], axis=1).max()
        for k in np.flatnonzero(np.linalg.norm(aside, axis=1) <= reaches).tolist():
            levels[k] = span(grown(mover, float(doubt[k])), aside[k : k + 1])[0]
        levels += places[:, 2:]
        yield from (Crossing(-1, mover.name, distance[run], levels[run]) for run in _runs(levels))


def _runs(levels: Floats) -> list[Ints]:
    """Return the runs of indices at which levels, (n, 2), are numbers."""
    inside = np.flatnonzero(np.isfinite(levels[:, 0]))
    return np.split(inside, np.flatnonzero(np.diff(inside) > 1) + 1) if len(inside) else []
