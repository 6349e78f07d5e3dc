"""A mover that keeps within what is stated of it stays within the doubt that its sightings leave."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from movers import depth_at
from replanned import BALL
from skyverse.live import Track

SEEN, HORIZON = 1.5, 2.0


@settings(max_examples=60)
@given(
    st.floats(0.5, 8), st.floats(3, 30), st.floats(0, 360), st.floats(0, 0.2), st.integers(1, 12), st.booleans(),
    st.integers(0, 1000),
)  # fmt: skip
def test_a_mover_stays_within_its_doubt_up_to_the_horizon(radius, period, bearing, error, count, hard, seed):
    rng = np.random.default_rng(seed)
    motion = sky.CircularMotion(centre=(0, 0, 0), radius=radius, period=period, bearing=bearing)
    rate = 2 * np.pi / period
    track = Track()
    for t in rng.permutation(np.linspace(SEEN - 1.0, SEEN, count)):
        off = rng.normal(size=3)
        place = motion.at([t])[0] + error * rng.uniform() * off / np.linalg.norm(off)
        track.add(
            float(t),
            sky.Sighting(
                name="spinner", shape=BALL, position=place, error=error * 1.000001, top_speed=radius * rate * 1.001,
                max_acceleration=radius * rate**2 * 1.001 if hard else None,
            ),
        )  # fmt: skip
    assert track.last <= SEEN
    mover = track.predicted(track.last + HORIZON)
    instants = track.last + np.linspace(0.0, HORIZON, 50)
    point = BALL.model_copy(update={"radius": 1e-9})
    assert depth_at(mover.model_copy(update={"shape": point}), instants, motion.at(instants), 1e-6).min() >= 0.0
