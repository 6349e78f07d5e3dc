"""What a result says of its path."""

from dataclasses import replace
from math import inf

import pytest


def test_a_gap_is_told_only_of_a_path_that_arrives(mission):
    for result in mission.results:
        assert (result.gap is not None) == result.status.reached


@pytest.mark.parametrize(("cost", "bound", "gap"), [(6, 4, 0.5), (0, 0, 0), (6, 0, inf), (6, -1, inf)])
def test_a_bound_that_says_nothing_makes_no_path_look_optimal(mission, cost, bound, gap):
    assert replace(mission.results[0], cost=cost, bound=bound).gap == gap
