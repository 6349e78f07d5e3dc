"""Regions of free space against a flood fill by SciPy, and free places that a UAV can fly to."""

import numpy as np
import pytest
from scipy import ndimage

import skyverse as sky
from skyverse.space.regions import Regions
from skyverse.space.unsafe_points import unsafe_points


def cave(seed, start=None, target=None):
    """Voxels of 1 m, a third of them occupied, with many pockets; the clearance leaves the middle of each free."""
    rng = np.random.default_rng(seed)
    occupied = rng.random((14, 14, 8)) < 0.62
    occupied[:3] = False  # a hall, which is the region of most starts
    places = [] if start is None else [{"start": start}]
    return sky.Scenario(
        name="cave",
        bounds={"min": (0, 0, 0), "max": (14, 14, 8)},
        obstacles=[sky.Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=occupied)],
        clearance=0.25,
        lattice={"step": (0.5, 0.5, 0.5)},
        uavs=places,
        targets=[] if target is None else [{"position": target}],
    )


@pytest.mark.parametrize("seed", range(3))
def test_regions_are_those_of_a_flood_fill(seed):
    scenario = cave(seed)
    world, middles = sky.World(scenario), np.argwhere(~scenario.obstacles[0].occupied)
    filled, _ = ndimage.label(~scenario.obstacles[0].occupied)  # faces join voxels: a gap of 1 m is wide enough
    regions = Regions(world, scenario.lattice)
    rng = np.random.default_rng(seed)
    for one, other in rng.integers(0, len(middles), (200, 2)):
        a, b = middles[one], middles[other]
        joined = filled[tuple(a)] == filled[tuple(b)]
        assert bool(regions.of([a + 0.5]) & regions.of([b + 0.5])) == joined
        assert regions.hold(b[None] + 0.5, regions.of([a + 0.5]))[0] == joined


@pytest.mark.parametrize("seed", range(3))
def test_free_places_for_targets_can_be_flown_to_from_the_start(seed):
    rng, count = np.random.default_rng(seed), 0
    occupied = cave(seed).obstacles[0].occupied
    filled, _ = ndimage.label(~occupied)
    for cell in rng.permutation(np.argwhere(occupied))[:40]:
        given = cave(seed, (1.5, 7.5, 4.5), tuple((cell + 0.5).tolist()))
        (found,) = unsafe_points(given)
        place = np.floor(found.nearest).astype(int)
        assert filled[tuple(place)] == filled[1, 7, 4]
        plain = unsafe_points(given.model_copy(update={"uavs": (), "targets": given.targets}))[0].nearest
        count += filled[tuple(np.floor(plain).astype(int))] != filled[1, 7, 4]
    assert count == 0  # without a start, the largest region is meant


def test_where_a_start_is_in_a_pocket_so_is_the_place_for_its_target():
    walls = [sky.Box(min=(5, 0, 0), max=(6, 10, 10)), sky.Box(min=(8.9, 4, 4), max=(9.2, 5, 5))]
    scenario = sky.Scenario(
        name="two rooms",
        bounds={"min": (0, 0, 0), "max": (10, 10, 10)},
        obstacles=walls,
        clearance=0.2,
        lattice={"step": (0.5, 0.5, 0.5)},
        uavs=[{"start": (2, 5, 5)}],
        targets=[{"position": (5.9, 5, 5)}],
    )
    (found,) = unsafe_points(scenario)
    assert found.nearest[0] < 5
    turned = scenario.model_copy(update={"uavs": (sky.UAV(start=(8, 8, 8)),)})
    assert unsafe_points(turned)[0].nearest[0] > 6
