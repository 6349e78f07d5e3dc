"""Up to a hundred UAVs that exchange places through a window."""

import numpy as np

from skyverse.errors import InputError, require_kind
from skyverse.model.scenario import Scenario, Target
from skyverse.model.shapes import Box
from skyverse.model.uav import UAV
from skyverse.samples.given_numbers import require_whole

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
    require_whole("window_swap", "uavs", uavs, 2, 100, even=True)
    require_kind(room, Scenario, "room")
    half = uavs // 2
    near, far = _places(half, -3.0, -1), _places(half, 7.0, 1)
    starts = near + far
    targets = far + near
    taken = next((place for place in starts if not _free(room, place)), None)
    if taken is not None:
        raise InputError(f"window_swap's room is free at its {uavs} UAVs' places, but {room.name} is not at {taken}")
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


def _places(count: int, first: float, away: int) -> list[tuple[float, float, float]]:
    """Return places in rows of ten, five rows high, from y = `first` on, in the direction away from the window."""
    dx, dy, dz = SWAP_SPACING
    return [
        (round(1.0 + dx * (i % 10), 6), round(first + away * dy * (i // 50), 6), round(0.8 + dz * (i // 10 % 5), 6))
        for i in range(count)
    ]
