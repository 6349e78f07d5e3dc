"""What is exported stays at or below the ceiling above ground, rounding included, also where the flight touches it."""

from dataclasses import replace

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse import Terrain
from skyverse.exports import LegChecker, LegSpace
from skyverse.exports.way_home import TOO_HIGH

ORIGIN = sky.Origin(latitude=46.8, longitude=9.85, altitude=1500.0)
CEILING = 30.0
ROUNDING = 0.016


def cliff(lowest=True):
    """A slope with a cliff of 10 m; the surface that ceilings are counted from is up to 6 m lower there."""
    x = np.linspace(-300, 300, 61)
    heights = np.where(x > 0, 10.0, 0.0)[:, None] + 0.05 * x[:, None] + np.zeros(61)
    below = heights.copy()
    below[28:34] -= 6.0
    return Terrain(origin=(-300, -300), step=(10, 10), heights=heights, clearance=2.0, lowest=below if lowest else None)


def touching(ground, error=0.0):
    """A level flight that touches the ceiling lowered by an error."""
    x = np.linspace(-100, 100, 81)
    limit = ground.lowest_ground.height(np.column_stack([x, np.zeros(81)])) + CEILING - error
    level = float(limit.min())
    flight = handmade.along([(-100, 0, level), (100, 0, level)], 20)
    mission = handmade.mission([flight], terrain=ground, origin=ORIGIN, clearance=0.5)
    return replace(mission, scenario=mission.scenario.model_copy(update={"max_height": CEILING}))


def greatest_height(scenario, points):
    ways = np.linspace(points[:-1], points[1:], 2000).reshape(-1, 3)
    below = scenario.terrain.lowest_ground.height(ways[:, :2])
    return float((ways[:, 2] - below).max())


@pytest.mark.parametrize("altitude", ["amsl", "agl"])
@pytest.mark.parametrize("lowest", [False, True])
def test_a_flight_that_touches_the_ceiling_is_exported_below_it(altitude, lowest):
    mission = touching(cliff(lowest))
    (route,) = sky.routes(mission, altitude=altitude)
    assert f" and stays at most {CEILING:g} m above ground" in route.sentence(mission.scenario)
    if altitude == "amsl":
        assert greatest_height(mission.scenario, route.points) <= CEILING - ROUNDING
    assert route.off >= float((mission.trajectories[0].at(np.zeros(1)).position - route.points[:1]).max())


def test_heights_above_ground_are_held_against_the_lowest_ground_between_waypoints():
    mission = touching(cliff())
    ground = mission.scenario.terrain
    ends = np.array([(-80.0, 0, 0), (80.0, 0, 0)])
    ends[:, 2] = ground.height(ends[:, :2])
    legs = LegChecker(LegSpace(mission.scenario, "agl"))
    for above, clear in ((CEILING - 6 - 0.3, True), (CEILING - 6 + 0.1, False), (CEILING - 0.3, False)):
        fault = legs.leg(*(ends + np.array([0, 0, above]))).fault
        assert (fault is None) == clear
        if not clear:
            assert "above the ceiling of 30 m" in fault.sentence(mission.scenario)


def test_a_straying_uav_is_exported_below_the_ceiling_with_its_error():
    error = sky.TrackingError(horizontal=0.5, vertical=1.5)
    mission = touching(cliff(), error=error.vertical + 1.0)
    uav = mission.scenario.uavs[0].model_copy(update={"tracking_error": error})
    mission = replace(mission, scenario=mission.scenario.model_copy(update={"uavs": (uav,)}))
    (route,) = sky.routes(mission, altitude="amsl")
    assert greatest_height(mission.scenario, route.points) <= CEILING - error.vertical


def steep(seed):
    """Ground that rises by a half, with cliffs of some metres, and what is flown over it close below the ceiling."""
    rng = np.random.default_rng(seed)
    x = np.linspace(-600, 600, 121)
    heights = 0.5 * x[:, None] + 25 * np.sin(x / 60)[:, None] * np.cos(x / 80) + rng.uniform(-4, 4, (121, 121))
    return sky.Scenario(
        name="steep",
        bounds=sky.Bounds(min=(-500, -500, -400), max=(500, 500, 500)),
        terrain=Terrain(origin=(-600, -600), step=(10, 10), heights=heights, clearance=20.0),
        clearance=5.0,
        max_height=60.0,
        frame=sky.Frame(origin=ORIGIN),
        uavs=[
            sky.UAV(
                start=(-400, -300, float(heights[20, 30] + 40)),
                max_speed=5,
                max_climb=3,
                tracking_error=sky.TrackingError(horizontal=1.6, vertical=3.0),
            )
        ],
        targets=[sky.Target(position=(400, 300, float(heights[100, 90] + 40)))],
    )


@pytest.mark.parametrize("seed", range(4))
def test_a_flight_below_the_ceiling_over_rough_ground_is_exported(seed):
    mission = sky.plan_mission(steep(seed), sky.Taut())
    assert not mission.violations
    (route,) = sky.routes(mission, altitude="amsl")
    assert greatest_height(mission.scenario, route.points[1:-1]) <= 60.0 - 3.0


@pytest.mark.usefixtures("unjudged")
def test_a_way_home_over_a_valley_is_said_to_lead_above_the_ceiling(tmp_path):
    x = np.linspace(-300, 300, 61)
    ground = Terrain(origin=(-300, -300), step=(10, 10), heights=np.abs(x)[:, None] * 0.5 + np.zeros(61), clearance=2.0)
    across = [(-100, 0, 65), (0, 0, 15), (100, 0, 65)]
    mission = handmade.mission([handmade.along(across, 10)], terrain=ground, origin=ORIGIN, clearance=0.5)
    mission = replace(mission, scenario=mission.scenario.model_copy(update={"max_height": CEILING}))
    certificate, notes, _ = handmade.exported(mission, tmp_path, "plan")
    assert certificate.returns[0].gaps == ()
    assert "held to the ceiling" in " ".join(notes)
    with pytest.raises(sky.InputError, match=TOO_HIGH):  # a return that is planned is no emergency
        sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(end="rtl"))
