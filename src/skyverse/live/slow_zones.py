"""What zones with a speed limit cost on a way: the seconds by which they make it longer."""

import math
from collections.abc import Sequence
from itertools import pairwise

from skyverse._typing import Floats
from skyverse.space.speed_zones import SpeedZone


def seconds_lost(zones: Sequence[SpeedZone], speed: float, place: Floats, points: Floats) -> float:
    """Return by about how many seconds zones' limits make a way longer that is otherwise flown at one speed.

    Parameters
    ----------
    zones
        With their limits.
    speed
        M/s, outside of zones.
    place, points
        (3,) and (n, 3) metres: where the way begins, and its points.
    """
    lost = 0.0
    for zone in zones:
        if zone.max_speed >= speed:
            continue
        for a, b in pairwise([place, *points]):
            within = zone.stretch(a, b, 0.0)
            if within is not None:
                inside = (within[1] - within[0]) * math.dist(b, a)
                lost += inside * (1.0 / zone.max_speed - 1.0 / speed)
    return lost
