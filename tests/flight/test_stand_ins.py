"""A vehicle that stands in for another one gives no verdict on it, and is refused where it cannot hold its speed."""

import re
from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from skyverse.flight import vehicle_of

LOST = sky.Violation(sky.Fault.TRAJECTORY_ENDS, (0,), "uav-1 is lost")


def mission(vehicle, **limits):
    scenario = sky.Scenario(
        name="field",
        bounds={"min": (0, 0, 0), "max": (60, 20, 20)},
        clearance=1.0,
        lattice={"step": (2, 2, 2)},
        objective={"unit": "metres"},
        uavs=[{"start": (30, 10, 8), "vehicle": vehicle, **limits}],
        targets=[{"position": (5, 10, 8)}],
    )
    return sky.plan_mission(scenario, sky.Taut())


@pytest.fixture(scope="module")
def heavy():
    return mission("heavy")


@pytest.fixture(scope="module")
def slow():
    return mission("heavy", max_speed=4.0)


@pytest.mark.parametrize("fly", [sky.fly, lambda *given: sky.fly(*given, runs=1)])
def test_a_stand_in_that_cannot_hold_the_speed_in_the_wind_is_refused(heavy, fly):
    with pytest.raises(sky.InputError, match=r"thesis cannot hold 18 m/s in a wind of 8 m/s, and stands in for heavy"):
        fly(heavy, sky.Conditions(wind=(8.0, 0.0, 0.0)))


@pytest.mark.parametrize("runs", [None, 2])
def test_no_mission_is_made_easier_for_a_stand_in(slow, runs, refuses):
    with refuses():
        sky.fly_until_safe(slow, runs=runs)
    with refuses():
        sky.fly_until_safe(slow, sky.Conditions(vehicle="camera"), runs=runs)


def test_a_vehicle_holds_less_airspeed_the_lower_its_tilt_and_thrust():
    thesis = vehicle_of("thesis")
    assert 5.0 < thesis.top_airspeed < 23.0 < replace(thesis, max_tilt=None).top_airspeed


@pytest.mark.parametrize("wrong", [(), (LOST,)])
def test_what_a_stand_in_does_is_no_verdict_on_the_mission(heavy, wrong):
    flight = sky.Flight(heavy, sky.Conditions(vehicle="thesis"), 0, 0.5, (None,), (), wrong)
    assert flight.sentence.startswith("No verdict: thesis is not the vehicle that was planned")
    assert "afe" not in flight.sentence
    assert not flight.safe


def test_the_camera_drone_flies_as_fast_as_its_class_and_no_faster():
    camera = vehicle_of("camera")
    assert camera.top_airspeed == pytest.approx(21.0, abs=0.1)
    assert sky.VEHICLE_PROFILES["camera"].limits["thrust_to_weight"] < camera.thrust_to_weight


@pytest.mark.parametrize(
    ("wind", "safe"), [((0.0, 0.0, 0.0), True), ((3.0, 4.0, 0.0), True), ((25.0, 0.0, 0.0), False)]
)
def test_a_mission_for_camera_drones_gets_a_verdict(wind, safe):
    flown = sky.fly(mission("camera"), sky.Conditions(wind=wind), runs=2, rng=1)
    assert not flown.stands_in
    assert flown.safe == safe
    assert flown.sentence.startswith("Safe" if safe else "Not safe")
    if not safe:
        assert airspeeds(flown.violations[0].message) == asked(flown.mission, wind)
    if not any(wind):
        assert flown.held == (True, True)


def airspeeds(said):
    """The wind, and the speeds through the air that are asked and held, as a sentence tells them."""
    found = re.search(r"; in a wind of (\S+) m/s it is to fly at up to (\S+) m/s .* camera holds (\S+) m/s$", said)
    return tuple(map(float, found.groups()))


def asked(flown, wind):
    (motion,) = flown.trajectories
    through = motion.at(np.linspace(motion.start, motion.end, 5000)).velocity - wind
    return pytest.approx((25.0, np.linalg.norm(through, axis=1).max(), 21.0), rel=0.01)


def test_who_is_lost_is_said_to_have_been_flown_faster_than_the_vehicle_can():
    pytest.importorskip("rotorpy", reason='rotorpy is not installed; pip install "skyverse[flight]"')
    planned, wind = mission("camera"), (0.0, -25.0, 0.0)
    one = sky.fly(planned, sky.Conditions(wind=wind))
    another = sky.fly_replanned(sky.Replanner(planned), planned.scenario, conditions=sky.Conditions(wind=wind)).flight
    for flight, fault in ((one, "is lost"), (another, "has not arrived")):
        (lost,) = [found for found in flight.violations if fault in found.message]
        assert airspeeds(lost.message) == asked(flight.mission, wind)


@pytest.mark.parametrize(
    ("off", "held"), [((1.5, 0.0, 0.0), True), ((1.2, 1.2, 0.0), False), ((0.0, 0.0, -3.1), False)]
)
def test_one_flight_says_whether_the_stated_tracking_error_held(off, held):
    planned = mission("camera")
    assert planned.scenario.uavs[0].tracking_error == sky.TrackingError(horizontal=1.6, vertical=3.0)
    meant = np.array([[30.0, 10.0, 8.0], [29.0, 10.0, 8.0]])
    where = meant + np.array([(0.0, 0.0, 0.0), off])
    times, still = np.array([0.0, 0.01]), np.zeros((2, 3))
    one = sky.Flown(0, times, where, still, meant, 0.1, 1.0, 9.0, 0.0, 0.0, 0.5, 0.5, 9.0, 1.0)
    flight = sky.Flight(planned, sky.Conditions(vehicle="camera"), 0, 0.5, (one,), (), ())
    assert flight.held is held
    assert ("held" if held else "exceeded") in flight.tube_sentence
    exact = replace(flight, mission=mission("camera", tracking_error={"horizontal": 0.0, "vertical": 0.0}))
    assert exact.held is None
