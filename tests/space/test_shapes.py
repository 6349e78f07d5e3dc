"""Points, segments and boxes against obstacles of all shapes: brute force, dense sampling, and shapely."""

import itertools

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.shapes import Box, Cylinder, Prism, Sphere, Terrain, Voxels
from skyverse.space import ground, obstacles, voxels
from skyverse.space.lattice import make_grid, positions

HALL = Prism(
    vertices=((2, 2), (9, 2), (9, 8), (6, 8), (6, 5), (2, 7)), holes=(((7, 3), (8, 3), (8, 4), (7, 4)),), low=1, high=6
)
HILLS = Terrain(
    origin=(0, 0), step=(2.5, 4), heights=[[0, 2, 1, 3], [3, 0, 1, 0], [1, 4, 0, 2], [0, 1, 3, 1], [2, 2, 2, 0]]
)

coordinate = st.one_of(st.integers(0, 20).map(lambda n: n / 2), st.floats(0, 10))
points = st.tuples(coordinate, coordinate, coordinate)


@st.composite
def shapes(draw):
    kind = draw(st.integers(0, 4))
    centre = tuple(draw(st.integers(0, 10)) for _ in range(3))
    low = draw(st.integers(0, 6))
    high = low + draw(st.integers(1, 4))
    if kind == 0:
        return Box(min=centre, max=tuple(c + draw(st.integers(1, 4)) for c in centre))
    if kind == 1:
        return Sphere(centre=centre, radius=draw(st.sampled_from([0.5, 1, 2.5])))
    if kind == 2:
        return Cylinder(centre=centre[:2], radius=draw(st.sampled_from([0.5, 1, 2.5])), low=low, high=high)
    if kind == 3:
        return HALL.model_copy(update={"low": float(low), "high": float(high)})
    cells = draw(st.lists(st.booleans(), min_size=27, max_size=27))
    return Voxels(origin=centre, step=(1, 0.5, 2), occupied=np.reshape(cells, (3, 3, 3)))


@st.composite
def worlds(draw):
    terrain = draw(st.sampled_from([None, HILLS, HILLS.model_copy(update={"clearance": 1.5})]))
    return sky.Scenario(
        name="shapes",
        bounds=sky.Bounds(min=(0, 0, 0), max=(10, 12, 10)),
        obstacles=tuple(draw(st.lists(shapes(), max_size=3))),
        terrain=terrain,
        max_height=None if terrain is None else draw(st.sampled_from([None, 2.5, 6.0])),
        clearance=draw(st.sampled_from([0.001, 0.5, 1.0])),
        lattice=sky.Lattice(step=draw(st.sampled_from([(1, 1, 1), (2.5, 3, 2)])), connectivity=26),
    )


def outside_polygon(prism, at):
    """Distance from places (n, 2) to a polygon, 0 inside, and to its outline: by NumPy, edge by edge."""
    odd, least = np.zeros(len(at), bool), np.full(len(at), np.inf)
    for ring in (prism.vertices, *prism.holes):
        for a, b in zip(np.array(ring, float), np.roll(np.array(ring, float), -1, axis=0), strict=True):
            t = np.clip((at - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
            least = np.minimum(least, np.linalg.norm(a + t[:, None] * (b - a) - at, axis=1))
            spans = (a[1] > at[:, 1]) != (b[1] > at[:, 1])
            with np.errstate(divide="ignore", invalid="ignore"):
                odd ^= spans & (a[0] + (at[:, 1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) > at[:, 0])
    return np.where(odd, 0.0, least), least


def z_of_ground(terrain, at):
    """Bilinear heights at places (n, 2)."""
    u, v = ((at - terrain.origin) / terrain.step).T
    i = np.clip(np.floor(u).astype(int), 0, terrain.heights.shape[0] - 2)
    j = np.clip(np.floor(v).astype(int), 0, terrain.heights.shape[1] - 2)
    u, v, h = u - i, v - j, terrain.heights
    return (h[i, j] * (1 - u) + h[i + 1, j] * u) * (1 - v) + (h[i, j + 1] * (1 - u) + h[i + 1, j + 1] * u) * v


def depth(scenario, at, growth=None):
    """How deep (n, 3) points are inside grown obstacles: the largest over all shapes, below 0 outside."""
    c = scenario.clearance if growth is None else growth
    deepest = np.full(len(at), -np.inf)
    for shape in scenario.obstacles:
        if isinstance(shape, Sphere):
            d = shape.radius + c - np.linalg.norm(at - shape.centre, axis=1)
        elif isinstance(shape, Cylinder | Prism):
            upright = np.minimum(at[:, 2] - shape.low, shape.high - at[:, 2]) + c
            if isinstance(shape, Cylinder):
                across = shape.radius + c - np.linalg.norm(at[:, :2] - shape.centre, axis=1)
            else:
                out, edge = outside_polygon(shape, at[:, :2])
                across = np.where(out == 0, edge, -out) + c
            d = np.minimum(across, upright)
        else:
            boxes = [(shape.min, shape.max)] if isinstance(shape, Box) else cells_of(shape)
            d = np.full(len(at), -np.inf)
            for low, high in boxes:
                d = np.maximum(d, np.min(np.minimum(at - low, np.array(high) - at), axis=1) + c)
            if isinstance(shape, Voxels) and c == 0:
                d[within(shape, at)] = np.inf
        deepest = np.maximum(deepest, d)
    if scenario.terrain is not None:
        margin = scenario.ground_clearance + c - scenario.clearance
        deepest = np.maximum(deepest, z_of_ground(scenario.terrain, at[:, :2]) + margin - at[:, 2])
    if scenario.max_height is not None:
        lowered = scenario.max_height - (c - scenario.clearance)
        deepest = np.maximum(deepest, at[:, 2] - z_of_ground(scenario.terrain, at[:, :2]) - lowered)
    return deepest


def beyond(scenario, at):
    """How far points (n, 3) are out of bounds; negative inside."""
    return np.max(np.maximum(scenario.bounds.min - at, at - scenario.bounds.max), axis=1)


def cells_of(shape):
    at = np.argwhere(shape.occupied)
    return [(np.array(shape.origin) + i * shape.step, np.array(shape.origin) + (i + 1) * shape.step) for i in at]


def within(shape, at):
    """Which places (n, 3) have occupied cells on all sides: no border between two cells is open."""
    filled = np.pad(shape.occupied, 2)
    sides = itertools.product((-1e-9, 1e-9), repeat=3)
    cells = [np.floor((at - shape.origin + side) / shape.step).astype(int) for side in sides]
    return np.all([filled[tuple(np.clip(cell, -1, shape.occupied.shape).T + 2)] for cell in cells], axis=0)


def along(a, b, n=2001):
    return np.array(a, float) + np.linspace(0, 1, n)[:, None] * (np.array(b, float) - a)


@settings(max_examples=60)
@given(worlds(), st.lists(points, min_size=1, max_size=8))
def test_a_point_is_free_outside_of_all_grown_obstacles(scenario, at):
    at = np.array(at)
    deep, free = depth(scenario, at), sky.World(scenario).free(at)
    assert not free[deep > 6e-7].any()
    assert free[deep < 1e-12].all()  # on the surface is safe
    for p, safe in zip(at, free, strict=True):
        assert (sky.World(scenario).why_unsafe(p) is None) == safe


@settings(max_examples=60)
@given(worlds(), points, points)
def test_a_free_segment_has_free_points_only_and_an_unsafe_point_blocks_a_segment(scenario, a, b):
    compiled = sky.World(scenario)
    deep = depth(scenario, along(a, b))
    free = bool(compiled.segments_free(a, b)[0])
    if deep.max() > 6e-7:
        assert not free
    if free:
        assert compiled.free(along(a, b, 101)).all()
    # between samples it can be deeper by what a sample's step adds, on slopes of at most 3.3
    if deep.max() < -np.linalg.norm(np.subtract(b, a)) / 2000 * 3.5 - 1e-8:
        assert free


@settings(max_examples=60)
@given(worlds(), points, points, st.sampled_from([0.0, 0.3]), st.integers(0, 1000))
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
        assert (depth(scenario, near, 0.25) < 1e-8).all()
    if dev == 0.0:
        assert swept == obstacles.crosses(space, margin, a, b)


@settings(max_examples=60)
@given(worlds(), points, points, st.sampled_from([0.0, 0.5]))
def test_a_box_that_no_obstacle_meets_holds_no_unsafe_point(scenario, a, b, growth):
    low, high = np.minimum(a, b), np.maximum(a, b)
    assume((high > low).all())
    space = sky.World(scenario).space
    inside = low + (high - low) * np.array(list(itertools.product(np.linspace(0.01, 0.99, 12), repeat=3)))
    deep = depth(scenario, inside, growth).max()
    corners = np.hstack((space.boxes[:, :3] - growth - high, low - growth - space.boxes[:, 3:]))
    meets = bool(np.all(corners < -1e-9, axis=1).any())
    meets |= obstacles.shapes_reach(space, growth - space.clearance, low, high)
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
    boxes = voxels.merged(Voxels(origin=(1, 2, 3), step=(1, 2, 0.5), occupied=occupied))
    filled = np.zeros((3, 4, 5), int)
    for row in boxes:
        first, last = (np.rint((corner - (1, 2, 3)) / (1, 2, 0.5)).astype(int) for corner in (row[:3], row[3:]))
        filled[tuple(slice(f, z) for f, z in zip(first, last, strict=True))] += 1
    np.testing.assert_array_equal(filled, occupied)


def test_a_full_block_of_voxels_is_one_box():
    assert len(voxels.merged(Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=np.ones((7, 5, 3))))) == 1


@settings(max_examples=60)
@given(points, points)
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


def test_along_walls_at_exactly_the_clearance_is_safe():
    for clearance, wall in ((0.001, 1.999), (0.5, 1.5)):
        scenario = sky.Scenario(
            name="wall",
            bounds=sky.Bounds(min=(0, 0, 0), max=(10, 10, 10)),
            obstacles=(HALL, Cylinder(centre=(4, 9), radius=0.5, low=0, high=9), Sphere(centre=(1, 8, 5), radius=0.5)),
            terrain=Terrain(origin=(0, 0), step=(10, 10), heights=[[0, 0], [1, 1]]),
            clearance=clearance,
            lattice=sky.Lattice(step=(1, 1, 1)),
        )
        compiled = sky.World(scenario)
        assert compiled.segments_free((1.5, wall, 3), (10, wall, 3))[0]
        assert not compiled.segments_free((1.5, wall + 1e-6, 3), (10, wall + 1e-6, 3))[0]
        assert compiled.segments_free((0, 0, clearance), (10, 0.5, 1 + clearance))[0]
        assert not compiled.segments_free((0, 0, clearance), (10, 0.5, 1 + clearance - 1e-6))[0]
        edge = 4.5 + clearance
        assert compiled.segments_free((edge, 8, 7), (edge, 10, 7))[0]
        top = 5.5 + clearance
        assert compiled.segments_free((0, 8, top), (2, 8, top))[0]
        assert not compiled.segments_free((0, 8, top - 1e-6), (2, 8, top - 1e-6))[0]


def test_a_dip_between_two_safe_ends_is_found_in_closed_form():
    saddle = Terrain(origin=(0, 0), step=(10, 10), heights=[[0, 4], [4, 0]], clearance=0.001)
    scenario = sky.Scenario(
        name="saddle",
        bounds=sky.Bounds(min=(0, 0, -5), max=(10, 10, 10)),
        terrain=saddle,
        clearance=0.001,
        lattice=sky.Lattice(step=(1, 1, 1)),
    )
    compiled = sky.World(scenario)
    assert compiled.segments_free((0, 0, 2.001), (10, 10, 2.001))[0]  # the ground is 2 m high in the middle
    assert not compiled.segments_free((0, 0, 2.001 - 1e-6), (10, 10, 2.001 - 1e-6))[0]
    assert compiled.why_unsafe((5, 5, 1)) == "lies -1 m above ground, but 0.001 m are required"


def test_what_is_in_the_way_is_named():
    scenario = sky.Scenario(
        name="named",
        bounds=sky.Bounds(min=(0, 0, 0), max=(10, 10, 10)),
        obstacles=(
            Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=[[[1]], [[0]], [[1]]]),
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
    made = ground.make_ground(Terrain(origin=(0, 0), step=(1, 1), heights=heights))
    for level, (first, rows, columns) in enumerate(made.levels):
        for i, j in itertools.product(range(rows), range(columns)) if level else ():
            block = heights[i << level : ((i + 1) << level) + 1, j << level : ((j + 1) << level) + 1]
            assert tuple(made.extremes[first + i * columns + j]) == (block.min(), block.max())
