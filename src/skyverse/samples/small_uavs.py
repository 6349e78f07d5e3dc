"""Small UAVs for scenarios indoors, and places for them that are apart."""

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.model.scenario import Bounds, Lattice, Objective, Scenario, Target
from skyverse.model.shapes import Box, Cylinder
from skyverse.model.uav import UAV

Place = tuple[float, float, float]

SEPARATION = 0.4
"""Metres between small UAVs at one height; above each other, twice as much."""
CLEARANCE = 0.1
"""Metres between a small UAV and walls."""
WALL = 0.35
"""Metres that places keep from walls."""
APART = 2.0
"""Separations between places, at least."""
TRIES = 10_000
"""Random places that are tried for one UAV."""


def small_uav(name: str, start: Place) -> UAV:
    """Return a small multirotor."""
    return UAV(name=name, start=start, separation=SEPARATION, max_speed=3.0, max_acceleration=3.0)


def scattered_places(rng: np.random.Generator, count: int, low: Floats, high: Floats) -> list[Place]:
    """Return random places in a box with corners (3,), metres, between which a small UAV can pass.

    Raises
    ------
    InputError
        If the box is too small for so many.
    """
    apart = APART * np.array([SEPARATION, SEPARATION, 2.0 * SEPARATION])
    found = np.empty((0, 3))
    for _ in range(TRIES * count):
        if len(found) == count:
            break
        place = np.round(rng.uniform(low + WALL, high - WALL), 3)
        if (np.linalg.norm((found - place) / apart, axis=1) >= 1.0).all():
            found = np.vstack([found, place])
    if len(found) < count:
        raise InputError(f"there is no space for {count} UAVs that are {apart[0]:g} m apart")
    return [(x, y, z) for x, y, z in found.tolist()]


def scenario_of_swap(
    *, name: str, description: str, size: Place, walls: tuple[Box | Cylinder, ...], near: list[Place], far: list[Place]
) -> Scenario:
    """Return a scenario of small UAVs, of which the i-th at the near places and the i-th at the far ones change places.

    Its bounds have one corner at zero and the other at `size`, metres.
    """
    return Scenario(
        name=name,
        description=description,
        bounds=Bounds(min=(0, 0, 0), max=size),
        obstacles=walls,
        clearance=CLEARANCE,
        lattice=Lattice(step=(0.25, 0.25, 0.25), connectivity=26),
        objective=Objective(unit="metres"),
        uavs=tuple(small_uav(f"uav-{i}", place) for i, place in enumerate(near + far, 1)),
        targets=tuple(Target(name=f"target-{i}", position=place) for i, place in enumerate(far + near, 1)),
    )
