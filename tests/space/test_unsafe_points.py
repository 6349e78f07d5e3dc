"""Starts and targets that are not safe: all are named, with the roof's height and a free place that is near."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.space.unsafe_points import nearest_free, unsafe_points

TOWN = sky.Scenario(
    name="town",
    bounds=sky.Bounds(min=(0, 0, 0), max=(20, 20, 10)),
    obstacles=(
        sky.Box(min=(4, 4, 0), max=(8, 8, 6), name="Tower", kind="building"),
        sky.Prism(vertices=((12, 4), (16, 8), (12, 12)), low=0, high=9),
        sky.Sphere(centre=(5, 15, 5), radius=2),
        sky.Cylinder(centre=(15, 15), radius=2, low=0, high=8.5),
        sky.Voxels(origin=(9, 0, 0), step=(1, 1, 1), occupied=np.ones((2, 2, 3), dtype=bool)),
    ),
    clearance=0.5,
    lattice=sky.Lattice(step=(1, 1, 1)),
)


def with_starts(scenario, *starts):
    return scenario.model_copy(update={"uavs": tuple(sky.UAV(name=f"u{i}", start=p) for i, p in enumerate(starts))})


def test_all_unsafe_points_are_named_in_order_and_safe_ones_are_not():
    scenario = with_starts(TOWN, (6, 6, 2), (1, 1, 1), (13, 8, 3)).model_copy(
        update={"targets": (sky.Target(name="t", position=(25, 5, 5)), sky.Target(name="v", position=(18, 2, 5)))}
    )
    found = unsafe_points(scenario)
    assert [(point.field, point.name) for point in found] == [
        ("uavs[0].start", "u0"),
        ("uavs[2].start", "u2"),
        ("targets[0].position", "t"),
    ]
    assert found[0].sentence == (
        "uavs[0].start (u0): expected a safe point, found (6, 6, 2), which lies inside obstacles[0] ('Tower', "
        "building) grown by the clearance of 0.5 m; the roof is at z = 6 m there; the nearest free place is "
        "(8.5, 6, 2), 2.5 m away"
    )
    assert found[2].nearest == (20, 5, 5)
    assert unsafe_points(with_starts(TOWN, (1, 1, 1))) == []


@pytest.mark.parametrize(
    ("point", "roof"),
    [((6, 6, 2), 6), ((13, 8, 3), 9), ((5, 15, 5), 7), ((15, 15, 1), 8.5), ((10, 1, 1), 3), ((8.7, 0.5, 1), 3)],
)
def test_the_roof_of_every_shape_is_told(point, roof):
    (found,) = unsafe_points(with_starts(TOWN, point))
    assert f"the roof is at z = {roof} m there" in found.reason


def test_the_roof_is_told_above_the_sea_where_the_frame_is_on_earth():
    origin = sky.Origin(latitude=46.8, longitude=9.8, altitude=1500)
    scenario = with_starts(TOWN.model_copy(update={"frame": sky.Frame(origin=origin)}), (6, 6, 2))
    (found,) = unsafe_points(scenario)
    assert "the roof is at z = 6 m (1506.0 m amsl) there" in found.reason
    assert "the nearest free place is (8.5, 6, 2) or 46.8000540,9.8001113,1502.00 m amsl, 2.5 m away" in found.advice


@pytest.mark.parametrize("seed", range(5))
def test_the_nearest_free_place_is_free_and_hardly_any_other_is_nearer(seed):
    rng = np.random.default_rng(seed)
    world = sky.World(TOWN)
    points = rng.uniform((-3, -3, -3), (23, 23, 13), (200, 3))
    near = rng.normal(size=(4000, 3))
    near *= (rng.uniform(0, 6, 4000) / np.linalg.norm(near, axis=1))[:, None]
    for point in points[~world.free(points)][:25]:
        place = nearest_free(world, tuple(point))
        assert world.free(place)[0]
        away = np.linalg.norm(np.subtract(place, point))
        others = near[world.free(point + near)]
        assert away <= 1.03 * np.linalg.norm(others, axis=1).min(initial=99) + 0.02
        assert np.allclose(np.round(place, 2), place)


def test_under_the_ground_the_place_above_it_is_told():
    ground = sky.Terrain(origin=(0, 0), step=(10, 10), heights=[[2, 2, 2], [4, 4, 4], [2, 2, 2]], clearance=1.0)
    scenario = with_starts(TOWN.model_copy(update={"terrain": ground, "obstacles": ()}), (2, 2, 1))
    (found,) = unsafe_points(scenario)
    assert "lies -1.4 m above ground, but 1 m are required" in found.reason
    assert found.nearest is not None
    assert sky.World(scenario).free(found.nearest)[0]
    assert 2.3 < np.linalg.norm(np.subtract(found.nearest, found.position)) <= 2.41


def test_where_no_place_is_free_that_is_said():
    full = TOWN.model_copy(update={"obstacles": (sky.Box(min=(-9, -9, -9), max=(30, 30, 30)),)})
    (found,) = unsafe_points(with_starts(full, (5, 5, 5)))
    assert found.nearest is None
    assert found.sentence.endswith("; no place within the bounds is free")


def test_a_place_just_inside_a_surface_is_moved_by_a_centimetre_or_less():
    (found,) = unsafe_points(with_starts(TOWN, (3.5 + 1e-5, 6, 2)))
    assert found.nearest == (3.5, 6, 2)


def test_over_an_obstacle_that_is_closed_above_no_place_is_told():
    shut = TOWN.obstacles[0].model_copy(update={"closed_above": True})
    (found,) = unsafe_points(with_starts(TOWN.model_copy(update={"obstacles": (shut,)}), (6, 6, 8)))
    assert found.reason.endswith("; it is closed above, so that no place above it is free")
    assert found.nearest == (8.5, 6, 8)


def test_under_a_ceiling_that_follows_the_ground_the_place_below_it_is_told():
    ground = sky.Terrain(origin=(0, 0), step=(10, 10), heights=[[0, 0, 0], [2, 2, 2], [0, 0, 0]])
    low = TOWN.model_copy(update={"terrain": ground, "obstacles": (), "max_height": 5.0})
    (found,) = unsafe_points(with_starts(low, (10, 10, 9)))
    assert sky.World(low).free(found.nearest)[0]
    assert 6.9 < found.nearest[2] <= 7


def test_a_place_is_called_the_nearest_only_where_no_uav_has_a_tracking_error():
    exact = with_starts(TOWN, (6, 6, 2))
    straying = exact.uavs[0].model_copy(update={"tracking_error": sky.TrackingError(horizontal=0.3, vertical=0.3)})
    (found,) = unsafe_points(exact)
    assert "; the nearest free place is (" in found.sentence
    (found,) = unsafe_points(exact.model_copy(update={"uavs": (straying,)}))
    assert "; a free place is (" in found.sentence
