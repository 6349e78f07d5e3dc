"""Straight flights from waypoint to waypoint, at rest at each, in the least time.

Each is a profile of seven segments, in each of which the jerk is constant: the UAV accelerates along a ramp (see
`ramp`), keeps its speed, and brakes along another ramp.
"""

from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.numerics.tolerances import LIMIT_MARGIN
from skyverse.space.speed_zones import SpeedZone
from skyverse.trajectory.leg_parts import cut_legs
from skyverse.trajectory.limits import limits_of
from skyverse.trajectory.straight_legs import corner_speeds, trajectory_along, without_repeats


def rest_to_rest(waypoints: Floats, uav: UAV, start: float = 0.0, zones: Sequence[SpeedZone] = ()) -> Trajectory:
    """Fly straight from waypoint to waypoint and stop at each, as fast as the limits allow.

    Parameters
    ----------
    waypoints
        (n, 3) metres; a single one for a UAV that stays where it is.
    uav
        A multirotor, whose limits are kept.
    start
        The first instant, seconds.
    zones
        With speed limits, which are kept too.

    Returns
    -------
    Trajectory
        Up to seven cubic pieces for each segment; a single piece that does not move where the UAV stays.
    """
    points = without_repeats(waypoints)
    if len(points) == 1:
        stay = np.zeros((1, 4, 3))
        stay[0, 0] = points[0]
        return Trajectory(np.array([start, start + 1.0]), stay)
    limits = limits_of(uav, -LIMIT_MARGIN)
    parts = cut_legs(zones, points, limits)
    legs = parts.legs(parts.ends(points), limits)
    speeds = corner_speeds(legs, np.where(parts.at_waypoint, 0.0, np.inf))
    return trajectory_along(legs, speeds, "stop-and-go").retimed(start)
