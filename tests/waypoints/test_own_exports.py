"""What skyverse exports is read back as what was exported."""

from itertools import product

import numpy as np
import pytest

import skyverse as sky
from skyverse.model.altitude import AboveHome, AboveSea
from skyverse.model.waypoints import OrderKind as Kind
from speed_zones import world_of

ORIGIN = sky.Origin(latitude=46.8, longitude=9.8, altitude=1560.0, geoid=52.0)


@pytest.fixture(scope="module")
def mission():
    uav = sky.UAV(start=(-60, 0, 12), home=0)
    targets = (sky.Target(position=(60, 30, 30)),)
    return sky.plan_mission(world_of(uavs=(uav,), targets=targets, frame=sky.Frame(origin=ORIGIN)), sky.Taut())


def read(mission, tmp_path, suffix, above, **how):
    told = {"end": "rtl"} if suffix in (".plan", ".waypoints", ".wpml.kmz") else {}
    (file,) = sky.export(mission, tmp_path / f"m{suffix}", sky.ExportOptions(altitude=above, **told))
    return sky.read_waypoints(file, **how)


def heights(mission, above, waypoints):
    """Latitude, longitude and height of each place of a route."""
    at = sky.to_wgs84(ORIGIN, waypoints)
    at[:, 2] -= {"amsl": 0.0, "home": ORIGIN.altitude}[above]
    return at


@pytest.mark.parametrize(
    ("suffix", "above"),
    [*product((".plan", ".waypoints", ".wpml.kmz"), ("home", "amsl")), (".litchi.csv", "home")],  # as Litchi is told
)
def test_autopilots_are_told_the_places_of_the_route(mission, tmp_path, suffix, above):
    dji = suffix in (".wpml.kmz", ".litchi.csv")
    (route,) = sky.routes(mission, altitude=above, **({"takeoff": 1.2, "stops": True} if dji else {}))
    told = read(mission, tmp_path, suffix, above)
    orders = [one for one in told.orders if one.kind in (Kind.WAYPOINT, *(() if dji else (Kind.TAKEOFF,)))]
    kinds = {type(one.place[2]) for one in orders}
    assert kinds == {AboveHome if above == "home" else AboveSea}
    found = np.array([(*one.place[:2], one.place[2].metres) for one in orders])
    expected = heights(mission, above, route.waypoints)
    np.testing.assert_allclose(found[:, :2], expected[:, :2], atol=1e-6)
    np.testing.assert_allclose(found[:, 2], expected[:, 2], atol=0.02)
    assert not [order for order in told.orders if order.kind in (Kind.PASSED_ON, Kind.OTHER)]
    if suffix != ".litchi.csv":
        assert told.orders[-1].kind is Kind.RETURN
    if suffix in (".plan", ".waypoints"):
        assert told.home == pytest.approx((*heights(mission, "amsl", np.array([[-60, 0, 0.0]]))[0],), abs=1e-6)
    speeds = [one.speed for one in told.orders if one.speed]
    assert speeds
    assert all(0 < speed <= 15 for speed in speeds)


@pytest.mark.parametrize("suffix", [".kml", ".kmz", ".gpx"])
def test_paths_on_maps_are_routes(mission, tmp_path, suffix):
    told = read(mission, tmp_path, suffix, "amsl", altitude="amsl")
    (trajectory,) = mission.trajectories
    ends = sky.to_wgs84(ORIGIN, trajectory.at(np.array([trajectory.start, trajectory.end])).position)
    for order, end in zip((told.orders[0], told.orders[-1]), ends, strict=True):
        assert order.place[:2] == pytest.approx(tuple(end[:2]), abs=1e-6)
        assert order.place[2].metres == pytest.approx(end[2], abs=0.02)
        assert isinstance(order.place[2], AboveSea)
