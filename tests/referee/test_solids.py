"""What all kinds of grown shapes share: chords of parts, distances, and bounds on their rounding errors."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from skyverse.referee.solids import chords, distance_error, distance_to_segment, grown

EPS = float(np.finfo(float).eps)


@given(arrays.arrays(float, (3, 4, 3), elements=st.integers(-50, 50).map(lambda n: n / 7)))
def test_a_part_is_no_farther_from_its_chord_than_said_and_the_chord_no_longer_than_the_part(part):
    chord = chords(part)
    for k in range(4):
        assert (distance_to_segment(part[:, k], chord.a, chord.b) <= chord.off + 1e-12).all()
    reach = np.linalg.norm(part[:, :, None] - part[:, None], axis=3).max(axis=(1, 2))
    assert (np.linalg.norm(chord.b - chord.a, axis=1) <= reach + 1e-12).all()
    # the chord lies along the coefficient that is farthest from the first one, which is not off at all
    far = part[np.arange(3), np.linalg.norm(part - part[:, :1], axis=2).argmax(axis=1)]
    assert (distance_to_segment(far, chord.a, chord.b) <= 1e-12).all()


@pytest.mark.parametrize("size", [1.0, 1e3, 1e6])
@pytest.mark.parametrize("count", [2, 6])
def test_rounding_errors_of_distances_are_bounded_from_both_sides(size, count):
    b = np.full((1, count, 3), size)
    own, far = (float(distance_error(each, np.zeros(1), farthest)[0]) for each, farthest in ((b, 0.0), (0 * b, size)))
    assert 45 * count * EPS * size <= own <= 500 * count * EPS * size  # 45 halvings of as many coefficients
    assert 8 * EPS * size <= far <= 100 * EPS * size
    assert distance_error(b, np.full(1, 1e-3), 0.0)[0] == pytest.approx(own + 4e-3)


def test_walls_give_way_by_a_micrometre():
    low, high = grown(np.array([1.0]), np.array([1.0 + 1e-7]), 0.5)
    np.testing.assert_allclose([low[0], high[0]], [0.5 + 1e-6, 1.5 + 1e-7 - 1e-6], rtol=1e-12)
