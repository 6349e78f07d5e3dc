"""
Replanned in flight
===================

Movers that are not known beforehand are seen ten times a second, and the flight is replanned. What is flown from now on
always ends at rest in a place that stays clear, wherever the movers may be by then.
"""

import dataclasses

import skyverse as sky

mission = sky.plan_mission(sky.read("map3"), sky.Taut())
spinners = sky.random_movers(mission.scenario, 10, speed=0.5, seed=3).movers  # what the UAV does not know
replanner = sky.Replanner(mission)
t = 0.0
while replanner.arrival(0) is None or t < replanner.arrival(0):
    seen = [
        sky.Sighting(name=m.name, shape=m.shape, position=m.at(t)[0], top_speed=0.5, max_acceleration=0.5)
        for m in spinners
    ]
    (replan,) = replanner.observe(t, movers=seen)
    t += 0.1
print(replan.sentence, f"It arrives after {replanner.arrival(0):.1f} s, {mission.makespan:.1f} s without movers.")

# %%
# The referee proves the whole flight among the movers as they were.

scenario = sky.Scenario(**{**dict(mission.scenario), "movers": spinners})
flown = dataclasses.replace(mission, scenario=scenario, trajectories=(replanner.flown(0),))
sky.certify(scenario, flown).trajectories[0]
