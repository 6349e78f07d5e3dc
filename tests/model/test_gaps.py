"""Gaps as tables tell them: rounded up, never below zero by rounding, and with a word on what the bound is."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.gaps import told_gap


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


def test_a_bound_that_is_the_straight_line_is_called_so(around_a_wall):
    result = sky.ThetaStar().plan(sky.Problem(around_a_wall))
    turn = around_a_wall.objective.divergence
    assert not result.bounded_by_straight_line()  # one turn is part of the bound
    assert result.bounded_by_straight_line(turn)
    plain = replace(result, bound=result.bound - turn)
    assert plain.bounded_by_straight_line()
    assert plain.gap_sentence.endswith("above the straight line, which no path beats")
    raised = replace(plain, bound=1.01 * plain.bound)
    assert raised.gap_sentence.endswith("above the best possible")


def test_a_path_with_columns_at_its_ends_is_held_against_the_line_between_them():
    path = np.array([(0.0, 0, 0), (0, 0, 5), (3, 4, 6), (6, 0, 5), (6, 0, 1)])
    found = sky.AStar().plan(sky.Problem(sky.read("map1")))
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    result = replace(found, path=path, terms={"fuel": 2 * length}, any_angle=True, bound=2 * (5 + 6 + 4))
    assert result.bounded_by_straight_line()
    assert not replace(result, bound=2 * (5 + 6 + 4.1)).bounded_by_straight_line()
    assert replace(result, bound=2 * float(np.linalg.norm(path[-1] - path[0]))).bounded_by_straight_line()


def test_an_optimum_on_the_lattice_is_not_called_the_best_of_all():
    result = sky.AStar().plan(sky.Problem(sky.read("map1")))
    assert result.gap_sentence == "no path on the lattice costs less"
    assert replace(result, cost=1.015 * result.cost).gap_sentence == (
        "at most 1.5 % above the best possible on the lattice"
    )
    assert "impossible" in replace(result, cost=0.9 * result.cost).gap_sentence
    assert replace(result, bound=None).gap_sentence == ""
