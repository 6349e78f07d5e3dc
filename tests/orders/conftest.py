"""Gives MAVSDK's ground station."""

from mavsdk_stations import stations  # noqa: F401
