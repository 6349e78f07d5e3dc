"""Gaps as tables tell them: rounded up, never below zero by rounding, and with a word on what the bound is."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.short_lines import told_gap


@pytest.mark.parametrize(
    ("gap", "told"),
    [
        (None, "-"),
        (float("inf"), "-"),
        (0.0, "0 %"),
        (-1e-12, "0 %"),
        (1e-12, "0 %"),
        (1e-6, "0.1 %"),
        (0.02, "2 %"),
        (0.0201, "2.1 %"),
        (1.0885, "109 %"),
        (12.3456, "1,235 %"),
        (-0.25, "-25 %"),
    ],
)
def test_a_gap_is_told_in_per_cent_and_rounded_up(gap, told):
    assert told_gap(gap) == told


@given(st.floats(1e-8, 1e4))
def test_no_gap_is_told_smaller_than_it_is(gap):
    told = float(told_gap(gap).removesuffix(" %").replace(",", "")) / 100
    assert gap * (1 - 1e-8) <= told <= gap + max(0.0011, 0.011 * (gap >= 0.1))


@pytest.fixture(scope="module")
def around_a_wall():
    wall = sky.Box(min=(4, -1, 0), max=(6, 9, 10))
    return sky.Scenario(
        name="wall",
        bounds=sky.Bounds(min=(0, -1, 0), max=(10, 10, 10)),
        obstacles=(wall,),
        clearance=0.25,
        lattice=sky.Lattice(step=(1, 1, 1)),
        objective="turns",
        uavs=(sky.UAV(start=(1, 1, 1)),),
        targets=(sky.Target(position=(9, 1, 1)),),
    )


def test_a_bound_with_a_turn_in_it_is_not_called_the_straight_line(around_a_wall):
    result = sky.ThetaStar().plan(sky.Problem(around_a_wall))
    assert result.bound == pytest.approx(8 + around_a_wall.objective.divergence)
    assert not result.straight_bound
    assert result.gap_sentence.endswith("above the best possible")


@pytest.mark.parametrize("planner", [sky.ThetaStar(), sky.Taut(proof=0), sky.Cheapest(proof=0)], ids=repr)
def test_a_bound_that_is_the_straight_line_is_called_so(around_a_wall, planner):
    plain = around_a_wall.model_copy(update={"objective": sky.Objective(unit="metres", fuel=2)})
    result = planner.plan(sky.Problem(plain))
    assert result.bound == pytest.approx(2 * 8)
    assert result.straight_bound
    assert result.gap_sentence.endswith("above the straight line, which no path beats")


def test_a_bound_that_knows_the_obstacles_is_not_called_the_straight_line(around_a_wall):
    result = sky.Taut().plan(sky.Problem(around_a_wall))
    assert result.bound > 8.5
    assert not result.straight_bound
    assert not sky.AStar().plan(sky.Problem(around_a_wall)).straight_bound


def test_the_straight_line_of_a_path_with_lifts_joins_their_tops(around_a_wall):
    strays = sky.UAV(start=(1, 1, 0.5), tracking_error=sky.TrackingError(horizontal=0.2, vertical=1))
    problem = sky.Problem(
        around_a_wall.model_copy(update={"objective": sky.Objective(unit="metres"), "uavs": (strays,)})
    )
    up, down = problem.start[2] - 0.5, problem.end[2] - 1
    assert up > 0
    result = sky.Taut(proof=0).plan(problem)
    assert result.bound == pytest.approx(up + np.linalg.norm(problem.end - problem.start) + down)
    assert result.straight_bound


def test_an_optimum_on_the_lattice_is_not_called_the_best_of_all():
    result = sky.AStar().plan(sky.Problem(sky.read("map1")))
    assert result.gap_sentence == "no path on the lattice costs less"
    assert replace(result, cost=1.015 * result.cost).gap_sentence == (
        "at most 1.5 % above the best possible on the lattice"
    )
    assert "impossible" in replace(result, cost=0.9 * result.cost).gap_sentence
    assert replace(result, bound=None).gap_sentence == ""
