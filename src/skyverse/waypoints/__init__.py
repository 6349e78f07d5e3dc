"""Missions that people have: read, proven as their autopilots fly them, and repaired."""

from skyverse.waypoints.check import CheckedMission, MissionFinding, Subject
from skyverse.waypoints.files import read_waypoints, write_waypoints
from skyverse.waypoints.fleet import CheckedFleet, check_waypoints
from skyverse.waypoints.flown import FlightSettings

__all__ = [
    "CheckedFleet",
    "CheckedMission",
    "FlightSettings",
    "MissionFinding",
    "Subject",
    "check_waypoints",
    "read_waypoints",
    "write_waypoints",
]
