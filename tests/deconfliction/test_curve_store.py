"""What a store holds, against each trajectory by itself."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from curves import random_flight
from skyverse.deconfliction import CurveStore, grow_tree, make_curves, position_at
from skyverse.deconfliction.curve_store import LEAF_SECONDS


@given(st.integers(0, 2**32), st.lists(st.integers(0, 9), min_size=1, max_size=8))
def test_curves_and_trees_are_those_of_each_trajectory_by_itself_whatever_came_before(seed, degrees):
    rng = np.random.default_rng(seed)
    store, flights = CurveStore(), []
    for degree in degrees:
        flight = random_flight(rng)
        rows = np.zeros((len(flight.coefficients), max(degree + 1, flight.coefficients.shape[1]), 3))
        rows[:, : flight.coefficients.shape[1]] = flight.coefficients
        flights.append(sky.Trajectory(flight.knots, rows))
        assert store.add(flights[-1]) == len(flights) - 1
    swept, curves = store.arrays, store.arrays.curves
    assert store.trajectories == flights
    for c, flight in enumerate(flights):
        padded = np.zeros((len(flight.coefficients), curves.rows.shape[1], 3))
        padded[:, : flight.coefficients.shape[1]] = flight.coefficients
        alone = make_curves([sky.Trajectory(flight.knots, padded)])
        assert np.isclose(store.seconds[c], flight.end - flight.start)
        for local in rng.uniform(-0.5, store.seconds[c] + 0.5, 5):
            np.testing.assert_array_equal(position_at(curves, c, local), position_at(alone, 0, local))
        boxes = swept.boxes[swept.base[c] : swept.base[c] + 2 * swept.leaves[c] + 1]
        np.testing.assert_array_equal(boxes, grow_tree(alone, 0))


@given(st.integers(0, 2**32))
def test_every_node_encloses_what_its_curve_sweeps_in_its_time(seed):
    flight = random_flight(np.random.default_rng(seed))
    boxes = grow_tree(make_curves([flight]), 0)
    leaves, whole = (len(boxes) - 1) // 2, flight.end - flight.start
    assert whole / leaves <= LEAF_SECONDS
    assert leaves == 1 or 2 * whole / leaves > LEAF_SECONDS
    samples = 8
    local = np.linspace(0.0, whole, leaves * samples + 1)
    position = flight.at(flight.start + local).position
    for depth in range(int(np.log2(leaves)) + 1):
        count = 2**depth  # nodes of one depth share the time equally
        each = leaves * samples // count
        for node in range(count):
            box = boxes[count + node]
            within = position[node * each : (node + 1) * each + 1]
            assert (box[:3] <= within.min(axis=0)).all()
            assert (within.max(axis=0) <= box[3:]).all()
