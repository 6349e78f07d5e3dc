"""How steeply and how high a trajectory flies, at samples, for tables that people read; no proof rests on it."""

import math
from dataclasses import dataclass

import numpy as np

from skyverse.model.shapes import Terrain
from skyverse.model.trajectory import Trajectory

SAMPLES = 16
"""Samples of each piece of a trajectory."""
LEAST_STEP = 1e-3
"""Metres between two samples at least, for the slope from one to the next to count."""


@dataclass(frozen=True)
class FlightMeasures:
    """What is read off a flight at samples.

    Attributes
    ----------
    climb
        Metres that are climbed, all climbs together.
    steepest
        The largest angle between the flight and the horizontal, up or down, degrees.
    lowest, highest
        The least and the greatest height above the terrain, metres, or z where there is no terrain.
    """

    climb: float
    steepest: float
    lowest: float
    highest: float


def measure_flight(trajectory: Trajectory, terrain: Terrain | None = None) -> FlightMeasures:
    """Return what is read off a trajectory at `SAMPLES` samples of each piece."""
    shares = np.arange(SAMPLES) / SAMPLES
    times = (trajectory.knots[:-1, None] + np.diff(trajectory.knots)[:, None] * shares).ravel()
    points = trajectory.at(np.append(times, trajectory.end)).position
    steps = np.diff(points, axis=0)
    rises = steps[:, 2]
    counted = np.linalg.norm(steps, axis=1) >= LEAST_STEP
    slopes = np.arctan2(np.abs(rises), np.linalg.norm(steps[:, :2], axis=1))[counted]
    heights = points[:, 2] if terrain is None else points[:, 2] - terrain.height(points[:, :2])
    return FlightMeasures(
        climb=float(rises[rises > 0].sum()),
        steepest=math.degrees(float(slopes.max(initial=0.0))),
        lowest=float(heights.min()),
        highest=float(heights.max()),
    )
