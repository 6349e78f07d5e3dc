"""UAVs that exchange the two ends of a random maze."""

import numpy as np

from skyverse.errors import InputError
from skyverse.model.scenario import Bounds, Lattice, Objective, Scenario, Target
from skyverse.model.shapes import Box
from skyverse.samples.small_uavs import CLEARANCE, scattered_places, small_uav

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
    if isinstance(uavs, bool) or not isinstance(uavs, int | np.integer) or not 2 <= uavs <= 40 or uavs % 2:
        raise InputError(f"random_maze's uavs is an even number from 2 to 40, not {uavs!r}")
    if isinstance(cells, bool) or not isinstance(cells, int | np.integer) or not 3 <= cells <= 20:
        raise InputError(f"random_maze's cells is a whole number from 3 to 20, not {cells!r}")
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise InputError(f"random_maze's seed is a whole number from 0 on, not {seed!r}")
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
    starts, targets = near + far, far + near
    return Scenario(
        name=f"maze-{uavs}-{seed}",
        description=f"{uavs} UAVs exchange the ends of a maze with corridors {CORRIDOR:g} m wide.",
        bounds=Bounds(min=(0, 0, 0), max=(length, side, HEIGHT)),
        obstacles=tuple(Box(min=_rounded(low), max=_rounded(high)) for low, high in walls),
        clearance=CLEARANCE,
        lattice=Lattice(step=(0.25, 0.25, 0.25), connectivity=26),
        objective=Objective(unit="metres"),
        uavs=tuple(small_uav(f"uav-{i}", place) for i, place in enumerate(starts, 1)),
        targets=tuple(Target(name=f"target-{i}", position=place) for i, place in enumerate(targets, 1)),
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
