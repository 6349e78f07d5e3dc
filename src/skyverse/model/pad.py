"""Pads: the places where a UAV stands, takes off and lands, too near to what carries it for its tracking error.

On a pad the clearance alone counts for what the UAV stands on: the bounds' floor, ground that is nowhere steeper than
45 degrees as near as the UAV may come, and solid obstacles that end, grown by the clearance, no higher than the start
or target. All else must keep the error from the pad; where something does not, the UAV has no pad, and a start or
target that needs one is refused. An aeroplane has no pads.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.model.scenario import Scenario
from skyverse.model.uav import TrackingError

ABOVE_ERROR = 0.01
"""Metres by which a pad is higher than it must be, clear of rounding."""


class Pad(NamedTuple):
    """An upright cylinder about a start or target.

    Attributes
    ----------
    place
        (3,) metres: the start or target, in the middle of its lower side.
    radius
        Metres: the larger of the clearance and the horizontal tracking error.
    spare
        Metres from its axis within which the nominal position must be: the radius less the clearance.
    top
        z of its upper side, metres: as far above as the vertical error, and where the UAV may stray from the ground.
    """

    place: tuple[float, float, float]
    radius: float
    spare: float
    top: float


def pad_at(scenario: Scenario, uav: int, place: tuple[float, float, float], above_ground: float) -> Pad | None:
    """Return the pad that a UAV would have at a start or target; ``None`` if it has no tracking error, or wings.

    Parameters
    ----------
    scenario, uav
        The index of the UAV in the scenario.
    place
        (3,) metres: the start or target.
    above_ground
        The least z there from which the UAV may stray and keeps its clearance from the ground, metres.
    """
    vehicle = scenario.uavs[uav]
    error = vehicle.tracking_error
    if vehicle.fixed_wing is not None or error == TrackingError():
        return None
    radius = max(scenario.clearance, error.horizontal)
    top = max(place[2] + error.vertical, above_ground) + ABOVE_ERROR
    return Pad(place, radius, radius - scenario.clearance, top)


def error_about_pads(scenario: Scenario, error: TrackingError) -> TrackingError:
    """Return how far a UAV may be from the axis of its pads: its error, and beside it what its pads have to spare."""
    return TrackingError(
        horizontal=error.horizontal + max(error.horizontal - scenario.clearance, 0.0), vertical=error.vertical
    )


def ground_height(scenario: Scenario, places: ArrayLike) -> Floats:
    """Return z of the ground, (...) metres, below places (..., 2): the terrain's, or the lower bound without one.

    It is without roofs and other obstacles.
    """
    at = np.asarray(places, dtype=np.float64)
    if scenario.terrain is not None:
        return scenario.terrain.height(at)
    return np.full(at.shape[:-1], scenario.bounds.min[2])


def home_height(scenario: Scenario, uav: int) -> float:
    """Return z of the ground from which a UAV takes off, metres.

    It is where the scenario states it, else the terrain's below the start, else the start itself: without a terrain, a
    UAV is taken to stand where it starts, and not at the lower bound.
    """
    vehicle = scenario.uavs[uav]
    if vehicle.home is not None:
        return vehicle.home
    return vehicle.start[2] if scenario.terrain is None else float(ground_height(scenario, vehicle.start[:2]))
