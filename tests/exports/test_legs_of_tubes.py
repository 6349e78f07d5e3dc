"""Exported legs keep the tracking error from obstacles, but for the pads at the UAV's own start and target."""

import numpy as np
import pytest

import skyverse as sky
from skyverse import World
from skyverse.exports import LegChecker, LegSpace, routes
from skyverse.exports.fleet_routes import leg_checkers

ERROR = sky.TrackingError(horizontal=1.5, vertical=2.0)


def mission(error=ERROR):
    given = {
        "name": "tube",
        "bounds": {"min": (0, 0, 0), "max": (60, 36, 36)},
        "clearance": 0.5,
        "lattice": {"step": (3, 3, 3), "connectivity": 26},
        "objective": {"unit": "metres"},
        "obstacles": (sky.Box(min=(27, 0, 0), max=(30, 24, 27)),),
        "uavs": ({"start": (9, 12, 0.5), "tracking_error": error},),
        "targets": ({"position": (45, 12, 3)},),
        "frame": {"origin": {"latitude": 47, "longitude": 8, "altitude": 400}},
    }
    return sky.plan_mission(sky.Scenario.model_validate(given), sky.Taut())


def test_waypoints_keep_the_tracking_error_from_obstacles():
    planned = mission()
    (route,) = routes(planned)
    assert route.points[0] == pytest.approx((9, 12, 0.5))
    world = World(planned.scenario.model_copy(update={"clearance": 0.48}), ERROR)
    climb, *others = zip(route.points[:-1], route.points[1:], strict=True)
    assert climb[0][:2] == pytest.approx(climb[1][:2], abs=1e-9)
    for a, b in others:
        assert world.first_crossing(a[None], b[None]) is None


def test_only_on_the_pad_at_the_own_start_the_error_does_not_count():
    (legs,) = leg_checkers(mission(), mission().scenario, "amsl")
    foot, top = legs.lifts[0]
    assert (foot[2], top[2]) == pytest.approx((0.5, 2.001))
    up, beside = np.array([0.0, 0.0, 5.0]), np.array([1.0, 0.0, 0.0])
    found = legs.leg(foot, foot + up)
    assert found.fault is None
    assert [part.error == ERROR for part in found.clear] == [False, True, True]
    assert [part.pad for part in found.clear] == [None, (9, 12, 0.5), None]
    assert legs.leg(foot + beside, foot + beside + up).fault is not None
    assert LegChecker(LegSpace(mission().scenario, "amsl")).leg(foot + beside, foot + beside + up).fault is None


def test_uavs_without_an_error_share_one_certificate():
    exact = mission(sky.TrackingError())
    (uav,) = exact.scenario.uavs
    two = exact.scenario.model_copy(update={"uavs": (uav, uav.model_copy(update={"name": "uav-2"}))})
    both = sky.Mission(two, (0, None), exact.results * 2, exact.trajectories * 2, (), exact.provenance)
    one, other = leg_checkers(both, two, "amsl")
    assert one is other


def hillside(error, above, clearance=1.0):
    """A mission from a hillside to another place on it; start and target are some metres above ground."""
    x = np.arange(31) * 4.0
    heights = 10 + 0.3 * x[:, None] + 4 * np.sin(x[:, None] / 20) * np.cos(x / 25)
    ground = sky.Terrain(origin=(0, 0), step=(4, 4), heights=heights)
    start, target = (
        (*place, float(ground.height(np.array(place))) + above) for place in ((10.3, 12.3), (105.7, 100.4))
    )
    scenario = sky.Scenario(
        name="hillside",
        bounds=sky.Bounds(min=(0, 0, 0), max=(120, 120, 90)),
        terrain=ground,
        clearance=clearance,
        lattice=sky.Lattice(step=(4, 4, 4), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=[{"start": start, "tracking_error": error}],
        targets=[{"position": target}],
        frame=sky.Frame(origin=sky.Origin(latitude=47, longitude=8, altitude=400)),
    )
    return sky.plan_mission(scenario, sky.Taut())


GNSS = sky.TrackingError(horizontal=1.6, vertical=3.0)


@pytest.mark.parametrize("altitude", ["amsl", "agl"])
@pytest.mark.parametrize("error", [sky.TrackingError(), GNSS], ids=["exact", "strays"])
def test_a_uav_on_a_hillside_can_be_as_near_to_the_ground_as_its_clearance(error, altitude):
    planned = hillside(error, above=1.0)
    assert planned.violations == ()
    (route,) = routes(planned, altitude=altitude)
    allowance = 0.02 + 0.016 * np.hypot(0.5, 0.2)
    assert (planned.scenario.terrain.height(route.points[:, :2]) + 1 - allowance <= route.points[:, 2]).all()


@pytest.mark.parametrize("above", [1.0, 3.0])
def test_the_first_climb_leads_off_the_pad(above):
    planned = hillside(GNSS, above)
    (route,) = routes(planned, takeoff=0.0)
    top = sky.Problem(planned.scenario).start
    assert route.takeoff > top[2] - route.points[0, 2]
    np.testing.assert_allclose(route.points[:2, :2], [top[:2], top[:2]], atol=1e-9)
    assert route.waypoint_times[0] == pytest.approx(route.times[0])
    first = planned.trajectories[0].at(route.times[0]).position[0]
    np.testing.assert_allclose(first, top, atol=1e-3)
    assert (np.diff(route.points[:, 2])[0] > 0) & (route.waypoints[:-1, 2] >= top[2]).all()


@pytest.mark.parametrize("stops", [False, True])
def test_a_uav_stops_above_a_pad_at_its_target_and_flies_straight_down(stops):
    scenario = sky.Scenario(
        name="plain",
        bounds=sky.Bounds(min=(0, 0, 0), max=(300, 40, 60)),
        obstacles=[sky.Box(min=(100, 0, 0), max=(120, 40, 20))],
        clearance=2.0,
        lattice=sky.Lattice(step=(5, 5, 5), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=[{"start": (10.3, 12.1, 3), "vehicle": "camera"}],
        targets=[{"position": (287.96, 22.38, 2.995)}],
        terrain=sky.Terrain(origin=(0, 0), step=(300, 40), heights=np.ones((2, 2)), clearance=1.99),
        frame=sky.Frame(origin=sky.Origin(latitude=47, longitude=8, altitude=400)),
    )
    planned = sky.plan_mission(scenario, sky.Taut())
    assert planned.violations == ()
    (route,) = routes(planned, stops=stops)
    above, end = route.points[-2:]
    np.testing.assert_allclose(end, scenario.targets[0].position, atol=1e-9)
    np.testing.assert_allclose(above, sky.Problem(scenario).end, atol=2e-3)
    assert stops or route.holds[-2] > 0
