"""Orders of turns, against what their descriptions say of every two UAVs."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.deconfliction.candidate import Candidate, PlacedFlight
from skyverse.deconfliction.forbidden_departures import TICK
from skyverse.deconfliction.prioritized_planning import first_keys, next_key, priority_order
from skyverse.trajectory import rest_to_rest


def candidates(count, flying=None):
    """Flights side by side, one longer than the other."""
    made = []
    for uav in range(count):
        path = np.array([(0, 3 * uav, 0), (5 + uav, 3 * uav, 0.0)])
        trajectory = rest_to_rest(path, sky.UAV(start=tuple(path[0])))
        target = uav if flying is None or flying[uav] else None
        made.append(Candidate(uav, target, uav, trajectory.end, None, trajectory))
    return made


UAVS = st.lists(st.tuples(st.booleans(), st.integers(-1, 1), st.booleans(), st.integers(0, 3)), min_size=1, max_size=8)


@given(UAVS)
def test_who_stays_comes_first_then_priority_then_who_is_in_no_conflict_then_the_key(drawn):
    flying, priority, conflict, key = (list(column) for column in zip(*drawn, strict=True))
    uavs = [sky.UAV(start=(0, 0, 0), priority=p) for p in priority]
    in_conflict = {u for u, is_in in enumerate(conflict) if is_in}
    order = priority_order(uavs, candidates(len(uavs), flying), in_conflict, np.array(key, dtype=float))
    assert sorted(order) == list(range(len(uavs)))
    for a, b in pairwise(order):
        if flying[a] != flying[b]:
            assert flying[b]
        elif priority[a] != priority[b]:
            assert priority[a] > priority[b]
        elif conflict[a] != conflict[b]:
            assert conflict[b]
        else:
            assert (key[a], a) < (key[b], b)


def test_the_first_keys_put_the_longest_first_then_who_is_in_nobodys_way_then_the_shortest():
    ends = [((0, 0, 0), (9, 0, 0)), ((4, 0, 0), (4, 9, 0)), ((0, 5, 0), (6, 0, 0))]
    made = []
    for uav, path in enumerate(np.array(ends, dtype=float)):
        trajectory = rest_to_rest(path, sky.UAV(start=tuple(path[0])))
        made.append(Candidate(uav, uav, uav, trajectory.end, None, trajectory))
    longest, crossed, shortest = first_keys(made)
    np.testing.assert_array_equal(longest, -shortest)
    np.testing.assert_array_equal(shortest, [c.seconds for c in made])
    # 1 starts on the path of 0, so it should go early; the target of 2 lies on it, so it should go late
    np.testing.assert_array_equal(crossed, [0, -1, 1])


@given(st.integers(0, 2**32), st.integers(2, 8))
def test_who_comes_latest_moves_ahead_by_the_whole_order_and_who_comes_in_time_stays(seed, count):
    rng = np.random.default_rng(seed)
    planned, order = candidates(count), rng.permutation(count).tolist()
    late = np.where(rng.random(count) < 0.4, 0.0, rng.uniform(TICK, 9.0, count))
    stuck = rng.random(count) < 0.2
    placed = [
        PlacedFlight(own, own.trajectory.start + seconds, in_conflict=bool(is_stuck))
        for own, seconds, is_stuck in zip(planned, late, stuck, strict=True)
    ]
    key = next_key(planned, order, placed)
    for position, uav in enumerate(order):
        moved = position - key[uav]
        if stuck[uav]:
            assert moved == count
        else:
            np.testing.assert_allclose(moved, count * late[uav] / max(late.max(), TICK), atol=1e-9)
