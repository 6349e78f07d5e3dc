"""Missions with one planted fault: found at the right items, and nothing else; the truth comes from dense samples."""

import numpy as np
import pytest

from planted_missions import FAULTS, unharmed
from planting import NOT_DJI, harmed, judged, mistakes


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_found_at_its_items_and_nothing_else(fault):
    case = harmed(np.random.default_rng([FAULTS.index(fault), 1]), fault)
    assert mistakes(case, judged(case)) == ([], [])


@pytest.mark.parametrize("seed", range(4))
def test_nothing_is_found_of_missions_that_are_right(seed):
    case = unharmed(np.random.default_rng([seed, 0]), two=seed == 0)
    assert judged(case) == [[] for _ in case.flights]


@pytest.mark.parametrize("fault", [one for one in FAULTS if one not in NOT_DJI])
def test_a_fault_planted_in_a_file_of_dji_is_found_at_its_waypoints_and_nothing_else(fault):
    case = harmed(np.random.default_rng([FAULTS.index(fault), 2]), fault, dji=True)
    assert case.flights[0].autopilot == "dji"
    assert mistakes(case, judged(case)) == ([], [])


@pytest.mark.parametrize("seed", range(40))
def test_more_faults_are_found_and_no_others(seed):
    fault = FAULTS[seed % len(FAULTS)]
    for case in (harmed(np.random.default_rng([seed, 1]), fault), unharmed(np.random.default_rng([seed, 0]))):
        assert mistakes(case, judged(case)) == ([], [])
