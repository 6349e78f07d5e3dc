"""Fleets that exchange places: on a circle, through a window, a tunnel or a forest; and small UAVs for that."""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, require_kind, require_number, require_whole
from skyverse.model.scenario import Bounds, Lattice, Objective, Scenario, Target
from skyverse.model.shapes import LEAST_CLEARANCE, Box, Cylinder
from skyverse.model.short_lines import counted
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


CIRCLE_SPACE_HEIGHT = 20.0
"""Metres from the floor of the space to its ceiling; the circle is half-way up."""


def circle_swap(uavs: int = 8, radius: float = 20.0) -> Scenario:
    """Make a circle on which each UAV's target is the start of the opposite one: all straight ways meet at the centre.

    Parameters
    ----------
    uavs
        The number of UAVs, which is even.
    radius
        The radius of the circle, metres.

    Returns
    -------
    Scenario
        It has no obstacles and costs in metres. Target i is that of UAV i, so plan with the assignment ``"identity"``.

    Raises
    ------
    InputError
        If the number is not even and positive, or the circle is too small for the separation of the UAVs.
    """
    require_whole(uavs, "uavs", 2, even=True)
    separation = UAV(start=(0, 0, 0)).separation
    least = separation / (2.0 * math.sin(math.pi / uavs))
    require_number(radius, "radius", f"metres, for {uavs} UAVs,", least)
    angles = 2.0 * math.pi * np.arange(uavs) / uavs
    places = [(radius * math.cos(a), radius * math.sin(a), CIRCLE_SPACE_HEIGHT / 2) for a in angles.tolist()]
    side = 1.25 * radius
    return Scenario(
        name=f"circle-{uavs}",
        description=f"{uavs} UAVs on a circle of radius {radius:g} m, each to the opposite side.",
        bounds=Bounds(min=(-side, -side, 0), max=(side, side, CIRCLE_SPACE_HEIGHT)),
        clearance=LEAST_CLEARANCE,
        lattice=Lattice(step=(side / 20, side / 20, 1), connectivity=26),
        objective=Objective(unit="metres"),
        uavs=tuple(UAV(start=place) for place in places),
        targets=tuple(Target(position=places[(i + uavs // 2) % uavs]) for i in range(uavs)),
    )


TUNNEL_ROOM = (6.0, 7.0, 3.0)
"""Metres along each axis: the inside of a room."""
TUNNEL_LENGTH = 4.0
"""Metres from room to room."""


def tunnel_swap(uavs: int = 20, *, width: float = 1.5, seed: int = 0) -> Scenario:
    """Make two rooms that are joined by a tunnel, with half of the UAVs in either, each of which flies to the other.

    UAV i of one room and UAV i of the other exchange places, so that each has to leave its place before the other one
    arrives, and all pass the tunnel.

    Parameters
    ----------
    uavs
        The number of UAVs, which is even and at most 60.
    width
        Of the tunnel, and its height, 0.8 to 2.5 m. UAVs keep 0.1 m from its walls.
    seed
        The same seed makes the same places, and the same tunnel.

    Returns
    -------
    Scenario
        Target i is that of UAV i, so plan with the assignment ``"identity"``. The separation is 0.4 m, and 0.8 m
        vertically; costs are in metres.

    Raises
    ------
    InputError
        If an argument is out of range.
    """
    require_whole(uavs, "uavs", 2, 60, even=True)
    require_number(width, "width", "metres", 0.8, 2.5)
    require_whole(seed, "seed", 0)
    rng = np.random.default_rng(seed)
    depth, across, high = TUNNEL_ROOM
    since, until = depth, depth + TUNNEL_LENGTH
    length = until + depth
    y, z = (round(float(rng.uniform(WALL, side - WALL - width)), 3) for side in (across, high))
    filled = (
        Box(min=(since, 0, 0), max=(until, y, high)),
        Box(min=(since, y + width, 0), max=(until, across, high)),
        Box(min=(since, y, 0), max=(until, y + width, z)),
        Box(min=(since, y, z + width), max=(until, y + width, high)),
    )
    half = uavs // 2
    near = scattered_places(rng, half, np.zeros(3), np.array([since, across, high]))
    far = scattered_places(rng, half, np.array([until, 0.0, 0.0]), np.array([length, across, high]))
    return scenario_of_swap(
        name=f"tunnel-{uavs}-{seed}",
        description=f"{uavs} UAVs exchange sides through a tunnel {width:g} m wide.",
        size=(length, across, high),
        walls=filled,
        near=near,
        far=far,
    )


SWAP_SPACING = (0.9, 0.9, 1.1)
"""Metres between neighbouring places, along x, y and z."""


def window_swap(room: Scenario, uavs: int = 100) -> Scenario:
    """Make a scenario with half of the UAVs on either side of Map 1's window, each of which flies to another's start.

    UAV i of the first half and UAV i of the second exchange places, so that each has to leave its place before the
    other arrives, and both have to pass the window.

    Parameters
    ----------
    room
        The scenario that gives bounds, obstacles and clearance: the built-in ``"map1"``, whose window lies between
        y = 2 and 2.5 m.
    uavs
        The number of UAVs, which is even and at most 100.

    Returns
    -------
    Scenario
        Target i is that of UAV i, so plan with the assignment ``"identity"``. The separation is 0.3 m, and 0.6 m
        vertically.

    Raises
    ------
    InputError
        If the number is odd or out of range, or a place is not free in the room.
    """
    require_whole(uavs, "uavs", 2, 100, even=True)
    require_kind(room, Scenario, "room")
    half = uavs // 2
    near, far = _rows_of_places(half, -3.0, -1), _rows_of_places(half, 7.0, 1)
    starts = near + far
    targets = far + near
    taken = next((place for place in starts if not _free(room, place)), None)
    if taken is not None:
        raise InputError(
            f"expected one that is free at the places of {uavs} UAVs, found it taken at {taken}", field="room"
        )
    return room.model_copy(
        update={
            "name": f"window-{uavs}",
            "description": f"{uavs} UAVs exchange places through the window of {room.name}.",
            "uavs": tuple(UAV(name=f"uav-{i}", start=p, separation=0.3) for i, p in enumerate(starts, 1)),
            "targets": tuple(Target(name=f"target-{i}", position=p) for i, p in enumerate(targets, 1)),
        }
    )


def _free(room: Scenario, place: tuple[float, float, float]) -> bool:
    """Return whether a place is in the room's bounds and clear of its boxes; other shapes are ignored."""
    p, (low, high) = np.array(place), (np.array(room.bounds.min), np.array(room.bounds.max))
    boxes = np.array([(box.min, box.max) for box in room.obstacles if isinstance(box, Box)]).reshape(-1, 2, 3)
    near = (boxes[:, 0] - room.clearance < p) & (p < boxes[:, 1] + room.clearance)
    return bool(np.all((low <= p) & (p <= high)) and not near.all(axis=1).any())


def _rows_of_places(count: int, first: float, away: int) -> list[tuple[float, float, float]]:
    """Return places in rows of ten, five rows high, from y = `first` on, in the direction away from the window."""
    dx, dy, dz = SWAP_SPACING
    return [
        (round(1.0 + dx * (i % 10), 6), round(first + away * dy * (i // 50), 6), round(0.8 + dz * (i // 10 % 5), 6))
        for i in range(count)
    ]


FOREST_SIDE, FOREST_HEIGHT = 10.0, 3.0
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
    require_whole(uavs, "uavs", 2, 40, even=True)
    require_whole(trees, "trees", 0, 50)
    require_whole(seed, "seed", 0)
    rng = np.random.default_rng(seed)
    half, length = uavs // 2, FOREST_SIDE + 2.0 * MEADOW
    near, far = (
        scattered_places(rng, half, np.array([west, 0.0, 0.0]), np.array([west + MEADOW, FOREST_SIDE, FOREST_HEIGHT]))
        for west in (0.0, length - MEADOW)
    )
    return scenario_of_swap(
        name=f"forest-{uavs}-{seed}",
        description=f"{uavs} UAVs exchange the sides of a forest of {counted(trees, 'tree')}.",
        size=(length, FOREST_SIDE, FOREST_HEIGHT),
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
            (
                rng.uniform(MEADOW + WALL, MEADOW + FOREST_SIDE - WALL),
                rng.uniform(0.0, FOREST_SIDE),
                rng.uniform(*RADII),
            ),
            3,
        ).tolist()
        if all(math.hypot(x - other[0], y - other[1]) >= radius + other[2] + GAP for other in found):
            found.append((x, y, radius))
    if len(found) < count:
        raise InputError(f"there is no space for {counted(count, 'tree')} that are {GAP:g} m apart")
    return tuple(Cylinder(centre=(x, y), radius=radius, low=0, high=FOREST_HEIGHT) for x, y, radius in found)
