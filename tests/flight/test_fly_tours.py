"""Tours in simulation: each visit is held against where the UAV was, and what makes them safe loses no target."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from skyverse.flight import farther, passings, slowed

pytest.importorskip("rotorpy", reason='rotorpy is not installed; pip install "skyverse[flight]"')

NEAR = sky.Scenario(
    name="near",
    bounds=sky.Bounds(min=(0, 0, 0), max=(9, 9, 4)),
    obstacles=(sky.Box(min=(3.5, 0, 0), max=(4, 2.5, 4)),),
    clearance=0.5,
    uavs=(sky.UAV(start=(2, 2, 2), end="home", batteries=2, swap=4.0),),
    targets=(sky.Target(position=(6, 2, 2), stay=1.5), sky.Target(position=(2, 5, 2), stay=0.5)),
)


@pytest.fixture(scope="module")
def tour():
    return sky.plan_mission(NEAR)


def test_every_visit_of_a_tour_is_told_as_it_was_flown(tour):
    flight = sky.fly(tour)
    assert flight.safe
    stated = [visit for own in tour.sorties_of(0) for visit in own.visits]
    assert [(one.target, one.arrival, one.departure) for one in flight.visits] == [
        (one.target, one.arrival, one.departure) for one in stated
    ]
    assert sorted(one.target for one in flight.visits) == [0, 1]
    flown = flight.flown[0]
    for one in flight.visits:
        there = (flown.times >= one.arrival) & (flown.times <= one.departure)
        away = np.linalg.norm(flown.positions[there] - NEAR.targets[one.target].position, axis=1)
        assert one.kept
        assert away.max() <= one.farthest <= away.max() + 0.02
    assert flown.commanded[-1] == pytest.approx((2, 2, 2))


def test_a_uav_that_is_off_its_target_during_a_visit_has_not_kept_it(tour):
    flight = sky.fly(tour, sky.Conditions(wind=(7, 0, 0)), margin=0.011)
    missed = [one for one in flight.visits if not one.kept]
    assert missed
    told = [one for one in flight.violations if one.fault is sky.Fault.VISIT]
    assert [(one.uavs, one.time) for one in told] == [((0,), one.arrival) for one in missed]
    assert not flight.safe


def test_a_visit_after_a_uav_was_lost_is_not_kept(tour):
    flight = sky.fly(tour)
    cut = replace(flight.flown[0], times=flight.flown[0].times[:200], positions=flight.flown[0].positions[:200])
    last = replace(flight, flown=(cut,)).visits[-1]
    assert last.farthest == np.inf
    assert not last.kept


def test_a_slowed_tour_stays_and_visits_when_it_is_there(tour):
    after = slowed(tour, 1.5)
    assert not after.violations
    for before, now in zip(tour.sorties_of(0), after.sorties_of(0), strict=True):
        assert (now.begin, now.end) == pytest.approx((1.5 * before.begin, 1.5 * before.end))
        for visit in now.visits:
            place = after.trajectories[0].at([visit.arrival, visit.departure]).position
            assert place == pytest.approx(np.array([NEAR.targets[visit.target].position] * 2))


def test_a_tour_planned_farther_from_obstacles_visits_all_targets(tour):
    after = farther(tour, 0.3)
    assert not after.violations
    assert after.complete
    assert sorted(visit.target for own in after.sorties_of(0) for visit in own.visits) == [0, 1]
    assert after.scenario == NEAR


def test_a_tour_that_slowed_down_would_miss_a_window_is_given_up(tour):
    arrival = next(visit for own in tour.sorties_of(0) for visit in own.visits)
    targets = list(NEAR.targets)
    targets[arrival.target] = targets[arrival.target].model_copy(update={"window": (0.0, arrival.arrival + 0.3)})
    strict = sky.plan_mission(NEAR.model_copy(update={"targets": tuple(targets)}))
    assert not strict.violations
    told = sky.fly_until_safe(strict, sky.Conditions(wind=(7, 0, 0)), margin=0.011, rounds=2)
    assert told.refusal
    assert told.mission == strict
    assert told.rounds == ()


def test_uavs_that_come_home_to_near_starts_are_excused_there():
    home = [sky.UAV(start=(x, 2, 2), end="home", separation=1.5) for x in (2.0, 3.0)]
    targets = [sky.Target(position=(2, 7, 2)), sky.Target(position=(8, 7, 2))]
    bare = NEAR.model_copy(update={"obstacles": (), "uavs": tuple(home), "targets": tuple(targets)})
    made = sky.plan_mission(bare, assignment="identity")
    apart, wrong = passings(made, (None, None), 0.05)
    assert apart[0].nearness < 1.0
    assert not wrong


def test_a_replanned_tour_is_judged_by_its_visits_as_they_were_flown(tour):
    flight = sky.fly_replanned(sky.Replanner(tour), NEAR).flight
    assert flight.safe
    assert [one.target for one in flight.visits] == [v.target for own in tour.sorties_of(0) for v in own.visits]
    assert all(one.kept for one in flight.visits)
    assert not sky.check(flight.mission.scenario, flight.mission)
