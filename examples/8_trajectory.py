"""
Without stopping
================

One path, flown in four ways within the same limits. By default a UAV flies along the straight legs of its path in the
least time, with a blend at each bend. It can also fly a smooth curve near the path, or stop at every bend, as the
thesis does it. Each is proven before it leaves ``plan_mission``.
"""

import matplotlib.pyplot as plt
import numpy as np

import skyverse as sky

scenario = sky.random_downtown(60, seed=1)
shapes = ("minimum-time", "minimum-snap", "minimum-jerk", "stop-and-go")  # the first one is the default
missions = {shape: sky.plan_mission(scenario, options=sky.MissionOptions(shape=shape)) for shape in shapes}
for shape, mission in missions.items():
    trajectory = mission.trajectories[0]
    print(f"{shape:12}  {trajectory.form:11}  {mission.makespan:.2f} s  {trajectory.note}")

# %%
# What a notebook shows of a mission that is the last thing in a cell:

missions["minimum-time"]

# %%
# The default over time. It is at the limit of speed nearly all the time, and at the limit of acceleration when it
# starts, turns and brakes.

uav = scenario.uavs[0]
sky.plot(missions["minimum-time"].trajectories[0], uav)

# %%
# Stopping at every bend takes longer.

sky.plot(missions["stop-and-go"].trajectories[0], uav)

# %%
# From above, at one bend: the blend keeps near the path, which leads around the grown corner of a building; a smooth
# curve takes the space that there is. Obstacles are drawn as grown by the clearance.

bend = missions["stop-and-go"].results[0].path[3]
figure, axes = plt.subplots(figsize=(7, 6), layout="constrained")
for box in scenario.obstacles:
    low, high = np.array(box.min) - scenario.clearance, np.array(box.max) + scenario.clearance
    axes.add_patch(plt.Rectangle(low[:2], *(high - low)[:2], color="#555555", alpha=0.25, lw=0))
for (shape, mission), style in zip(missions.items(), ("-", "--", ":", "-"), strict=True):
    trajectory = mission.trajectories[0]
    place = trajectory.at(np.linspace(trajectory.start, trajectory.end, 5000)).position
    axes.plot(place[:, 0], place[:, 1], style, label=shape, linewidth=1 if shape == "stop-and-go" else 2)
axes.set(xlim=bend[0] + np.array([-20, 20]), ylim=bend[1] + np.array([-17, 17]), xlabel="x, m", ylabel="y, m")
axes.set_aspect("equal")
axes.legend(frameon=False)
plt.show()
