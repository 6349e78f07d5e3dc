"""Random movers are where and as fast as they say, and away from starts and targets; plans among them are proven."""

import numpy as np
import pytest

import skyverse as sky

KINDS = ("spinners", "patrols", "knots", "traffic")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("speed", [0.5, 2.0])
def test_their_mean_speed_is_what_was_asked_for(kind, speed):
    moving = sky.random_movers(sky.read("map3"), 5, kind=kind, speed=speed, seed=3)
    for mover in moving.movers:
        motion = mover.motion
        cycle = motion.period if hasattr(motion, "period") else 2 * (motion.times[1] - motion.times[0])
        places = mover.at(np.linspace(0, cycle, 20_001))
        assert np.linalg.norm(np.diff(places, axis=0), axis=1).sum() / cycle == pytest.approx(speed, rel=2e-3)
        assert places[-1] == pytest.approx(places[0], abs=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_they_keep_away_from_starts_and_targets(kind):
    scenario = sky.read("map3")
    moving = sky.random_movers(scenario, 20, kind=kind, seed=1)
    ends = [*(uav.start for uav in scenario.uavs), *(target.position for target in scenario.targets)]
    radius = moving.movers[0].shape.radius
    assert radius == pytest.approx(0.01 * np.ptp([scenario.bounds.min, scenario.bounds.max], axis=0)[:2].min())
    for mover in moving.movers:
        gaps = np.linalg.norm(mover.at(np.arange(0, 300, 0.05))[:, None] - ends, axis=2)
        assert gaps.min() > radius + scenario.clearance


def test_a_knot_is_a_trefoil():
    (knot,) = sky.random_movers(sky.read("map3"), 1, kind="knots", seed=2).movers
    places = knot.at(np.linspace(0, knot.motion.period, 4001))
    a = (places - knot.motion.centre) / np.abs(places - knot.motion.centre).max(axis=0)
    angle = np.linspace(0, 2 * np.pi, 4001)
    trefoil = np.column_stack(
        [np.sin(angle) + 2 * np.sin(2 * angle), np.cos(angle) - 2 * np.cos(2 * angle), -np.sin(3 * angle)]
    )
    trefoil /= np.abs(trefoil).max(axis=0)
    for place in a[::100]:  # each place of the one curve lies on the other, wherever it begins
        assert np.linalg.norm(trefoil - place, axis=1).min() < 5e-3


def test_the_same_seed_makes_the_same_movers_and_names_differ():
    scenario = sky.random_movers(sky.read("map1"), 3, seed=5)
    assert scenario == sky.random_movers(sky.read("map1"), 3, seed=5)
    assert scenario != sky.random_movers(sky.read("map1"), 3, seed=6)
    both = sky.random_movers(scenario, 2, kind="patrols", seed=5)
    assert [mover.name for mover in both.movers] == ["spinner-1", "spinner-2", "spinner-3", "patrol-1", "patrol-2"]


@pytest.mark.parametrize("kind", KINDS)
def test_plans_among_them_are_proven(kind):
    mission = sky.plan_mission(sky.random_movers(sky.read("map3"), 10, kind=kind, speed=1.0, seed=7))
    assert mission.violations == ()


@pytest.mark.parametrize("given", [{"kind": "birds"}, {"count": -1}, {"speed": 0.0}, {"seed": 1.5}])
def test_bad_arguments_get_one_sentence(given, refuses):
    with refuses():
        sky.random_movers(sky.read("map1"), **given)
