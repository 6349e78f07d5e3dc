"""From a path to a trajectory: the waypoints that are needed, then a motion along them within the UAV's limits."""

from skyverse.trajectory.path_to_trajectory import Shape, fly_along
from skyverse.trajectory.rest_to_rest import rest_to_rest

__all__ = ["Shape", "fly_along", "rest_to_rest"]
