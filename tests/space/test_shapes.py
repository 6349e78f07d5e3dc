"""Swept segments, boxes, moves and distances among all shapes: brute force, dense sampling, and shapely."""

import itertools

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import skyverse as sky
from depths import depth
from drawn_shapes import along, places, worlds
from skyverse.space import ground, obstacles, voxels
from skyverse.space.lattice import make_grid, positions

HALL = sky.Prism(
    vertices=((2, 2), (9, 2), (9, 8), (6, 8), (6, 5), (2, 7)), holes=(((7, 3), (8, 3), (8, 4), (7, 4)),), low=1, high=6
)


@settings(max_examples=60)
@given(worlds(), places, places, st.sampled_from([0.0, 0.3]), st.integers(0, 1000))
def test_points_within_a_swept_segment_are_free_where_the_whole_sweep_is(scenario, a, b, dev, seed):
    space = sky.World(scenario).space
    a, b = np.array(a), np.array(b)
    margin = 0.25 - space.clearance
    swept = obstacles.box_crossed(space, margin + dev, a, b) >= 0 or obstacles.shapes_crossed(space, margin, dev, a, b)
    if not swept:
        rng = np.random.default_rng(seed)
        way = rng.normal(size=(400, 3))
        near = along(a, b, 400) + dev * way / np.linalg.norm(way, axis=1)[:, None]
        near = near[np.all((near >= space.low) & (near <= space.high), axis=1)]
        assert (depth(scenario, near, margin) < 1e-8).all()
    if dev == 0.0:
        assert swept == obstacles.crosses(space, margin, a, b)


@settings(max_examples=60)
@given(worlds(), places, places, st.sampled_from([0.0, 0.5]))
def test_a_box_that_no_obstacle_meets_holds_no_unsafe_point(scenario, a, b, growth):
    low, high = np.minimum(a, b), np.maximum(a, b)
    assume((high > low).all())
    space = sky.World(scenario).space
    inside = low + (high - low) * np.array(list(itertools.product(np.linspace(0.01, 0.99, 12), repeat=3)))
    margin = growth - space.clearance
    deep = depth(scenario, inside, margin).max()
    corners = np.hstack((space.boxes[:, :3] - growth - high, low - growth - space.boxes[:, 3:]))
    meets = bool(np.all(corners < -1e-9, axis=1).any())
    meets |= obstacles.shapes_reach(space, margin, low, high)
    if deep > 1e-8:
        assert meets
    elif deep < -np.linalg.norm(high - low) / 12 * 3.5 - 1e-8:
        assert not meets


@settings(max_examples=20)
@given(worlds())
def test_no_safe_move_of_the_lattice_passes_an_unsafe_point(scenario):
    compiled = sky.World(scenario)
    grid = make_grid(compiled, scenario.lattice)
    places = positions(grid, np.arange(len(grid.exits)))
    node, move = np.nonzero(grid.exits[:, None] >> np.arange(len(grid.moves)) & 1)
    a, b = places[node], places[node + grid.offsets[move]]
    assert compiled.segments_free(a, b).all()
    shares = np.linspace(0, 1, 7)[:, None, None]
    assert (depth(scenario, (a + shares * (b - a)).reshape(-1, 3)) < 1e-8).all()
    # a node that is clearly off all obstacles, and has such a neighbour, is not lost
    reach = float(np.linalg.norm(scenario.lattice.step)) * 4.5
    clear = depth(scenario, places) < -reach
    assert grid.exits[clear].all()


@given(st.lists(st.booleans(), min_size=60, max_size=60))
def test_merged_voxels_fill_the_occupied_cells_once(cells):
    occupied = np.reshape(cells, (3, 4, 5))
    boxes = voxels.merged(sky.Voxels(origin=(1, 2, 3), step=(1, 2, 0.5), occupied=occupied))
    filled = np.zeros((3, 4, 5), int)
    for row in boxes:
        first, last = (np.rint((corner - (1, 2, 3)) / (1, 2, 0.5)).astype(int) for corner in (row[:3], row[3:]))
        filled[tuple(slice(f, z) for f, z in zip(first, last, strict=True))] += 1
    np.testing.assert_array_equal(filled, occupied)


def test_a_full_block_of_voxels_is_one_box():
    assert len(voxels.merged(sky.Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=np.ones((7, 5, 3))))) == 1


@settings(max_examples=60)
@given(places, places)
def test_the_distance_to_a_prism_with_a_hole_is_that_of_shapely(p, q):
    shapely = pytest.importorskip("shapely")
    area = shapely.Polygon(HALL.vertices, HALL.holes)
    scenario = sky.Scenario(
        name="hall",
        bounds=sky.Bounds(min=(0, 0, 0), max=(10, 10, 10)),
        obstacles=(HALL,),
        clearance=0.75,
        lattice=sky.Lattice(step=(1, 1, 1)),
    )
    compiled = sky.World(scenario)
    place = shapely.Point(p[:2])
    across = place.distance(area) or -place.distance(area.boundary)
    upright = max(HALL.low - p[2], p[2] - HALL.high)
    apart = max(across, upright) if min(across, upright) <= 0 else np.hypot(across, upright)
    assert compiled.distance(p)[0] == pytest.approx(apart, abs=1e-12)
    level = (*q[:2], 3.0)
    gap = shapely.LineString([(*p[:2],), level[:2]]).distance(area)
    assume(abs(gap - 0.75) > 1e-8)
    assert compiled.segments_free((*p[:2], 3.0), level)[0] == (gap > 0.75)


def test_what_is_in_the_way_is_named():
    scenario = sky.Scenario(
        name="named",
        bounds=sky.Bounds(min=(0, 0, 0), max=(10, 10, 10)),
        obstacles=(
            sky.Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=[[[1]], [[0]], [[1]]]),
            HALL.model_copy(update={"name": "Town hall", "kind": "building"}),
        ),
        clearance=0.25,
        lattice=sky.Lattice(step=(1, 1, 1)),
    )
    compiled = sky.World(scenario)
    assert compiled.why_unsafe((2.5, 0.5, 0.5)) == "lies inside obstacles[0] grown by the clearance of 0.25 m"
    assert "obstacles[1] ('Town hall', building)" in compiled.why_unsafe((5, 3, 3))
    assert compiled.why_unsafe((7.5, 3.5, 3)) is None  # in the hole


def test_the_pyramid_knows_the_least_and_the_greatest_height_of_every_block():
    heights = np.random.default_rng(3).uniform(0, 50, (14, 23))
    made = ground.make_ground(sky.Terrain(origin=(0, 0), step=(1, 1), heights=heights))
    for level, (first, rows, columns) in enumerate(made.levels):
        for i, j in itertools.product(range(rows), range(columns)) if level else ():
            block = heights[i << level : ((i + 1) << level) + 1, j << level : ((j + 1) << level) + 1]
            assert tuple(made.extremes[first + i * columns + j]) == (block.min(), block.max())
