"""Legs cut into parts where they enter and leave zones, so that each part has one speed limit.

`rest_to_rest` flies straight from waypoint to waypoint, at rest at each, in the least time: a profile of seven segments
of constant jerk.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Bools, Floats, Ints
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.model.wind import STILL_AIR, WindBall
from skyverse.numerics.tolerances import LIMIT_MARGIN
from skyverse.space.speed_zones import SpeedZone
from skyverse.trajectory.limits import Limits, limits_of
from skyverse.trajectory.straight_legs import Legs, corner_speeds, legs_between, trajectory_along, without_repeats

ZONE_MARGIN = 0.01
"""Metres from a zone at which its speed limit begins and ends, so that no rounding takes a faster UAV into it."""


class LegParts(NamedTuple):
    """The parts of the legs between n waypoints.

    Attributes
    ----------
    places
        (m + 1,) the ends of the parts: k + u stands for the place at the share u of the leg from waypoint k.
    speeds
        (m,) the speed limit on each part, m/s; infinite where there is none.
    """

    places: Floats
    speeds: Floats

    @property
    def limited(self) -> bool:
        """Whether any part has a speed limit."""
        return bool(np.isfinite(self.speeds).any())

    @property
    def at_waypoint(self) -> Bools:
        """(m + 1,) whether each end of a part is a waypoint."""
        return self.places == np.floor(self.places)

    @property
    def neighbours(self) -> tuple[Ints, Ints]:
        """(m,) the last end before each part, and the first after it, that are waypoints."""
        ends = np.arange(len(self.places))
        before = np.maximum.accumulate(np.where(self.at_waypoint, ends, 0))
        after = np.minimum.accumulate(np.where(self.at_waypoint, ends, ends[-1])[::-1])[::-1]
        return before[:-1], after[1:]

    def ends(self, waypoints: Floats) -> Floats:
        """Return where the parts end, (m + 1, 3) metres, between waypoints (n, 3)."""
        leg = np.minimum(self.places.astype(np.int64), len(waypoints) - 2)
        share = (self.places - leg)[:, None]
        return (1.0 - share) * waypoints[leg] + share * waypoints[leg + 1]

    def legs(self, ends: Floats, limits: Limits) -> Legs:
        """Return the parts as legs between their ends (m + 1, 3), each with its speed limit."""
        legs = legs_between(ends, limits)
        return legs._replace(speeds=np.minimum(legs.speeds, (1.0 - LIMIT_MARGIN) * self.speeds))


def whole_legs(waypoints: Floats) -> LegParts:
    """Return the legs between waypoints (n, 3) as parts without a speed limit."""
    return LegParts(np.arange(float(len(waypoints))), np.full(len(waypoints) - 1, np.inf))


def cut_legs(zones: Sequence[SpeedZone], waypoints: Floats, limits: Limits, margin: float = ZONE_MARGIN) -> LegParts:
    """Cut the legs between waypoints (n, 3) where they come within `margin` metres of zones, and where they leave them.

    What is left between a zone and a bend belongs to the slow part too, where a blend at the zone's speed limit would
    not fit into it.
    """
    if not zones:
        return whole_legs(waypoints)
    ways = np.diff(waypoints, axis=0)
    lengths = np.linalg.norm(ways, axis=1)
    units = ways / lengths[:, None]
    sharpness = np.r_[0.0, np.linalg.norm(np.diff(units, axis=0), axis=1), 0.0]
    stretches = []
    for k, length in enumerate(lengths):
        for zone in zones:
            inside = zone.stretch(waypoints[k], waypoints[k + 1], margin)
            if inside is None or zone.max_speed >= limits.speed:
                continue
            room = _blend_ways(zone.max_speed, sharpness[k : k + 2], limits) / length
            first = 0.0 if inside[0] <= room[0] else inside[0]
            last = 1.0 if inside[1] >= 1.0 - room[1] else inside[1]
            stretches.append((k + first, k + last, zone.max_speed))
    places = np.unique(np.r_[np.arange(len(waypoints)), [end for stretch in stretches for end in stretch[:2]]])
    middles = 0.5 * (places[:-1] + places[1:])
    speeds = np.full(len(middles), np.inf)
    for first, last, most in stretches:
        inside = (first < middles) & (middles < last)
        speeds[inside] = np.minimum(speeds[inside], most)
    kept = np.r_[True, (speeds[1:] != speeds[:-1]) | (places[1:-1] == np.floor(places[1:-1])), True]
    return LegParts(places[kept], speeds[kept[:-1]])


def _blend_ways(speed: float, sharpness: Floats, limits: Limits) -> Floats:
    """Return about how many metres before bends of a sharpness (n,) the blends at a speed begin, (n,)."""
    seconds = speed * sharpness / limits.acceleration + limits.acceleration / limits.jerk
    return np.where(sharpness > 0.0, 0.5 * speed * seconds, ZONE_MARGIN)


def rest_to_rest(
    waypoints: Floats, uav: UAV, start: float = 0.0, zones: Sequence[SpeedZone] = (), winds: WindBall = STILL_AIR
) -> Trajectory:
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
    winds
        In which the UAV flies.

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
    limits = limits_of(uav, -LIMIT_MARGIN, winds)
    parts = cut_legs(zones, points, limits)
    legs = parts.legs(parts.ends(points), limits)
    speeds = corner_speeds(legs, np.where(parts.at_waypoint, 0.0, np.inf))
    return trajectory_along(legs, speeds, "stop-and-go").retimed(start)
