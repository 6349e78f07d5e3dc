"""UAVs that exchange sides through a tunnel between two rooms."""

from numbers import Real

import numpy as np

from skyverse.errors import InputError
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Box
from skyverse.samples.given_numbers import require_whole
from skyverse.samples.small_uavs import WALL, scattered_places, scenario_of_swap

ROOM = (6.0, 7.0, 3.0)
"""Metres along each axis: the inside of a room."""
TUNNEL_LENGTH = 4.0
"""Metres from room to room."""
MOST_UAVS = 60


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
    require_whole("tunnel_swap", "uavs", uavs, 2, MOST_UAVS, even=True)
    if isinstance(width, bool) or not isinstance(width, Real) or not 0.8 <= width <= 2.5:
        raise InputError(f"tunnel_swap's width is from 0.8 to 2.5 m, not {width!r}")
    require_whole("tunnel_swap", "seed", seed, 0)
    rng = np.random.default_rng(seed)
    depth, across, high = ROOM
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
