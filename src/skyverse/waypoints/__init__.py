"""Missions that people have: read, proven as their autopilots fly them, and repaired."""

from skyverse.waypoints.check import CheckedMission
from skyverse.waypoints.files import read_waypoints, write_waypoints
from skyverse.waypoints.findings import FindingKind, MissionFinding, Subject
from skyverse.waypoints.fleet import CheckedFleet, check_waypoints
from skyverse.waypoints.flown import FlightSettings
from skyverse.waypoints.mender import Change
from skyverse.waypoints.repair import RepairedFleet, repair_waypoints

__all__ = [
    "Change",
    "CheckedFleet",
    "CheckedMission",
    "FindingKind",
    "FlightSettings",
    "MissionFinding",
    "RepairedFleet",
    "Subject",
    "check_waypoints",
    "read_waypoints",
    "repair_waypoints",
    "write_waypoints",
]
