"""Random cities: boxes of log-normal height on a square, under a flight ceiling."""

import math

import numpy as np

from skyverse.errors import InputError
from skyverse.model.scenario import Bounds, Lattice, Objective, Scenario, Target
from skyverse.model.shapes import Box
from skyverse.model.uav import UAV

CITY_DENSITY = 2000 / 2000.0**2
"""Buildings per square metre, of 2,000 on 2 km x 2 km."""


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
    opposite side.

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
    for name, number, least in (("buildings", buildings, 0), ("uavs", uavs, 0), ("seed", seed, 0)):
        if isinstance(number, bool) or not isinstance(number, int | np.integer) or number < least:
            raise InputError(f"random_city's {name} is a whole number from {least} on, not {number!r}")
    for name, metres in (("side", side), ("ceiling", ceiling), ("clearance", clearance)):
        number = isinstance(metres, int | float | np.number) and not isinstance(metres, bool) and math.isfinite(metres)
        if metres is not None and (not number or metres < 0 or (metres == 0 and name != "clearance")):
            raise InputError(f"random_city's {name} is metres above 0, not {metres!r}")
    side = float(math.ceil(math.sqrt(max(buildings, 1) / CITY_DENSITY))) if side is None else side
    rng = np.random.default_rng(seed)
    middle = rng.uniform(0.0, side, (buildings, 2))
    half = rng.uniform(5.0, 20.0, (buildings, 2))
    low = np.clip(middle - half, 0.0, side)
    high = np.clip(middle + half, 0.0, side)
    height = np.exp(rng.normal(math.log(25.0), 0.6, buildings))
    boxes = np.round(np.column_stack([low, np.zeros(buildings), high, height]), 2)
    boxes = boxes[np.all(boxes[:, 3:] > boxes[:, :3], axis=1)]

    def free_place(near: tuple[float, float], reach: tuple[float, float]) -> tuple[float, float, float]:
        for _ in range(1000):
            xy = np.clip(np.array(near) + rng.uniform(-1.0, 1.0, 2) * reach, 0.0, side)
            p = np.floor([*100 * xy, 100 * rng.uniform(min(10.0, ceiling / 2), min(50.0, ceiling))]) / 100
            if not np.any(np.all((boxes[:, :3] - clearance - 0.5 < p) & (p < boxes[:, 3:] + clearance + 0.5), axis=1)):
                return float(p[0]), float(p[1]), float(p[2])
        raise InputError(f"{buildings} buildings on {side:g} m leave no room for starts and targets")

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
        name=f"city-{buildings}-{seed}",
        description=f"{buildings} random buildings on {side:g} m x {side:g} m under {ceiling:g} m (seed {seed}).",
        bounds=Bounds(min=(0, 0, 0), max=(side, side, ceiling)),
        obstacles=tuple(Box(min=tuple(row[:3]), max=tuple(row[3:])) for row in boxes.tolist()),
        clearance=clearance,
        lattice=Lattice(step=(step, step, step), connectivity=26),
        objective=Objective(unit="metres"),
        uavs=tuple(UAV(start=a, max_speed=15.0, max_acceleration=5.0) for a, _ in ways),
        targets=tuple(Target(position=b) for _, b in ways),
    )
