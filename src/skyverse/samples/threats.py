"""Random fields of threats: boxes as obstacles, and zones that a path may cross at a risk."""

import math

import numpy as np

from skyverse.errors import require_whole
from skyverse.model.scenario import AltitudeBand, Bounds, ClimbLimit, Lattice, Objective, Scenario, Target
from skyverse.model.shapes import Box, Cylinder, Prism
from skyverse.model.short_lines import counted
from skyverse.model.uav import UAV

FIELD_SIDE, FIELD_CEILING, FIELD_CLEARANCE = 1000.0, 200.0, 5.0
"""Metres."""


def random_threats(threats: int = 15, *, seed: int = 0) -> Scenario:
    """Make a field of 1000 m x 1000 m x 200 m with random threats in it, and a UAV that has to cross it.

    Each threat is, with equal probability, a box as an obstacle, or a cylinder or a prism as a zone with a risk of 0.5
    to 3 a metre. Some reach the ceiling; UAVs can fly over the others, and under some zones, outside the altitude band.
    The objective has all terms: metres, turns, end, altitude, risk and climb.

    Parameters
    ----------
    threats
        The number of threats.
    seed
        The same seed makes the same field.

    Returns
    -------
    Scenario
        It has a 26-connected lattice with steps of 20 m, for planners that need one.

    Raises
    ------
    InputError
        If the number of threats or the seed is not a whole number from 0 on.
    """
    for name, number in (("threats", threats), ("seed", seed)):
        require_whole(number, name, 0)
    rng = np.random.default_rng(seed)
    start = _place(rng, 40.0, 100.0)
    target = _place(rng, FIELD_SIDE - 100.0, FIELD_SIDE - 40.0)
    boxes: list[Box] = []
    zones: list[Cylinder | Prism] = []
    while len(boxes) + len(zones) < threats:
        centre = rng.uniform(0.0, FIELD_SIDE, 2)
        top = float(rng.choice([80.0, 120.0, FIELD_CEILING]))
        low = float(rng.choice([0.0, 0.0, 40.0]))
        risk = round(float(rng.uniform(0.5, 3.0)), 2)
        kind = rng.integers(3)
        if kind == 0:
            half = rng.uniform(30.0, 110.0, 2)
            box = Box(min=(*_rounded(centre - half), 0.0), max=(*_rounded(centre + half), top))
            if not any(_near(box, end) for end in (start, target)):
                boxes.append(box)
        elif kind == 1:
            radius = round(float(rng.uniform(50.0, 140.0)), 1)
            zones.append(Cylinder(centre=_rounded(centre), radius=radius, low=low, high=top, risk=risk))
        else:
            zones.append(Prism(vertices=_star(rng, centre), low=low, high=top, risk=risk))
    return Scenario(
        name=f"threats-{threats}-{seed}",
        description=f"{counted(threats, 'random threat')} on {FIELD_SIDE:g} m x {FIELD_SIDE:g} m "
        f"under {FIELD_CEILING:g} m (seed {seed}).",
        bounds=Bounds(min=(0, 0, 0), max=(FIELD_SIDE, FIELD_SIDE, FIELD_CEILING)),
        obstacles=tuple(boxes),
        zones=tuple(zones),
        clearance=FIELD_CLEARANCE,
        lattice=Lattice(step=(20, 20, 20), connectivity=26),
        objective=Objective(
            divergence=10,
            end=1000,
            unit="metres",
            altitude=AltitudeBand(low=50, high=70, weight=0.02),
            climb=ClimbLimit(angle=5, weight=4),
        ),
        uavs=(UAV(start=start, max_speed=15.0, max_acceleration=5.0),),
        targets=(Target(position=target),),
    )


def _place(rng: np.random.Generator, low: float, high: float) -> tuple[float, float, float]:
    x, y = _rounded(rng.uniform(low, high, 2))
    return x, y, round(float(rng.uniform(20.0, 60.0)), 1)


def _rounded(place: np.ndarray) -> tuple[float, float]:
    return round(float(place[0]), 1), round(float(place[1]), 1)


def _near(box: Box, end: tuple[float, float, float]) -> bool:
    room = FIELD_CLEARANCE + 25.0  # so that a lattice node beside the box is free
    return all(box.min[k] - room < end[k] < box.max[k] + room for k in range(2))


def _star(rng: np.random.Generator, centre: np.ndarray) -> tuple[tuple[float, float], ...]:
    """Return a random polygon of five to nine corners around a centre; it is rarely convex."""
    corners = int(rng.integers(5, 10))
    turn = 2 * math.pi * (np.arange(corners) + rng.uniform(-0.3, 0.3, corners)) / corners
    reach = rng.uniform(50.0, 160.0, corners)
    return tuple(_rounded(centre + r * np.array([math.cos(a), math.sin(a)])) for r, a in zip(reach, turn, strict=True))
