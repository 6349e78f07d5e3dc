"""Trajectories in a wind: within the airspeed whatever gust blows, slower against it, and as before without it."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.wind import STILL_AIR, WindBall
from skyverse.trajectory.limits import THROUGH_AIR, limits_of, used_share

ROOM = sky.Scenario(
    name="room",
    bounds={"min": (0, 0, 0), "max": (80, 80, 60)},
    clearance=0.5,
    obstacles=[{"min": (30, 0, 0), "max": (40, 50, 60)}, {"min": (30, 60, 0), "max": (40, 80, 25)}],
    lattice={"step": (5, 5, 5)},
    objective={"unit": "metres"},
    uavs=[{"start": (5, 5, 5)}],
    targets=[{"position": (70, 20, 40)}],
)
UNIT = st.floats(-1, 1)


def in_wind(wind, uav=(), scenario=ROOM):
    """Return a scenario in a wind, whose UAV has other limits."""
    uavs = tuple(one.model_copy(update=dict(uav)) for one in scenario.uavs)
    return scenario.model_copy(update={"wind": wind, "uavs": uavs})


def airspeeds(flown, wind, gusts):
    """Return the airspeeds along a trajectory, sampled finely, in the wind and one of some gusts (n, 3) each time."""
    times = np.linspace(flown.start, flown.end, len(gusts))
    motion = flown.at(times)
    return np.linalg.norm(motion.velocity - wind.at(motion.position[:, 2]) - gusts, axis=1)


def gusts_within(gust, count, seed):
    """Return velocities (count, 3) in a ball, most of them on its rim."""
    rng = np.random.default_rng(seed)
    ways = rng.normal(size=(count, 3))
    return gust * np.minimum(rng.uniform(0, 2, (count, 1)), 1) * ways / np.linalg.norm(ways, axis=1)[:, None]


@given(st.tuples(UNIT, UNIT, UNIT), st.tuples(UNIT, UNIT, UNIT), st.floats(0, 0.999), st.floats(0.1, 40))
def test_the_share_of_the_airspeed_is_the_gauge_of_its_ball(wind, velocity, calm, airspeed):
    size = np.linalg.norm(wind)
    wind = tuple((calm * (airspeed - 0.002) / max(size, 1e-9) * np.array(wind)).tolist())
    uav = sky.UAV(start=(0, 0, 0), max_speed=1000, max_airspeed=airspeed)
    limits = limits_of(uav, 0.0, WindBall(wind, 0.001))
    share = used_share(limits, THROUGH_AIR, *velocity)
    if share > 0:
        on_rim = np.array(velocity) / share
        rim = np.linalg.norm(on_rim - np.array(wind))
        assert rim == pytest.approx(airspeed - 0.001, rel=1e-9)
    else:
        assert not any(velocity)
    for shorter in (0.3, 2.0):  # homogeneous, as a gauge is
        assert used_share(limits, THROUGH_AIR, *(shorter * np.array(velocity))) == pytest.approx(shorter * share)


@settings(deadline=None, max_examples=25)
@given(
    st.floats(0, 2 * math.pi),
    st.floats(0, 0.9),
    st.floats(0, 0.5),
    st.floats(3, 12),
    st.sampled_from(["minimum-time", "minimum-snap", "stop-and-go"]),
    st.integers(0, 2**20),
)
def test_what_is_planned_in_a_wind_is_proven_and_no_gust_makes_it_too_fast(turn, share, spare, top, shape, seed):
    blows = share * (top - 0.1)
    gust = spare * (top - 0.1 - blows)
    sheared = [
        {"altitude": 10, "velocity": (0.6 * blows * math.cos(turn), 0.6 * blows * math.sin(turn), 0)},
        {"altitude": 50, "velocity": (0.9 * blows * math.cos(turn), 0.9 * blows * math.sin(turn), 0.1 * blows)},
    ]
    wind = sky.Wind(layers=sheared, gust=gust) if seed % 2 else sky.Wind(velocity=sheared[1]["velocity"], gust=gust)
    scenario = in_wind(wind, {"max_speed": 1.2 * top, "max_airspeed": top})
    mission = sky.plan_mission(scenario, "taut", options=sky.MissionOptions(shape=shape))
    assert not mission.violations
    assert mission.certificates[0].verdict is sky.Verdict.PROVEN
    speeds = airspeeds(mission.trajectories[0], wind, gusts_within(gust, 20_000, seed))
    assert speeds.max() <= top * (1 + 2e-6)


def test_a_wind_makes_a_flight_against_it_slower_and_one_with_it_no_faster_than_the_limit_over_ground():
    east, west = ((5, 70, 30), (75, 70, 30)), ((75, 70, 30), (5, 70, 30))
    open_air = ROOM.model_copy(update={"obstacles": ()})
    times = []
    for start, end in (east, west):
        scenario = open_air.model_copy(
            update={"uavs": (sky.UAV(start=start, max_speed=8, max_airspeed=10),), "targets": ({"position": end},)}
        )
        mission = sky.plan_mission(scenario.model_copy(update={"wind": sky.Wind(velocity=(6, 0, 0))}), "taut")
        still = sky.plan_mission(scenario, "taut")
        speed = np.linalg.norm(mission.trajectories[0].at(np.linspace(0, mission.makespan, 2000)).velocity, axis=1)
        times.append((mission.makespan, still.makespan, speed.max()))
    assert times[0][0] == pytest.approx(times[0][1])
    assert times[0][2] == pytest.approx(8, rel=1e-6)
    assert times[1][2] == pytest.approx(10 - 6, rel=1e-6)
    assert times[1][0] > 1.6 * times[1][1]


@pytest.mark.parametrize("shape", ["minimum-time", "minimum-snap", "stop-and-go"])
def test_a_wind_that_the_airspeed_bears_anyway_changes_no_bit(shape):
    how = {"options": sky.MissionOptions(shape=shape)}
    still = sky.plan_mission(ROOM, "taut", **how).trajectories[0]
    blown = sky.plan_mission(in_wind(sky.Wind(velocity=(3, 1, 0), gust=1), {"max_airspeed": 10}), "taut", **how)
    assert np.array_equal(still.coefficients, blown.trajectories[0].coefficients)
    assert np.array_equal(still.knots, blown.trajectories[0].knots)
    assert limits_of(ROOM.uavs[0], 0.0, STILL_AIR).through_air == math.inf


def test_an_airspeed_below_the_speed_over_ground_counts_in_still_air():
    slow = sky.plan_mission(in_wind(None, {"max_airspeed": 2}), "taut")
    assert not slow.violations
    speeds = airspeeds(slow.trajectories[0], sky.Wind(velocity=(0, 0, 0)), np.zeros((5000, 3)))
    assert speeds.max() == pytest.approx(2, rel=1e-5)


@pytest.mark.parametrize(
    ("wind", "uav", "said"),
    [
        (
            {"speed": 14, "from": 270},
            {"max_airspeed": 12},
            "against 14 m/s from 270 degrees, uav-1, whose airspeed is at most 12 m/s, cannot hold its place",
        ),
        ({"speed": 4, "from": 270, "gust": 1}, {}, r"\(up to 1 m/s off\), uav-1, .* at most 5 m/s, cannot hold"),
        (
            {"layers": [{"altitude": 0, "velocity": (4, 0, 0)}, {"altitude": 60, "velocity": (-6.1, 0, 0)}]},
            {},
            "cannot hold",
        ),
        (
            {"velocity": (0, 4, 0), "gust": 1},
            {"max_speed": 20.0, "max_acceleration": 7.0, "fixed_wing": {"speed": 15, "turn_radius": 40, "climb": 7.5}},
            "cannot hold its speed over ground of 15 m/s: it flies in winds of 4.871 m/s at most",
        ),
    ],
)
def test_a_wind_in_which_a_uav_cannot_fly_is_refused(wind, uav, said):
    with pytest.raises(sky.InputError, match=said) as refused:
        sky.plan_mission(in_wind(sky.Wind.model_validate(wind), uav), "taut")
    assert refused.value.sentence.field == "wind"


def test_conflicts_are_resolved_in_a_wind_and_all_stays_proven():
    swap = sky.circle_swap(6)
    mission = sky.plan_mission(
        swap.model_copy(update={"wind": sky.Wind(velocity=(1.6, 0.5, 0), gust=0.4)}), "taut", assignment="identity"
    )
    assert mission.deconfliction.actions
    assert not mission.violations
    wind = mission.scenario.wind
    for seed, (uav, flown) in enumerate(zip(mission.scenario.uavs, mission.trajectories, strict=True)):
        assert airspeeds(flown, wind, gusts_within(0.4, 5000, seed)).max() <= uav.airspeed * (1 + 2e-6)
