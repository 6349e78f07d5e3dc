"""Corners that are cut need over level ground what legs need, and those that are short of little are mended."""

import numpy as np
import pytest
from test_repair import flight, mended, ridge, scenario

import skyverse as sky
from skyverse.waypoints.findings import Subject

PX4, ARDUPILOT = 12, 3
SURE = sky.FlightSettings(return_altitude=90)
NORTH_THEN_EAST = [(100, -80), (100, 100), (200, 100)]


def ground_with_rock(high):
    """Level ground, and a rock that the way inside the corner at (100, 100) comes near to, while no leg does."""
    heights = np.zeros((601, 601))
    heights[205, 395] = high
    return sky.Terrain(origin=(-100, -300), step=(1, 1), heights=heights, clearance=2.0)


@pytest.mark.parametrize("firmware", [PX4, ARDUPILOT])
@pytest.mark.parametrize("lower", [0.0, 0.03])
def test_over_level_ground_a_corner_needs_no_more_than_its_legs(tmp_path, firmware, lower):
    path = flight(tmp_path, [(x, y, 5.0 - lower) for x, y in NORTH_THEN_EAST], radius=3, firmware=firmware)
    (found,) = sky.check_waypoints([sky.read_waypoints(path)], scenario(), SURE).missions
    low = {(1,), (3,)} if firmware == PX4 else set()  # PX4 leaves the climb below its end
    assert {one.items for one in found.of(Subject.CORNERS)} <= low, found.findings
    assert bool(found.of(Subject.LEGS)) == (lower > 0.02)


@pytest.mark.parametrize("firmware", [PX4, ARDUPILOT])
@pytest.mark.parametrize(
    ("obstacles", "high", "rock"),
    [
        ((), 5.3, 1.5),
        ((sky.Box(min=(103.7, -90, 0), max=(140, 96.4, 60), kind="building"),), 30, 0),
        ((sky.Box(min=(103.7, -90, 0), max=(140, 96.4, 60), kind="building"),
          sky.Box(min=(90, 103.8, 0), max=(96.2, 140, 60), kind="building")), 30, 0),
    ],
    ids=["over a rock", "around a corner of a building", "with another one beyond it"],
)  # fmt: skip
def test_a_corner_that_is_short_of_little_is_mended(tmp_path, firmware, obstacles, high, rock):
    world = scenario(*obstacles, terrain=ground_with_rock(rock) if rock else ridge(0.0))
    path = flight(tmp_path, [(x, y, high) for x, y in NORTH_THEN_EAST], radius=3, firmware=firmware)
    (before,) = sky.check_waypoints([sky.read_waypoints(path)], world, SURE).missions
    assert before.of(Subject.CORNERS)
    assert not before.of(Subject.LEGS)
    _, found, *_ = mended(path, world, settings=SURE)
    assert not found.of(Subject.CORNERS) + found.of(Subject.LEGS), found.findings
