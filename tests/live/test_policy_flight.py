"""Every policy flies by the same machinery: what it flies is proven, whatever ways it finds."""

from dataclasses import dataclass

import numpy as np
import pytest

import skyverse as sky
from replanned import BALL, certified, faults, hall
from skyverse.live import NO_EFFORT, Found, Policy, Way, make_policy

CROSSING = sky.Mover(
    name="cart", shape=BALL, motion=sky.WaypointMotion(points=[(10, 0, 1), (10, 10, 1)], times=[0, 20], then="returns")
)
WALL = sky.Box(min=(12, 2, 0), max=(12.5, 8, 4))


@dataclass(frozen=True, kw_only=True)
class Blind(Policy):
    """Flies straight to the target, whatever is there."""

    proof: bool = True

    def find(self, known):
        target = np.array(known.scenario.targets[known.target].position)
        return Found(Way(target[None], np.zeros(1), np.full(1, -1)), NO_EFFORT, proof=self.proof)


@dataclass(frozen=True, kw_only=True)
class Clueless(Policy):
    """Finds nothing."""

    def find(self, known):
        return Found(None, NO_EFFORT)


def flight(policy, mission=None, seed=0):
    mission = sky.plan_mission(hall()) if mission is None else mission
    return sky.Replanner(mission, policy=policy, rng=seed)


def flown(one, *movers, obstacles=(), longest=60.0):
    scenario = one.mission.scenario
    truth = sky.Scenario(**{**dict(scenario), "movers": movers, "obstacles": (*scenario.obstacles, *obstacles)})
    answers = []
    arrived = sky.fly_closed_loop(one, truth, sky.Sensor(range=6.0), longest=longest, rng=1, on_answers=answers.extend)
    return arrived, answers


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("wait", {}),
        ("velocity-obstacles", {}),
        ("from-scratch", {"planner": "astar"}),
        ("from-scratch", {"planner": "mvo", "paths": 60}),
        ("from-scratch", {"planner": "auto"}),
    ],
)
def test_each_policy_arrives_past_a_mover_and_an_unknown_wall_and_is_proven(name, settings):
    one = flight(make_policy(name, **settings))
    arrived, answers = flown(one, CROSSING, obstacles=[WALL])
    assert arrived
    assert all(answer.proven for answer in answers)
    proven = certified(one, [CROSSING], obstacles=[WALL])
    assert [each.verdict for each in proven.trajectories] == [sky.Verdict.PROVEN]


def test_a_blind_policy_is_held_back_by_the_proof_and_hits_without_it():
    head_on = sky.Mover(
        name="ram", shape=BALL, motion=sky.WaypointMotion(points=[(14, 5, 1), (14, 5, 1.1)], times=[0, 60])
    )
    held = flight(Blind())
    assert flown(held, head_on, longest=8.0)[0] is False
    assert certified(held, [head_on]).trajectories[0].sentence.count("mover") == 0
    free = flight(Blind(proof=False))
    assert flown(free, head_on)[0] is True
    assert "mover 'ram'" in certified(free, [head_on]).trajectories[0].sentence


def test_who_finds_nothing_stays_where_it_is():
    one = flight(Clueless())
    arrived, answers = flown(one, longest=2.0)
    assert not arrived
    assert np.allclose(one.flown(0).at([2.0]).position[0], (1, 5, 1))
    assert all(answer.proven for answer in answers)


def test_the_referee_finds_nothing_wrong_with_any_answer_up_to_the_horizon():
    one = flight(make_policy("from-scratch", planner="astar"))
    scenario = one.mission.scenario
    truth = sky.Scenario(**{**dict(scenario), "movers": [CROSSING]})
    found = []

    def judge(answers):
        if answers[0].proven:
            found.extend(faults(one))

    sky.fly_closed_loop(one, truth, sky.Sensor(), longest=5.0, on_answers=judge)
    assert found == []


def test_the_same_seed_gives_the_same_flight():
    mission = sky.plan_mission(hall())
    policy = make_policy("from-scratch", planner="mvo", paths=40)
    first, second, other = (flight(policy, mission, seed) for seed in (1, 1, 2))
    for one in (first, second, other):
        flown(one, CROSSING)
    assert np.array_equal(first.flown(0).coefficients, second.flown(0).coefficients)
    assert first.effort.generated_paths > 0
    assert first.effort == second.effort


def test_uavs_of_a_fleet_keep_apart():
    uavs = [sky.UAV(start=(1, 5, 1)), sky.UAV(start=(19, 5, 1))]
    targets = [sky.Target(position=(18, 5, 1)), sky.Target(position=(2, 5, 1))]
    scenario = hall(uavs=uavs, targets=targets)
    one = flight(make_policy("from-scratch", planner="auto"), sky.plan_mission(scenario, assignment="identity"))
    arrived, answers = flown(one, longest=30.0)
    assert len(answers) % 2 == 0
    assert certified(one, []).apart.verdict is sky.Verdict.PROVEN
    assert arrived or all(answer.proven for answer in answers)


def test_a_policy_may_be_given_by_its_name_or_as_in_study_files():
    mission = sky.plan_mission(hall())
    assert sky.Replanner(mission, policy="wait").policy == make_policy("wait")
    given = {"policy": "from-scratch", "planner": "astar"}
    assert sky.Replanner(mission, policy=given).policy == make_policy("from-scratch", planner="astar")


@pytest.mark.parametrize("policy", ["weit", 3, b"wait", {"planner": "astar"}, {"policy": "wait", "sweep": 1}])
def test_what_is_no_policy_is_refused(policy, refuses):
    mission = sky.plan_mission(hall(), sky.Taut())
    with refuses():
        sky.Replanner(mission, policy=policy)
