"""Terrain, shapes by kind, map and profiles: what is drawn, as data."""

import dataclasses
import itertools
import json
import re
from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.draw import (
    KINDS,
    MAP_MARGIN,
    MAX_SPACE_HEIGHTS,
    Relief,
    along,
    below,
    cleared,
    coarser,
    contours,
    faces,
    flight_table,
    footprint,
    from_above,
    from_the_side,
    legend_entries,
    page,
    relief,
    scenario_scene,
    scene,
    scene_data,
    spacing,
    span,
    surface,
    tinted,
    touching,
    trajectories,
    triangles,
    turned,
    united,
)
from skyverse.draw import shape_kinds as kinds_module
from skyverse.maps.readers.cityjson import KIND_OF_TYPE
from skyverse.model.shape_extent import extent
from towns import buildings, hills, rectangle, town, with_terrain
from traces import area, columns, enclosed, numbers, of_role


def area_of(points, cut):
    u, v = points[cut[:, 1]] - points[cut[:, 0]], points[cut[:, 2]] - points[cut[:, 0]]
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


# ---- polygons ----
@given(st.integers(0, 2**32 - 1))
def test_triangles_cover_a_polygon_with_holes_exactly_once(seed):
    geometry = pytest.importorskip("shapely.geometry", reason='shapely is not installed; pip install "skyverse[maps]"')
    rng = np.random.default_rng(seed)

    def star(count, least, most):
        turn = np.sort(rng.uniform(0, 2 * np.pi, count))
        return rng.uniform(least, most, count)[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])

    polygon = geometry.Polygon(star(rng.integers(3, 40), 1.0, 10.0))
    for _ in range(rng.integers(0, 6)):
        hole = geometry.Polygon(rng.uniform(-8, 8, 2) + star(rng.integers(3, 12), 0.2, 1.5))
        clear = all(geometry.Polygon(other).distance(hole) > 1e-6 for other in polygon.interiors)
        if hole.is_valid and clear and polygon.contains(hole) and polygon.exterior.distance(hole) > 1e-6:
            polygon = geometry.Polygon(polygon.exterior, [*polygon.interiors, hole.exterior])
    rings = [np.array(ring.coords)[:-1] for ring in (polygon.exterior, *polygon.interiors)]
    rings = [turned(ring, 1 if k == 0 else -1) for k, ring in enumerate(rings)]
    cut = triangles(rings)
    areas = area_of(np.concatenate(rings), cut) / 2
    assert len(cut) == sum(map(len, rings)) + 2 * (len(rings) - 1) - 2
    assert areas.min() > -1e-9 * polygon.area
    assert np.abs(areas).sum() == pytest.approx(polygon.area, rel=1e-9)


def test_holes_in_rows_and_columns_are_left_out():
    outer = np.array([(0, 0), (20, 0), (20, 20), (0, 20)], dtype=float)
    square = np.array([(0, 0), (0, 1), (1, 1), (1, 0)], dtype=float)
    holes = [square + np.array((x, y)) for x in range(1, 19, 2) for y in range(1, 19, 2)]
    rings = [outer, *holes]
    assert np.abs(area_of(np.concatenate(rings), triangles(rings))).sum() / 2 == pytest.approx(400 - len(holes))


# ---- shapes ----
OCCUPIED = np.zeros((4, 3, 2), dtype=bool)
OCCUPIED[0, 0] = OCCUPIED[1:3, 1, 0] = True
SHAPES = [
    (sky.Box(min=(0, 0, 0), max=(2, 3, 4)), 24.0),
    (sky.Cylinder(centre=(1, 2), radius=3, low=-1, high=2), np.pi * 27),
    (sky.Sphere(centre=(1, 2, 3), radius=2), 4 / 3 * np.pi * 8),
    (sky.Prism(vertices=rectangle((3, 4), 8, 6, 0.7), holes=(rectangle((3, 4), 2, 2, 0.2),), low=1, high=3), 88.0),
    (sky.Voxels(origin=(1, 1, 1), step=(1, 2, 3), occupied=OCCUPIED), 24.0),
]


@pytest.mark.parametrize(("shape", "volume"), SHAPES, ids=lambda value: getattr(value, "shape", ""))
def test_a_surface_encloses_the_shapes_volume(shape, volume):
    points, cut = surface(shape)
    assert enclosed(points, cut) == pytest.approx(volume, rel=0.02)
    low, high = extent(shape)
    assert np.all(points >= low - 1e-9)
    assert np.all(points <= high + 1e-9)
    polygons = faces(shape)
    assert np.concatenate(polygons).min(axis=0) == pytest.approx(points.min(axis=0))


def test_voxels_have_faces_only_between_occupied_and_free():
    occupied = np.ones((5, 4, 3), dtype=bool)
    made = surface(sky.Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=occupied))
    assert area(*made) == pytest.approx(2 * (20 + 15 + 12))


def test_coarser_voxels_cover_all_that_was_occupied():
    occupied = np.random.default_rng(1).random((17, 9, 8)) < 0.1
    fine = sky.Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=occupied)
    coarse = coarser(fine, 300)
    assert len(surface(coarse)[1]) <= 300
    centres = np.argwhere(occupied) + 0.5
    cells = (centres / coarse.step).astype(int)
    assert coarse.occupied[tuple(cells.T)].all()


def test_spans_are_what_stands_over_a_place():
    places = np.array([(1.0, 2.0), (2.5, 2.0), (50.0, 2.0)])
    np.testing.assert_allclose(span(SHAPES[2][0], places)[0], (1, 5))
    np.testing.assert_allclose(span(SHAPES[2][0], places)[1], 3 + np.sqrt(4 - 1.5**2) * np.array((-1, 1)))
    assert np.isnan(span(SHAPES[2][0], places)[2]).all()
    prism = SHAPES[3][0]
    np.testing.assert_array_equal(span(prism, np.array([(3.0, 4.0), (5.0, 5.5)])), [(np.nan, np.nan), (1, 3)])
    np.testing.assert_array_equal(span(SHAPES[4][0], np.array([(1.5, 2.0), (2.5, 4.0)])), [(1, 7), (1, 4)])


# ---- boxes that are seen through are drawn as one solid: no wall inside it is darker than the others ----
def test_a_party_wall_is_not_drawn():
    made = united([sky.Box(min=(0, 0, 0), max=(2, 3, 4)), sky.Box(min=(2, 0, 0), max=(5, 3, 4))])
    assert enclosed(*made) == pytest.approx(60)
    assert area(*made) == pytest.approx(2 * (15 + 20 + 12))


def test_boxes_that_overlap_have_one_surface():
    boxes = [sky.Box(min=(0, 0, 0), max=(2, 2, 2)), sky.Box(min=(1, 1, 1), max=(3, 3, 3))]
    assert enclosed(*united(boxes)) == pytest.approx(15)
    assert area(*united(boxes)) == pytest.approx(48 - 6)
    assert enclosed(*united([*boxes, sky.Box(min=(10, 0, 0), max=(11, 1, 1))])) == pytest.approx(16)


def test_only_boxes_that_touch_are_taken_together():
    boxes = [sky.Box(min=(k, 0, 0), max=(k + 1, 1, 1)) for k in (0, 1, 3, 5.5)]
    assert touching([sky.Sphere(centre=(0, 0, 0), radius=1), *boxes]) == {1, 2}
    assert touching(boxes[1:]) == set()


def test_too_many_boxes_stay_apart():
    rng = np.random.default_rng(0)
    corners = rng.uniform(0, 100, (100, 3))
    assert united([sky.Box(min=tuple(low), max=tuple(low + 1)) for low in corners]) is None


# ---- the ground ----
def test_ground_is_bilinear_in_each_cell():
    terrain = sky.Terrain(origin=(10, 20), step=(2, 4), heights=[[0, 8], [4, 16]])
    for u, v in itertools.product((0.0, 0.25, 0.5, 1.0), repeat=2):
        expected = 0 * (1 - u) * (1 - v) + 4 * u * (1 - v) + 8 * (1 - u) * v + 16 * u * v
        assert terrain.height([(10 + 2 * u, 20 + 4 * v)])[0] == pytest.approx(expected)


def test_a_large_terrain_is_drawn_from_end_to_end_in_few_heights():
    heights = np.add.outer(np.arange(1501.0), 0.1 * np.arange(901.0))
    terrain = sky.Terrain(origin=(-100, 50), step=(2, 3), heights=heights)
    drawn = relief(terrain, (-100, 50), (2900, 2750))
    assert drawn.z.shape == (MAX_SPACE_HEIGHTS, MAX_SPACE_HEIGHTS)
    np.testing.assert_allclose((drawn.x[0], drawn.x[-1], drawn.y[0], drawn.y[-1]), (-100, 2900, 50, 2750))
    np.testing.assert_allclose(drawn.z, (drawn.x[:, None] + 100) / 2 + 0.1 * (drawn.y - 50) / 3, atol=1e-6)


def test_a_small_terrain_is_drawn_height_by_height():
    terrain = hills(300)
    drawn = relief(terrain, (0, 0), (300, 300))
    np.testing.assert_allclose(drawn.z, terrain.heights, atol=1e-9)


@given(st.integers(0, 2**32 - 1))
def test_no_path_above_ground_seems_to_run_below(seed):
    rng = np.random.default_rng(seed)
    terrain = sky.Terrain(origin=(0, 0), step=(1, 1), heights=rng.uniform(0, 30, (81, 81)))
    places = np.vstack([rng.uniform(0, 80, 2), rng.uniform(0, 80, 2)])
    points = along([np.column_stack([places, np.zeros(2)])], 0.25)
    points[:, 2] = terrain.height(points[:, :2]) + rng.uniform(0, 5, len(points))
    drawn = cleared(relief(terrain, (0, 0), (80, 80), 12), terrain, points)
    shown = sky.Terrain(origin=(0, 0), step=(drawn.x[1], drawn.y[1]), heights=drawn.z)
    assert np.all(shown.height(points[:, :2]) <= points[:, 2] + 1e-6)


def test_the_map_is_stretched_only_where_the_ground_is_flat():
    level = sky.Terrain(origin=(0, 0), step=(100, 100), heights=np.zeros((11, 11)))
    assert scene(with_terrain(town(), level)).world.stretch == 1.0
    flat = town()
    low = flat.scenario.bounds.model_copy(update={"max": (1000.0, 1000.0, 165.0)})
    flat = dataclasses.replace(flat, scenario=flat.scenario.model_copy(update={"bounds": low}))
    world = scene(with_terrain(flat, level)).world
    assert world.stretch == 1.5
    assert scene_data(scene(with_terrain(flat, level)))["stretch"] == 1.5


def test_a_map_ends_where_there_is_nothing_but_air_and_ground():
    mission = town(10, terrain=False)
    bounds = sky.Bounds(min=(-4000, -3000, 0), max=(5000, 6000, 900))
    wide = dataclasses.replace(mission, scenario=mission.scenario.model_copy(update={"bounds": bounds}))
    world = scene(wide).world
    margin = MAP_MARGIN * 1000
    assert world.low[:2] == pytest.approx((-margin, -margin), abs=150)
    assert world.high == pytest.approx((1000 + margin, 1000 + margin, 170 + margin), abs=150)
    for shape in (*mission.scenario.obstacles, *mission.scenario.zones):
        low, high = extent(shape)
        assert np.all(world.low <= low)
        assert np.all(high <= world.high)


def test_level_ground_has_no_contour_lines_and_no_peaks():
    heights = 5 + 0.01 * np.random.default_rng(0).random((101, 101))
    drawn = scene(with_terrain(town(10), sky.Terrain(origin=(0, 0), step=(10, 10), heights=heights)))
    (lines,) = of_role(from_above(drawn)["traces"], "contours")
    assert (lines["visible"], lines["meta"]["step"]) == (False, None)
    assert np.ptp(tinted(drawn.overhead.relief), axis=(0, 1)).max() < 0.02
    hilly = of_role(from_above(scene(town(10)))["traces"], "contours")[0]
    assert (hilly["visible"], hilly["meta"]["step"]) == (True, 10)


def test_contour_lines_stand_at_round_altitudes_above_the_sea():
    origin, x = sky.Origin(latitude=46.8, longitude=9.8, altitude=1503.7), np.linspace(-7000, 7000, 101)
    hill = np.add.outer(x, x) / 100
    above_sea, local = (contours(Relief(x, x, hill), place) for place in (origin, None))
    assert (above_sea["meta"]["above"], local["meta"]["above"]) == (" above sea level", "")
    for lines, low in ((above_sea, 1503.7 - 140), (local, -140)):
        first, step = lines["contours"]["start"], lines["contours"]["size"]
        assert first % step == 0
        assert low <= first < low + step


# ---- kinds ----
def test_what_city_models_hold_has_colours_of_its_own():
    found = kinds_module.shapes_by_kind(
        [
            sky.Box(min=(k, 0, 0), max=(k + 1, 1, 1), kind=kind)
            for k, kind in enumerate(sorted(set(KIND_OF_TYPE.values())))
        ],
        (),
        (),
    )
    colours = {kind.name: kind.colour for kind in found}
    assert colours.pop("tree") == colours.pop("vegetation")
    assert set(colours.values()) < set(KINDS.values())
    assert len(set(colours.values())) == len(colours) == 4


@pytest.mark.parametrize("kind", ["no-fly zone", "office space", "building"])
def test_airspace_is_seen_through_and_what_is_solid_is_not(kind):
    found = kinds_module.shapes_by_kind(
        [sky.Box(min=(0, 0, 0), max=(1, 1, 1), kind=kind, solid=solid) for solid in (True, False)], (), ()
    )
    assert sorted((one.solid, one.count) for one in found) == [(False, 1), (True, 1)]


def test_the_legend_of_a_page_and_of_a_figure_names_the_speed_limits_of_zones():
    slow = sky.Box(min=(10, 0, 0), max=(20, 30, 30), max_speed=3)
    school = sky.Box(min=(30, 0, 0), max=(40, 30, 30), max_speed=2.5, kind="school", risk=0.1)
    risky = sky.Box(min=(50, 0, 0), max=(60, 30, 30), risk=0.2)
    scenario = sky.Scenario(
        name="limits",
        bounds=sky.Bounds(min=(0, 0, 0), max=(100, 60, 30)),
        zones=(slow, slow.model_copy(update={"min": (70, 0, 0), "max": (80, 30, 30)}), school, risky),
        clearance=1,
        lattice=sky.Lattice(step=(2, 2, 2)),
        uavs=(sky.UAV(start=(5, 50, 10)),),
        targets=(sky.Target(position=(90, 50, 10)),),
    )
    drawn = scene(sky.plan_mission(scenario, sky.Taut()))
    titles = ["speed limit 3 m/s (2)", "school, speed limit 2.5 m/s (1)", "zone (1)"]
    assert [kind["title"] for kind in scene_data(drawn)["kinds"]] == titles
    labels = legend_entries(drawn)[1]
    assert labels == [titles[0], f"{titles[1]}, at a risk", f"{titles[2]}, at a risk"]


def test_every_kind_is_in_the_legend_with_its_count_hard_and_soft_apart():
    drawn = scene_data(scene(town(50)))
    shown = {kind["title"]: kind["hard"] for kind in drawn["kinds"]}
    assert shown == {
        "building (50)": True,
        "no-fly zone (1)": True,
        "balloon (1)": True,
        "rubble (1)": True,
        "obstacle (1)": True,
        "school (1)": False,
    }
    meshes = Counter(trace["meta"]["kind"] for trace in drawn["space"] if trace["meta"]["role"] == "kind")
    assert meshes == Counter(range(6))
    footprints = of_role(drawn["map"]["traces"], "kind")
    assert [trace["name"] for trace in footprints] == [title.rsplit(" (", 1)[0] for title in shown]
    words = [text.get_text() for text in trajectories(scene(town(50))).legends[0].get_texts()]
    assert {"building (50)", "school (1), at a risk"} <= set(words)


def test_too_many_shapes_are_told_and_those_near_the_paths_stay(monkeypatch):
    monkeypatch.setattr(kinds_module, "MAX_TRIANGLES", 400)
    near = sky.Prism(vertices=rectangle((5, 5), 4, 4, 0.3), low=0, high=5, kind="building")
    found = kinds_module.shapes_by_kind((*buildings(100), near), (), [np.array([(0.0, 0.0, 5.0), (10.0, 10.0, 5.0)])])
    (kind,) = found
    assert near in kind.shapes
    assert 0 < len(kind.shapes) < 101
    assert kind.title == f"building ({len(kind.shapes)} of 101)"


def test_boxes_without_names_have_no_map(mission):
    drawn = scene_data(scene(mission))
    assert not drawn["mapped"]
    assert "map" not in drawn
    assert [kind["title"] for kind in drawn["kinds"]] == ["Obstacles"]
    assert 'id="profile"' not in page(scene(mission)).split("<script", 1)[0]


def test_a_city_of_boxes_without_names_is_opaque_and_has_a_map():
    scenario = sky.random_city(400, seed=3)
    drawn = scene_data(scenario_scene(scenario))
    assert drawn["mapped"]
    assert [kind["solid"] for kind in drawn["kinds"]] == [True]
    mesh = next(trace for trace in drawn["space"] if trace["meta"]["role"] == "kind")
    triangles = columns(mesh, "xyz")[columns(mesh, "ijk")]
    level = np.ptp(triangles[:, :, 2], axis=1) == 0
    assert 0 < level.sum() < len(level)
    brightness = numbers(mesh["intensity"])
    assert brightness[level].min() > 1.2 * brightness[~level].max()  # roofs stand out
    assert brightness.max() <= 1


def test_what_is_higher_than_the_picture_has_a_roof_where_it_is_cut_off():
    ring = ((0, 0), (5, 0), (5, 5))
    tall = (
        sky.Box(min=(0, 0, 0), max=(10, 10, 90)),
        sky.Cylinder(centre=(30, 30), radius=5, low=0, high=70),
        sky.Prism(vertices=ring, low=2, high=61),
    )
    for shape in tall:
        points, triangle = surface(below(shape, 60.0))
        edges = Counter(frozenset(pair) for a, b, c in triangle for pair in ((a, b), (b, c), (c, a)))
        assert set(edges.values()) == {2}  # closed
        assert points[:, 2].max() == 60
        assert points[:, 2].min() == surface(shape)[0][:, 2].min()
    for kept in (tall[0], sky.Box(min=(0, 0, 95), max=(10, 10, 99)), sky.Sphere(centre=(0, 0, 60), radius=9)):
        assert below(kept, 90.0) is kept
    city = sky.random_downtown(40, seed=1)
    mission = sky.plan_mission(city, sky.ThetaStar())
    top = city.bounds.max[2]
    meshes = of_role(scene_data(scene(mission))["space"], "kind")
    assert max(numbers(mesh["z"]).max() for mesh in meshes) == top
    assert f"cut off at its top, z = {top:g} m" in page(scene(mission))
    assert "cut off" not in page(scene(town(5)))


# ---- profiles and map ----
def test_a_profiles_ground_is_that_below_the_path():
    mission = town()
    drawn = scene(mission)
    for profile, trajectory in zip(drawn.profiles, mission.trajectories, strict=True):
        share = profile.distance / profile.distance[-1]
        np.testing.assert_allclose(profile.points, trajectory.at(60.0 * share).position, atol=1e-6)
        np.testing.assert_allclose(profile.ground, mission.scenario.terrain.height(profile.points[:, :2]))
        np.testing.assert_allclose(profile.band, profile.ground[:, None] + (40, 90))
        assert profile.clearance == 20
        assert np.diff(profile.distance).max() < 5


def test_the_table_tells_the_least_and_the_greatest_height_above_ground():
    mission = town(10)
    text = flight_table(scene(mission))
    for trajectory in mission.trajectories:
        points = trajectory.at(np.linspace(0, 60, 20_001)).position
        above = points[:, 2] - mission.scenario.terrain.height(points[:, :2])
        least, most = re.search(rf"({above.min():.0f}\.\d|{above.min():.1f}) to (\d+\.\d) m", text).groups()
        assert float(least) == pytest.approx(above.min(), abs=0.2)
        assert float(most) == pytest.approx(above.max(), abs=0.2)
    assert "Above ground" in text
    assert "Above ground" not in flight_table(scene(town(10, terrain=False)))


def test_a_profile_shows_the_ceiling_above_ground():
    mission = town()
    below = dataclasses.replace(mission, scenario=mission.scenario.model_copy(update={"max_height": 300.0}))
    drawn = scene(below)
    for profile, free in zip(drawn.profiles, scene(mission).profiles, strict=True):
        np.testing.assert_allclose(profile.ceiling, profile.ground + 300)
        assert free.ceiling is None
    roles = [trace["meta"]["role"] for trace in from_the_side(drawn)[0]["traces"]]
    assert roles.count("ceiling") == 1
    terrain = below.scenario.terrain.model_copy(update={"lowest": below.scenario.terrain.heights - 2.5})
    lower = dataclasses.replace(below, scenario=below.scenario.model_copy(update={"terrain": terrain}))
    for profile in scene(lower).profiles:
        np.testing.assert_allclose(profile.ceiling, profile.ground - 2.5 + 300)


def test_a_profile_shows_what_is_crossed_and_nothing_beside():
    mission = town()
    for profile, uav in zip(scene(mission).profiles, range(2), strict=True):
        places = mission.trajectories[uav].at(np.linspace(0, 60, 20_001)).position[:, :2]
        everything = (*mission.scenario.obstacles, *mission.scenario.zones)
        crossed = [shape for shape in everything if np.isfinite(span(shape, places)).sum() > 200]
        assert len(profile.crossings) >= len(crossed) > 3
        for crossing in profile.crossings:
            place = profile.points[np.searchsorted(profile.distance, crossing.distance), :2]
            spans = np.array([span(shape, place) for shape in everything])
            assert np.any(np.all(spans == crossing.levels, axis=(1, 2)))


def test_the_map_knows_latitude_and_longitude():
    mission = town()
    drawn = scene(mission)
    degrees = np.array(from_above(drawn)["degrees"])
    low, high = drawn.world.low, drawn.world.high
    up = drawn.overhead.relief.z.mean()
    corner = sky.to_wgs84(mission.scenario.frame.origin, [(high[0], low[1], up)])[0]
    np.testing.assert_allclose(degrees[-1, 0], corner[:2], atol=1e-9)
    assert from_above(scene(town(origin=False)))["degrees"] is None


def test_footprints_run_one_way_and_holes_the_other():
    outer, hole = footprint(SHAPES[3][0])
    assert area_of(outer, np.array([[0, 1, 2]]))[0] > 0 > area_of(hole, np.array([[0, 1, 2]]))[0]


@pytest.mark.parametrize(("heights", "step"), [(100, 10), (1300, 200), (41, 5), (0, 0.01)])
def test_contour_lines_are_round_metres_apart(heights, step):
    assert spacing(heights) == pytest.approx(step)


def test_a_page_of_two_thousand_buildings_on_hills_stays_small():
    drawn = scene(town(2000))
    text = page(drawn)
    assert len(text) < 15e6
    held = json.loads(text.split('id="mission">', 1)[1].split("</script>", 1)[0])
    assert len(held["space"]) < 25
    surfaces = [trace for trace in held["space"] if trace["type"] == "surface"]
    assert numbers(surfaces[0]["z"]).shape == drawn.world.relief.z.T.shape
    assert isinstance(drawn.world.relief, Relief)
    building = next(trace for trace in held["space"] if trace["name"] == "building")
    assert numbers(building["i"]).max() < len(numbers(building["x"]))
    assert len(numbers(building["i"])) < kinds_module.MAX_TRIANGLES


def test_zones_are_named_in_profiles_in_the_middle_of_what_is_seen_of_them():
    drawn = town(10)
    (x, y), (_, high) = scene(drawn).profiles[0].points[len(scene(drawn).profiles[0].points) // 2, :2], (0, 1000)
    zone = sky.Box(min=(x - 20, y - 20, 0), max=(x + 20, y + 20, high), name="Hospital <b>", solid=False)
    house = sky.Box(min=(x - 9, y - 9, 0), max=(x + 9, y + 9, 5), name="house")
    named = scene(dataclasses.replace(drawn, scenario=drawn.scenario.model_copy(update={"obstacles": (zone, house)})))
    side = from_the_side(named)[0]
    (names,) = of_role(side["traces"], "names")
    (crossing,) = (one for one in named.profiles[0].crossings if one.name.startswith("Hospital"))
    assert len(names["text"]) == 1
    assert "<b>" not in names["text"][0]
    assert crossing.distance[0] < names["x"][0] < crossing.distance[-1]
    assert 0 < names["y"][0] < side["range"][1] < high
    assert not of_role(from_the_side(scene(drawn))[0]["traces"], "names")


def test_zones_are_named_on_the_map_and_buildings_are_not():
    drawn = town(10)
    zone = sky.Box(min=(0, 0, 0), max=(2, 2, 5), name="Hospital <b>", solid=False)
    house = sky.Box(min=(0, 0, 0), max=(2, 2, 5), name="house")
    named = dataclasses.replace(drawn, scenario=drawn.scenario.model_copy(update={"obstacles": (zone, house)}))
    (names,) = of_role(from_above(scene(named))["traces"], "names")
    assert len(names["text"]) == 1
    assert names["text"][0].startswith("Hospital")
    assert "<b>" not in names["text"][0]
    assert not of_role(from_above(scene(drawn))["traces"], "names")
