"""
An aeroplane: turns and climbs that it can fly
==============================================

What cannot hover flies on at one speed, turns no tighter than a radius, and climbs no steeper than an angle. Its
trajectory is a Dubins path around and over obstacles, proven like every other.
"""

import matplotlib.pyplot as plt
import numpy as np

import skyverse as sky

# %%
# Two towers, and a wall across all of the space. The start lies close before the wall, too close to climb over it.

towers = [sky.Box(min=(130, 120, 0), max=(190, 260, 120)), sky.Box(min=(300, 0, 0), max=(350, 190, 120))]
wall = sky.Box(min=(480, 0, 0), max=(495, 400, 60))
wing = sky.FixedWing(speed=15, turn_radius=40, climb=12)  # m/s, m, degrees
scenario = sky.Scenario(
    name="valley",
    bounds=sky.Bounds(min=(0, 0, 0), max=(700, 400, 120)),
    obstacles=(*towers, wall),
    clearance=4,
    lattice=sky.Lattice(step=(10, 10, 10), connectivity=26),
    objective=sky.Objective(unit="metres"),
    uavs=(
        sky.UAV(name="from the west", start=(40, 200, 30), max_speed=16, max_acceleration=7, fixed_wing=wing),
        sky.UAV(name="at the wall", start=(440, 280, 10), max_speed=16, max_acceleration=7, fixed_wing=wing),
    ),
    targets=(sky.Target(position=(430, 90, 40)), sky.Target(position=(660, 330, 20))),
)
mission = sky.plan_mission(scenario, assignment="identity")
print(len(mission.violations), "violations")

# %%
# What it flies: the way seen from above against the straight legs of Taut, the tightest turn, the steepest climb.

motions = []
for uav, result, trajectory in zip(scenario.uavs, mission.results, mission.trajectories, strict=True):
    motion = trajectory.at(np.linspace(trajectory.start, trajectory.end, 4000))
    motions.append(motion)
    (vx, vy, vz), (ax, ay, _) = motion.velocity.T, motion.acceleration.T
    turning = np.abs(vx * ay - vy * ax) / np.hypot(vx, vy) ** 3
    climb = np.degrees(np.arctan2(np.abs(vz), np.hypot(vx, vy)))
    print(
        f"{uav.name}: {wing.speed * trajectory.end:.0f} m, straight legs {result.cost:.0f} m, "
        f"radius {1 / turning.max():.1f} m or more, climb {climb.max():.1f} degrees or less"
    )

# %%
# Seen from above, and the heights along the way. Where a climb does not fit the way, the way is made longer.

figure, (above, aside) = plt.subplots(2, figsize=(8, 7), height_ratios=(2, 1), layout="constrained")
for box, shade in zip(scenario.obstacles, ("0.6", "0.6", "0.85"), strict=True):
    above.add_patch(plt.Rectangle(box.min[:2], box.max[0] - box.min[0], box.max[1] - box.min[1], color=shade))
for uav, result, trajectory, motion in zip(scenario.uavs, mission.results, mission.trajectories, motions, strict=True):
    (line,) = above.plot(*motion.position[:, :2].T, linewidth=1.8, label=uav.name)
    above.plot(*result.path[:, :2].T, "--", linewidth=0.8, color=line.get_color())
    above.plot(*motion.position[0, :2], "o", color=line.get_color())
    way = wing.speed * np.linspace(trajectory.start, trajectory.end, 4000)
    aside.plot(way, motion.position[:, 2], linewidth=1.8, color=line.get_color())
above.set(xlabel="east (m)", ylabel="north (m)", xlim=(0, 700), ylim=(0, 400), aspect="equal")
above.legend(loc="upper left", frameon=False)
aside.set(xlabel="flown (m)", ylabel="height (m)")
plt.show()
