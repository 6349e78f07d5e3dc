"""Assignments of UAVs to targets, against every permutation."""

import itertools
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky


@st.composite
def matrices(draw, infinite=True):
    m, n = draw(st.integers(1, 5)), draw(st.integers(1, 5))
    cost = st.one_of(st.integers(0, 9).map(float), st.floats(0, 1e6))
    if infinite:
        cost = st.one_of(cost, cost, st.just(np.inf))
    return np.array(draw(st.lists(st.lists(cost, min_size=n, max_size=n), min_size=m, max_size=m)))


def pairs(assigned):
    return [(i, j) for i, j in enumerate(assigned) if j is not None]


def every_assignment(costs):
    """All that give a finite target to as many UAVs as can have one."""
    m, n = costs.shape
    padded = list(range(n)) + [None] * m
    found = set(itertools.permutations(padded, m)) if m + n <= 7 else set(_partial(m, n))
    found = [a for a in found if all(np.isfinite(costs[p]) for p in pairs(a))]
    most = max(len(pairs(a)) for a in found)
    return [a for a in found if len(pairs(a)) == most]


def _partial(m, n):
    for uavs in range(min(m, n) + 1):
        for chosen in itertools.combinations(range(m), uavs):
            for targets in itertools.permutations(range(n), uavs):
                assigned = [None] * m
                for i, j in zip(chosen, targets, strict=True):
                    assigned[i] = j
                yield tuple(assigned)


def check_shape(costs, assigned):
    targets = [j for j in assigned if j is not None]
    assert len(assigned) == len(costs)
    assert len(set(targets)) == len(targets)
    assert all(np.isfinite(costs[p]) for p in pairs(assigned))


@given(matrices())
def test_min_sum_has_the_smallest_total_of_all_assignments(costs):
    assigned = sky.assign(costs)
    check_shape(costs, assigned)
    choices = every_assignment(costs)
    assert len(pairs(assigned)) == len(pairs(choices[0]))
    total = sum(costs[p] for p in pairs(assigned))
    assert total == pytest.approx(min(sum(costs[p] for p in pairs(a)) for a in choices), rel=1e-9, abs=1e-9)


@given(matrices())
def test_min_max_has_the_smallest_maximum_and_then_the_smallest_total(costs):
    assigned = sky.assign(costs, "min-max")
    check_shape(costs, assigned)
    choices = every_assignment(costs)
    assert len(pairs(assigned)) == len(pairs(choices[0]))

    def key(a):
        return max((costs[p] for p in pairs(a)), default=0.0), sum(costs[p] for p in pairs(a))

    least = min(key(a)[0] for a in choices)
    assert key(assigned)[0] == least
    assert key(assigned)[1] == pytest.approx(min(key(a)[1] for a in choices if key(a)[0] == least), abs=1e-9)


def algorithm_4(distances):
    """The thesis's steps to the letter; lines and zeros are chosen by trying all of them."""
    A = distances - distances.min(axis=1, keepdims=True)
    A = A - A.min(axis=0)
    N = len(A)
    while True:
        zero = A < 1e-9
        covers = []
        for rows in itertools.chain.from_iterable(itertools.combinations(range(N), k) for k in range(N + 1)):
            open_rows = [i for i in range(N) if i not in rows]
            columns = [j for j in range(N) if zero[open_rows, j].any()]
            covers.append((len(rows) + len(columns), rows, columns))
        lines, rows, columns = min(covers)
        if lines == N:
            return next(p for p in itertools.permutations(range(N)) if all(zero[i, j] for i, j in enumerate(p)))
        uncovered = [i for i in range(N) if i not in rows]
        smallest = A[np.ix_(uncovered, [j for j in range(N) if j not in columns])].min()
        A[uncovered] -= smallest
        A[:, columns] += smallest


@pytest.mark.parametrize("fleet", ["table-4.8", "table-4.9-4", "table-4.11", "table-4.12", "table-4.13"])
def test_the_thesis_algorithm_4_done_by_hand_gives_the_same_total(fleet):
    scenario = sky.read(fleet)
    distances = sky.straight_line([u.start for u in scenario.uavs], [t.position for t in scenario.targets])
    by_hand = sum(distances[i, j] for i, j in enumerate(algorithm_4(distances)))
    assert sum(distances[p] for p in pairs(sky.assign(distances))) == pytest.approx(by_hand, rel=1e-12)


def test_more_uavs_than_targets_leave_the_dearest_idle_and_the_reverse_the_dearest_target():
    assert sky.assign([[5], [2], [9]]) == (None, 0, None)
    assert sky.assign([[5, 2, 9]]) == (1,)
    assert sky.assign(np.zeros((2, 0))) == (None, None)
    assert sky.assign(np.zeros((0, 2))) == ()


def test_huge_and_tiny_costs_do_not_drown_each_other():
    costs = np.array([[1e15, 1.0, np.inf], [1e15, np.inf, 2.0], [1e15 + 8, 4.0, 1.0]])
    assigned = sky.assign(costs)
    check_shape(costs, assigned)
    assert sum(costs[p] for p in pairs(assigned)) == 1e15 + 2


def grid(rows, columns, origin):
    """A formation on a grid of 5 m."""
    return [(origin[0] + 5.0 * i, origin[1] + 5.0 * j, origin[2]) for i in range(rows) for j in range(columns)]


def test_four_hundred_change_from_one_grid_to_another_by_one_translation():
    """Many distances are equal. Along the way between the grids all fly as far in sum, so that nothing is shorter."""
    away, seeds = (100.0, 0.0, 0.0), (1, 2)
    starts, targets = (
        np.random.default_rng(seed).permutation(grid(20, 20, place))
        for seed, place in zip(seeds, ((0, 0, 0), away), strict=True)
    )
    distances = sky.straight_line(starts, targets)
    begun = time.process_time()
    assigned = sky.assign(distances, "min-max")
    assert time.process_time() - begun < 3.0  # it takes a tenth of that
    assert sorted(assigned) == list(range(400))
    assert max(distances[p] for p in pairs(assigned)) == pytest.approx(np.linalg.norm(away), rel=1e-12)


@pytest.mark.parametrize(
    ("costs", "criterion"),
    [([1, 2], "min-sum"), ([[np.nan]], "min-sum"), ([[-np.inf]], "min-sum"), ([[1]], "min-average")],
)
def test_what_is_no_cost_matrix_is_refused(refuses, costs, criterion):
    with refuses():
        sky.assign(costs, criterion)


def test_straight_lines_are_euclidean():
    found = sky.straight_line([(0, 0, 0), (1, 1, 1)], [(3, 4, 0), (1, 1, 3), (0, 0, 0)])
    np.testing.assert_allclose(found, [[5, np.sqrt(11), 0], [np.sqrt(14), 2, np.sqrt(3)]])
    assert sky.straight_line([], [(0, 0, 0)]).shape == (0, 1)
