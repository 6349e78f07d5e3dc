"""How steep the referee takes ground to be, which bounds how a depth changes from place to place."""

import pytest

from judged_clearance import world
from skyverse.model.shapes import Terrain
from skyverse.referee.ground import grown_ground


def test_the_steepness_is_one_and_the_steepest_slopes_along_both_axes():
    terrain = Terrain(origin=(0, 0), step=(5.0, 4.0), heights=[[0, 0, 0, 0], [1, 1, 1, 1], [1, 1, 2, 3]])
    ground = grown_ground(world(terrain=terrain))
    assert ground.slope == pytest.approx(2 / 5 + 1 / 4)
    assert ground.steepness == pytest.approx(1 + ground.slope)
