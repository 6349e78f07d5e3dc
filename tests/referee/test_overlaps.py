"""The referee's spatial index finds exactly the pairs of boxes that overlap, each once."""

import numpy as np
import pytest

from skyverse.referee import overlaps
from skyverse.referee.overlaps import BoxTree


def brute(low, high, shape_low, shape_high):
    apart = (low[:, None] >= shape_high).any(axis=2) | (high[:, None] <= shape_low).any(axis=2)
    return np.argwhere(~apart)


def found(low, high, shape_low, shape_high):
    pairs = np.concatenate([np.zeros((0, 2), dtype=np.intp), *BoxTree(shape_low, shape_high).overlapping(low, high)])
    return pairs[np.lexsort(pairs.T[::-1])]


@pytest.mark.parametrize("shapes", [0, 1, 7, 8, 9, 63, 64, 65, 700])
@pytest.mark.parametrize("spread", [0.0, 3.0, 100.0])
def test_the_pairs_are_those_of_comparing_all_with_all(shapes, spread):
    rng = np.random.default_rng(shapes)
    shape_low = np.round(rng.normal(size=(shapes, 3)) * spread, 1)
    low = np.round(rng.normal(size=(50, 3)) * spread, 1)
    corners = (
        low,
        low + np.round(rng.exponential(2, (50, 3)), 1),
        shape_low,
        shape_low + rng.integers(0, 9, (shapes, 3)),
    )
    assert np.array_equal(found(*corners), brute(*corners))


def test_each_box_of_the_tree_holds_neighbours():
    places = np.random.default_rng(0).permutation(np.argwhere(np.ones((8, 8, 8))).astype(float))
    low, high = BoxTree(places, places + 1).levels[1]
    assert (high - low == 2).all()


def test_faces_that_touch_do_not_overlap_and_flat_boxes_inside_do():
    tree = BoxTree(np.zeros((1, 3)), np.ones((1, 3)))

    def meets(low, high):
        return bool(np.concatenate(list(tree.overlapping(np.array([low], float), np.array([high], float)))).size)

    assert not meets((1, 0, 0), (2, 1, 1))
    assert not meets((0.5, 0.5, -1), (0.5, 0.5, 0))
    assert meets((0.5, 0.5, 0.5), (0.5, 0.5, 0.5))
    assert meets((0.5, -1, -1), (0.5, 2, 2))


def test_a_box_without_numbers_overlaps_everything_and_the_ground_is_everywhere():
    low, high = np.zeros((20, 3)) + np.arange(20)[:, None], np.ones((20, 3)) + np.arange(20)[:, None]
    nowhere = np.full((1, 3), np.nan)
    assert len(found(nowhere, nowhere, low, high)) == 20
    ground = np.full((1, 3), -np.inf), np.full((1, 3), np.inf)
    assert len(found(low, high, *ground)) == 20


def test_many_pairs_come_in_portions(monkeypatch):
    monkeypatch.setattr(overlaps, "PAIRS_AT_ONCE", 10)
    rng = np.random.default_rng(1)
    low, shape_low = rng.uniform(0, 5, (40, 3)), rng.uniform(0, 5, (90, 3))
    corners = low, low + 3, shape_low, shape_low + 3
    assert np.array_equal(found(*corners), brute(*corners))
    assert max(map(len, BoxTree(*corners[2:]).overlapping(*corners[:2]))) <= 10


def met(starts, ends, low, high):
    """Which open boxes each segment runs through, by the shares at which it is between each two faces."""
    found = []
    for a, b in zip(starts, ends, strict=True):
        with np.errstate(divide="ignore", invalid="ignore"):
            one, other = (low - a) / (b - a), (high - a) / (b - a)
        inside = (low < a) & (a < high)
        enter = np.where(a == b, np.where(inside, -np.inf, np.inf), np.minimum(one, other)).max(axis=1)
        leave = np.where(a == b, np.where(inside, np.inf, -np.inf), np.maximum(one, other)).min(axis=1)
        found.append(np.maximum(enter, 0) < np.minimum(leave, 1))
    return np.array(found)


@pytest.mark.parametrize("shapes", [0, 1, 9, 300])
@pytest.mark.parametrize("wide", [0.0, 0.7])
def test_segments_are_found_near_every_box_that_they_meet_and_each_pair_once(shapes, wide):
    rng = np.random.default_rng(shapes)
    low = rng.uniform(-50, 50, (shapes, 3))
    high = low + rng.uniform(0.5, 8, (shapes, 3))
    starts, ends = rng.uniform(-60, 60, (2, 80, 3))
    ends[:20, 1:] = starts[:20, 1:]
    ends[20:30, 0] = starts[20:30, 0]
    ends[30:40] = starts[30:40]
    pairs = near_segments(low, high, starts, ends, np.full(80, wide))
    near = np.zeros((80, shapes), dtype=bool)
    near[tuple(pairs.T)] = True
    assert near.sum() == len(pairs)
    assert not (met(starts, ends, low - wide, high + wide) & ~near).any()
    assert not (near & ~met(starts, ends, low - wide - 1e-9, high + wide + 1e-9)).any()


def near_segments(low, high, *segments):
    """All pairs of segments and boxes that may meet."""
    none = np.zeros((0, 2), dtype=np.intp)
    return np.concatenate([none, *BoxTree(low, high).near_segments(*segments)])


def test_a_segment_without_numbers_is_near_everything_and_all_are_near_the_ground():
    low, high = np.zeros((20, 3)) + np.arange(20)[:, None], np.ones((20, 3)) + np.arange(20)[:, None]
    starts = np.array([[0.0, 0, 0], [np.nan, 0, 0]])
    pairs = near_segments(low, high, starts, starts + 0.5, np.array([0.0, np.nan]))
    assert (pairs[:, 0] == 1).sum() == 20
    ground = np.full((1, 3), -np.inf), np.full((1, 3), np.inf)
    assert len(near_segments(*ground, starts, starts + 500.0, np.zeros(2))) == 2
