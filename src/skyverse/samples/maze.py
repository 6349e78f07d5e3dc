"""UAVs that exchange the two ends of a random maze."""

import numpy as np

from skyverse.errors import require_whole
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Box
from skyverse.samples.swaps import scattered_places, scenario_of_swap

CORRIDOR, THICKNESS = 1.0, 0.1
"""Metres: the width of corridors, and the thickness of walls between them."""
HEIGHT = 2.0
"""Metres from floor to ceiling."""
HALL = 4.0
"""Metres along x: the hall at either end."""
OPENED = 0.15
"""The share of the inner walls left by the maze that are taken away, so that there are several ways."""


def random_maze(uavs: int = 20, *, cells: int = 6, seed: int = 0) -> Scenario:
    """Make a random maze of corridors a metre wide between two halls, whose UAVs exchange places.

    UAV i of one hall and UAV i of the other exchange places, so that each has to leave its place before the other one
    arrives. From every place in the maze there is a way to every other one, and some walls are taken away besides.

    Parameters
    ----------
    uavs
        The number of UAVs, which is even and at most 40.
    cells
        Cells of the maze along either side, 3 to 20.
    seed
        The same seed makes the same maze.

    Returns
    -------
    Scenario
        Target i is that of UAV i, so plan with the assignment ``"identity"``. The separation is 0.4 m, and 0.8 m
        vertically; costs are in metres.

    Raises
    ------
    InputError
        If an argument is out of range, or the halls are too small for so many UAVs.
    """
    require_whole(uavs, "uavs", 2, 40, even=True)
    require_whole(cells, "cells", 3, 20)
    require_whole(seed, "seed", 0)
    rng = np.random.default_rng(seed)
    pitch = CORRIDOR + THICKNESS
    side = cells * pitch
    length = 2.0 * HALL + side + THICKNESS
    open_east, open_north = _passages(rng, cells)
    walls = []
    for i in range(-1, cells):
        for j in range(cells):
            entrance = i in (-1, cells - 1) and j % max(cells // 2, 1) == cells // 4
            if not entrance and (i in (-1, cells - 1) or not open_east[i, j]):
                x, y = HALL + (i + 1) * pitch, j * pitch
                walls.append(((x, y, 0.0), (x + THICKNESS, y + pitch, HEIGHT)))
    for i in range(cells):
        for j in range(cells - 1):
            if not open_north[i, j]:
                x, y = HALL + i * pitch, (j + 1) * pitch
                walls.append(((x, y, 0.0), (x + pitch + THICKNESS, y + THICKNESS, HEIGHT)))
    half = uavs // 2
    near, far = (
        scattered_places(rng, half, np.array([west, 0.0, 0.0]), np.array([west + HALL, side, HEIGHT]))
        for west in (0.0, length - HALL)
    )
    return scenario_of_swap(
        name=f"maze-{uavs}-{seed}",
        description=f"{uavs} UAVs exchange the ends of a maze with corridors {CORRIDOR:g} m wide.",
        size=(length, side, HEIGHT),
        walls=tuple(Box(min=_rounded(low), max=_rounded(high)) for low, high in walls),
        near=near,
        far=far,
    )


def _rounded(corner: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = np.round(corner, 6).tolist()
    return x, y, z


def _passages(rng: np.random.Generator, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Return between which cells there is no wall: eastwards (cells - 1, cells), and northwards (cells, cells - 1).

    A random walk that backs up where it is stuck joins all cells; then some walls are taken away.
    """
    east, north = rng.random((cells, cells)) < OPENED, rng.random((cells, cells)) < OPENED
    seen = np.zeros((cells, cells), np.bool_)
    way = [(int(rng.integers(cells)), int(rng.integers(cells)))]
    seen[way[0]] = True
    while way:
        i, j = way[-1]
        around = [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)]
        fresh = [(k, m) for k, m in around if 0 <= k < cells and 0 <= m < cells and not seen[k, m]]
        if not fresh:
            way.pop()
            continue
        k, m = fresh[int(rng.integers(len(fresh)))]
        (east if k != i else north)[min(i, k), min(j, m)] = True
        seen[k, m] = True
        way.append((k, m))
    return east[:-1], north[:, :-1]
