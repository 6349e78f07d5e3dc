"""The yaw of a multirotor whose motion is replanned: it goes on from what the nose does, within the UAV's limits.

The yaw rate is linear between instants a tick apart, so that it is a sum of turns, each spread over a tick. Which of
them are flown is fixed once: a later answer replaces those that come after it.
"""

import math
from dataclasses import replace

import numpy as np

from skyverse._typing import Floats
from skyverse.model.trajectory import Pointing, Trajectory
from skyverse.model.uav import UAV
from skyverse.numerics.kernel import kernel
from skyverse.trajectory.heading import wanted_yaws

TICK = 1.0 / 32.0
"""Seconds between the instants at which the yaw acceleration changes; a power of two, so that sums of it are exact."""
GAIN = 8.0
"""Rad/s of yaw rate for each rad by which the nose is off, where that is little."""
LEAST_RATE = 1e-3
"""Rad/s: a slower turn is not begun."""
LONGEST_SETTLING = 10.0
"""Seconds for which the nose turns on at most after the motion has ended."""


def still(yaw: float, uav: UAV) -> Pointing:
    """Return the pointing of a UAV whose nose does not turn."""
    return Pointing(yaw, np.zeros(0), np.zeros(0), TICK, TICK, uav.look_at)


def steered_heading(
    before: Pointing, since: float, motion: Trajectory, uav: UAV, planned: Trajectory | None, leaves: float
) -> Pointing:
    """Return the pointing that leaves another one, from the first tick after an instant on.

    The nose follows the planned trajectory's yaw as long as that is flown. Then it points as
    `uav.look_at` or `uav.heading` say, or else along the motion; where that has no course it stays.

    Parameters
    ----------
    before, since
        Another pointing of whole ticks, and the instant until which it is kept, seconds.
    motion, uav
        What is flown from then on, to rest, and by which UAV.
    planned, leaves
        The trajectory that the motion follows, and until when; ``None`` if it follows none.
    """
    begin = math.ceil(since / TICK)
    (yaw,), (rate,), _ = before.at(np.array([begin * TICK]), np.zeros((1, 3)))
    most, hardest = math.radians(uav.max_yaw_rate), math.radians(uav.max_yaw_acceleration)
    settling = abs(rate) / hardest + min(math.pi / most + most / hardest, LONGEST_SETTLING)
    ticks = np.arange(begin, math.ceil((motion.end + settling) / TICK) + 3)
    wanted = _wanted(ticks * TICK, yaw + 0.5 * rate * abs(rate) / hardest, motion, uav, planned, leaves)
    rates = _followed(wanted, yaw, rate, most, hardest)
    kept = before.instants <= begin * TICK
    turning = np.flatnonzero(rates)
    return replace(
        before,
        instants=np.r_[before.instants[kept], ticks[1:][turning] * TICK],
        turns=np.r_[before.turns[kept], rates[turning] * TICK],
    )


def _wanted(t: Floats, held: float, motion: Trajectory, uav: UAV, planned: Trajectory | None, leaves: float) -> Floats:
    """Return where the nose is to point at instants (m,), rad, without leaps; `held` where there is no course yet."""
    known, courses = wanted_yaws(motion, t, uav)
    wanted = np.full(len(t), np.nan)
    wanted[known] = courses
    if planned is not None:
        wanted[t <= leaves] = planned.heading(t[t <= leaves]).yaw
    wanted = np.r_[held, wanted]
    last = np.maximum.accumulate(np.where(np.isnan(wanted), 0, np.arange(len(wanted))))
    return np.unwrap(wanted[last])[1:]


@kernel
def _followed(wanted: Floats, yaw: float, rate: float, most: float, hardest: float) -> Floats:
    """Return the yaw rates (m - 2,), rad/s, after each tick with which the nose follows wanted yaws, (m,) rad.

    It slows down at half of the largest acceleration, and does not turn any more at the end.
    """
    n = len(wanted) - 2
    rates = np.empty(n)
    for k in range(n):
        ahead = 0.5 * (wanted[k + 2] - wanted[k]) / TICK
        off = wanted[k + 1] - (yaw + 0.5 * (rate + ahead) * TICK)
        size = min(GAIN * abs(off), math.sqrt(hardest * abs(off)))
        asked = ahead + (size if off > 0.0 else -size)
        top = min(most, hardest * TICK * (n - 1 - k))
        asked = min(max(asked, -top), top)
        if abs(asked) < LEAST_RATE:
            asked = 0.0
        then = min(max(asked, rate - hardest * TICK), rate + hardest * TICK)
        yaw += 0.5 * (rate + then) * TICK
        rate = then
        rates[k] = rate
    return rates
