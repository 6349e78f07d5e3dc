"""When movers are too near to a place or to a leg, with steps in which the distance that is left cannot be used up."""

import numpy as np

from skyverse._typing import Floats
from skyverse.deconfliction.space_time.leg_profiles import PEAK, SECONDS, StraightLeg, share_flown
from skyverse.numerics.kernel import inner_query
from skyverse.numerics.tolerances import MOVER_MARGIN
from skyverse.space.moving_shapes import MovingShapes, gap_at

HOVER_STEP = 0.01
"""Seconds by which time goes on at least where the UAV hovers."""
LEG_STEP = 0.002
"""Seconds by which time goes on at least while it flies a leg."""


@inner_query
def near_until(
    shapes: MovingShapes, m: int, place: Floats, now: float, more: float, moved: Floats
) -> tuple[bool, float]:
    """Return whether mover m may be too near to a place at an instant, and until when that surely does not change.

    `more` is how much farther than it must the UAV is to be, metres.
    """
    gap, rate = gap_at(shapes, m, now, place, moved) - MOVER_MARGIN - more, shapes.rate[m]
    if now < shapes.active[m, 0]:
        return False, shapes.active[m, 0]
    if now > shapes.active[m, 1]:
        return False, np.inf
    if rate <= 0.0:
        return gap < 0.0, np.nextafter(shapes.active[m, 1], np.inf)
    step = max(abs(gap) / rate, HOVER_STEP)
    return gap < rate * HOVER_STEP, min(now + step, np.nextafter(shapes.active[m, 1], np.inf))


@inner_query
def leg_kept_off(shapes: MovingShapes, leg: StraightLeg, departure: float, horizon: float, room: Floats) -> float:
    """Return by how many seconds a leg must depart later because of a mover that it meets; 0 if it meets none.

    Where it meets one, the mover must have gone from the place at which the UAV would be then. `room` is
    (7, 3) metres to work in.
    """
    here, moved = room[5], room[6]
    arrival = departure + leg.profile[SECONDS]
    for m in range(len(shapes.kind)):
        speed = shapes.rate[m] + leg.profile[PEAK]
        now, until = max(departure, shapes.active[m, 0]), min(arrival, shapes.active[m, 1])
        while now <= until:
            share = share_flown(leg.profile, now - departure)
            for axis in range(3):
                here[axis] = leg.place[axis] + share * leg.way[axis]
            gap = gap_at(shapes, m, now, here, moved) - MOVER_MARGIN
            if gap < speed * LEG_STEP:
                gone = now + HOVER_STEP
                near, after = near_until(shapes, m, here, gone, speed * LEG_STEP, moved)
                while near and gone < horizon:
                    gone = after
                    near, after = near_until(shapes, m, here, gone, speed * LEG_STEP, moved)
                return np.inf if near else gone - now
            now += gap / speed
    return 0.0
