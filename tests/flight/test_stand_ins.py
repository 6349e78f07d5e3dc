"""A vehicle that stands in for another one gives no verdict on it, and is refused where it cannot hold its speed."""

from dataclasses import replace

import pytest

import skyverse as sky
from skyverse.flight.vehicle import vehicle_of
from skyverse.model.flight_record import Flight
from skyverse.model.verdict import Fault, Violation


def mission(vehicle):
    scenario = sky.Scenario(
        name="field",
        bounds={"min": (0, 0, 0), "max": (60, 20, 20)},
        clearance=1.0,
        lattice={"step": (2, 2, 2)},
        objective={"unit": "metres"},
        uavs=[{"start": (5, 10, 8), "vehicle": vehicle}],
        targets=[{"position": (30, 10, 8)}],
    )
    return sky.plan_mission(scenario, sky.Taut())


@pytest.fixture(scope="module")
def camera():
    return mission("camera")


@pytest.mark.parametrize("fly", [sky.fly, lambda one, **how: sky.fly_many(one, runs=1, **how)])
def test_a_stand_in_that_cannot_hold_the_speed_in_the_wind_is_refused(camera, fly):
    with pytest.raises(sky.InputError, match=r"thesis cannot hold 15 m/s in a wind of 8 m/s, and stands in for camera"):
        fly(camera, wind=(8.0, 0.0, 0.0))


def test_a_vehicle_holds_less_airspeed_the_lower_its_tilt_and_thrust():
    thesis = vehicle_of("thesis")
    assert thesis.holds(5.0)
    assert not thesis.holds(23.0)
    assert replace(thesis, max_tilt=None).holds(23.0)


@pytest.mark.parametrize("wrong", [(), (Violation(Fault.TRAJECTORY_ENDS, (0,), "uav-1 is lost"),)])
def test_what_a_stand_in_does_is_no_verdict_on_the_mission(camera, wrong):
    flight = Flight(camera, "thesis", (0.0, 0.0, 0.0), 0.0, 0, 0.5, (None,), (), wrong)
    assert flight.sentence.startswith("No verdict: thesis is not the vehicle that was planned")
    assert "afe" not in flight.sentence
