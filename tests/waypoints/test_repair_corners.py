"""Corners that are cut are mended on every autopilot, also those that are short of little."""

import pytest
from test_repair import flight, mended, ridge, scenario

import skyverse as sky
from skyverse.waypoints.findings import Subject

PX4, ARDUPILOT = 12, 3
SURE = sky.FlightSettings(return_altitude=90)


@pytest.mark.parametrize("firmware", [PX4, ARDUPILOT])
@pytest.mark.parametrize(
    ("obstacles", "points"),
    [
        ((), [(100, 0, 5.0), (100, 100, 5.0), (200, 100, 5.0)]),
        ((sky.Box(min=(103.7, -90, 0), max=(140, 96.4, 60), kind="building"),),
         [(100, -80, 30), (100, 100, 30), (200, 100, 30)]),
        ((sky.Box(min=(103.7, -90, 0), max=(140, 96.4, 60), kind="building"),
          sky.Box(min=(90, 103.8, 0), max=(96.2, 140, 60), kind="building")),
         [(100, -80, 30), (100, 100, 30), (200, 100, 30)]),
    ],
    ids=["level ground", "around a corner of a building", "with another one beyond it"],
)  # fmt: skip
def test_a_corner_that_is_short_of_little_is_mended(tmp_path, firmware, obstacles, points):
    world = scenario(*obstacles, terrain=ridge(0.0))
    path = flight(tmp_path, points, radius=3, firmware=firmware)
    (before,) = sky.check_waypoints([sky.read_waypoints(path)], world, SURE).missions
    assert {one.subject for one in before.findings if one.wrong} >= {Subject.CORNERS}
    _, found, *_ = mended(path, world, settings=SURE)
    assert not found.of(Subject.CORNERS) + found.of(Subject.LEGS), found.findings
