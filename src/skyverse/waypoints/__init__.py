"""Missions that people have: read, proven as their autopilots fly them, and repaired."""

from skyverse.waypoints.files import read_waypoints, write_waypoints

__all__ = ["read_waypoints", "write_waypoints"]
