"""How steep the referee takes ground to be, which bounds how a depth changes from place to place."""

import numpy as np
import pytest

from judged_clearance import world
from skyverse.model.shapes import Terrain
from skyverse.referee.ground import ceiling_above_ground, grown_ground


def test_the_steepness_is_one_and_the_steepest_slopes_along_both_axes():
    terrain = Terrain(origin=(0, 0), step=(5.0, 4.0), heights=[[0, 0, 0, 0], [1, 1, 1, 1], [1, 1, 2, 3]])
    scenario = world(terrain=terrain).model_copy(update={"max_height": 5.0})
    ground, ceiling = grown_ground(scenario), ceiling_above_ground(scenario)
    assert ground.slope == pytest.approx(2 / 5 + 1 / 4)
    assert ground.steepness == pytest.approx(1 + ground.slope)
    assert ceiling.steepness == ground.steepness
    assert not ground.is_convex(0)
    assert not ceiling.is_convex(0)


def test_the_greatest_heights_are_those_of_squares_of_cells_of_all_sizes():
    heights = np.random.default_rng(0).uniform(0, 9, (12, 14))
    ground = grown_ground(world(terrain=Terrain(origin=(0, 0), step=(1.0, 1.0), heights=heights)))
    assert [squares.shape for squares in ground.highest] == [(11, 13), (6, 7), (3, 4), (2, 2), (1, 1)]
    for k, squares in enumerate(ground.highest):
        for i, j in np.ndindex(squares.shape):
            nodes = (slice(n << k, (n + 1 << k) + 1) for n in (i, j))
            assert squares[i, j] == heights[tuple(nodes)].max()
