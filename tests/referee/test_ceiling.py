"""The ceiling above ground and obstacles that are closed above, as the referee judges them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from judged_clearance import judged, of, straight, verdict, world

ROUGH = sky.Terrain(
    origin=(0, 0), step=(2.5, 2.0), heights=np.random.default_rng(3).uniform(0, 3, (5, 6)), clearance=0.5
)


def under(max_height, terrain=ROUGH):
    return world(terrain=terrain).model_copy(update={"max_height": max_height})


@given(st.integers(0, 10_000), st.integers(1, 5), st.floats(2.0, 5.0))
def test_a_curve_is_proven_exactly_where_dense_samples_stay_below_the_ceiling(seed, degree, most):
    rng = np.random.default_rng(seed)
    a, b = rng.uniform((0, 0, 3.5), (10, 10, 6.0), (2, 3))
    rows = np.zeros((1, degree + 1, 3))
    rows[0, 0], rows[0, 1] = a, b - a
    rows[0, 2:] = rng.uniform(-0.4, 0.4, (degree - 1, 3))
    times = np.linspace(0, 1, 4001)
    positions = sum(rows[0, k] * times[:, None] ** k for k in range(degree + 1))
    above = positions[:, 2] - ROUGH.height(positions[:, :2])
    excess = max((above - most).max(), (0.5 - above).max())
    found = judged(under(most), of([0, 1], rows))
    if excess > 1e-5:
        assert verdict(found) == "refuted"
        assert found.incursion.depth >= excess - 1e-6
    elif excess < -0.01:
        assert verdict(found) == "proven"


def test_a_message_says_how_far_above_which_ceiling():
    flat = sky.Terrain(origin=(0, 0), step=(10, 10), heights=np.ones((2, 2)), clearance=0.5)
    scenario = under(5.0, flat)
    found = judged(scenario, straight((1, 1, 3), (9, 9, 7.5)))
    assert found.incursion.sentence(scenario, "uav-1", "at t = 1 s") == (
        "uav-1 is 1.5 m above the ceiling of 5 m above ground at t = 1 s, position (9, 9, 7.5)."
    )


LOWER = ROUGH.model_copy(update={"lowest": ROUGH.heights - np.random.default_rng(4).uniform(0, 2, (5, 6))})


@given(st.integers(0, 10_000), st.floats(4.0, 6.0))
def test_the_ceiling_is_counted_from_the_lowest_heights_where_there_are_such(seed, most):
    rng = np.random.default_rng(seed)
    a, b = rng.uniform((0, 0, 3.5), (10, 10, 6.0), (2, 3))
    positions = np.linspace(a, b, 2001)
    excess = (positions[:, 2] - LOWER.lowest_ground.height(positions[:, :2]) - most).max()
    excess = max(excess, (0.5 - (positions[:, 2] - LOWER.height(positions[:, :2]))).max())
    if abs(excess) > 1e-4:
        found = judged(under(most, LOWER), straight(a, b))
        assert verdict(found) == ("refuted" if excess > 0 else "proven")
        assert sky.World(under(most, LOWER)).segments_free([a], [b]).tolist() == [excess < 0]
