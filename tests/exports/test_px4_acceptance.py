"""PX4 goes on with its return before it is quite where it should be; its parameter file says how far before."""

import handmade_exports as handmade
import numpy as np
import pytest
from exported_fleets import ORIGIN as FIELD
from exported_fleets import read_orders
from replayed_autopilot import fly

import skyverse as sky
from skyverse import Origin, Terrain
from skyverse.exports import USUAL_TOLERANCE, WAYS, timed_path
from skyverse.exports.flight_parts import flown_legs

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = Origin(latitude=47.0, longitude=8.5, altitude=400.0, geoid=48.0)
FLAT = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=np.zeros((33, 33)), clearance=1.0)
BESIDE, BELOW = 1.0, 0.5


def exported(mission, folder, suffix="plan", **how):
    return handmade.exported(mission, folder, suffix, **how).back


def test_the_parameter_file_says_how_near_is_near_enough(tmp_path):
    exported(handmade.mission([handmade.along([(0, 0, 10), (50, 0, 10)], 20)], origin=ORIGIN), tmp_path)
    values = handmade.parameters(tmp_path)
    assert values["NAV_ACC_RAD"] == BESIDE
    assert values["NAV_MC_ALT_RAD"] == BELOW
    assert values["RTL_MIN_DIST"] <= BESIDE  # PX4 1.14 would return lower within that


def gap(box, points):
    return float(np.maximum(np.array(box[0]) - points, points - np.array(box[1])).max(axis=1).min())


def as_px4(place, home, level):
    """The way over the wall if PX4 goes on 0.5 m below the return altitude, and climbs the rest at once or evenly."""
    shares = np.linspace(0, 1, 2000)[:, None]
    start, over = np.array([*place[:2], max(level - BELOW, place[2])]), np.array([*home[:2], level])
    flat = np.array([*home[:2], start[2]])
    return np.concatenate([start + shares * (over - start), start + shares * (flat - start)])


def test_a_wall_is_passed_with_half_the_clearance_also_below_the_return_altitude(tmp_path):
    wall = ((30, -200, -50), (31, 200, 50.0))
    flight = handmade.along([(0, 0, 10), (0, 0, 70), (60, 0, 70), (60, 0, 10)], 10)
    back = exported(handmade.mission([flight], boxes=[wall], clearance=1.0, origin=ORIGIN), tmp_path)
    assert not back.gaps
    level = back.plan.home[2] + handmade.parameters(tmp_path)["RTL_RETURN_ALT"]
    for place in ((60.0, 0.0, 10.0), (60.0, 0.0, level - 0.2), (40.0, 0.0, 30.0)):
        assert gap(wall, as_px4(np.array(place), back.plan.home, level)) >= 0.5 - 0.02


@pytest.mark.parametrize(
    ("suffix", "away", "clear"), [("plan", 1.2, False), ("plan", 1.8, True), ("waypoints", 1.2, True)]
)
def test_a_descent_that_begins_before_it_is_over_home_keeps_clear_of_walls(tmp_path, suffix, away, clear):
    """The wall stands between home and the flight, lower than the return; PX4 descends beside it, or onto it."""
    wall = ((away, -10, -5), (away + 1, 10, 6))
    flight = handmade.along([(0, 0, 12), (100, 0, 12)], 20)
    mission = handmade.mission([flight], boxes=[wall], clearance=1.0, origin=ORIGIN, terrain=FLAT)
    back = exported(mission, tmp_path, suffix)
    beside = np.array([[BESIDE, 0.0, z] for z in np.linspace(1, 12, 100)])
    assert (gap(wall, beside) >= 0.5) == (away >= BESIDE + 0.5)
    assert (not back.gaps) == clear
    if not clear:
        assert {gap.why for gap in back.gaps} == {WAYS[2]}


def test_a_flight_along_the_bounds_may_return_along_them(tmp_path):
    mission = handmade.mission([handmade.along([(0, 0, 12), (100, 0, 12)], 20)], origin=ORIGIN, terrain=FLAT)
    low = mission.scenario.bounds.model_copy(update={"min": (-300.0, 0.0, -50.0)})
    assert not exported(handmade.changed(mission, bounds=low), tmp_path).gaps


@pytest.mark.parametrize("degrees", [20, 40])
def test_a_uav_returns_to_a_home_on_a_slope(tmp_path, degrees):
    """Beside home the ground is nearer to it than the clearance that it keeps there."""
    heights = np.tan(np.radians(degrees)) * np.linspace(-320, 320, 33)[:, None] * np.ones((1, 33))
    ground = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=heights, clearance=1.0)
    flight = handmade.along([(0, 0, 12), (0, 100, 12)], 20)
    mission = handmade.mission([flight], clearance=1.0, origin=ORIGIN, terrain=ground)
    back = exported(mission, tmp_path)
    assert not back.gaps
    assert back.plan.home[2] == 0.0


@pytest.mark.parametrize(("high", "clear"), [(1.5, False), (1.9, False), (2.1, True)])
def test_no_return_altitude_is_written_from_which_px4_climbs_higher(tmp_path, high, clear):
    """PX4 1.14 returns no lower than twice `NAV_ACC_RAD` above home, where it may leave the bounds."""
    flat = FLAT.model_copy(update={"clearance": 0.5})
    flight = handmade.along([(0, 0, 1), (100, 0, 1)], 20)
    mission = handmade.mission([flight], origin=ORIGIN, terrain=flat, high=(300, 300, high))
    back = exported(mission, tmp_path, radius=0.3, takeoff=0)
    assert (not back.gaps) == clear
    assert handmade.parameters(tmp_path)["RTL_RETURN_ALT"] >= 2 * BESIDE


@pytest.mark.parametrize("radius", [0.3, 2.0])
def test_separations_count_that_a_takeoff_ends_below_its_waypoint(tmp_path, radius):
    """PX4 takes `NAV_MC_ALT_RAD` off the climb and flies straight on from there, earlier, and below the first leg."""
    mission = handmade.mission([handmade.along([(0, 0, 10), (60, 0, 10)], 20)], origin=ORIGIN, terrain=FLAT)
    plan = exported(mission, tmp_path, radius=radius).plan
    below = handmade.parameters(tmp_path)["NAV_MC_ALT_RAD"]
    path = timed_path(mission.scenario, plan, USUAL_TOLERANCE)
    top, to = plan.waypoints[:2]
    (leg,) = np.flatnonzero((path.starts == top).all(axis=1) & (path.ends == to).all(axis=1))
    shares = np.linspace(0, 1, 50)
    lower = np.column_stack([top[0] + shares * (to - top)[0], 0 * shares, top[2] - (1 - shares) * below])
    counted = path.deviation[leg, 0] + shares * np.diff(path.deviation[leg])
    assert (np.abs(lower[:, 2] - top[2]) <= counted).all()
    least = (top[2] - below - plan.home[2]) / USUAL_TOLERANCE.fastest_climb
    assert path.earliest[leg, 0] <= plan.delay + least + 1e-9


def as_taken_off(plan):
    """The first leg of a UAV that PX4 turns to it as far below its waypoint as `NAV_MC_ALT_RAD` allows."""
    top, to = plan.waypoints[:2]
    begin = top - [0.0, 0.0, plan.takeoff_cut]
    return begin + np.linspace(0, 1, 2000)[:, None] * (to - begin)


@pytest.mark.parametrize(("top", "higher"), [(8.9, 0.0), (9.59, 0.0), (9.9, 0.0), (9.99, 0.5)])
def test_the_first_leg_is_clear_also_from_below_its_waypoint(tmp_path, top, higher):
    """The start is so high that the take-off ends there; a box stands beside it, 2 m away, below the first leg."""
    box = ((2, -10, -50), (6, 10, top - 0.4))
    flight = handmade.along([(0, 0, 10), (50, 0, 10)], 20)
    mission = handmade.mission([flight], boxes=[box], clearance=0.4, origin=ORIGIN, terrain=FLAT)
    back = exported(mission, tmp_path)
    assert back.plan.takeoff_cut == handmade.parameters(tmp_path)["NAV_MC_ALT_RAD"]
    assert gap(box, as_taken_off(back.plan)) >= 0.4 - 0.021
    assert back.plan.waypoints[0][2] == 10 + higher


def test_returns_begin_wherever_a_cut_takeoff_leads(tmp_path):
    """PX4 cuts the take-off, and the corner after a first leg of 3.5 m 2 m before its end: there it is still lower."""
    flight = handmade.along([(0, 0, 10), (3.5, 0, 10), (3.5, 60, 10)], 20)
    box = ((0.1, 4, -50), (0.85, 6, 9.5))  # for which the route keeps the corner
    mission = handmade.mission([flight], boxes=[box], clearance=0.6, origin=ORIGIN, terrain=FLAT)
    back = exported(mission, tmp_path)
    plan, legs = back.plan, flown_legs(back.plan, mission.scenario, 0.0)
    first = as_taken_off(plan)
    turned = first[np.argmax(np.linalg.norm(first - plan.waypoints[1], axis=1) <= plan.route.radius)]
    assert turned[2] < 9.8
    second = turned + np.linspace(0, 1, 200)[:, None] * (plan.waypoints[2] - turned)
    parts = legs.parts(0.2)
    low, high = parts.box
    low, high = low - legs.off(parts)[:, None], high + legs.off(parts)[:, None]
    for leg, places in ((0, first[::10]), (1, second)):
        own = parts.leg == leg
        assert (leg == 0) == (parts.box[0][own, 2].min() == 9.5)
        held = ((low[own] <= places[:, None] + 0.01) & (places[:, None] - 0.01 <= high[own])).all(axis=2)
        assert held.any(axis=1).all()


@pytest.mark.parametrize("speed", [0.3, 0.4, 0.7, 2.0])
@pytest.mark.parametrize("acceleration", [0.2, 2.0])
def test_a_slow_uav_stops_at_its_corner_in_a_narrow_corridor(tmp_path, speed, acceleration):
    """PX4 counts a stop from when it is near: a slow UAV would turn before it is there, into the inner wall."""
    walls = [((-5, 0.55, 0), (11.45, 17, 6)), ((-5, -3, 0), (15, -0.55, 6)), ((12.55, -0.55, 0), (15, 17, 6))]
    uav = sky.UAV(start=(0, 0, 2.0), max_speed=speed, max_acceleration=acceleration, home=0.0)
    scenario = sky.Scenario(
        name="corridor",
        frame=sky.Frame(origin=FIELD),
        bounds=sky.Bounds(min=(-5, -3, 0), max=(15, 17, 6)),
        clearance=0.5,
        obstacles=[sky.Box(min=low, max=high) for low, high in walls],
        lattice=sky.Lattice(step=(0.5, 0.5, 0.5)),
        objective=sky.Objective(unit="metres"),
        uavs=[uav],
        targets=[sky.Target(position=(12, 12, 2.0))],
    )
    mission = sky.plan_mission(scenario, rng=1)
    assert not sky.check(scenario, mission)
    certificate, _, files = handmade.exported(mission, tmp_path, end="land")
    assert certificate.flights[0].legs_proven
    (orders,) = read_orders(scenario, files)
    track = fly(orders, 1.5, 1.5, 1.0, 1.0)
    flown = track[np.argmax(track[:, 2] > 1) :]
    assert min(gap(wall, flown[flown[:, 2] > 0.5]) for wall in walls) >= 0.48
    assert np.linalg.norm(track - (12, 12, 2), axis=1).min() < 0.06  # it lands from above its target
