"""What closes a way is found by leaving it out, and no path is a proof only where it was proven."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.maps.readers.voxel_grid import KIND_OF_UNKNOWN
from skyverse.mission.closed_ways import closed_ways

HALL = sky.Bounds(min=(0, 0, 0), max=(40, 20, 10))
WALL = {"min": (18, -1, -1), "max": (20, 21, 11)}


def unreached(**more):
    """The mission of a UAV that has to cross a hall, and what closes its way."""
    given = {
        "name": "hall",
        "bounds": HALL,
        "clearance": 0.5,
        "lattice": sky.Lattice(step=(1, 1, 1)),
        "objective": sky.Objective(unit="metres"),
        "uavs": [sky.UAV(start=(5, 10, 5))],
        "targets": [sky.Target(position=(35, 10, 5))],
    }
    mission = sky.plan_mission(sky.Scenario(**(given | more)), sky.Taut(), rng=1)
    (closed,) = closed_ways(mission)
    return mission.results[0].status, closed, {one.field for one in closed.give}


def test_the_wall_in_the_way_is_named_and_not_what_stands_beside_it():
    wall, aside = sky.Box(**WALL, name="wall"), sky.Box(min=(30, 15, 0), max=(32, 17, 10), name="pillar")
    status, closed, _ = unreached(obstacles=[aside, wall])
    assert status is sky.Status.NO_PATH_EXISTS
    assert closed.by[0] == "the obstacle obstacles[1] (wall)"
    assert not any("pillar" in one for one in closed.by)


def test_a_zone_is_closed_until_the_bounds_are_higher_or_wider():
    zone = sky.Cylinder(centre=(20, 10), radius=12, low=-1, high=12, kind="no-fly zone", solid=False)
    status, closed, opens = unreached(obstacles=[zone])
    assert status is sky.Status.NO_PATH  # of a round zone there is no proof
    assert closed.by[0] == "the no-fly zone obstacles[0]"
    assert opens == {"ceiling", "margin"}


def test_a_gap_that_the_clearance_closes_asks_for_a_smaller_one():
    walls = [sky.Box(min=(18, -50, -50), max=(20, 9.6, 60)), sky.Box(min=(18, 10.4, -50), max=(20, 70, 60))]
    lattice = sky.Lattice(step=(1, 1, 1))
    status, closed, opens = unreached(obstacles=walls, lattice=lattice)
    assert status is sky.Status.NO_PATH_EXISTS
    assert opens == {"clearance"} | (opens & {"ceiling", "margin"})
    assert "the clearance of 0.5 m" in closed.by


def test_a_ceiling_above_ground_over_a_cliff_is_named():
    cliff = np.zeros((41, 21))
    cliff[20:] = 6
    ground = sky.Terrain(origin=(0, 0), step=(1, 1), heights=cliff, clearance=1.0)
    status, closed, opens = unreached(
        terrain=ground,
        max_height=4,
        bounds=sky.Bounds(min=(0, 0, 0), max=(40, 20, 20)),
        uavs=[sky.UAV(start=(5, 10, 2))],
        targets=[sky.Target(position=(35, 10, 8))],
    )
    assert status is sky.Status.NO_PATH
    assert closed.by == ("the ceiling of 4 m above ground",)
    assert opens == {"max_height"}


def test_space_that_nobody_has_seen_may_be_taken_as_free():
    occupied = np.ones((1, 22, 12), bool)
    voxels = sky.Voxels(origin=(18, -1, -1), step=(1, 1, 1), occupied=occupied, kind=KIND_OF_UNKNOWN["occupied"])
    _, closed, opens = unreached(obstacles=[voxels])
    assert "unknown" in opens
    assert closed.by[0].startswith("the occupied or unknown space")


def test_a_mission_with_all_its_ways_has_none_that_is_closed():
    assert closed_ways(sky.plan_mission(sky.read("table-4.8"), rng=1)) == []


@pytest.mark.parametrize("lattice", [(1, 1, 1), (2, 2, 2)])
def test_what_is_left_out_does_open_the_way(lattice):
    """The truth: without the thing that is named, a path is found."""
    wall = sky.Box(**WALL)
    _, closed, _ = unreached(obstacles=[wall], lattice=sky.Lattice(step=lattice))
    assert len(closed.by) > 1
    wide = sky.Bounds(min=(-40, -40, 0), max=(80, 60, 10))
    opened = sky.plan_mission(
        sky.Scenario(
            name="wide",
            bounds=wide,
            obstacles=[wall],
            clearance=0.5,
            lattice=sky.Lattice(step=lattice),
            uavs=[sky.UAV(start=(5, 10, 5))],
            targets=[sky.Target(position=(35, 10, 5))],
        ),
        sky.Taut(),
    )
    assert opened.complete is ("the edge of the area" in closed.by)
