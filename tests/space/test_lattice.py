"""The lattice: which nodes are blocked, which moves are safe, and which node stands for a point."""

import itertools

import numpy as np
import pytest
from hypothesis import given

import skyverse as sky
from skyverse.numerics.tolerances import CLOSED_MARGIN
from skyverse.space import blocks, lattice
from worlds import exits_of, grown, indices_of, neighbours, scenarios, shape_of, whole


def grid_of(scenario):
    return lattice.make_grid(sky.World(scenario), scenario.lattice)


def node_at(grid, *index):
    return int(np.ravel_multi_index(index, tuple(grid.shape)))


def leads(grid, node, move):
    """Whether a move, given as an index step, is safe."""
    m = int(np.flatnonzero((grid.moves == move).all(axis=1))[0])
    return bool(grid.exits[node] >> m & 1)


def hall(**changes):
    """An empty hall of 4 x 4 x 4 nodes, a metre apart."""
    given = {
        "name": "hall",
        "bounds": sky.Bounds(min=(0, 0, 0), max=(3, 3, 3)),
        "clearance": 0.001,
        "lattice": sky.Lattice(step=(1, 1, 1)),
    }
    return sky.Scenario(**(given | changes))


@pytest.mark.parametrize(
    ("name", "shape"), [("map1", (101, 251, 13)), ("map2", (201, 51, 13)), ("map3", (101, 251, 13))]
)
def test_the_thesis_lattices_have_as_many_nodes_as_it_says(name, shape):
    assert tuple(grid_of(sky.read(name)).shape) == shape


@pytest.mark.parametrize("name", ["map1", "map2", "map3"])
def test_a_node_of_a_thesis_map_is_blocked_in_or_on_a_grown_box(name):
    scenario = sky.read(name)
    grid = grid_of(scenario)
    # twentieths of a metre: 0.1 and 0.25 m are whole
    places = whole(scenario.bounds.min) + np.stack(np.indices(tuple(grid.shape)), -1).reshape(-1, 3) * [2, 2, 10]
    blocked = np.zeros(len(places), bool)
    for low, high in zip(*grown(scenario), strict=True):
        blocked |= np.all((places >= low) & (places <= high), axis=1)
    np.testing.assert_array_equal(grid.exits == 0, blocked)


@given(scenarios(most_nodes=6))
def test_every_exit_of_every_node_is_as_brute_force_says(scenario):
    grid = grid_of(scenario)
    assert tuple(grid.shape) == shape_of(scenario)
    exits = grid.exits[:, None] >> np.arange(len(grid.moves)) & 1
    np.testing.assert_array_equal(exits, exits_of(scenario, grid.moves))
    assert not (grid.exits >> len(grid.moves)).any()


@given(scenarios(most_nodes=5))
def test_every_safe_move_is_a_free_segment_of_the_world_and_leads_back(scenario):
    grid = grid_of(scenario)
    places = lattice.positions(grid, np.arange(len(grid.exits)))
    for m, offset in enumerate(grid.offsets):
        nodes = np.flatnonzero(grid.exits >> m & 1)
        assert sky.World(scenario).segments_free(places[nodes], places[nodes + offset]).all()
        assert (grid.exits[nodes + offset] >> (m ^ 1) & 1).all()


@pytest.mark.parametrize("connectivity", [6, 26])
def test_the_moves_are_all_of_the_neighbourhood_in_opposite_pairs(connectivity):
    moves = lattice.lattice_moves(connectivity)
    assert len(moves) == connectivity
    assert {tuple(m) for m in moves} == {tuple(m) for m in neighbours(connectivity)}
    np.testing.assert_array_equal(moves[0::2], -moves[1::2])
    # pairs 0, 1, 2 are the axes x, y, z: the turn count of the exact search counts on it
    np.testing.assert_array_equal(moves[:6:2], np.eye(3))


@pytest.mark.parametrize("connectivity", [6, 26])
def test_toward_holds_the_moves_that_come_nearer_on_every_axis_they_change(connectivity):
    grid = grid_of(hall(lattice=sky.Lattice(step=(1, 1, 1), connectivity=connectivity)))
    for left in itertools.product((-1, 0, 1), repeat=3):
        code = 13 + 9 * left[0] + 3 * left[1] + left[2]
        chosen = {m for m in range(connectivity) if grid.toward[code] >> m & 1}
        wanted = {
            m
            for m, move in enumerate(grid.moves)
            if all(abs(a - b) < abs(a) for a, b in zip(left, move, strict=True) if b)
        }
        assert chosen == wanted


@given(scenarios(most_nodes=6))
def test_numbers_indices_and_places_of_nodes_agree(scenario):
    grid = grid_of(scenario)
    nodes = np.arange(len(grid.exits))
    indices = indices_of(scenario)
    places = np.array(scenario.bounds.min) + indices * np.array(scenario.lattice.step)
    np.testing.assert_allclose(lattice.positions(grid, nodes), places, rtol=0, atol=1e-12)
    np.testing.assert_allclose([lattice.position(grid, n) for n in nodes], places, rtol=0, atol=1e-12)
    for m, move in enumerate(grid.moves):
        inside = np.all((indices + move >= 0) & (indices + move < grid.shape), axis=1)
        np.testing.assert_array_equal(indices[nodes[inside] + grid.offsets[m]], indices[inside] + move)


@pytest.mark.parametrize("thickness", [1e-6, 0.05, 0.9])
@pytest.mark.parametrize("axis", range(3))
def test_a_wall_between_two_layers_of_nodes_lets_no_move_through(thickness, axis):
    low, high = np.zeros(3), np.full(3, 3.0)
    low[axis], high[axis] = 1.5 - thickness / 2, 1.5 + thickness / 2
    walled = hall(obstacles=(sky.Box(min=low, max=high),), lattice=sky.Lattice(step=(1, 1, 1), connectivity=26))
    grid = grid_of(walled)
    assert (grid.exits != 0).all()  # no node is blocked
    near = indices_of(walled)[:, axis] == 1
    through = grid.moves[:, axis] == 1
    exits = grid.exits[:, None] >> np.arange(26) & 1
    assert not exits[np.ix_(near, through)].any()
    assert exits[np.ix_(near, grid.moves[:, axis] == 0)].any()


def test_a_diagonal_move_does_not_cut_a_corner():
    post = sky.Box(min=(0.9, -0.1, 0), max=(1.1, 0.1, 3))  # stands on the edge from (1, 0, 0) up
    grid = grid_of(hall(obstacles=(post,), lattice=sky.Lattice(step=(1, 1, 1), connectivity=26)))
    beside = node_at(grid, 0, 0, 1)
    assert not leads(grid, beside, (1, 0, 0))
    assert not leads(grid, beside, (1, 1, 0))
    assert not leads(grid, beside, (1, 1, 1))
    assert leads(grid, beside, (0, 1, 0))
    assert leads(grid, node_at(grid, 0, 1, 1), (1, 1, 0))


def snapped(scenario, point):
    grid = grid_of(scenario)
    node, shut_in = lattice.snap(grid, sky.World(scenario).space, np.array(point, float))
    return (None if node < 0 else tuple(lattice.position(grid, node))), shut_in


def test_a_point_snaps_down_as_in_the_thesis():
    place, shut_in = snapped(sky.read("table-4.8"), (5, 10, 5.8))
    assert place == pytest.approx((5, 10, 5.5))
    assert not shut_in
    assert snapped(sky.read("map1"), (0.19, -4, 1))[0] == pytest.approx((0.1, -4, 1))


def test_a_point_on_a_node_snaps_to_it_whatever_rounding_does():
    scenario = sky.read("map1")
    for i in range(101):
        assert snapped(scenario, (i / 10, 3 + i / 10, 5))[0] == pytest.approx((i / 10, 3 + i / 10, 5), abs=1e-9)


def test_where_the_lower_corner_cannot_be_reached_the_nearest_other_corner_is_taken():
    # a plate over the cell's floor, at z 0.4: of the upper corners (1, 0, 1) is nearest
    plate = sky.Box(min=(0, 0, 0.35), max=(1, 1, 0.4))
    place, shut_in = snapped(hall(obstacles=(plate,)), (0.8, 0.1, 0.7))
    assert place == (1, 0, 1)
    assert not shut_in


def test_a_corner_with_safe_moves_is_preferred_to_one_without():
    # the node (1, 1, 1) is caged in; (1.4, 1.4, 1.4) sees it, and the open node (2, 2, 2) too
    cage = [sky.Box(min=np.array(c) - 0.1, max=np.array(c) + 0.1) for c in np.array([1, 1, 1]) + neighbours(6) * 0.5]
    place, shut_in = snapped(hall(obstacles=tuple(cage)), (1.4, 1.4, 1.4))
    assert place != (1, 1, 1)
    assert not shut_in


def test_a_point_from_which_no_corner_has_a_move_is_shut_in():
    walls = [
        sky.Box(min=(2.4, 0, 0), max=(2.5, 3, 3)),
        sky.Box(min=(0, 2.4, 0), max=(3, 2.5, 3)),
        sky.Box(min=(0, 0, 2.4), max=(3, 3, 2.5)),
    ]
    place, shut_in = snapped(hall(obstacles=tuple(walls)), (2.7, 2.8, 2.9))
    assert place == (3, 3, 3)
    assert shut_in


def test_a_point_in_a_wall_has_no_node():
    assert snapped(hall(obstacles=(sky.Box(min=(1, 1, 1), max=(2, 2, 2)),)), (1.5, 1.5, 1.5)) == (None, False)


@given(scenarios(most_nodes=5))
def test_the_node_of_a_point_is_within_a_step_and_in_line_of_sight(scenario):
    grid, compiled = grid_of(scenario), sky.World(scenario)
    point = np.array(scenario.uavs[0].start)
    node, shut_in = lattice.snap(grid, compiled.space, point)
    below = np.minimum(np.floor((point - grid.origin) / grid.step + 1e-9), grid.shape - 1)
    near = [np.array(c) for c in itertools.product(*map(range, grid.shape))]
    near = [c for c in near if np.all(np.abs(grid.origin + c * grid.step - point) <= grid.step * (1 + 1e-9))]
    seen = [node_at(grid, *c) for c in near if compiled.segments_free(point, grid.origin + c * grid.step)[0]]
    if node < 0:
        assert not seen
        return
    assert node in seen
    assert shut_in == (not grid.exits[seen].any())
    if grid.exits[node] and node != node_at(grid, *below.astype(int)):
        lower = node_at(grid, *below.astype(int))
        assert lower not in seen or not grid.exits[lower]


@given(scenarios(most_nodes=4, most_boxes=6))
def test_the_kernels_say_what_their_plain_python_says(scenario):
    space = sky.World(scenario).space
    grid = grid_of(scenario)
    touched = [np.zeros(tuple(grid.shape), np.uint8) for _ in range(2)]
    for kernel, array in zip((blocks.mark_boxes, plain(blocks.mark_boxes)), touched, strict=True):
        kernel(space.boxes, space.clearance + CLOSED_MARGIN, grid.origin, grid.step, grid.shape, array)
    np.testing.assert_array_equal(*touched)
    np.testing.assert_array_equal(plain(lattice._safe_moves)(touched[0], grid.moves), grid.exits)
    for node in range(0, len(grid.exits), 7):
        np.testing.assert_array_equal(plain(lattice.position)(grid, node), lattice.position(grid, node))


def plain(kernel):
    return getattr(kernel, "py_func", kernel)


@pytest.mark.parametrize("error", [(0.5, 2.0), (1.7, 0.3), (0.0, 1.0), (1.0, 0.0)])
def test_the_lattice_stays_where_it_is_and_its_moves_are_free(error):
    given = sky.Scenario(
        name="tube",
        bounds=sky.Bounds(min=(0, 0, 0), max=(20, 20, 12)),
        obstacles=(sky.Box(min=(3, 3, 0), max=(5, 6, 4)),),
        clearance=0.4,
        lattice=sky.Lattice(step=(1, 1, 1)),
    )
    tube = sky.World(given, sky.TrackingError(horizontal=error[0], vertical=error[1]))
    grid, plain = lattice.make_grid(tube, given.lattice), lattice.make_grid(sky.World(given), given.lattice)
    np.testing.assert_array_equal(grid.origin, plain.origin)
    np.testing.assert_array_equal(grid.shape, plain.shape)
    nodes = np.flatnonzero(grid.exits)
    for m, offset in enumerate(grid.offsets):
        some = nodes[(grid.exits[nodes] >> m & 1) == 1]
        assert tube.segments_free(lattice.positions(grid, some), lattice.positions(grid, some + offset)).all()
    assert not (grid.exits & ~plain.exits).any()
    free = tube.free(lattice.positions(grid, np.arange(len(grid.exits))))
    assert free[nodes].all()
