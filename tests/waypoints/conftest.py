"""Puts `written_missions` on the path, and gives MAVSDK's ground station."""

import sys
from pathlib import Path

from mavsdk_stations import stations  # noqa: F401

sys.path.insert(0, str(Path(__file__).parent))
