"""Tours whose legs turn out dearer than they seemed, and tours that are interrupted: what is flown is sound."""

import numpy as np
import pytest

import skyverse as sky
from rounds import rounds
from skyverse.mission.closed_ways import closed_ways
from turns import CancelledAtLook


def windy(battery):
    """Fourteen targets in a wind, which makes legs dearer than their lower bounds say."""
    rng = np.random.default_rng(2)
    places = [tuple(map(float, rng.uniform((13, 1, 1), (19, 19, 8)))) for _ in range(14)]
    uavs = [uav.model_copy(update={"battery": battery}) for uav in rounds().scenario.uavs]
    targets = [{"name": f"m{k}", "position": place, "stay": 1.0} for k, place in enumerate(places)]
    wind = {"velocity": (2.5, 0, 0), "gust": 0.5}
    return rounds().scenario.model_copy(update={"targets": targets, "uavs": uavs, "wind": wind})


def named_once(mission):
    targets = range(len(mission.scenario.targets))
    return sorted([*mission.visited, *(one.target for one in mission.unvisited)]) == [*targets]


@pytest.mark.parametrize("battery", [0.45, 0.6, 0.9])
def test_what_batteries_give_is_flown_and_the_rest_is_named(battery):
    mission = sky.plan_mission(windy(battery), sky.Taut(), rng=1)
    assert mission.violations == ()
    assert named_once(mission)
    alone = [sky.plan_mission(only(mission.scenario, k), sky.Taut(), rng=1).visited for k in range(14)]
    assert len(mission.visited) >= sum(map(len, alone)) / 2
    for one in mission.unvisited:
        assert ("no battery gives" in one.why) == (not alone[one.target])


def only(scenario, target):
    return scenario.model_copy(update={"targets": (scenario.targets[target],)})


@pytest.mark.parametrize(("scenario", "look"), [(windy(0.9), 200), (rounds().scenario, 38)], ids=["PyVRP", "exact"])
def test_an_interrupted_search_gives_the_best_tours_so_far_and_marks_them(scenario, look):
    mission = sky.plan_mission(scenario, sky.Taut(), stop=CancelledAtLook(look), workers=1, rng=1)
    assert mission.interrupted
    assert not mission.complete
    assert {one.fault for one in sky.check(scenario, mission)} <= {sky.Fault.SEPARATION}
    assert len(mission.visited) >= 6


def test_a_budget_of_paths_is_none_of_routes():
    mission = sky.plan_mission(windy(0.9), sky.Taut(), stop=sky.MaxIterations(1), rng=1)
    assert not mission.interrupted
    assert mission.assignment == sky.plan_mission(windy(0.9), sky.Taut(), rng=1).assignment


def test_what_shuts_a_target_in_is_told():
    mission = rounds()
    (closed,) = closed_ways(mission)
    assert closed.target == "<shut>"
    assert any("obstacles[0]" in one for one in closed.by)
