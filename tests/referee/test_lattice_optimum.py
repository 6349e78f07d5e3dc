"""The optimum of the lattice is that of an oracle, which searches anew with the referee's geometry."""

import numpy as np
import pytest

import skyverse as sky
from lattice_oracle import cheapest_costs


def room(seed, **objective):
    rng = np.random.default_rng(seed)
    middles = rng.uniform(1, 7, size=(6, 3)) * [1, 1, 0.5]
    reach = np.array([0.6, 0.8, 1.0])
    shapes = [sky.Box(min=tuple(middle - reach), max=tuple(middle + reach)) for middle in middles[:3]]
    shapes += [sky.Sphere(centre=tuple(middles[3]), radius=1.0), sky.Sphere(centre=tuple(middles[4]), radius=0.7)]
    shapes.append(sky.Cylinder(centre=tuple(middles[5, :2]), radius=0.8, low=0.0, high=3.0))
    connectivity = 26 if seed % 2 else 6
    return sky.Scenario(
        name=f"room {seed}",
        bounds=sky.Bounds(min=(0, 0, 0), max=(8, 8, 4)),
        obstacles=tuple(shapes),
        clearance=0.1,
        lattice=sky.Lattice(step=(0.5, 0.5, 0.5), connectivity=connectivity),
        objective=sky.Objective(**({"fuel": 1, "end": 10, "unit": "metres"} | objective)),
        uavs=(sky.UAV(start=(0.2, 0.2, 0.2)),),
        targets=(sky.Target(position=(7.8, 7.8, 3.8)),),
    )


def optimum_of(scenario):
    """The cost of the planner's optimum, and the least and the most that the oracle finds."""
    result = sky.AStar().plan(sky.Problem(scenario))
    assert result.status is sky.Status.OPTIMAL
    assert result.bound == pytest.approx(result.cost, rel=1e-9)
    return result.cost, *cheapest_costs(scenario, result.start, result.goal)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(
    "objective",
    [{}, {"unit": "nodes"}, {"divergence": 0.7}, {"divergence": 0.7, "unit": "nodes", "fuel": 0.3}],
    ids=["metres", "nodes", "turns", "turns and nodes"],
)
def test_the_planners_optimum_is_the_oracles(seed, objective):
    cost, least, most = optimum_of(room(seed, **objective))
    assert least * (1 - 1e-9) <= cost <= most * (1 + 1e-9)
    assert most == pytest.approx(least)


@pytest.mark.parametrize(
    "soft",
    [
        {"altitude": sky.AltitudeBand(low=1.0, high=2.0, weight=0.5), "climb": sky.ClimbLimit(angle=20, weight=2.0)},
        {"risk": 0.5},
        {"risk": 3.0},
    ],
)
def test_the_optimum_with_soft_terms_is_the_oracles(soft):
    zones = (sky.Box(min=(2, 2, 0), max=(5.3, 5.3, 3.3), risk=2.0),) if "risk" in soft else ()
    changes = {"lattice": sky.Lattice(step=(1, 1, 0.5), connectivity=26), "zones": zones}
    cost, least, most = optimum_of(room(1, **soft).model_copy(update=changes))
    assert least * (1 - 1e-9) <= cost <= most * (1 + 1e-9)


def test_the_optimum_through_a_gap_that_is_too_narrow_by_what_is_let_pass_lies_between_both_of_the_oracle():
    walls = (sky.Box(min=(4, 0, 0), max=(4.2, 3.9, 4)), sky.Box(min=(4, 4.1 - 5e-7, 0), max=(4.2, 8, 3)))
    low = (sky.Target(position=(7.8, 7.8, 0.2)),)
    cost, least, most = optimum_of(
        sky.Scenario.model_validate(room(0).model_dump() | {"obstacles": walls, "targets": low})
    )
    assert least < cost <= most


def test_nodes_that_planners_may_block_are_none_that_they_have_to_use():
    wall = sky.Box(min=(3, 0, 0), max=(5, 8, 2.9 - 2.5e-6))
    low = (sky.Target(position=(7.8, 7.8, 0.2)),)
    cost, least, most = optimum_of(room(2).model_copy(update={"obstacles": (wall,), "targets": low}))
    assert least <= cost <= most
