import math

import numpy as np
import pytest

import skyverse as sky


def test_the_same_seed_makes_the_same_city_and_another_one_another():
    assert sky.random_city(50, seed=3, uavs=2) == sky.random_city(50, seed=3, uavs=2)
    assert sky.random_city(50, seed=3) != sky.random_city(50, seed=4)


@pytest.mark.parametrize("seed", range(5))
def test_everybody_starts_and_ends_in_the_open_and_on_opposite_sides(seed):
    city = sky.random_city(300, seed=seed, uavs=9)
    world, side = sky.World(city), city.bounds.max[0]
    starts = np.array([uav.start for uav in city.uavs])
    ends = np.array([target.position for target in city.targets])
    assert world.free(starts).all()
    assert world.free(ends).all()
    assert np.all(np.abs(starts - ends)[:, :2].max(axis=1) > 0.8 * side)


def test_heights_are_log_normal_and_density_is_kept():
    city = sky.random_city(20_000, seed=1)
    heights = np.array([box.max[2] for box in city.obstacles])
    assert np.median(heights) == pytest.approx(25, rel=0.03)
    assert np.log(heights).std() == pytest.approx(0.6, rel=0.03)
    assert city.bounds.max[0] == pytest.approx(2000 * 10**0.5, abs=1)


@pytest.mark.parametrize("seed", range(3))
def test_downtown_most_buildings_reach_the_ceiling_and_everybody_starts_and_ends_in_the_open(seed):
    city = sky.random_downtown(seed=seed, uavs=5)
    assert city == sky.random_downtown(seed=seed, uavs=5)
    side, ceiling = city.bounds.max[0], city.bounds.max[2]
    assert (side, ceiling, city.clearance) == (1500.0, 60.0, 2.0)
    sizes = np.array([np.subtract(box.max, box.min) for box in city.obstacles])
    assert len(sizes) == 1500
    assert 0.82 < np.mean(sizes[:, 2] >= ceiling) < 0.88
    assert 44.5 < sizes[:, :2].max() <= 45.0
    world = sky.World(city)
    assert world.free(np.array([uav.start for uav in city.uavs])).all()
    assert world.free(np.array([target.position for target in city.targets])).all()
    first = np.subtract(city.targets[0].position, city.uavs[0].start)
    assert np.all(first[:2] > 0.8 * side)


@pytest.mark.parametrize("buildings", [5, 20, 50, 100])
def test_small_downtowns_are_made_also_where_corners_are_built_up(buildings):
    for seed in range(20):
        city = sky.random_downtown(buildings, seed=seed, uavs=3)
        world, middle = sky.World(city), city.bounds.max[0] / 2
        starts = np.array([uav.start for uav in city.uavs])
        ends = np.array([target.position for target in city.targets])
        assert world.free(starts).all()
        assert world.free(ends).all()
        assert np.all(starts[0, :2] <= middle)
        assert np.all(ends[0, :2] >= middle)
        assert np.any((starts[:, :2] - middle) * (ends[:, :2] - middle) <= 0, axis=1).all()


def test_what_cannot_be_is_refused_in_one_sentence(refuses):
    with refuses():
        sky.random_city(-1)
    for name in ("side", "ceiling", "clearance"):
        for wrong in (-5, math.nan, math.inf, "x"):
            with refuses():
                sky.random_city(5, **{name: wrong})
    with refuses():
        sky.random_city(3000, side=100.0)
    with refuses():
        sky.random_downtown(True)
