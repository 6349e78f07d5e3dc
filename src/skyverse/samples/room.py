"""Random rooms full of boxes, with all difficulties that boxes can make."""

import numpy as np

from skyverse.errors import require_whole
from skyverse.model.scenario import Bounds, Lattice, Objective, Scenario, Target
from skyverse.model.shapes import Box
from skyverse.model.uav import UAV

ROOM_GRID = 0.25


def random_room(*, seed: int = 0) -> Scenario:
    """Make a random room that is difficult to plan in, for tests of planners.

    A room with sides of 6 to 16 m contains 0 to 200 boxes on a grid of 0.25 m, many of which touch or overlap. Some
    rooms have a wall with a slit, some a closed room inside. Start and target are at random places, also inside boxes,
    and often exactly on the surface of a box grown by the clearance, which is 1 mm to 0.25 m.

    Parameters
    ----------
    seed
        The same seed makes the same room.

    Returns
    -------
    Scenario
        It has a 26-connected lattice with steps of 0.25 m, and costs in metres.

    Raises
    ------
    InputError
        If the seed is not a whole number from 0 on.
    """
    require_whole(seed, "seed", 0)
    rng = np.random.default_rng(seed)
    count = int(rng.choice([0, 1, 2, 5, 10, 20, 40, 80, 140, 200]))
    side = rng.integers(6, 17, 3).astype(float)
    kind = rng.choice(["plain", "bars", "slit", "small"])
    boxes = []
    for _ in range(count):
        size = rng.integers(1, 5 if kind == "small" else 9, 3) * ROOM_GRID
        if kind != "small":
            size *= rng.choice([1, 1, 2])
        if kind == "bars" and rng.random() < 0.3:
            size[rng.integers(3)] = side.max()
        low = np.floor(rng.uniform(-0.5, side) / ROOM_GRID) * ROOM_GRID
        boxes.append((low, low + size))
    if kind == "slit":
        x, y = (float(rng.integers(2, side[axis] - 1)) for axis in (0, 1))
        width = float(rng.choice([0.25, 0.5, 0.5001, 0.75]))
        boxes.append((np.array([x, 0, 0]), np.array([x + ROOM_GRID, y, side[2]])))
        boxes.append((np.array([x, y + width, 0]), np.array([x + ROOM_GRID, max(side[1], y + width + 0.1), side[2]])))
    if rng.random() < 0.2:
        low = rng.integers(1, 4, 3).astype(float)
        high = low + rng.integers(1, 4, 3)
        for axis in range(3):
            for face in (low[axis] - ROOM_GRID, high[axis]):
                a, b = low - ROOM_GRID, high + ROOM_GRID
                a[axis], b[axis] = face, face + ROOM_GRID
                boxes.append((a, b))
    clearance = float(rng.choice([0.001, 0.001, 0.05, 0.125, 0.25]))

    def place() -> tuple[float, float, float]:
        p = rng.uniform(0, side)
        if boxes and rng.random() < 0.4:  # on the surface of a grown box
            a, b = boxes[rng.integers(len(boxes))]
            axis = rng.integers(3)
            p[axis] = (a - clearance if rng.random() < 0.5 else b + clearance)[axis]
        x, y, z = np.clip(p, 0, side).tolist()
        return x, y, z

    return Scenario(
        name=f"room-{seed}",
        bounds=Bounds(min=(0, 0, 0), max=tuple(side)),
        obstacles=tuple(Box(min=tuple(a), max=tuple(b)) for a, b in boxes),
        clearance=clearance,
        lattice=Lattice(step=(ROOM_GRID, ROOM_GRID, ROOM_GRID), connectivity=26),
        objective=Objective(unit="metres"),
        uavs=(UAV(start=place()),),
        targets=(Target(position=place()),),
    )
