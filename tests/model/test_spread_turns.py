"""How turns are spread over time so that no limit on the yaw is broken, also where they undo each other."""

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

from skyverse.model.trajectory import spread_turns

TURNS = st.lists(st.tuples(st.floats(0.01, 2.0), st.floats(-3.0, 3.0)), min_size=1, max_size=12)


@settings(max_examples=50)
@given(TURNS)
@example([(0.5, 1.0), (1.9, -3.0), (1.9, 1.0)])
def test_no_window_of_time_holds_more_of_the_turns_than_the_rate_allows(drawn):
    pauses, turns = np.array(drawn).T
    instants = np.cumsum(pauses)
    spread, _ = spread_turns(instants, turns, 1.0, 2.0, 0.2)
    slid = np.linspace(instants[0] - spread, instants[-1], 20_001)
    held = (instants >= slid[:, None]) & (instants <= slid[:, None] + spread)
    assert np.abs(held @ turns).max() <= spread * (1.0 + 1e-9)
