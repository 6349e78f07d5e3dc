"""Random cities on a square, under a flight ceiling: mostly lower than it, or downtown, mostly as high."""

import math
from collections.abc import Iterator

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, require_number, require_whole
from skyverse.model.scenario import Bounds, Lattice, Objective, Scenario, Target
from skyverse.model.shapes import LEAST_CLEARANCE, Box
from skyverse.model.short_lines import counted
from skyverse.model.uav import UAV

CITY_DENSITY = 2000 / 2000.0**2
"""Buildings per square metre, of 2,000 on 2 km x 2 km."""

DOWNTOWN_DENSITY = 1500 / 1500.0**2
"""Buildings per square metre downtown, of 1,500 on 1.5 km x 1.5 km."""

TALL_SHARE = 0.85
"""The share of the buildings downtown that reach the ceiling."""

TRIES = 1000
"""How many random places are tried before starts and targets are sought farther from a corner or a side."""


def random_city(
    buildings: int = 2000,
    *,
    side: float | None = None,
    ceiling: float = 60.0,
    clearance: float = 2.0,
    uavs: int = 1,
    seed: int = 0,
) -> Scenario:
    """Make a city of random buildings, and UAVs that have to cross it.

    Footprints are rectangles with sides of 10 to 40 m at random places, so that some touch or overlap. Heights are
    log-normal with median 25 m (sigma 0.6), so that about 7 % exceed a ceiling of 60 m. The first UAV crosses from
    corner to corner; the others start at a random place on one side of the square and have their target on the
    opposite side. Where there is no room, they start and end farther from the corners or sides.

    Parameters
    ----------
    buildings
        The number of buildings.
    side
        The side of the square, metres; by default it gives the density of 2,000 buildings on 2 km x 2 km.
    ceiling
        The upper bound of flight, metres above the ground, which is the lower bound.
    clearance
        The distance to keep from buildings, metres.
    uavs
        The number of UAVs, and of targets.
    seed
        The same seed makes the same city.

    Returns
    -------
    Scenario
        It has a 26-connected lattice with steps of at most 5 m, and costs in metres.

    Raises
    ------
    InputError
        If an argument is out of range, or the buildings leave no space for starts and targets.
    """
    side = _checked_side(buildings, CITY_DENSITY, side, ceiling, clearance, uavs, seed)
    rng = np.random.default_rng(seed)
    low, high = _footprints(rng, buildings, side, (10.0, 40.0))
    height = np.exp(rng.normal(math.log(25.0), 0.6, buildings))
    boxes = _buildings(low, high, height)
    described = f"{counted(buildings, 'random building')} on {side:g} m x {side:g} m under {ceiling:g} m (seed {seed})."
    return _to_cross(f"city-{buildings}-{seed}", described, boxes, side, ceiling, clearance, uavs, rng)


def random_downtown(
    buildings: int = 1500,
    *,
    side: float | None = None,
    ceiling: float = 60.0,
    clearance: float = 2.0,
    uavs: int = 1,
    seed: int = 0,
) -> Scenario:
    """Make a city whose buildings mostly reach the flight ceiling, and UAVs that have to find a way between them.

    Footprints are rectangles with sides of 10 to 45 m at random places, so that many touch or overlap. Of the
    buildings, 85 % are as high as the ceiling or up to twice as high; the others have 10 to 90 % of its height, evenly
    spread. Starts and targets are placed as in `random_city`; some may be shut in, so that there is no path.

    Parameters
    ----------
    buildings
        The number of buildings.
    side
        The side of the square, metres; by default it gives the density of 1,500 buildings on 1.5 km x 1.5 km.
    ceiling
        The upper bound of flight, metres above the ground, which is the lower bound.
    clearance
        The distance to keep from buildings, metres.
    uavs
        The number of UAVs, and of targets.
    seed
        The same seed makes the same city.

    Returns
    -------
    Scenario
        It has a 26-connected lattice with steps of at most 5 m, and costs in metres.

    Raises
    ------
    InputError
        If an argument is out of range, or the buildings leave no space for starts and targets.
    """
    side = _checked_side(buildings, DOWNTOWN_DENSITY, side, ceiling, clearance, uavs, seed)
    rng = np.random.default_rng(seed)
    low, high = _footprints(rng, buildings, side, (10.0, 45.0))
    tall = rng.random(buildings) < TALL_SHARE
    height = ceiling * np.where(tall, rng.uniform(1.0, 2.0, buildings), rng.uniform(0.1, 0.9, buildings))
    boxes = _buildings(low, high, height)
    described = (
        f"{counted(buildings, 'random building')} downtown, {side:g} m x {side:g} m under {ceiling:g} m (seed {seed})."
    )
    return _to_cross(f"downtown-{buildings}-{seed}", described, boxes, side, ceiling, clearance, uavs, rng)


def _checked_side(
    buildings: int,
    density: float,
    side: float | None,
    ceiling: float,
    clearance: float,
    uavs: int,
    seed: int,
) -> float:
    """Return the side of the square, metres, after a check of a generator's arguments."""
    for name, number in (("buildings", buildings), ("uavs", uavs), ("seed", seed)):
        require_whole(number, name, 0)
    for name, metres in (("side", 1.0 if side is None else side), ("ceiling", ceiling), ("clearance", clearance)):
        require_number(metres, name, "metres", LEAST_CLEARANCE)
    return float(math.ceil(math.sqrt(max(buildings, 1) / density))) if side is None else side


def _footprints(
    rng: np.random.Generator, buildings: int, side: float, sides: tuple[float, float]
) -> tuple[Floats, Floats]:
    """Return the min and the max corners of random rectangles on the square, (n, 2) metres each."""
    middle = rng.uniform(0.0, side, (buildings, 2))
    half = rng.uniform(0.5 * sides[0], 0.5 * sides[1], (buildings, 2))
    return np.clip(middle - half, 0.0, side), np.clip(middle + half, 0.0, side)


def _buildings(low: Floats, high: Floats, height: Floats) -> Floats:
    """Return buildings as boxes (n, 6) in whole centimetres; those without extent are left out."""
    boxes = np.round(np.column_stack([low, np.zeros(len(low)), high, height]), 2)
    return np.asarray(boxes[np.all(boxes[:, 3:] > boxes[:, :3], axis=1)])


def _reaches(reach: tuple[float, float], side: float) -> Iterator[Floats]:
    """Yield how far from a corner or side places are sought, (2,) metres: twice as far each time, up to the middle."""
    wide = np.array(reach)
    yield wide
    while wide.min() < side / 2:
        wide = np.minimum(2 * wide, side / 2)
        yield wide


def _to_cross(
    name: str,
    description: str,
    boxes: Floats,
    side: float,
    ceiling: float,
    clearance: float,
    uavs: int,
    rng: np.random.Generator,
) -> Scenario:
    """Return the scenario of a city and UAVs that have to cross it; the first one does from corner to corner."""

    def free_place(near: tuple[float, float], reach: tuple[float, float]) -> tuple[float, float, float]:
        for wide in _reaches(reach, side):
            for _ in range(TRIES):
                xy = np.clip(np.array(near) + rng.uniform(-1.0, 1.0, 2) * wide, 0.0, side)
                p = np.floor([*100 * xy, 100 * rng.uniform(min(10.0, ceiling / 2), min(50.0, ceiling))]) / 100
                inside = (boxes[:, :3] - clearance - 0.5 < p) & (p < boxes[:, 3:] + clearance + 0.5)
                if not np.any(np.all(inside, axis=1)):
                    return float(p[0]), float(p[1]), float(p[2])
        raise InputError(f"{len(boxes)} buildings on {side:g} m leave no room for starts and targets")

    step = min(5.0, side, ceiling)
    edge = side / 20.0
    ends = [((0.0, 0.0), (side, side), (edge, edge))]
    while len(ends) < uavs:
        across, far = rng.random() < 0.5, rng.random() < 0.5
        here, there = (0.0, side) if far else (side, 0.0)
        a, b, reach = (here, side / 2), (there, side / 2), (edge, side / 2)
        ends.append((a, b, reach) if across else (a[::-1], b[::-1], reach[::-1]))
    ways = [(free_place(a, reach), free_place(b, reach)) for a, b, reach in ends[:uavs]]
    return Scenario(
        name=name,
        description=description,
        bounds=Bounds(min=(0, 0, 0), max=(side, side, ceiling)),
        obstacles=tuple(Box(min=tuple(row[:3]), max=tuple(row[3:])) for row in boxes.tolist()),
        clearance=clearance,
        lattice=Lattice(step=(step, step, step), connectivity=26),
        objective=Objective(unit="metres"),
        uavs=tuple(UAV(start=a, max_speed=15.0, max_acceleration=5.0) for a, _ in ways),
        targets=tuple(Target(position=b) for _, b in ways),
    )
