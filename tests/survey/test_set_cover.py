"""Few sets that have all elements, beside the fewest by an exact integer programme."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import Bounds, LinearConstraint, linprog, milp

from skyverse.survey.set_cover import few_sets


def rectangles(seed, elements, sets, half):
    """Return which of random squares (sets,) hold which of random places (elements,)."""
    rng = np.random.default_rng(seed)
    places, centres = rng.random((elements, 2)), rng.random((sets, 2))
    return (np.abs(centres[:, None] - places) < half).all(axis=2)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), elements=st.integers(1, 40), sets=st.integers(1, 60))
def test_small_covers_are_the_fewest(seed, elements, sets):
    held = rectangles(seed, elements, sets, 0.2)
    chosen = few_sets(*np.nonzero(held))
    assert (held[chosen].any(axis=0) == held.any(axis=0)).all()
    if held.any():
        rows = held[:, held.any(axis=0)].T.astype(float)
        least = milp(
            np.ones(sets), constraints=LinearConstraint(rows, 1.0), integrality=np.ones(sets), bounds=Bounds(0, 1)
        )
        assert len(chosen) == round(least.fun)


@pytest.mark.parametrize("seed", [1, 2])
def test_large_covers_are_near_the_linear_programme(seed):
    held = rectangles(seed, 300, 2000, 0.07)
    chosen = few_sets(*np.nonzero(held))
    rows = held[:, held.any(axis=0)].T.astype(float)
    assert (held[chosen].any(axis=0) == held.any(axis=0)).all()
    assert len(chosen) <= 1.12 * linprog(np.ones(len(held)), A_ub=-rows, b_ub=-np.ones(len(rows))).fun
