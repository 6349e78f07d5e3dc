"""Trajectories of every shape climb and descend no faster than their UAV may, as the planners and the referee find."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from skyverse.model.verdict import Fault, Verdict
from skyverse.trajectory.proof import prove

CLIMB, DESCENT = 1.2, 0.7


def over_a_wall(**limits):
    """A flight that must climb 24 m over a wall and come down behind it."""
    return sky.Scenario(
        name="over a wall",
        bounds=sky.Bounds(min=(0, 0, 0), max=(60, 20, 40)),
        obstacles=[sky.Box(min=(28, 0, 0), max=(32, 20, 28))],
        clearance=1.0,
        lattice=sky.Lattice(step=(5, 5, 5)),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(start=(3, 10, 5), max_speed=8, max_acceleration=4, **limits)],
        targets=[sky.Target(position=(57, 10, 3))],
    )


@pytest.mark.parametrize("shape", ["minimum-time", "minimum-snap", "minimum-jerk", "stop-and-go"])
def test_a_trajectory_climbs_and_descends_within_its_limits_and_uses_them(shape):
    mission = sky.plan_mission(
        over_a_wall(max_climb=CLIMB, max_descent=DESCENT), sky.Taut(), rng=1, options=sky.MissionOptions(shape=shape)
    )
    assert mission.violations == ()
    assert mission.certificates[0].verdict is Verdict.PROVEN
    flown = mission.trajectories[0]
    assert (flown.form == "stop-and-go") == (shape == "stop-and-go")
    rates = flown.at(np.linspace(flown.start, flown.end, 20_001)).velocity[:, 2]
    assert 0.8 * CLIMB < rates.max() <= CLIMB * (1 + 1e-6)
    assert 0.8 * DESCENT < -rates.min() <= DESCENT * (1 + 1e-6)


def test_a_limit_that_is_not_reached_changes_nothing():
    free, wide = (sky.plan_mission(over_a_wall(**more), sky.Taut(), rng=1) for more in ({}, {"max_climb": 1e3}))
    t = np.linspace(0, free.trajectories[0].end, 101)
    assert np.allclose(free.trajectories[0].at(t).position, wide.trajectories[0].at(t).position, atol=0.05)


@pytest.mark.parametrize(("field", "fault"), [("max_climb", Fault.CLIMB_RATE), ("max_descent", Fault.DESCENT_RATE)])
def test_the_planners_proof_and_the_referee_refute_a_flight_that_is_too_steep(field, fault):
    mission = sky.plan_mission(over_a_wall(), sky.Taut(), rng=1)
    limited = over_a_wall(**{field: 1.0})
    proof = prove(sky.Problem(limited).airspace.world, limited.uavs[0], mission.trajectories[0])
    assert (proof.verdict, proof.what) == (Verdict.REFUTED, "vertical speed")
    found = sky.check(limited, replace(mission, scenario=limited))
    assert fault in {violation.fault for violation in found}


def test_fleets_whose_flights_are_delayed_or_slowed_keep_the_limits():
    scenario = over_a_wall(max_climb=CLIMB, max_descent=DESCENT, separation=2.0)
    other = scenario.uavs[0].model_copy(update={"name": "uav-2", "start": (3, 16, 5)})
    goal = sky.Target(name="target-2", position=(57, 4, 3))
    first = scenario.targets[0].model_copy(update={"position": (57, 16, 3)})
    fleet = scenario.model_copy(update={"uavs": (*scenario.uavs, other), "targets": (first, goal)})
    mission = sky.plan_mission(fleet, sky.Taut(), rng=1, assignment="identity")
    assert mission.violations == ()
    assert mission.deconfliction.found
    for flown in mission.trajectories:
        rates = flown.at(np.linspace(flown.start, flown.end, 20_001)).velocity[:, 2]
        assert -DESCENT * (1 + 1e-6) <= rates.min() <= rates.max() <= CLIMB * (1 + 1e-6)


def test_an_aeroplane_within_its_climb_angle_is_within_its_climb_rate():
    wing = sky.FixedWing(speed=12, turn_radius=20, climb=10)
    rise = 12 * np.tan(np.radians(10))
    scenario = sky.Scenario(
        name="climb",
        bounds=sky.Bounds(min=(0, 0, 0), max=(600, 600, 120)),
        clearance=1.0,
        lattice=sky.Lattice(step=(20, 20, 20)),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(start=(60, 300, 20), max_speed=14, max_acceleration=9, fixed_wing=wing, max_climb=rise)],
        targets=[sky.Target(position=(540, 300, 100))],
    )
    mission = sky.plan_mission(scenario, sky.Taut(), rng=1)
    assert mission.violations == ()
    assert mission.certificates[0].sentence.count("climb rate") == 1
