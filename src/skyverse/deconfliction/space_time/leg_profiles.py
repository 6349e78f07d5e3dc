"""How far along a straight leg a multirotor is at an instant, if it flies from rest to rest in the least time."""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner_query, kernel
from skyverse.trajectory.limits import Limits
from skyverse.trajectory.ramp import largest_acceleration, largest_speed, peak_speed, ramp_parts, ramp_seconds

SECONDS, LENGTH, PEAK, RISE, HOLD, BRAKE_RISE, BRAKE_HOLD = range(7)
"""The columns of a profile: how long the leg takes and is, its top speed, and the parts of both ramps, seconds."""


class StraightLeg(NamedTuple):
    """A leg from a place (3,) along a way (3,), metres, and its profile (7,)."""

    place: Floats
    way: Floats
    profile: Floats


@kernel
def leg_profiles(ways: Floats, limits: Limits) -> Floats:
    """Return the profiles, (k, 7), of legs that lead along vectors (k, 3), metres."""
    profiles = np.empty((len(ways), 7))
    way = np.empty(3)
    for k in range(len(ways)):
        length = np.sqrt(ways[k, 0] ** 2 + ways[k, 1] ** 2 + ways[k, 2] ** 2)
        for axis in range(3):
            way[axis] = ways[k, axis] / length
        forwards, backwards = largest_acceleration(limits, way), largest_acceleration(limits, -way)
        peak = peak_speed(length, (0.0, 0.0), largest_speed(limits, way), (forwards, backwards, limits.jerk))
        first, last = ramp_seconds(peak, forwards, limits.jerk), ramp_seconds(peak, backwards, limits.jerk)
        cruise = max(length / peak - 0.5 * (first + last), 0.0)
        profiles[k, SECONDS], profiles[k, LENGTH], profiles[k, PEAK] = first + cruise + last, length, peak
        profiles[k, RISE], profiles[k, HOLD] = ramp_parts(peak, forwards, limits.jerk)
        profiles[k, BRAKE_RISE], profiles[k, BRAKE_HOLD] = ramp_parts(peak, backwards, limits.jerk)
    return profiles


@inner_query
def share_flown(profile: Floats, since: float) -> float:
    """Return the share of a leg that is flown some seconds after its departure, from 0 to 1."""
    seconds, length, peak = profile[SECONDS], profile[LENGTH], profile[PEAK]
    if since <= 0.0:
        return 0.0
    if since >= seconds:
        return 1.0
    first = 2.0 * profile[RISE] + profile[HOLD]
    last = 2.0 * profile[BRAKE_RISE] + profile[BRAKE_HOLD]
    if since < first:
        flown = _ramp_way(since, peak, profile[RISE], profile[HOLD])
    elif seconds - since < last:
        flown = length - _ramp_way(seconds - since, peak, profile[BRAKE_RISE], profile[BRAKE_HOLD])
    else:
        flown = 0.5 * peak * first + peak * (since - first)
    return min(max(flown / length, 0.0), 1.0)


@inner_query
def _ramp_way(since: float, peak: float, rise: float, hold: float) -> float:
    """Return the metres that are covered some seconds after the beginning of a ramp from rest to a speed."""
    most = peak / (rise + hold)
    if since < rise:
        return most / rise * since**3 / 6.0
    if since < rise + hold:
        after = since - rise
        return most * (rise * rise / 6.0 + 0.5 * rise * after + 0.5 * after * after)
    left = 2.0 * rise + hold - since
    return 0.5 * peak * (2.0 * rise + hold) - peak * left + most / rise * left**3 / 6.0
