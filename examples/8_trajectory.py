"""
Without stopping
================

The same path flown twice within the same limits: at rest at every waypoint, as the thesis does it, and as a smooth
trajectory. Both are proven before they leave ``plan_mission``.
"""

import matplotlib.pyplot as plt
import numpy as np

import skyverse as sky

scenario = sky.read("map3")
flights = {shape: sky.plan_mission(scenario, sky.Taut(), shape=shape) for shape in ("stop-and-go", "minimum-snap")}
for shape, mission in flights.items():
    print(f"{shape}: {mission.makespan:.2f} s, {mission.certificates[0].sentence}")

# %%
# Speed and acceleration: the smooth one flies at one limit or the other nearly all the time.

uav = scenario.uavs[0]
figure, axes = plt.subplots(2, 1, sharex=True, figsize=(8, 5), layout="constrained")
for (shape, mission), colour in zip(flights.items(), ("#8a94a6", "#1456c8"), strict=True):
    t = np.linspace(0, mission.makespan, 2000)
    motion = mission.trajectories[0].at(t)
    axes[0].plot(t, np.linalg.norm(motion.velocity, axis=1), color=colour, label=shape)
    axes[1].plot(t, np.linalg.norm(motion.acceleration, axis=1), color=colour)
for axis, limit, label in zip(
    axes, (uav.max_speed, uav.max_acceleration), ("speed, m/s", "acceleration, m/s²"), strict=True
):
    axis.axhline(limit, color="#c0392b", linewidth=1, linestyle="--")
    axis.text(0, limit, " limit", color="#c0392b", va="bottom")
    axis.set_ylabel(label)
    axis.set_ylim(0, 1.2 * limit)
axes[1].set_xlabel("seconds")
axes[0].legend(loc="upper right", ncols=2, frameon=False)
plt.show()

# %%
# From the side and from above: it passes the corners of the obstacles, grown by the clearance, at speed.

figure, axes = plt.subplots(2, 1, sharex=True, figsize=(8, 5), layout="constrained")
for axis, other, label in ((axes[0], 2, "z, m"), (axes[1], 0, "x, m")):
    for box in scenario.obstacles:
        low, high = np.array(box.min) - scenario.clearance, np.array(box.max) + scenario.clearance
        size = high - low
        axis.add_patch(plt.Rectangle((low[1], low[other]), size[1], size[other], color="#555555", alpha=0.2, lw=0))
    for (shape, mission), colour in zip(flights.items(), ("#8a94a6", "#1456c8"), strict=True):
        place = mission.trajectories[0].at(np.linspace(0, mission.makespan, 2000)).position
        axis.plot(place[:, 1], place[:, other], color=colour, label=shape)
    axis.set_ylabel(label)
    axis.set_xlim(scenario.bounds.min[1], scenario.bounds.max[1])
    axis.set_ylim(scenario.bounds.min[other], scenario.bounds.max[other])
axes[1].set_xlabel("y, m")
axes[0].legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, frameon=False)
plt.show()
