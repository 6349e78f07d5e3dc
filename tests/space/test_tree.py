"""The spatial index: it finds what asking every box finds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skyverse.space import box, tree
from skyverse.space.tree import FIRST, SKIP, STOP


def some_boxes(rng, count):
    low = rng.integers(0, 40, (count, 3)).astype(float)
    return np.hstack([low, low + rng.integers(1, 9, (count, 3))])


@given(st.integers(0, 60), st.integers(0, 2**32), st.sampled_from([0.0, 0.5, 2.0]))
def test_the_index_finds_what_asking_every_box_finds(count, seed, growth):
    rng = np.random.default_rng(seed)
    given_ = some_boxes(rng, count)
    index, order = tree.build(given_)
    assert sorted(order) == list(range(count))
    boxes = given_[order]
    points = rng.integers(-4, 52, (80, 3)) + rng.choice([0.0, 0.25], (80, 3))
    for p, q in zip(points[::2], points[1::2], strict=True):
        holding = {i for i in range(count) if box.holds(boxes, i, growth, *p)}
        found = tree.containing(index, boxes, growth, *p)
        assert found in holding if holding else found == -1
        meeting = {i for i in range(count) if box.meets(boxes, i, growth, box.ray(p, q))}
        found = tree.crossed(index, boxes, growth, p, q)
        assert found in meeting if meeting else found == -1
        nearest = min((box.gap(boxes, i, *p) for i in range(count)), default=np.inf)
        assert tree.distance(index, boxes, *p) == nearest


@pytest.mark.parametrize("count", [0, 1, 4, 5, 1000, 4097])
def test_every_node_bounds_what_is_below_it_and_every_box_has_one_leaf(count):
    given_ = some_boxes(np.random.default_rng(0), count)
    index, order = tree.build(given_)
    boxes = given_[order]
    links = index.links
    assert sum(links[:, STOP] - links[:, FIRST]) == count
    for node, skip in enumerate(links[:, SKIP]):
        below = [i for leaf in range(node, skip) for i in range(links[leaf, FIRST], links[leaf, STOP])]
        np.testing.assert_array_equal(index.bounds[node, :3], boxes[below, :3].min(axis=0))
        np.testing.assert_array_equal(index.bounds[node, 3:], boxes[below, 3:].max(axis=0))
