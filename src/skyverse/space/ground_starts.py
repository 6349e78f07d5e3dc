"""UAVs that stand on the ground: they rise straight up to where they may stray, and their flight starts there."""

from collections.abc import Callable, Collection

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.model.pad import ground_height
from skyverse.model.quantities import derived
from skyverse.model.scenario import Bounds, Scenario
from skyverse.space.world import World

ABOVE = 1.0
"""Metres that starts are higher than their clearance from the ground and their tracking error make them."""
ON_GROUND = 1e-3
"""Metres from the terrain within which a start is on the ground."""


def lowest_starts(around: World, places: Floats) -> Floats:
    """Return the lowest starts (n, 3) above places (n, 2) from which UAVs may stray, and a little more."""
    return np.array([(x, y, around.least_height((x, y, 0.0)) + ABOVE) for x, y in places.tolist()])


def can_rise(around: World, places: Floats) -> NDArray[np.bool_]:
    """Tell for each of (n, 2) places whether a UAV may stray on its way from the ground up to its lowest start there.

    The ground itself and the ceiling above it do not count on that way.
    """
    scenario, starts = around.scenario, lowest_starts(around, places)
    deep = Bounds(min=(*scenario.bounds.min[:2], -1e6), max=scenario.bounds.max)
    bare = derived(scenario, terrain=None, max_height=None, bounds=deep)
    below = np.column_stack([places, starts[:, 2] if scenario.terrain is None else ground_height(scenario, places)])
    return World(bare, around.error).segments_free(below, starts)


def standing(scenario: Scenario) -> list[int]:
    """Return the indices of the UAVs that start on the terrain."""
    if scenario.terrain is None:
        return []
    starts = np.array([uav.start for uav in scenario.uavs]).reshape(-1, 3)
    return np.flatnonzero(np.abs(starts[:, 2] - ground_height(scenario, starts[:, :2])) <= ON_GROUND).tolist()


def risen(scenario: Scenario, uavs: Collection[int], tell: Callable[[str], object]) -> Scenario:
    """Return a scenario in which some UAVs start straight above the ground on which they stand, and tell how high.

    Raises
    ------
    InputError
        If one is an aeroplane, or an obstacle or a zone is in its way.
    """
    changed = list(scenario.uavs)
    worlds = {error: World(scenario, error) for error in {changed[k].tracking_error for k in uavs}}
    for k in uavs:
        uav, place = changed[k], np.array([changed[k].start[:2]])
        around = worlds[uav.tracking_error]
        if uav.fixed_wing is not None:
            raise InputError(f"{uav.name}: expected a start in the air, as an aeroplane cannot rise straight up")
        if not can_rise(around, place)[0]:
            said = f"{uav.name}: expected a place from which it can rise straight up from the ground"
            raise InputError(f"{said}, found an obstacle or a zone in the way, or too near")
        (start,) = lowest_starts(around, place).tolist()
        changed[k] = uav.model_copy(update={"start": tuple(start)})
        up = start[2] - float(ground_height(scenario, start[:2]))
        tell(f"{uav.name} takes off from the ground and rises straight up by {up:.1f} m, where its flight starts")
    return scenario.model_copy(update={"uavs": tuple(changed)})
