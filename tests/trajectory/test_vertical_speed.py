"""Trajectories of every shape climb and descend no faster than their UAV may, as the planners and the referee find."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from handmade import hall
from skyverse.trajectory import prove

CLIMB, DESCENT = 1.2, 0.7


def over_a_wall(**limits):
    """A flight that must climb 24 m over a wall and come down behind it."""
    wall = sky.Box(min=(28, 0, 0), max=(32, 20, 28))
    uav = sky.UAV(start=(3, 10, 5), max_speed=8, max_acceleration=4, **limits)
    return hall((60, 20, 40), [uav], [(57, 10, 3)], step=5, obstacles=[wall], clearance=1.0)


@pytest.mark.parametrize("shape", ["minimum-time", "minimum-snap", "minimum-jerk", "stop-and-go"])
def test_a_trajectory_climbs_and_descends_within_its_limits_and_uses_them(shape):
    mission = sky.plan_mission(
        over_a_wall(max_climb=CLIMB, max_descent=DESCENT), sky.Taut(), rng=1, options=sky.MissionOptions(shape=shape)
    )
    assert mission.violations == ()
    assert mission.certificates[0].verdict is sky.Verdict.PROVEN
    flown = mission.trajectories[0]
    assert (flown.form == "stop-and-go") == (shape == "stop-and-go")
    rates = flown.at(np.linspace(flown.start, flown.end, 20_001)).velocity[:, 2]
    assert 0.8 * CLIMB < rates.max() <= CLIMB * (1 + 1e-6)
    assert 0.8 * DESCENT < -rates.min() <= DESCENT * (1 + 1e-6)


@pytest.mark.parametrize(
    ("field", "fault"), [("max_climb", sky.Fault.CLIMB_RATE), ("max_descent", sky.Fault.DESCENT_RATE)]
)
def test_the_planners_proof_and_the_referee_refute_a_flight_that_is_too_steep(field, fault):
    mission = sky.plan_mission(over_a_wall(), sky.Taut(), rng=1)
    limited = over_a_wall(**{field: 1.0})
    proof = prove(sky.Problem(limited).airspace.world, limited.uavs[0], mission.trajectories[0])
    assert (proof.verdict, proof.what) == (sky.Verdict.REFUTED, "vertical speed")
    found = sky.check(limited, replace(mission, scenario=limited))
    assert fault in {violation.fault for violation in found}


def test_an_aeroplane_within_its_climb_angle_is_within_its_climb_rate():
    wing = sky.FixedWing(speed=12, turn_radius=20, climb=10)
    rise = 12 * np.tan(np.radians(10))
    uav = sky.UAV(start=(60, 300, 20), max_speed=14, max_acceleration=9, fixed_wing=wing, max_climb=rise)
    scenario = hall((600, 600, 120), [uav], [(540, 300, 100)], step=20, clearance=1.0)
    mission = sky.plan_mission(scenario, sky.Taut(), rng=1)
    assert mission.violations == ()
    assert mission.certificates[0].sentence.count("climb rate") == 1
