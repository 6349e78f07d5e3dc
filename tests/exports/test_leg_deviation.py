"""Legs that autopilots fly straight, near the origin and far from it, are off no more than is reckoned."""

import numpy as np
import pytest
from handmade_exports import local
from test_terrain_following import ALLOWANCE, EXACT, least_lift, random_case

import terrain_follower as follower
from skyverse import Bounds, Frame, Origin, Scenario
from skyverse.exports.global_positions import global_positions
from skyverse.exports.leg_geometry import leg_deviation
from skyverse.numerics.tolerances import MAVLINK_ROUNDING

pyproj = pytest.importorskip("pyproj", reason="an independent geodesy")
SHARES = np.linspace(0, 1, 101)


def great_circle(a, b):
    """Degrees (n, 2) on a sphere between two places."""
    (p, q), turn = np.radians([a[0], b[0]]), np.radians([a[1], b[1]])
    u, v = np.column_stack([np.cos([p, q]) * np.cos(turn), np.cos([p, q]) * np.sin(turn), np.sin([p, q])])
    angle = 2 * np.arcsin(np.linalg.norm(u - v) / 2)
    x, y, z = (np.outer(np.sin((1 - SHARES) * angle), u) + np.outer(np.sin(SHARES * angle), v)).T / np.sin(angle)
    return np.degrees(np.column_stack([np.arcsin(z), np.unwrap(np.arctan2(y, x))]))


def geodesic(a, b):
    """Degrees (n, 2) on the ellipsoid between two places."""
    geod = pyproj.Geod(ellps="WGS84")
    turn, _, length = geod.inv(a[1], a[0], b[1], b[0])
    every = np.ones(len(SHARES))
    east, north, _ = geod.fwd(a[1] * every, a[0] * every, turn * every, SHARES * length)
    return np.column_stack([north, east])


def on_azimuthal_map(a, b, home):
    """Degrees (n, 2) of a line that PX4 holds in metres from its home, on a sphere."""
    to_map = pyproj.Transformer.from_pipeline(
        "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad "
        f"+step +proj=aeqd +R=6371000 +lat_0={home[0]!r} +lon_0={home[1]!r}"
    )
    x, y = to_map.transform([a[1], b[1]], [a[0], b[0]])
    longitude, latitude = to_map.transform(
        x[0] + SHARES * (x[1] - x[0]), y[0] + SHARES * (y[1] - y[0]), direction="INVERSE"
    )
    return np.column_stack([latitude, longitude])


def from_home(a, b, origin):
    """Degrees (n, 2) of a line that ArduPilot holds in metres from its origin, with longitudes scaled."""
    ends = np.array([[place[0], (place[1] - origin.longitude + 180) % 360 - 180] for place in (a, b)])

    def shrunk(north):
        return np.cos(np.radians((north + origin.latitude) / 2))

    metres = np.column_stack([ends[:, 0], ends[:, 1] * shrunk(ends[:, 0])])
    line = metres[0] + SHARES[:, None] * (metres[1] - metres[0])
    return np.column_stack([line[:, 0], origin.longitude + line[:, 1] / shrunk(line[:, 0])])


@pytest.mark.parametrize("away", [1e3, 1e4, 8e4])
@pytest.mark.parametrize("length", [5.0, 500.0, 5e3])
def test_legs_are_off_no_more_than_is_reckoned(length, away):
    rng, geod = np.random.default_rng(int(length + away)), pyproj.Geod(ellps="WGS84")
    most = 0.0
    for _ in range(25):
        origin = Origin(latitude=rng.uniform(-75, 75), longitude=rng.uniform(-180, 180), altitude=100.0, geoid=0.0)
        east, north, _ = geod.fwd(origin.longitude, origin.latitude, rng.uniform(0, 360), away)
        on_east, on_north, _ = geod.fwd(east, north, rng.uniform(0, 360), length)
        home_east, home_north, _ = geod.fwd(origin.longitude, origin.latitude, rng.uniform(0, 360), away)
        heights = 200 + rng.uniform(0, min(length, 300.0), 2)
        a, b = (north, east), (on_north, east + (on_east - east + 180) % 360 - 180)
        ends = local(origin, [north, on_north], [east, on_east], heights)
        straight = np.array(a) + SHARES[:, None] * (np.array(b) - np.array(a))
        side = away + length
        given = Scenario(
            name="far",
            clearance=0.001,
            frame=Frame(origin=origin),
            bounds=Bounds(min=(-side, -side, 0), max=(side, side, 900)),
        )
        allowed = MAVLINK_ROUNDING + float(leg_deviation(given, length))
        home = home_north, home_east
        ways = straight, great_circle(a, b), geodesic(a, b), from_home(a, b, origin), on_azimuthal_map(a, b, home)
        for places in ways:
            flown = local(origin, *places.T, heights[0] + SHARES * (heights[1] - heights[0]))
            way = ends[1] - ends[0]
            along = np.clip((flown - ends[0]) @ way / (way @ way), 0, 1)
            off = float(np.linalg.norm(flown - ends[0] - along[:, None] * way, axis=1).max())
            assert off <= allowed + 1e-7
            most = max(most, off / allowed)
    assert most > 0.3 or length < 5000  # it is not reckoned much larger than it is


def far_case(seed, away):
    """A random case at some metres from the origin."""
    scenario, above, radius, stops, rng = random_case(seed)
    turn = rng.uniform(0, 2 * np.pi)
    middle = away * np.array([np.cos(turn), np.sin(turn)])
    terrain = scenario.terrain
    origin = tuple(np.array(terrain.origin) + middle)
    moved = terrain.model_copy(update={"origin": origin})
    boxes = []
    for box in scenario.obstacles:
        x, y = ((low + high) / 2 for low, high in zip(box.min[:2], box.max[:2], strict=True))
        more = np.array([*middle, float(moved.height(np.array([x, y]) + middle) - terrain.height([x, y]))])
        boxes.append(box.model_copy(update={"min": tuple(box.min + more), "max": tuple(box.max + more)}))
    bounds = Bounds(min=(*(middle - 200), -500), max=(*(middle + 200), 600))
    changes = {"terrain": moved, "obstacles": tuple(boxes), "bounds": bounds, "clearance": 1.0}
    return scenario.model_copy(update=changes), above + np.r_[middle, 0.0], radius, stops, rng


def on_the_globe(scenario, points, radius, stops, rng):
    """Where points (n, 3), exported with altitudes above ground, lead: local metres (m, 3), over the lowest ground."""
    origin, terrain = scenario.frame.origin, scenario.terrain
    exported = global_positions(scenario, 0, points, "agl")
    scale = np.array([111e3, 111e3 * np.cos(np.radians(exported.latitude[0])), 1.0])
    metres = np.column_stack([exported.latitude, exported.longitude, exported.altitude]) * scale
    latitude, longitude, above = (follower.ways(metres, 0.98 * radius, stops, rng, 200, 8) / scale).T
    lowest = terrain.heights if terrain.lowest is None else terrain.lowest
    at = local(origin, latitude, longitude, origin.altitude + above)
    at[:, 2] += follower.height(terrain, lowest, at[:, :2])
    return at


@pytest.mark.parametrize("away", [1e3, 8e4])
@pytest.mark.parametrize("bare", [False, True])
@pytest.mark.parametrize("seed", [0, 1])
def test_heights_above_ground_are_kept_far_from_the_origin(seed, bare, away):
    scenario, above, radius, stops, rng = far_case(seed, away)
    if bare:
        scenario = scenario.model_copy(update={"obstacles": ()})
        above[:, 2] += 60.0
        higher = scenario.terrain.model_copy(update={"clearance": 62.0})
        scenario = scenario.model_copy(update={"terrain": higher})
    above[:, 2] += least_lift(scenario, EXACT, above, radius, stops)
    points = above.copy()
    points[:, 2] += follower.height(scenario.terrain, scenario.terrain.heights, above[:, :2])
    flown = on_the_globe(scenario, points, radius, stops, rng)
    obstacle, ground, _ = follower.rooms(scenario, flown)
    assert obstacle >= -ALLOWANCE
    assert ground >= -ALLOWANCE
