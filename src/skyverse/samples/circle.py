"""UAVs on a circle, each of which has to fly to the opposite side."""

import math
from numbers import Real

import numpy as np

from skyverse.errors import InputError
from skyverse.model.scenario import Bounds, Lattice, Objective, Scenario, Target
from skyverse.model.shapes import LEAST_CLEARANCE
from skyverse.model.uav import UAV
from skyverse.samples.given_numbers import require_whole

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
    require_whole("circle_swap", "uavs", uavs, 2, even=True)
    separation = UAV(start=(0, 0, 0)).separation
    least = separation / (2.0 * math.sin(math.pi / uavs))
    if isinstance(radius, bool) or not isinstance(radius, Real) or not least < radius < math.inf:
        raise InputError(f"circle_swap's radius for {uavs} UAVs is above {least:.4g} m, not {radius!r}")
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
