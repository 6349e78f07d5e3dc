"""
Moving obstacles: a train, a crane, and a restriction that ends
===============================================================

What moves in a stated way is a mover. A flight waits, flies more slowly or goes around it, and is proven clear of it at
every instant.
"""

# sphinx_gallery_thumbnail_number = 1
import matplotlib.pyplot as plt
import numpy as np

import skyverse as sky

train = sky.Mover(
    name="train",
    shape=sky.Box(min=(-12, -2, 0), max=(12, 2, 5)),
    motion=sky.WaypointMotion(points=[(-60, 30, 0), (160, 30, 0)], times=[-5, 15]),
)
crane = sky.Mover(
    name="crane",
    shape=sky.Cylinder(centre=(0, 0), radius=3, low=-40, high=2),
    motion=sky.CircularMotion(centre=(60, 75, 20), radius=20, period=40),
    doubt=sky.Doubt(radius=1, growth=0.05),  # metres, and metres a second
)
restriction = sky.Cylinder(centre=(50, 50), radius=9, low=0, high=30, name="airshow", active=[[0, 30]])
scenario = sky.Scenario(
    name="yard",
    bounds=sky.Bounds(min=(0, 0, 0), max=(100, 120, 25)),
    clearance=1,
    lattice=sky.Lattice(step=(5, 5, 5), connectivity=26),
    objective=sky.Objective(unit="metres"),
    movers=[train, crane],
    zones=[restriction],
    uavs=[sky.UAV(start=(50, 5, 3))],
    targets=[sky.Target(position=(55, 115, 3))],
)
mission = sky.plan_mission(scenario)
print(*(action.sentence for action in mission.deconfliction.actions), mission.certificates[0], sep="\n")

# %%
# How far the UAV is from both at each instant. The referee proves that it never comes nearer than 1 m, doubt included.

flown = mission.trajectories[0]
times = np.linspace(0, flown.end, 2000)
at = flown.at(times).position
figure, axes = plt.subplots(figsize=(8, 3.5), layout="constrained")
for mover in scenario.movers:
    axes.plot(times, np.linalg.norm(at - mover.at(times), axis=1), label=f"distance to the middle of the {mover.name}")
axes.set(xlabel="time (s)", ylabel="distance (m)", xlim=(0, flown.end), ylim=(0, None))
axes.legend(frameon=False)
plt.show()
