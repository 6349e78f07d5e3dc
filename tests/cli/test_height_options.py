"""The ceiling above ground on the command line, and warnings of flights over zones."""

import numpy as np
import pytest

import skyverse as sky


def over_a_zone(**more):
    """A flight at 30 m over a no-fly zone of 10 m, on flat ground."""
    zone = sky.Box(min=(8, 0, 0), max=(12, 20, 10), kind="no-fly zone", name="school", solid=False)
    given = {
        "name": "over",
        "bounds": sky.Bounds(min=(0, 0, 0), max=(20, 20, 40)),
        "obstacles": [zone],
        "clearance": 1.0,
        "lattice": sky.Lattice(step=(1, 1, 1)),
        "uavs": [sky.UAV(start=(2, 10, 30))],
        "targets": [sky.Target(position=(18, 10, 30))],
    }
    return sky.Scenario(**(given | more))


def test_plan_says_which_zone_is_flown_over_and_how_to_forbid_it(skyverse):
    sky.write(over_a_zone(), "over.yaml")
    code, out, _ = skyverse("plan", "over.yaml", "--planner", "taut", "--no-page")
    assert code == 0
    assert "uav-1 flies over the no-fly zone obstacles[0] (school), 20 m above its upper end; give" in out
    assert "--zones-closed-above" in out
    closed = over_a_zone().obstacles[0].model_copy(update={"closed_above": True})
    sky.write(over_a_zone(obstacles=[closed]), "closed.yaml")
    code, out, _ = skyverse("plan", "closed.yaml", "--planner", "taut", "--no-page")
    assert code == 1
    assert "no path" in out
    assert "flies over" not in out


def test_plan_sets_a_ceiling_above_ground(skyverse):
    ground = sky.Terrain(origin=(0, 0), step=(20, 20), heights=np.zeros((2, 2)))
    sky.write(over_a_zone(terrain=ground), "over.yaml")
    code, _, err = skyverse(
        "plan", "over.yaml", "--planner", "taut", "--no-page", "-o", "m.json", "--max-height", "35 m agl"
    )
    assert code == 0, err
    assert sky.read_mission("m.json").scenario.max_height == 35
    code, _, err = skyverse("plan", "over.yaml", "--max-height", "25 m agl")
    assert (code, "lies 30 m above ground, above the ceiling of 25 m" in err) == (2, True)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("120", "--max-height: expected a height above ground, as in '120 m agl', found '120'"),
        ("120 agl", "--max-height: expected an altitude in m or ft, as in '120 m agl'"),
        ("120 m amsl", "--max-height: expected a height above ground, as in '120 m agl', found '120 m amsl'"),
        ("120 m agl", "--max-height: is counted from the ground, but map1 has no terrain"),
    ],
)
def test_a_ceiling_that_cannot_be_is_refused_in_one_sentence(skyverse, words, says):
    code, _, err = skyverse("plan", "map1", "--max-height", words)
    assert code == 2
    assert says in err
    assert err.count("\n") == 1
