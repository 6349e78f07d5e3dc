from dataclasses import replace

import numpy as np
import pytest

from skyverse.lab import Rows, runs_at_budget
from studies import ROW

ROW = replace(ROW, budget="10 paths", cost=300.0, bound=None)
RUNS = [
    ROW,
    replace(ROW, seed=1, cost=250.0, success=False),
    replace(ROW, planner="bbo", cost=330.0),
    replace(ROW, scenario="map2", cost=400.0, bound=200.0),
    replace(ROW, scenario="map3", cost=np.inf, success=False),
    replace(ROW, budget="20 paths", planner="gso"),
]


@pytest.fixture
def runs(tmp_path):
    with Rows(tmp_path / "rows.db") as rows:
        for number, row in enumerate(RUNS):
            rows.add(row, str(number))
        yield runs_at_budget(rows, "10 paths")


def test_a_sheet_has_one_budgets_runs_only(runs):
    assert runs.scenarios == ("map1", "map2", "map3")
    assert runs.planners == ("mvo", "bbo")
    assert runs.all("mvo", "cost").tolist() == [300.0, 250.0, 400.0, np.inf]
    assert len(runs.cells["map2", "bbo"]["cost"]) == 0


def test_the_reference_is_the_optimum_or_the_best_that_arrived(runs):
    assert [runs.bound(scenario) for scenario in runs.scenarios] == [None, 200.0, None]
    assert [runs.reference(scenario) for scenario in runs.scenarios] == [300.0, 200.0, np.inf]


def test_costs_of_several_scenarios_are_over_their_references_and_keep_failures(runs):
    assert runs.costs("mvo", ["map1"]) == {"map1": {0: 300.0, 1: 250.0}}
    assert runs.costs("mvo", ["map1", "map2"]) == {"map1": {0: 1.0, 1: 250 / 300}, "map2": {0: 2.0}}
    assert runs.costs("bbo", runs.scenarios) == {"map1": {0: 1.1}, "map2": {}, "map3": {}}


def test_failed_runs_have_no_ratio(runs):
    np.testing.assert_array_equal(runs.ratios("mvo"), [1.0, np.inf, 2.0, np.inf])
