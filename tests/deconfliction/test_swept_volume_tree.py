"""Boxes of swept volume trees, against dense samples of the curves that they enclose."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from curves import random_flight
from skyverse.deconfliction.curves import make_curves, stay_at_start
from skyverse.deconfliction.swept_volume_tree import LEAF_SECONDS, grow_tree


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


@given(st.integers(0, 2**32))
def test_leaves_are_hardly_larger_than_what_they_enclose_and_nodes_no_larger_than_their_children(seed):
    flight = random_flight(np.random.default_rng(seed))
    boxes = grow_tree(make_curves([flight]), 0)
    leaves, whole = (len(boxes) - 1) // 2, flight.end - flight.start
    position = flight.at(flight.start + np.linspace(0.0, whole, leaves * 16 + 1)).position
    swept = np.stack([position[i : i + 17] for i in range(0, leaves * 16, 16)])
    excess = np.maximum(
        swept.min(axis=1) - boxes[leaves : 2 * leaves, :3], boxes[leaves : 2 * leaves, 3:] - swept.max(axis=1)
    )
    assert excess.max() < 0.02
    for node in range(1, leaves):
        children = boxes[2 * node : 2 * node + 2]
        np.testing.assert_array_equal(boxes[node, :3], children[:, :3].min(axis=0))
        np.testing.assert_array_equal(boxes[node, 3:], children[:, 3:].max(axis=0))
    for row, end in ((0, position[0]), (2 * leaves, position[-1])):
        np.testing.assert_allclose(boxes[row], np.tile(end, 2), atol=1e-9)


def test_a_uav_that_stays_at_its_start_has_a_single_leaf():
    boxes = grow_tree(make_curves([stay_at_start(sky.UAV(start=(1, 2, 3)))]), 0)
    assert boxes.shape == (3, 6)
    np.testing.assert_allclose(boxes, np.tile((1, 2, 3, 1, 2, 3), (3, 1)), atol=1e-8)
