"""Outlines of prisms: whichever way they are looked at, the same edges meet."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse import shapes


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(3, 30), st.booleans())
def test_edges_that_meet_are_the_same_by_a_sweep_as_by_looking_at_all_pairs(seed, count, coarse):
    rng = np.random.default_rng(seed)
    ring = rng.integers(0, 6, (count, 2)).astype(float) if coarse else rng.uniform(0, 1, (count, 2))
    whole = [ring, rng.uniform(-1, 2, (4, 2))] if seed % 2 else [ring]
    low = np.concatenate([np.minimum(one, np.roll(one, -1, axis=0)) for one in whole])
    high = np.concatenate([np.maximum(one, np.roll(one, -1, axis=0)) for one in whole])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shapes, "FEW_EDGES", 10**9)
        every, told = _pairs(low, high), shapes._edges_that_meet(whole)
        patch.setattr(shapes, "FEW_EDGES", 0)
        patch.setattr(shapes, "PAIRS", 7)
        swept = _pairs(low, high)
        overlap = {(a, b) for a, b in every if (low[a] <= high[b]).all() and (low[b] <= high[a]).all()}
        assert overlap <= swept <= every
        assert shapes._edges_that_meet(whole) == told


def _pairs(low, high):
    return {pair for a, b in shapes._edges_near(low, high) for pair in zip(a.tolist(), b.tolist(), strict=True)}


def test_an_outline_of_many_thousand_corners_is_checked_at_once():
    turn = np.linspace(0, 2 * np.pi, 20_000, endpoint=False)
    ring = 1000 * np.column_stack([np.cos(turn), np.sin(turn)])
    tracemalloc.start()
    sky.Prism(vertices=ring, low=0, high=1)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3e8
    ring[9_000, 0] += 3000  # across the other side
    with pytest.raises(ValueError, match="must not touch or cross itself"):
        sky.Prism(vertices=ring, low=0, high=1)
