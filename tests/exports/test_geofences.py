"""Geofences of scenarios with fences, as MAVSDK reads them and as PX4 and ArduPilot judge places by them."""

import json
from dataclasses import replace

import handmade_exports as handmade
import numpy as np
import pytest

shapely = pytest.importorskip("shapely", reason="building scenarios needs shapely")
pytest.importorskip("pyproj", reason="an independent geodesy")

import skyverse as sky  # noqa: E402
from proj_map import proj_local  # noqa: E402
from skyverse.exports.mavlink_formats import geofence  # noqa: E402
from skyverse.maps.assembly.fences import fence_area, fence_around  # noqa: E402

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = sky.Origin(latitude=47.0, longitude=8.5, altitude=400.0)
INCLUSION, EXCLUSION = 5001, 5002
"""MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION and _EXCLUSION."""


def square(x, y, half):
    return np.array([(x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half)])


AREAS = {
    "one": [(square(0, 0, 250), [])],
    "with a hole": [(square(0, 0, 250), [square(0, 100, 50)])],
    "two": [(square(-150, 0, 140), []), (square(150, 0, 140), [])],
    "an island in a hole": [(square(0, 0, 280), [square(0, 100, 90)]), (square(0, 100, 40), [])],
    "across the bounds": [(square(250, 0, 280), [square(250, 100, 20)]), (square(-150, 0, 50), [])],
}


def mission_within(areas):
    flight = handmade.along([(100, 0, 10), (130, 0, 10)], 10)
    mission = handmade.mission([flight], origin=ORIGIN)
    found = []
    for number, (outline, holes) in enumerate(areas, 1):
        globe = [sky.to_wgs84(ORIGIN, np.column_stack([ring, 0 * ring[:, 0]]))[:, 1::-1] for ring in (outline, *holes)]
        found += fence_area(globe[0], globe[1:], f"area {number}")
    fence = fence_around(found, ORIGIN, mission.scenario.bounds)
    scenario = mission.scenario.model_copy(update={"obstacles": fence.prisms})
    return replace(mission, scenario=scenario)


def winds_around(places, ring):
    """The rule of both autopilots for a place in a polygon, in degrees: an odd number of edges crossed."""
    (x, y), odd = places.T, np.zeros(len(places), dtype=bool)
    for (ax, ay), (bx, by) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        if ay != by:
            odd ^= ((ay > y) != (by > y)) & (x < (bx - ax) * (y - ay) / (by - ay) + ax)
    return odd


def allowed(rings, places):
    """Both rules for several areas to stay in, intersection and union, which must agree."""
    within = np.array([winds_around(places, ring) for kept, ring in rings if kept])
    without = ~np.array([winds_around(places, ring) for kept, ring in rings if not kept] or [[False] * len(places)])
    each = [rule(within, axis=0) & without.all(axis=0) for rule in (np.all, np.any)]
    np.testing.assert_array_equal(*each)
    return each[0]


@pytest.mark.parametrize("name", AREAS)
def test_a_geofence_allows_what_the_fence_allows(name):
    scenario = mission_within(AREAS[name]).scenario
    written = geofence(scenario)
    assert written["circles"] == []
    rings = [(one["inclusion"], np.array(one["polygon"])) for one in written["polygons"]]
    points = np.random.default_rng(5).uniform(-299, 299, (6000, 2))
    truth = shapely.union_all([shapely.Polygon(outline, holes) for outline, holes in AREAS[name]])
    places = sky.to_wgs84(ORIGIN, np.column_stack([points, 0 * points[:, 0]]))[:, :2]
    off = shapely.distance(shapely.points(points), truth.boundary)
    sure = off > 0.7  # the tolerance of outlines
    inside = allowed(rings, places)
    np.testing.assert_array_equal(inside[sure], shapely.intersects_xy(truth, *points[sure].T))
    assert 0.05 < inside.mean() < 0.95
    outside = ~shapely.intersects_xy(truth, *points.T) & (off > 0.01)
    assert not inside[outside].any()


@pytest.mark.parametrize("autopilot", ["px4", "ardupilot"])
@pytest.mark.parametrize("name", AREAS)
def test_mavsdk_reads_the_geofence_of_a_fence(stations, tmp_path, name, autopilot):

    mission = mission_within(AREAS[name])
    file = tmp_path / "m.plan"
    sky.export(mission, file, sky.ExportOptions(altitude="home", autopilot=autopilot))
    items = stations.mission.import_qgroundcontrol_mission(str(file)).geofence_items
    rings = []
    while items:  # each corner tells how many its polygon has
        size = int(items[0].param1)
        rings.append((items[0].command, np.array([(item.x / 1e7, item.y / 1e7) for item in items[:size]])))
        assert {item.command for item in items[:size]} == {rings[-1][0]}
        items = items[size:]
    assert [kind for kind, _ in rings].count(INCLUSION) == 1
    written = json.loads(file.read_text())["geoFence"]["polygons"]
    assert [INCLUSION if one["inclusion"] else EXCLUSION for one in written] == [kind for kind, _ in rings]
    for (_, ring), one in zip(rings, written, strict=True):
        np.testing.assert_allclose(ring, one["polygon"], atol=1e-7)
        local = shapely.Polygon(proj_local(ORIGIN, *ring.T, 0.0)[:, :2])
        assert local.is_valid
        assert local.area > 1.0
