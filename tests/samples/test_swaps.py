"""Fleets that exchange sides through a tunnel, a maze or a forest: who is where, what is free, and what is refused."""

import numpy as np
import pytest

import skyverse as sky

MADE = [sky.tunnel_swap(20, width=1.0, seed=3), sky.random_maze(20, seed=3), sky.forest_swap(20, seed=3)]


@pytest.mark.parametrize("given", MADE, ids=["tunnel", "maze", "forest"])
def test_each_uav_flies_to_the_start_of_one_on_the_other_side(given):
    n = len(given.uavs)
    starts, ends = np.array([uav.start for uav in given.uavs]), np.array([t.position for t in given.targets])
    assert n == len(given.targets) == 20
    np.testing.assert_array_equal(ends, np.roll(starts, n // 2, axis=0))
    middle = given.bounds.max[0] / 2
    assert (starts[: n // 2, 0] < middle - 2).all()
    assert (starts[n // 2 :, 0] > middle + 2).all()


@pytest.mark.parametrize("given", MADE, ids=["tunnel", "maze", "forest"])
def test_every_uav_has_a_way_and_nobody_is_given_too_close(given):
    airspace = sky.Airspace(given)
    for uav in range(len(given.uavs)):
        assert sky.Taut(proof=0).plan(sky.Problem(airspace, uav, uav)).status.reached
    starts = np.array([uav.start for uav in given.uavs]) / [0.4, 0.4, 0.8]
    gaps = np.linalg.norm(starts[:, None] - starts, axis=2)[np.triu_indices(20, 1)]
    assert gaps.min() >= 2.0


@pytest.mark.parametrize("seed", range(20))
def test_all_cells_of_a_maze_are_joined(seed):
    given = sky.random_maze(2, cells=5, seed=seed)
    airspace = sky.Airspace(given)
    cells = [(4.0 + 0.1 + 1.1 * i + 0.5, 1.1 * j + 0.6, 1.0) for i in range(5) for j in range(5)]
    moved = given.model_copy(update={"targets": tuple(sky.Target(position=cell) for cell in cells)})
    airspace = sky.Airspace(moved)
    assert all(sky.Taut(proof=0).plan(sky.Problem(airspace, 0, k)).status.reached for k in range(25))


def test_a_uav_can_pass_between_any_two_trees():
    trees = sky.forest_swap(2, trees=50, seed=1).obstacles
    assert len(trees) == 50
    places, radii = np.array([tree.centre for tree in trees]), np.array([tree.radius for tree in trees])
    gaps = np.linalg.norm(places[:, None] - places, axis=2) - radii[:, None] - radii
    assert gaps[np.triu_indices(50, 1)].min() >= 0.8


def test_the_same_seed_makes_the_same_scenario_and_another_one_another():
    assert sky.tunnel_swap(4, seed=1) == sky.tunnel_swap(4, seed=1) != sky.tunnel_swap(4, seed=2)
    assert sky.random_maze(4, seed=1) == sky.random_maze(4, seed=1) != sky.random_maze(4, seed=2)
    assert sky.forest_swap(4, seed=1) == sky.forest_swap(4, seed=1) != sky.forest_swap(4, seed=2)


@pytest.mark.parametrize(
    "make",
    [
        lambda: sky.tunnel_swap(7),
        lambda: sky.tunnel_swap(62),
        lambda: sky.tunnel_swap(4, width=0.5),
        lambda: sky.tunnel_swap(4, seed=-1),
        lambda: sky.random_maze(0),
        lambda: sky.random_maze(4, cells=2),
        lambda: sky.random_maze(4, seed=0.5),
        lambda: sky.forest_swap(9),
        lambda: sky.forest_swap(4, trees=51),
        lambda: sky.random_maze(40, cells=3),
    ],
)
def test_what_cannot_be_made_is_refused_in_one_sentence(make, refuses):
    with refuses():
        make()
