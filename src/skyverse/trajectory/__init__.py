"""From a path to a trajectory: the waypoints that are needed, then a motion along them within the UAV's limits."""

from skyverse.trajectory.aeroplane import fly_aeroplane, least_ways
from skyverse.trajectory.blended import blended
from skyverse.trajectory.heading import HeldYaw, with_heading
from skyverse.trajectory.leg_parts import rest_to_rest
from skyverse.trajectory.path_to_trajectory import (
    Shape,
    fly_along,
    leg_along,
    needed_waypoints,
    stopping_along,
    straight_along,
)
from skyverse.trajectory.proof import Proof, prove
from skyverse.trajectory.smooth import smooth
from skyverse.trajectory.straight_legs import least_seconds

__all__ = [
    "HeldYaw",
    "Proof",
    "Shape",
    "blended",
    "fly_aeroplane",
    "fly_along",
    "least_seconds",
    "least_ways",
    "leg_along",
    "needed_waypoints",
    "prove",
    "rest_to_rest",
    "smooth",
    "stopping_along",
    "straight_along",
    "with_heading",
]
