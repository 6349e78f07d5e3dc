"""Corners that are cut need over level ground what legs need, and those that are short of little are mended."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
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


@pytest.mark.parametrize("top", [24.4, 24.8])
def test_a_corner_at_the_end_of_a_take_off_that_is_short_of_little_is_raised(tmp_path, top):
    crate = sky.Box(min=(6, -5, 0), max=(15, 5, top))
    path = flight(tmp_path, [(100, 0, 30), (100, 100, 30)], radius=3)
    (before,) = sky.check_waypoints([sky.read_waypoints(path)], scenario(crate), SURE).missions
    assert [one.items for one in before.of(Subject.CORNERS)] == [(1,)]
    made, found, *_ = mended(path, scenario(crate), settings=SURE)
    assert found.is_proven, found.findings
    assert [one.items for one in made.changes[0]] == [(1,)]


@settings(max_examples=20)
@given(st.integers(0, 10_000))
@example(23)
def test_whatever_is_in_the_way_of_a_small_mission_it_is_mended_or_told(tmp_path_factory, seed):
    rng = np.random.default_rng(seed)
    places = np.round(rng.uniform((-60, -60, 20), (60, 60, 40), (rng.integers(2, 4), 3)), 1)
    around = np.concatenate([[(0.0, 0.0, places[0, 2])], places])
    boxes = []
    for _ in range(rng.integers(1, 3)):  # little below and beside a place
        x, y, z = around[rng.integers(len(around))] + rng.uniform((-10, -10, -7), (10, 10, -4))
        boxes.append(sky.Box(min=(x - 4, y - 4, 0), max=(x + 4, y + 4, max(z, 1.0))))
    firmware, radius = rng.choice([PX4, ARDUPILOT]), rng.choice([0.0, 3.0, 10.0])
    path = flight(tmp_path_factory.mktemp("small"), places.tolist(), radius=radius, firmware=int(firmware))
    told = sky.read_waypoints(path)
    try:
        made = sky.repair_waypoints([told], scenario(*boxes), SURE)
    except sky.InputError:
        return  # as of a box over the place where it stands
    (found,) = made.checked.missions
    assert found.is_proven or any(one.wrong for one in found.findings)
