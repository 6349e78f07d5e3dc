"""
A survey of a ridge, proven
===========================

Two UAVs photograph a slope beside the Jacksboro fault at 4 cm a pixel. What photos show of every place, and that nothing is
missed, is proven over the terrain.
"""

import matplotlib.pyplot as plt
import numpy as np

import skyverse as sky

ridges = sky.read("jacksboro")
places = np.array([(4400.0, -1500.0), (4440.0, -1460.0)])
home = np.column_stack([places, ridges.terrain.height(places) + 40.0])
uavs = [{"vehicle": "camera", "start": tuple(start), "end": "home"} for start in home.tolist()]

# %%
# The survey says what is to be seen: an area, by a camera, how finely, and how much of each photo its neighbours show as
# well. On a slope the ground sample distance is kept in the photo that is nearest to each place.

area = [(3500, -1700), (4100, -1800), (4200, -1200), (3700, -1000), (3400, -1250)]
survey = {"area": area, "camera": "mavic-3e", "gsd": "4 cm", "overlap": (75, 65), "gsd_of": "place"}
scenario = sky.Scenario.model_validate(
    ridges.model_dump()
    | {
        "name": "slope",
        "description": "A slope beside the Jacksboro fault.",
        "uavs": uavs,
        "targets": [],
        "obstacles": [],
    }
    | {"surveys": [survey], "max_height": 170.0, "objective": {"unit": "metres"}}
)
mission = sky.plan_mission(scenario, rng=1, options=sky.MissionOptions(criterion="min-max"))
print(mission)
print(mission.coverage[0].sentence)

# %%
# Strips follow the ground, with as few bends as the asked ground sample distance, the overlap and the clearance allow. Each
# dot is a photo; its colour is how high above ground it is taken, and lines are level of the ground, 20 m apart.

photos = sky.photos_of(mission)
above = photos.position[:, 2] - scenario.terrain.height(photos.position[:, :2])
east, north = np.meshgrid(np.arange(3200.0, 4600.0, 20.0), np.arange(-2000.0, -800.0, 20.0))
heights = scenario.terrain.height(np.column_stack([east.ravel(), north.ravel()])).reshape(east.shape)
figure, (over, side) = plt.subplots(1, 2, figsize=(12, 5), layout="constrained", width_ratios=(3, 2))
over.contour(east, north, heights, levels=np.arange(0, 1000, 20), colors="#b0a898", linewidths=0.6)
over.fill(*np.array(area, dtype=float).T, fill=False, edgecolor="black")
for uav, trajectory in zip(scenario.uavs, mission.trajectories, strict=True):
    if trajectory is not None:
        path = trajectory.at(np.linspace(trajectory.start, trajectory.end, 3000)).position
        over.plot(path[:, 0], path[:, 1], linewidth=0.8, label=uav.name)
    over.plot(*uav.start[:2], "s", color="black", markersize=5)
shown = over.scatter(*photos.position[:, :2].T, c=above, s=9, cmap="viridis", zorder=3)
figure.colorbar(shown, ax=over, label="above ground, m")
over.set(xlabel="east, m", ylabel="north, m", aspect="equal")
over.legend(loc="upper left")

longest = max(
    np.unique(photos.strip[photos.uav == 0]), key=lambda strip: np.sum((photos.uav == 0) & (photos.strip == strip))
)
one = photos.taken((photos.uav == 0) & (photos.strip == longest))
along = np.hypot(*(one.position[:, :2] - one.position[0, :2]).T)
fine = np.linspace(0.0, 1.0, 300)[:, None] * (one.position[-1, :2] - one.position[0, :2]) + one.position[0, :2]
flown = np.linspace(0.0, along[-1], 300)
side.fill_between(flown, scenario.terrain.height(fine), 200.0, color="#d3c7b2", label="ground")
side.plot(along, one.position[:, 2], "o-", markersize=3, label="photos of a strip")
side.set(
    xlabel="along the strip, m", ylabel="z, m", ylim=(one.position[:, 2].min() - 250, one.position[:, 2].max() + 50)
)
side.legend()
