"""The referee's own judgement of the wind, against dense sampling."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky

SPEED = st.floats(-4, 4)
CALM = sky.Scenario(
    name="air",
    bounds={"min": (-500, -500, -500), "max": (500, 500, 500)},
    clearance=0.0,
    lattice={"step": (50, 50, 50)},
    uavs=[{"start": (0, 0, 0), "max_speed": 1e3, "max_acceleration": 1e3, "max_jerk": 1e4}],
    targets=[{"position": (60, 20, 40)}],
)
PLANNED = sky.plan_mission(
    CALM.model_copy(update={"uavs": ({"start": (0, 0, 0), "max_speed": 9},)}),
    "taut",
    options=sky.MissionOptions(shape="minimum-snap"),
)


def judged(wind, airspeed, trajectory=PLANNED.trajectories[0], **limits):
    """Return what the referee finds wrong with the wind of a flight, and the certificate."""
    uav = CALM.uavs[0].model_copy(update={"max_airspeed": airspeed} | limits)
    scenario = CALM.model_copy(update={"wind": wind, "uavs": (uav,)})
    mission = replace(PLANNED, scenario=scenario, trajectories=(trajectory,))
    found = [one for one in sky.check(scenario, mission) if one.fault in (sky.Fault.WIND, sky.Fault.UNDECIDED)]
    return found, sky.certify(scenario, mission).trajectories[0]


@settings(deadline=None, max_examples=60)
@given(
    st.lists(
        st.tuples(st.integers(-40, 400).map(lambda n: n / 8), st.tuples(SPEED, SPEED, SPEED)),
        min_size=1,
        max_size=5,
        unique_by=lambda r: round(r[0]),
    ),
    st.floats(0, 2),
)
def test_an_airspeed_is_proven_just_above_what_is_needed_and_refuted_just_below(rows, gust):
    wind = sky.Wind(layers=[{"altitude": z, "velocity": velocity} for z, velocity in sorted(rows)], gust=gust)
    flown = PLANNED.trajectories[0]
    motion = flown.at(np.linspace(flown.start, flown.end, 40_000))
    needed = np.linalg.norm(motion.velocity - wind.at(motion.position[:, 2]), axis=1).max() + gust
    found, certificate = judged(wind, float(needed) * 1.001)
    assert not found
    assert certificate.verdict is sky.Verdict.PROVEN
    (found,), certificate = judged(wind, float(needed) * 0.999)
    assert found.fault is sky.Fault.WIND
    assert certificate.verdict is sky.Verdict.REFUTED
    at = flown.at([found.time])
    told = np.linalg.norm(at.velocity - wind.at(at.position[:, 2])) + gust
    assert told == pytest.approx(needed, rel=1e-4)
    assert f"flies at up to {told:.4g}"[:-1] in found.message


def test_a_flight_planned_in_still_air_is_refuted_in_a_wind_with_the_numbers():
    (found,), _ = judged(sky.Wind(velocity=(-8, 0, 0), gust=1), 12.0)
    assert "in a wind of 8 m/s from 90 degrees with gusts of 1 m/s (of 12) at t = " in found.message


def test_a_certificate_tells_the_wind_and_its_gusts():
    _, certificate = judged(sky.Wind(velocity=(1, 0, 0), gust=0.5), 20.0)
    assert (
        "speed through the air in a wind of 1 m/s from 270 degrees, with gusts of up to 0.5 m/s" in certificate.sentence
    )
    layers = [{"altitude": 0, "velocity": (1, 0, 0)}, {"altitude": 10, "velocity": (2, 0, 0)}]
    _, certificate = judged(sky.Wind(layers=layers), 20.0)
    assert (
        "1 m/s from 270 degrees at z = 0 m, by 2 layers, to 2 m/s from 270 degrees at z = 10 m" in certificate.sentence
    )


def test_a_uav_at_rest_needs_the_airspeed_of_the_wind():
    hover = sky.Trajectory(np.array([0.0, 5.0]), np.zeros((1, 1, 3)))
    wind = sky.Wind(velocity=(3, 4, 0))
    assert not judged(wind, 5.0, hover)[0]
    (found,), _ = judged(wind, 4.99, hover)
    assert "through the air in a wind of 5 m/s" in found.message


def test_an_aeroplane_holds_its_speed_in_no_more_wind_than_it_can():
    plane = sky.UAV(start=(0, 0, 0), vehicle="mapping")
    ring = sky.Scenario(
        name="field",
        bounds={"min": (-400, -400, 0), "max": (400, 400, 200)},
        clearance=0.0,
        lattice={"step": (20, 20, 20)},
        uavs=[plane.model_copy(update={"start": (-300, 0, 100)})],
        targets=[{"position": (300, 100, 100)}],
        wind={"velocity": (0, 4, 0), "gust": 0.7},
    )
    mission = sky.plan_mission(ring, "taut")
    assert not mission.violations
    stronger = ring.model_copy(update={"wind": sky.Wind(velocity=(0, 4, 0), gust=0.8)})
    (found,) = sky.check(stronger, replace(mission, scenario=stronger))
    assert found.fault is sky.Fault.WIND
    assert "holds its speed over ground in a wind of 4 m/s from 180 degrees" in found.message
    assert "(4.8 m/s, of 4.7)" in found.message


def test_no_wind_and_no_airspeed_ask_for_nothing():
    found, certificate = judged(None, None)
    assert not found
    assert "wind" not in certificate.sentence
    assert math.isfinite(PLANNED.makespan)
