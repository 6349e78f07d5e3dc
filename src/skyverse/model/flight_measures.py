"""How far, how steeply and how high a trajectory flies, at samples, for tables; no proof rests on it."""

import math
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.model.arrays import arctan2
from skyverse.model.shapes import Terrain
from skyverse.model.trajectory import Trajectory

SAMPLES = 16
"""Samples of each piece of a trajectory at least."""
MAX_SAMPLES = 100_000
"""Samples of a trajectory at most, unless its pieces alone need more, which bounds time and memory."""
APART = 1.0
"""Metres, about, between the places along a flight."""
MIN_PLACES, MAX_PLACES = 1000, 20_000
"""Places along a flight at least and at most."""
LEAST_STEP = 1e-3
"""Metres between two samples at least, for the slope from one to the next to count."""


@dataclass(frozen=True)
class FlightMeasures:
    """What is read off a flight at samples.

    Attributes
    ----------
    length
        Metres that are flown.
    climb
        Metres that are climbed, all climbs together.
    steepest
        The largest angle between the flight and the horizontal, up or down, degrees.
    lowest, highest
        The least height above the terrain, and the greatest above its lowest heights, from which a ceiling is counted;
        z where there is no terrain. Metres.
    """

    length: float
    climb: float
    steepest: float
    lowest: float
    highest: float


def measure_flight(trajectory: Trajectory, terrain: Terrain | None = None) -> FlightMeasures:
    """Return what is read off a trajectory at `SAMPLES` samples of each piece, and at two in each cell of a terrain."""
    points = trajectory.at(_instants(trajectory, math.inf if terrain is None else min(terrain.step) / 2)).position
    steps = np.diff(points, axis=0)
    distances, rises = np.linalg.norm(steps, axis=1), steps[:, 2]
    slopes = arctan2(np.abs(rises), np.linalg.norm(steps[:, :2], axis=1))[distances >= LEAST_STEP]
    lowest = highest = points[:, 2]
    if terrain is not None:
        lowest = points[:, 2] - terrain.height(points[:, :2])
        highest = points[:, 2] - terrain.lowest_ground.height(points[:, :2])
    return FlightMeasures(
        length=float(distances.sum()),
        climb=float(rises[rises > 0].sum()),
        steepest=math.degrees(float(slopes.max(initial=0.0))),
        lowest=float(lowest.min()),
        highest=float(highest.max()),
    )


def places_along(trajectory: Trajectory) -> Floats:
    """Return places (n, 3) along a trajectory, metres, at equal times, about `APART` metres from one another."""

    def places(count: int) -> Floats:
        return trajectory.at(np.linspace(trajectory.start, trajectory.end, count)).position

    rough = places(MIN_PLACES)
    wanted = int(min(float(np.linalg.norm(np.diff(rough, axis=0), axis=1).sum()) / APART, MAX_PLACES))
    return rough if wanted <= MIN_PLACES else places(wanted)


def _instants(trajectory: Trajectory, apart: float) -> Floats:
    """Return instants (m,), seconds: the same number in each piece, about `apart` metres of flight from one another."""
    pieces = len(trajectory.coefficients)
    for_length = 1
    if math.isfinite(apart):
        rough = trajectory.at(_shared(trajectory, SAMPLES)).position
        legs = np.linalg.norm(np.diff(rough, axis=0), axis=1)
        for_length = math.ceil(SAMPLES * min(float(legs.max()) / apart, MAX_SAMPLES / pieces))
    return _shared(trajectory, max(SAMPLES, min(for_length, MAX_SAMPLES // pieces)))


def _shared(trajectory: Trajectory, count: int) -> Floats:
    """Return instants (m,), seconds, that share each piece of a trajectory into `count` equal parts."""
    shares = np.arange(count) / count
    times = (trajectory.knots[:-1, None] + np.diff(trajectory.knots)[:, None] * shares).ravel()
    return np.append(times, trajectory.end)
