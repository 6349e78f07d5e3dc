"""Policies that ask a planner: among what they plan, and what they remember."""

from itertools import pairwise

import numpy as np
import pytest

import skyverse as sky
from replanned import BALL, hall
from skyverse.live import Situation, Span, Way, make_policy, problem_now
from skyverse.model.temporary_zones import TimedShape

TARGET = (19.0, 5.0, 1.0)


def situation(*movers, place=(4.0, 5.0, 1.0), scenario=None, memory=None, now=3.0):
    scenario = hall() if scenario is None else scenario
    return Situation(
        scenario=scenario, uav=0, target=0, world=sky.World(scenario), span=Span(now, now + 0.1, now + 2.5, now + 2.5),
        state=np.array([place, (0.0, 0, 0), (0.0, 0, 0)]), stop=np.array(place), movers=movers,
        guidance=Way(np.array([TARGET]), np.zeros(1), np.zeros(1, int)), memory=memory, rng=np.random.default_rng(0),
    )  # fmt: skip


def ball(at):
    return TimedShape(BALL, sky.WaypointMotion(points=[at], times=[0]), sky.Doubt(), 0.2)


@pytest.mark.parametrize("planner", ["astar", "mvo", "hybrid-mvo", "auto"])
@pytest.mark.parametrize("name", ["from-scratch", "kept-population"])
def test_ways_lead_to_the_target_and_keep_clear_of_where_a_mover_is(name, planner):
    if name == "kept-population" and planner in ("astar", "auto"):
        with pytest.raises(ValueError, match=r"planner is a metaheuristic on lattice paths, such as 'mvo', not"):
            make_policy(name, planner=planner)
        return
    found = make_policy(name, planner=planner, paths=60).find(situation(ball((10.0, 5.0, 1.0))))
    assert tuple(found.way.points[-1]) == TARGET
    path = np.vstack([(4.0, 5.0, 1.0), found.way.points])
    along = np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(path)])
    assert np.linalg.norm(along - (10.0, 5.0, 1.0), axis=1).min() >= BALL.radius + 0.2


def test_no_way_is_found_where_movers_shut_the_hall():
    shut = TimedShape(
        sky.Box(min=(0, -5, -2), max=(1, 5, 4)), sky.WaypointMotion(points=[(10, 5, 1)], times=[0]), sky.Doubt(), 0.2
    )
    assert make_policy("from-scratch", planner="astar").find(situation(shut)).way is None


def test_timed_planners_are_told_the_movers_and_when_the_uav_departs():
    problem = problem_now(situation(ball((10.0, 5.0, 1.0))), 1.0, timed=True)
    assert problem.departs == pytest.approx(3.1)
    assert [mover.shape for mover in problem.scenario.movers] == [BALL]
    assert problem.scenario.obstacles == ()
    boxed = problem_now(situation(ball((10.0, 5.0, 1.0))), 1.0, timed=False)
    assert boxed.scenario.movers == ()
    assert len(boxed.scenario.obstacles) == 4
    with pytest.raises(
        ValueError, match="timed needs a planner that prices contact in time, such as 'mvo', not 'astar'"
    ):
        make_policy("from-scratch", planner="astar", timed=True)


def test_a_population_that_is_kept_is_no_worse_than_its_best_path_before():
    policy = make_policy("kept-population", planner="mvo", paths=400)
    wall = sky.Box(min=(9, 2, 0), max=(10, 8, 4))
    scenario = hall(wall)
    first = policy.find(situation(scenario=scenario))
    again = policy.find(situation(scenario=scenario, memory=first.memory))
    assert len(first.memory) > 1
    assert steps(again.memory[0]) <= steps(first.memory[0])
    assert again.effort.generated_paths > 0


def steps(path):
    return len(path)


def test_a_kept_population_is_taken_up_where_the_uav_is_now():
    policy = make_policy("kept-population", planner="mvo", paths=60)
    first = policy.find(situation())
    later = policy.find(situation(place=(8.0, 5.0, 1.0), memory=first.memory))
    assert np.allclose(later.memory[0][0], (8.0, 5.0, 1.0))
    assert tuple(later.way.points[-1]) == TARGET


def test_memory_is_from_the_last_answer_alone():
    policy = make_policy("from-scratch", planner="mvo", paths=60)
    assert policy.find(situation()).memory is None
