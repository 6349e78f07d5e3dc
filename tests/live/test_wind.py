"""UAVs that are replanned among movers in a wind fly no faster through the air than they can, whatever gust blows."""

import numpy as np
import pytest

import skyverse as sky
from replanned import BALL, hall

CROSSING = sky.Mover(
    name="cart", shape=BALL, motion=sky.WaypointMotion(points=[(10, 0, 1), (10, 10, 1)], times=[0, 20], then="returns")
)


@pytest.mark.parametrize("policy", [None, "velocity-obstacles"])
@pytest.mark.parametrize("velocity", [(1.2, 0.4, 0.0), (-1.0, 0.0, 0.3)])
def test_replanned_flights_keep_the_airspeed_in_a_wind(velocity, policy):
    wind = sky.Wind(velocity=velocity, gust=0.3)
    fleet = [sky.UAV(start=(1, 5, 1), max_speed=2.0), sky.UAV(start=(19, 6, 1), max_speed=1.5, max_airspeed=2.0)]
    ends = [sky.Target(position=(19, 4, 1)), sky.Target(position=(1, 7, 2))]
    scenario = hall(uavs=fleet, targets=ends).model_copy(update={"wind": wind})
    mission = sky.plan_mission(scenario, assignment="identity")
    truth = scenario.model_copy(update={"movers": (CROSSING,)})
    replanner = sky.Replanner(mission, policy=policy)
    sky.fly_closed_loop(replanner, truth, sky.Sensor(range=6.0), longest=60.0)
    for uav in range(len(fleet)):
        flown = replanner.flown(uav)
        motion = flown.at(np.linspace(flown.start, flown.end, 20_000))
        through_air = np.linalg.norm(motion.velocity - np.array(velocity), axis=1) + wind.gust
        assert through_air.max() <= scenario.uavs[uav].airspeed * (1 + 1e-6)
        assert np.linalg.norm(motion.velocity, axis=1).max() > 0.3  # it does fly
