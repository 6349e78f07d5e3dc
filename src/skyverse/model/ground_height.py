"""Where the ground is taken to be, whether or not a scenario has a terrain."""

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.model.scenario import Scenario


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
