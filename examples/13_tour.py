"""
Ten masts, two UAVs, three batteries
====================================

Masts on the ridges of Jacksboro are inspected by two UAVs with three batteries between them, in wind. Who goes where, in
which order, and when a battery is changed follows from what each leg takes.
"""

import matplotlib.pyplot as plt
import numpy as np

import skyverse as sky

ridges = sky.read("jacksboro")
MASTS = np.array(
    [
        (4075, 1200), (4600, 600), (3700, 700), (4300, -300), (3400, 100),
        (3100, -600), (3800, -900), (4500, -1000), (3000, 900), (4950, 200),
    ],
    dtype=float,
)  # fmt: skip
HEIGHT = 60.0
ground = ridges.terrain.height(MASTS)

# %%
# A UAV stands for four minutes beside each mast, 25 m from it and 50 m above ground, and looks at its top. Home is where
# each UAV starts; there it changes its battery within 90 seconds. Of 77 Wh, 20 % are the reserve, and another 10 % are
# not counted on.

home = [(4774.6, -475.8), (4926.8, -353.7)]
uavs = [
    {
        "vehicle": "camera",
        "start": (x, y, float(ridges.terrain.height([(x, y)])[0]) + 40.0),
        "end": "home",
        "swap": 90.0,
    }
    | {"batteries": batteries}
    for (x, y), batteries in zip(home, (2, 1), strict=True)
]
masts = [
    {"shape": "cylinder", "centre": (x, y), "radius": 1.0, "low": z - 5.0, "high": z + HEIGHT, "kind": "mast"}
    for (x, y), z in zip(MASTS.tolist(), ground.tolist(), strict=True)
]
targets = [
    {"name": f"mast-{k}", "position": (x + 25.0, y, z + 50.0), "look_at": (x, y, z + HEIGHT), "stay": 240.0}
    for k, ((x, y), z) in enumerate(zip(MASTS.tolist(), ground.tolist(), strict=True), 1)
]
scenario = sky.Scenario.model_validate(
    ridges.model_dump()
    | {"name": "ten-masts", "description": "Ten masts on the ridges beside the Jacksboro fault."}
    | {"uavs": uavs, "targets": targets, "obstacles": masts, "wind": {"speed": 6, "from": 250, "gust": 2}}
)

mission = sky.plan_mission(scenario, rng=1)
print(mission)
for uav, sorties in zip(scenario.uavs, mission.sorties, strict=True):
    for number, sortie in enumerate(sorties, 1):
        visited = ", ".join(scenario.targets[visit.target].name for visit in sortie.visits)
        print(f"{uav.name}, sortie {number}, {sortie.begin:.0f} to {sortie.end:.0f} s: {visited}")

# %%
# Two batteries would not do, so uav-1 comes home for its second. What each sortie takes at most, in the stated wind and its
# gusts, is proven to fit into its battery. Seen from above, with the masts in the order of the visits:

east, north = np.meshgrid(np.arange(2800.0, 5200.0, 50.0), np.arange(-1300.0, 1500.0, 50.0))
heights = ridges.terrain.height(np.column_stack([east.ravel(), north.ravel()])).reshape(east.shape)
figure, axes = plt.subplots(figsize=(8, 7), layout="constrained")
axes.contourf(east, north, heights, levels=20, cmap="Greys", alpha=0.5)
for uav, trajectory, sorties in zip(scenario.uavs, mission.trajectories, mission.sorties, strict=True):
    for number, sortie in enumerate(sorties, 1):
        path = trajectory.at(np.linspace(sortie.begin, sortie.end, 2000)).position
        axes.plot(path[:, 0], path[:, 1], label=f"{uav.name}, sortie {number}")
        for count, visit in enumerate(sortie.visits, 1):
            place = scenario.targets[visit.target].position[:2]
            axes.annotate(str(count), place, (7, 7), textcoords="offset points", fontsize=12, fontweight="bold")
    axes.plot(*uav.start[:2], "s", color="black")
axes.plot(MASTS[:, 0], MASTS[:, 1], "^", color="tab:red", label="mast")
axes.annotate("", (3250, 1400), (2870, 1262), arrowprops={"arrowstyle": "-|>", "lw": 2})  # from 250 degrees
axes.text(2870, 1340, "wind, 6 m/s")
axes.set(xlabel="east, m", ylabel="north, m", aspect="equal")
axes.legend()
