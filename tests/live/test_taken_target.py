"""A UAV whose target a mover has taken comes to rest near it, and flies there when the mover has left."""

import math

import numpy as np
import pytest

import skyverse as sky
from replanned import BALL, certified, hall

WAYS = {
    "rests": lambda t: (0.0, 0.0, 0.0),
    "hovers about": lambda t: (0.3 * math.sin(0.5 * t), 0.2 * math.cos(0.4 * t), 0.0),
    "goes to and fro": lambda t: (0.0, 0.8 * math.sin(0.3 * t), 0.0),
}
SCENARIOS = {"map1": lambda: sky.read("map1"), "hall": hall}


@pytest.mark.parametrize("acceleration", [None, 1.0])
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("where", SCENARIOS)
def test_it_rests_near_its_target_until_the_mover_leaves(where, way, acceleration):
    flight = sky.Replanner(sky.plan_mission(SCENARIOS[where](), sky.Taut(), rng=1))
    (target,) = flight.scenario.targets
    settled = 2.0 * flight.mission.trajectories[0].end + 5.0
    leaves = settled + 15.0
    for t in np.arange(0.0, leaves, 0.2):
        place = np.array(target.position) + WAYS[way](t)
        seen = sky.Sighting(
            name="ball", shape=BALL, position=tuple(place), error=0.02, top_speed=1.0, max_acceleration=acceleration
        )
        (answer,) = flight.observe(t, movers=[seen])
        assert answer.proven
    instants = np.linspace(settled, leaves, 1000)
    flown = flight.flown(0).at(instants)
    length = np.linalg.norm(np.diff(flown.position, axis=0), axis=1).sum()
    assert length < 2.0
    assert np.linalg.norm(flown.velocity[-50:], axis=1).max() < 1e-6
    assert math.dist(flown.position[-1], target.position) < 5.0
    while t < leaves + 10.0 and (flight.arrival(0) is None or flight.arrival(0) > t):
        t += 0.2
        flight.observe(t, gone=["ball"])
    assert flight.arrival(0) is not None


def test_it_arrives_beside_a_mover_that_may_be_at_its_target_before_it_would_have_come_to_rest_from_full_speed():
    uav = sky.UAV(start=(1, 5, 1), max_speed=3.0, max_acceleration=3.0)
    mission = sky.plan_mission(hall(uavs=[uav], targets=[sky.Target(position=(15, 5, 1))]))
    circle = sky.CircularMotion(centre=(15, 5, 3), radius=2, period=4 / 3 * math.pi)
    truth = sky.Scenario(**{**dict(mission.scenario), "movers": [sky.Mover(name="fast", shape=BALL, motion=circle)]})
    flight, looked_ahead = sky.Replanner(mission), []

    def take_note(answers):
        (answer,) = answers
        if answer.proven:
            assert flight.motion(0).end <= answer.clear_until + 1e-9
            looked_ahead.append(answer.clear_until - answer.time)

    assert sky.fly_closed_loop(flight, truth, sky.Sensor(), longest=30.0, on_answers=take_note)
    assert certified(flight, truth.movers).trajectories[0].verdict is sky.Verdict.PROVEN
    assert max(looked_ahead) == pytest.approx(flight.horizon)
    assert min(looked_ahead) == pytest.approx(flight.lead + 3 / 50 + 0.5)  # s: from rest, at a jerk of 50 m/s^3


@pytest.mark.parametrize("kept_away", [False, True])
def test_it_looks_as_far_as_ever_once_it_has_another_target(kept_away):
    flight = sky.Replanner(sky.plan_mission(hall(uavs=[sky.UAV(start=(1, 5, 1), max_speed=2.0)])))
    seen = [sky.Sighting(name="ball", shape=BALL, position=(19, 5, 1), top_speed=3.0, max_acceleration=None)]
    looked_ahead = {}
    for t in np.arange(0.0, 40.0, 0.2):
        asked = {0: (1.0, 5.0, 1.0)} if t == 20.0 else {}
        near, gone = kept_away and t < 20.0, ["ball"] if kept_away and t >= 20.0 else []
        (answer,) = flight.observe(t, movers=seen if near else [], gone=gone, targets=asked)
        assert answer.proven or t < 20.0
        looked_ahead[t] = answer.clear_until - answer.time
    assert flight.arrival(0) is not None
    assert min(s for t, s in looked_ahead.items() if t >= 20.0) == pytest.approx(flight.horizon)
    assert (min(looked_ahead.values()) < 0.9 * flight.horizon) == kept_away
