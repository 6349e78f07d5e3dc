"""The Euclidean norm of a vector."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skyverse.numerics.norm import norm

COMPONENTS = st.floats(-1e150, 1e150)


@given(COMPONENTS, COMPONENTS, COMPONENTS)
def test_the_norm_is_that_of_the_standard_library(x, y, z):
    assert norm(x, y, z) == pytest.approx(math.hypot(x, y, z), rel=1e-15, abs=0.0)


@pytest.mark.parametrize("size", [5e-324, 1e-310, 1e-260, 1e-160, 1e-145, 1e-140])
def test_squares_that_underflow_do_not_make_a_vector_shorter(size):
    assert norm(size, 0.0, 0.0) == size
    assert norm(0.0, -size, size) == pytest.approx(math.hypot(size, size), rel=1e-15, abs=1e-323)


def test_where_nothing_underflows_the_norm_is_the_root_of_the_sum_of_squares_to_the_last_bit():
    for x, y, z in np.random.default_rng(1).normal(0.0, 10.0 ** np.arange(-140, 140, 14)[:, None], (20, 3)):
        assert norm(x, y, z) == math.sqrt(x**2 + y**2 + z**2)
