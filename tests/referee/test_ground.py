"""The ground: how steep the referee takes it to be, and that no peak and no lowest instant escapes it."""

import numpy as np
import pytest

import skyverse as sky
from judged_clearance import judged, legs, of, verdict, world
from skyverse.model.quantities import derived
from skyverse.referee.ground import ceiling_above_ground, grown_ground

EPS = float(np.finfo(float).eps)


def on(terrain):
    """Return a terrain as the referee's ground, with the least clearance."""
    return grown_ground(derived(world(clearance=0.001), terrain=terrain))


def test_the_slope_is_the_sum_of_the_steepest_along_both_axes():
    terrain = sky.Terrain(origin=(0, 0), step=(5.0, 4.0), heights=[[0, 0, 0, 0], [1, 1, 1, 1], [1, 1, 2, 3]])
    scenario = world(terrain=terrain).model_copy(update={"max_height": 5.0})
    ground, ceiling = grown_ground(scenario), ceiling_above_ground(scenario)
    assert ground.slope == pytest.approx(2 / 5 + 1 / 4)
    assert ceiling.upside_down.slope == ground.slope


def test_the_greatest_heights_are_those_of_squares_of_cells_of_all_sizes():
    heights = np.random.default_rng(0).uniform(0, 9, (12, 14))
    ground = grown_ground(world(terrain=sky.Terrain(origin=(0, 0), step=(1.0, 1.0), heights=heights)))
    assert [squares.shape for squares in ground.highest] == [(11, 13), (6, 7), (3, 4), (2, 2), (1, 1)]
    for k, squares in enumerate(ground.highest):
        for i, j in np.ndindex(squares.shape):
            nodes = (slice(n << k, (n + 1 << k) + 1) for n in (i, j))
            assert squares[i, j] == heights[tuple(nodes)].max()


@pytest.mark.parametrize("below", [5e-6, 0.5])
def test_a_place_over_low_ground_is_above_it_however_little_it_is_below_the_highest_around(below):
    heights = np.zeros((4, 4))
    heights[1, 1] = 2.0
    ground = on(sky.Terrain(origin=(0, 0), step=(1.0, 1.0), heights=heights))
    depth = ground.depth(np.array([[[1.9, 1.9, 2.001 - below]]]), np.array([0]))[0]
    assert depth == pytest.approx(0.02 - 2 + below, abs=1e-5)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("cells", [1, 2, 3, 4])
def test_a_part_over_some_cells_is_no_less_deep_than_below_the_peak_in_the_last(cells, axis):
    heights = np.zeros((6, 6))
    heights[cells] = 2.0
    ground = on(sky.Terrain(origin=(0, 0), step=(1.0, 1.0), heights=heights if axis == 0 else heights.T))
    part = np.array([[[0.5, 0.5, 1.0], [0.5, 0.5, 1.0]]])
    part[0, 1, axis] = cells - 0.1
    assert ground.depth(part, np.array([0]))[0] >= 0.8


@pytest.mark.parametrize("size", [1.0, 1e3, 1e6])
@pytest.mark.parametrize("count", [1, 2, 6])
def test_rounding_errors_of_depths_are_bounded_from_both_sides(size, count):
    ground = on(sky.Terrain(origin=(0, 0), step=(1.0, 1.0), heights=np.zeros((3, 3))))
    bound = float(ground.error(np.full((1, count, 3), size), np.zeros(1))[0])
    assert (45 * count + 64) * EPS * size <= bound <= (90 * count + 200) * EPS * size
    assert float(ground.error(np.zeros((1, count, 3)), np.full(1, 1e-3))[0]) == pytest.approx(1e-3)


def test_the_steepest_slope_about_a_place_is_that_of_the_cells_nearer_than_the_radius():
    rng = np.random.default_rng(3)
    heights, step = rng.uniform(0, 3, (9, 7)), np.array([1.5, 0.8])
    ground = on(sky.Terrain(origin=(-2, 1), step=tuple(step), heights=heights))
    i, j = np.meshgrid(np.arange(8), np.arange(6), indexing="ij")
    corner = np.array([-2, 1]) + np.stack([i, j], axis=-1) * step
    for _ in range(200):
        place, radius = rng.uniform((-2, 1), (10, 5.8)), rng.uniform(0, 4)
        nearest = np.clip(place, corner, corner + step)
        some = np.argwhere(np.hypot(*np.moveaxis(nearest - place, -1, 0)) < radius)
        expected = 0.0
        for a, b in some:
            h = heights[a : a + 2, b : b + 2]
            east, north = np.abs(h[1] - h[0]).max() / step[0], np.abs(h[:, 1] - h[:, 0]).max() / step[1]
            expected = max(expected, np.hypot(east, north))
        assert ground.steepest_about(place, radius) == pytest.approx(expected)


def test_the_greatest_height_around_some_cells_is_not_below_that_of_any_of_them():
    heights = np.random.default_rng(1).uniform(0, 9, (12, 14))
    ground = on(sky.Terrain(origin=(0, 0), step=(1.0, 1.0), heights=heights))
    for k in np.ndindex(11, 11):
        first, last = np.sort(np.array([k, np.random.default_rng(k).integers(0, 11, 2)]), axis=0)
        greatest = heights[first[0] : last[0] + 2, first[1] : last[1] + 2].max()
        assert ground._highest_around(first[None], last[None])[0] >= greatest


def test_a_ceiling_asks_for_no_clearance():
    terrain = sky.Terrain(origin=(0, 0), step=(5.0, 5.0), heights=np.zeros((3, 3)), clearance=3.0)
    ceiling = ceiling_above_ground(world(terrain=terrain, clearance=2.0).model_copy(update={"max_height": 7.0}))
    assert ceiling.clearance == 0.0
    assert ceiling.depth(np.array([[[4.0, 4.0, 7.5]]]), np.array([0]))[0] == pytest.approx(0.5, abs=1e-5)


@pytest.mark.parametrize("seed", range(8))
def test_no_peak_below_a_leg_escapes_however_many_cells_it_crosses(seed):
    """Legs that keep, or miss by a centimetre, what must be kept above the highest of many samples."""
    rng = np.random.default_rng(seed)
    terrain = sky.Terrain(origin=(0, 0), step=(1, 1), heights=3.0 * (rng.random((11, 11)) < 0.2), clearance=0.1)
    scenario = world(terrain=terrain)
    for a in rng.uniform(0, 10, (12, 2)):
        b = np.clip(a + rng.uniform(-2.5, 2.5, 2), 0, 10)
        highest = terrain.height(np.linspace(a, b, 2001)).max()
        for above, expected in ((0.09, "refuted"), (0.11, "proven")):
            z = highest + above
            assert verdict(legs(scenario, (*a, z), (*b, z))) == expected


@pytest.mark.parametrize("seed", range(20))
def test_the_lowest_instant_is_found_to_a_nanometre(seed):
    when, bend = np.random.default_rng(seed).uniform((0.1, 1), (0.9, 40))
    flat = world(terrain=sky.Terrain(origin=(0, 0), step=(10, 10), heights=np.zeros((2, 2)), clearance=0.5))
    dips = of([0, 1], [[(1, 1, 0.1 + bend * when**2), (7, 5, -2 * bend * when), (0, 0, bend)]])
    assert 0 <= judged(flat, dips).incursion.gap - 0.1 <= 1.1e-9
