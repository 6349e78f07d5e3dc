"""A path of one's own becomes a result, a trajectory and a mission as any other, and what is none is refused."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky

MAP1 = sky.read("map1")
PROBLEM = sky.Problem(MAP1)
PATH = sky.Taut().plan(PROBLEM).path
STRAYING = MAP1.model_copy(
    update={
        "clearance": 0.1,
        "uavs": tuple(uav.model_copy(update={"tracking_error": sky.TrackingError(vertical=0.05)}) for uav in MAP1.uavs),
    }
)


class Ruler:
    """A planner that derives from nothing."""

    def __init__(self, path):
        self.path = path

    def plan(self, problem, *, stop=None, rng=None, on_iteration=None):
        return self.path if callable(self.path) or self.path is None else sky.result_of_path(problem, self.path)


class Returning(sky.Planner):
    """A planner without settings that returns the points themselves."""

    def plan(self, problem, *, stop=None, rng=None, on_iteration=None):
        return PATH


def test_a_path_costs_what_the_same_path_of_a_planner_costs_and_is_found_right():
    for path in (PATH, PATH.tolist(), tuple(map(tuple, PATH))):
        mine, theirs = sky.result_of_path(PROBLEM, path), sky.Taut().plan(PROBLEM)
        assert (mine.cost, mine.terms, mine.status.reached) == (theirs.cost, theirs.terms, True)
        assert mine.bound == pytest.approx(np.linalg.norm(PROBLEM.target_place - PROBLEM.uav_place))
        assert sky.check_result(MAP1, "uav-1", "target-1", mine) == []
        flown = sky.fly_along(PROBLEM, mine)
        assert flown == sky.fly_along(PROBLEM, theirs)


def test_a_path_that_ends_elsewhere_is_incomplete():
    mine = sky.result_of_path(PROBLEM, PATH[:-1])
    assert mine.status is sky.Status.INCOMPLETE
    assert sky.fly_along(PROBLEM, mine) is None
    assert sky.check_result(MAP1, 0, 0, mine) == []


@pytest.mark.parametrize(
    "path",
    [
        [[0, -4, 1], [2, 17, 3]],
        [[0, -4, 1], [0, -4, 2], [-1, -4, 2]],
        [[0, -4, 2], [2, 17, 3]],
        PATH[0],
        PATH[:, :2],
        [],
        "straight on",
        PATH * np.nan,
    ],
)
def test_what_is_no_free_path_is_refused(path, refuses):
    with refuses():
        sky.result_of_path(PROBLEM, path)


def test_a_path_from_the_place_itself_gets_its_legs_on_pads():
    low = STRAYING.model_copy(update={"uavs": (STRAYING.uavs[0].model_copy(update={"start": (0, -4, 0.02)}),)})
    problem = sky.Problem(low)
    assert len(problem.lifts[0])
    found = sky.Taut().plan(problem)
    for path in (np.vstack([problem.uav_place, found.path[2:]]), found.path[1:]):
        mine = sky.result_of_path(problem, path)
        np.testing.assert_allclose(mine.path[:2], [problem.uav_place, problem.start])
        assert sky.check_result(low, 0, 0, mine) == []


def test_a_planner_of_ones_own_plans_a_proven_mission():
    mission = sky.plan_mission(MAP1, Ruler(PATH))
    assert mission.certificate("uav-1").verdict.value == "proven"
    assert mission.result(0).path == pytest.approx(PATH)
    assert sky.plan_many(MAP1, Ruler(PATH))[0] == mission.result(0)


@pytest.mark.parametrize("planner", [Ruler(None), Ruler(len), Returning()])
def test_a_planner_that_returns_anything_else_is_refused(planner, refuses):
    for door in (sky.plan_mission, sky.plan_many):
        with refuses() as refused:
            door(MAP1, planner)
        assert refused.value.sentence.field == "planner"


def test_a_result_of_another_planner_is_as_good():
    named = sky.plan_mission(MAP1, "taut")
    assert replace(named.result(0), seconds=0.0) == replace(sky.plan_mission(MAP1, sky.Taut()).result(0), seconds=0.0)
