"""From a path to a trajectory: waypoints that matter, then a motion through them within the UAV's limits."""

from skyverse.trajectory.along import Shape, fly_along
from skyverse.trajectory.quintic import rest_to_rest

__all__ = ["Shape", "fly_along", "rest_to_rest"]
