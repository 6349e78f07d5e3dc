"""Lattices have few enough nodes, and steps upright that fit between the clearance from the ground and the ceiling."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.round_steps import MAX_BELOW_CEILING, MAX_DEFAULT_NODES, round_steps
from skyverse.model.scenario import upright_step, with_fitting_lattice


def nodes(bounds, lattice):
    sizes = (high - low for low, high in zip(bounds.min, bounds.max, strict=True))
    return math.prod(size / step + 1 for size, step in zip(sizes, lattice.step, strict=True))


@given(
    st.tuples(*[st.floats(2, 20_000)] * 2, st.floats(2, 2_000)),
    st.sampled_from([math.inf, 1.0, 5.0, 20.0]),
)
def test_steps_are_the_shortest_of_few_enough_nodes(size, upright):
    bounds = sky.Bounds(min=(0, 0, 0), max=size)
    lattice = sky.Lattice(step=round_steps(size, 1.0, upright))
    most = MAX_DEFAULT_NODES if upright == math.inf else MAX_BELOW_CEILING
    assert nodes(bounds, lattice) <= most
    assert lattice.step[2] <= upright
    shorter = max(lattice.step[:2]) / 2.5  # steps are 1, 2, 5, 10 ... times as long
    steps = zip((shorter, shorter, min(shorter, upright)), size, strict=True)
    assert shorter < 1 or nodes(bounds, sky.Lattice(step=tuple(min(one, side) for one, side in steps))) > most


STRAYS = {"horizontal": 1.6, "vertical": 3}


def slope(**more):
    """A scenario over a slope of 20 degrees, 2 km long."""
    x = np.linspace(0, 2000, 201)
    ground = sky.Terrain(
        origin=(0, 0), step=(10, 500), heights=np.tan(np.pi / 9) * np.tile(x[:, None], 2), clearance=30
    )
    given = {
        "name": "slope",
        "bounds": sky.Bounds(min=(0, 0, 0), max=(2000, 500, 1400)),
        "terrain": ground,
        "clearance": 5,
        "lattice": sky.Lattice(step=(50, 50, 50)),
        "objective": sky.Objective(unit="metres"),
        "uavs": [sky.UAV(start=(100, 250, 50 + float(ground.height((100, 250)))), tracking_error=STRAYS)],
        "targets": [sky.Target(position=(1900, 250, float(ground.height((1900, 250))) + 50))],
    }
    return sky.Scenario(**(given | more))


def test_upright_steps_fit_twice_between_clearance_and_ceiling():
    assert upright_step(slope()) == math.inf
    assert upright_step(slope(max_height=75)) == 10  # of 75 - 30 - 2 x 3 = 39 m
    assert upright_step(slope(max_height=170)) == 50
    fitted = with_fitting_lattice(slope(max_height=75))
    assert fitted.lattice.step == (50, 50, 10)
    assert with_fitting_lattice(fitted) is fitted


@pytest.mark.parametrize("most", [75, 80, 90])
def test_a_path_follows_a_slope_below_a_ceiling_on_the_fitting_lattice(most):
    fitted = with_fitting_lattice(slope(max_height=most))
    assert sky.AStar().plan(sky.Problem(fitted)).status.reached
    assert not sky.AStar().plan(sky.Problem(slope(max_height=75))).status.reached  # as this can fail
