"""UAVs that exchange sides through a forest."""

import math

import numpy as np

from skyverse.errors import InputError
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Cylinder
from skyverse.model.short_lines import counted
from skyverse.samples.given_numbers import require_whole
from skyverse.samples.small_uavs import TRIES, WALL, scattered_places, scenario_of_swap

SIDE, HEIGHT = 10.0, 3.0
"""Metres: the forest is a square, under a ceiling that all trees reach."""
MEADOW = 2.5
"""Metres along x: the meadow on either side."""
RADII = (0.1, 0.3)
"""Metres: the least and the largest radius of a tree."""
GAP = 0.8
"""Metres between the trunks of any two trees, at least, so that a UAV can pass between them."""


def forest_swap(uavs: int = 10, *, trees: int = 25, seed: int = 0) -> Scenario:
    """Make a forest of 10 m by 10 m with a meadow on either side, whose UAVs exchange sides.

    UAV i of one meadow and UAV i of the other exchange places, so that each has to leave its place before the other one
    arrives.

    Parameters
    ----------
    uavs
        The number of UAVs, which is even and at most 40.
    trees
        The number of trees, upright cylinders from the ground to the ceiling; at most 50.
    seed
        The same seed makes the same forest.

    Returns
    -------
    Scenario
        Target i is that of UAV i, so plan with the assignment ``"identity"``. The separation is 0.4 m, and 0.8 m
        vertically; costs are in metres.

    Raises
    ------
    InputError
        If an argument is out of range, or there is no space for so many trees.
    """
    require_whole("forest_swap", "uavs", uavs, 2, 40, even=True)
    require_whole("forest_swap", "trees", trees, 0, 50)
    require_whole("forest_swap", "seed", seed, 0)
    rng = np.random.default_rng(seed)
    half, length = uavs // 2, SIDE + 2.0 * MEADOW
    near, far = (
        scattered_places(rng, half, np.array([west, 0.0, 0.0]), np.array([west + MEADOW, SIDE, HEIGHT]))
        for west in (0.0, length - MEADOW)
    )
    return scenario_of_swap(
        name=f"forest-{uavs}-{seed}",
        description=f"{uavs} UAVs exchange the sides of a forest of {counted(trees, 'tree')}.",
        size=(length, SIDE, HEIGHT),
        walls=_trees(rng, trees),
        near=near,
        far=far,
    )


def _trees(rng: np.random.Generator, count: int) -> tuple[Cylinder, ...]:
    """Return trees at random places between which a UAV can pass."""
    found: list[tuple[float, float, float]] = []
    for _ in range(TRIES * count):
        if len(found) == count:
            break
        x, y, radius = np.round(
            (rng.uniform(MEADOW + WALL, MEADOW + SIDE - WALL), rng.uniform(0.0, SIDE), rng.uniform(*RADII)), 3
        ).tolist()
        if all(math.hypot(x - other[0], y - other[1]) >= radius + other[2] + GAP for other in found):
            found.append((x, y, radius))
    if len(found) < count:
        raise InputError(f"there is no space for {counted(count, 'tree')} that are {GAP:g} m apart")
    return tuple(Cylinder(centre=(x, y), radius=radius, low=0, high=HEIGHT) for x, y, radius in found)
