"""Puts `handmade_exports` on the path, and gives MAVSDK's ground station."""

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from mavsdk_stations import stations  # noqa: F401

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def unjudged(monkeypatch):
    """Let missions that were made by hand be exported: the referee refutes them, as they have no results."""
    monkeypatch.setattr(
        "skyverse.exports.requirements.judged", lambda scenario, mission: replace(mission, violations=())
    )
