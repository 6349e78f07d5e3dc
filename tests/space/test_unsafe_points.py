"""Starts and targets that are not safe, pads, and the regions in which free places are sought."""

import numpy as np
import pytest
from scipy import ndimage

import skyverse as sky
from skyverse.model.mission import Mission
from skyverse.planners.base import provenance
from skyverse.space.pads import fleet_pads, pads_sentence
from skyverse.space.unsafe_points import Regions, nearest_free, unsafe_points

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


ERROR = {"horizontal": 1.0, "vertical": 1.5}


def straying_at(start, target=(3, 3, 3), uav=None, **changes):
    return sky.Scenario.model_validate(
        {
            "name": "tube",
            "bounds": {"min": (0, 0, 0), "max": (20, 12, 12)},
            "clearance": 0.5,
            "lattice": {"step": (1, 1, 1)},
            "obstacles": [{"min": (9, 2, 6), "max": (15, 8, 12)}],
            "uavs": [{"start": start, "tracking_error": ERROR} | (uav or {})],
            "targets": [{"position": target}],
        }
        | changes
    )


def test_a_start_below_a_free_column_is_safe_but_not_for_an_aeroplane():
    assert unsafe_points(straying_at((3, 3, 0.2))) == []
    (bad,) = unsafe_points(straying_at((3, 3, 0.2), uav={"fixed_wing": {"speed": 3, "turn_radius": 3, "climb": 30}}))
    assert bad.field == "uavs[0].start"
    assert bad.reason.startswith("lies too near the bounds, (0, 0, 0) to (20, 12, 12), for the tracking error of 1 m")


def test_a_start_and_a_target_beside_or_below_what_does_not_end_above_are_told():
    start, target = unsafe_points(straying_at((12, 5, 5), target=(8.2, 5, 9)))
    assert start.field == "uavs[0].start"
    assert start.reason == (
        "is 2.51 m too near obstacles[0]: all but what it stands on must keep the tracking error of 1 m horizontally "
        "and 1.5 m vertically from its pad, 1 m about it and up to z = 6.51 m"
    )
    assert start.nearest == (12, 5, 4)
    assert target.field == "targets[0].position"


def test_a_start_too_near_a_wall_is_told_by_how_much_and_where_the_nearest_place_with_room_for_a_pad_is():
    given = straying_at((8.2, 5, 0.5), obstacles=(sky.Box(min=(9, 0, 0), max=(15, 12, 11)),))
    (bad,) = unsafe_points(given)
    assert bad.reason.startswith("is 1.2 m too near obstacles[0]: all but what it stands on")
    assert bad.nearest == (7.5, 5, 1.5)  # from where it may stray


def test_a_start_beside_steep_ground_is_told_so():
    terrain = {"origin": (0, 0), "step": (10, 12), "heights": [[0, 0], [0, 0], [30, 30]]}
    around = {"bounds": {"min": (0, 0, 0), "max": (20, 12, 60)}, "obstacles": ()}
    (within,) = unsafe_points(straying_at((8.6, 5, 0.5), terrain=terrain, **around))
    assert within.reason.startswith(
        "is too near ground that is steeper than 45 degrees: all but what it stands on must"
    )
    assert unsafe_points(straying_at((8.4, 5, 0.5), terrain=terrain, **around)) == []


def test_a_start_over_airspace_is_told_that_nobody_stands_on_it():
    zone = sky.Box(min=(0, 0, 0), max=(5, 5, 1), kind="no-fly zone", solid=False)
    (bad,) = unsafe_points(straying_at((3, 3, 1.5), obstacles=(zone,)))
    assert bad.reason.startswith("is 1.5 m too near obstacles[0] (no-fly zone): all but what it stands on must keep")


WING = {"speed": 3, "turn_radius": 3, "climb": 30}


def fleet(*uavs):
    return sky.Scenario.model_validate(
        {
            "name": "pads",
            "bounds": {"min": (0, 0, 0), "max": (40, 12, 12)},
            "clearance": 0.5,
            "lattice": {"step": (1, 1, 1)},
            "uavs": uavs,
            "targets": [{"position": (20, 6, 0.25)}, {"position": (20, 6, 6)}],
        }
    )


def told(given, assignment):
    nothing = (None,) * len(given.uavs)
    mission = Mission(given, tuple(assignment), nothing, nothing, (), provenance("nobody", None, None))
    return pads_sentence(given, fleet_pads(mission))


def straying(x, **changes):
    return {"start": (x, 6, 0.5), "tracking_error": ERROR} | changes


def test_pads_at_starts_and_targets_are_named_with_their_tops():
    given = fleet(straying(3), {"start": (6, 6, 0.5)}, straying(9, fixed_wing=WING), straying(12))
    assert told(given, (0, None, None, 1)) == (
        "On the pads at starts and targets the tracking error does not count for the ground and roofs below: "
        "of uav-1 at its start up to z = 2.01 m and at its target up to z = 1.76 m; "
        "of uav-4 at its start up to z = 2.01 m."
    )


def test_of_large_fleets_the_first_pads_are_named_and_the_others_counted():
    given = fleet(*(straying(x) for x in range(3, 33, 3)))
    assert told(given, (None,) * 10).endswith("of uav-3 at its start up to z = 2.01 m; and of 7 more UAVs.")
    four = fleet(*(straying(x) for x in range(3, 15, 3)))
    assert told(four, (None,) * 4).endswith("; and of 1 more UAV.")


def test_without_lifts_nothing_is_said():
    assert told(fleet({"start": (3, 6, 0.5)}), (0,)) == ""
    assert told(fleet(straying(3, start=(3, 6, 6))), (1,)) == ""


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
