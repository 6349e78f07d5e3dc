"""Conflicts of fleets against dense sampling, and in cases whose answer is obvious."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from curves import random_flight
from skyverse.trajectory import rest_to_rest


def fleet(starts, **limits):
    return sky.Scenario(
        name="fleet",
        bounds=sky.Bounds(min=(-50, -50, -50), max=(50, 50, 50)),
        clearance=0.001,
        lattice=sky.Lattice(step=(1, 1, 1)),
        uavs=[sky.UAV(start=tuple(start), **limits) for start in starts],
    )


def flight(scenario, uav, *points, start=0.0):
    return rest_to_rest(np.array([scenario.uavs[uav].start, *points]), scenario.uavs[uav], start=start)


def nearness(scenario, trajectories, i, j, times):
    a, b = (trajectories[k].at(times).position for k in (i, j))
    one, other = (scenario.uavs[k].ellipsoid for k in (i, j))
    semi_axis_xy, semi_axis_z = max(one[0], other[0]), max(one[1], other[1])
    gap = (a - b) / (semi_axis_xy, semi_axis_xy, semi_axis_z)
    return np.sqrt(np.sum(gap**2, axis=1))


@given(st.integers(0, 2**32))
@settings(max_examples=25)
def test_conflicts_are_those_that_dense_sampling_finds(seed):
    rng = np.random.default_rng(seed)
    flights = [random_flight(rng) for _ in range(5)]
    uavs = [
        sky.UAV(start=tuple(f.at(f.start).position[0]), separation=s, vertical_separation=2 * s)
        for f, s in zip(flights, rng.uniform(0.2, 0.8, 5), strict=True)
    ]
    scenario = fleet([(0, 0, 0)]).model_copy(update={"uavs": tuple(uavs)})
    found = sky.find_conflicts(scenario, flights)
    times = np.arange(0.0, max(f.end for f in flights), 0.002)
    for i in range(5):
        for j in range(i + 1, 5):
            near = nearness(scenario, flights, i, j, times)
            spans = [(c.begin, c.end) for c in found if c.uavs == (i, j)]
            inside = np.zeros(len(times), bool)
            for begin, end in spans:
                inside |= (times >= begin - 1e-5) & (times <= end + 1e-5)
            assert inside[near < 1 - 1e-5].all()
            outside = np.ones(len(times), bool)
            for begin, end in spans:
                outside &= (times < begin + 1e-5) | (times > end - 1e-5)
            assert outside[near > 1 + 1e-5].all()
            for conflict in (c for c in found if c.uavs == (i, j)):
                within = near[(times >= conflict.begin) & (times <= conflict.end)]
                assert conflict.begin <= conflict.time <= conflict.end
                assert not len(within) or conflict.nearness <= within.min() + 1e-3


def test_a_uav_that_waits_at_its_start_or_stays_at_its_target_counts():
    scenario = fleet([(0, 0, 0), (-5, 0.2, 0), (-5, 0.2, 9)])
    first = flight(scenario, 0, (0, 9, 0), start=30.0)
    second = flight(scenario, 1, (5, 0.2, 0))
    conflict, *others = sky.find_conflicts(scenario, [first, second, None])
    assert not others
    assert conflict.uavs == (0, 1)
    assert not conflict.given
    assert conflict.nearness == pytest.approx(0.4, abs=1e-3)
    assert 0 < conflict.begin < conflict.time < conflict.end < second.end


def test_more_distance_is_kept_below_and_above_than_beside():
    scenario = fleet([(0, 0, 0), (-5, 0, 0.9), (0, -5, 0), (-5, 0.6, 0)])
    flights = [None, flight(scenario, 1, (5, 0, 0.9)), None, flight(scenario, 3, (5, 0.6, 0))]
    assert {c.uavs for c in sky.find_conflicts(scenario, flights)} == {(0, 1)}


def test_starts_and_targets_that_are_too_close_are_given():
    scenario = fleet([(0, 0, 0), (0, 0.3, 0)])
    flights = [flight(scenario, 0, (9, 0, 0), start=1.0), flight(scenario, 1, (9, 9, 0), (9, 0.4, 0))]
    first, last = sky.find_conflicts(scenario, flights)
    assert first.given
    assert first.begin == 0.0
    assert first.nearness == pytest.approx(0.6, abs=1e-6)
    assert last.given
    assert last.end == flights[1].end


def test_a_pair_that_comes_closer_than_its_given_starts_is_in_a_conflict_like_any_other():
    scenario = fleet([(0, 0, 0), (0.4, 0, 0)])
    flights = [flight(scenario, 0, (9, 0, 0)), flight(scenario, 1, (0.4, 9, 0), start=5.0)]
    (through,) = sky.find_conflicts(scenario, flights)
    assert not through.given
    assert through.begin == 0.0
    assert through.nearness == pytest.approx(0.0, abs=1e-6)
    flights = [flight(scenario, 0, (9, 0, 0), start=5.0), flight(scenario, 1, (0.4, 9, 0))]
    (given,) = sky.find_conflicts(scenario, flights)
    assert given.given
    assert given.nearness == pytest.approx(0.8, abs=1e-6)


def test_half_a_metre_is_far_enough():
    scenario = fleet([(0, 0, 0), (0, 0.5, 0), (0, 0, 1)])
    assert sky.find_conflicts(scenario, [None, None, None]) == ()


def test_uavs_that_keep_no_separation_are_never_too_close():
    scenario = fleet([(0, 0, 0), (0, 0, 0)], separation=0)
    assert sky.find_conflicts(scenario, [None, None]) == ()


def test_there_must_be_as_many_trajectories_as_uavs():
    with pytest.raises(ValueError, match="2 UAVs need as many"):
        sky.find_conflicts(fleet([(0, 0, 0), (1, 0, 0)]), [None])
