"""Missions over hills and among buildings, made by hand."""

import dataclasses

import numpy as np

import skyverse as sky


def hills(size=1000.0, step=10.0, clearance=20.0):
    """Waves of 40 m on a slope."""
    x = np.arange(0.0, size + step, step)
    east, north = np.meshgrid(x, x, indexing="ij")
    heights = 30 + 0.02 * east + 20 * np.sin(east / 90) * np.cos(north / 70)
    return sky.Terrain(origin=(0, 0), step=(step, step), heights=heights, clearance=clearance)


def rectangle(centre, length, width, turn):
    """The corners of a turned rectangle."""
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (length / 2, width / 2)
    cos, sin = np.cos(turn), np.sin(turn)
    return tuple(map(tuple, corners @ np.array([[cos, sin], [-sin, cos]]) + centre))


def buildings(count, size=1000.0, rng=3):
    """Turned rectangles, one in twenty with a courtyard."""
    rng = np.random.default_rng(rng)
    side = int(np.ceil(np.sqrt(count)))
    cell = size / side
    found = []
    for k in range(count):
        centre = (np.array(divmod(k, side)) + 0.5) * cell
        turn = rng.uniform(0, np.pi)
        holes = (rectangle(centre, 0.2 * cell, 0.1 * cell, turn),) if k % 20 == 0 else ()
        low, high = 0.0, float(rng.uniform(60, 90))
        outer = rectangle(centre, 0.6 * cell, 0.4 * cell, turn)
        found.append(sky.Prism(vertices=outer, holes=holes, low=low, high=high, kind="building"))
    return tuple(found)


def line(start, end, seconds):
    """A straight flight at constant speed."""
    start, end = np.array(start, float), np.array(end, float)
    return sky.Trajectory(np.array([0.0, seconds]), np.array([[start, (end - start) / seconds]]))


def town(count=50, terrain=True, origin=True):
    """Two UAVs over `count` buildings, with shapes of every sort and kind."""
    occupied = np.zeros((4, 4, 3), dtype=bool)
    occupied[1:3, 1:3] = occupied[0, 0, 0] = True
    obstacles = (
        *buildings(count),
        sky.Cylinder(centre=(800, 200), radius=60, low=0, high=150, kind="no-fly zone", solid=False),
        sky.Sphere(centre=(200, 800, 140), radius=30, kind="balloon"),
        sky.Voxels(origin=(500, 100, 40), step=(10, 10, 10), occupied=occupied, kind="rubble"),
        sky.Box(min=(880, 880, 0), max=(920, 920, 100)),
    )
    school = sky.Prism(vertices=rectangle((500, 500), 80, 60, 0.4), low=0, high=150, kind="school", risk=2)
    ends = (((100, 100, 130), (900, 850, 160)), ((850, 60, 140), (100, 700, 120)))
    band = sky.AltitudeBand(low=40, high=90, weight=0.1, above="ground") if terrain else None
    scenario = sky.Scenario(
        name="town",
        bounds=sky.Bounds(min=(0, 0, 0), max=(1000, 1000, 200)),
        obstacles=obstacles,
        zones=(school,),
        terrain=hills() if terrain else None,
        clearance=5,
        lattice=sky.Lattice(step=(20, 20, 20)),
        objective=sky.Objective(unit="metres", altitude=band),
        uavs=tuple(sky.UAV(start=start) for start, _ in ends),
        targets=tuple(sky.Target(position=end) for _, end in ends),
        frame=sky.Frame(origin=sky.Origin(latitude=46.8, longitude=9.8, altitude=1500)) if origin else sky.Frame(),
    )
    flights = tuple(line(start, end, 60.0) for start, end in ends)
    return sky.Mission(scenario, (0, 1), (None, None), flights, (), sky.Provenance("", "by hand", "", 0, ""))


def with_terrain(mission, terrain):
    """The same mission over other ground."""
    scenario = mission.scenario.model_copy(update={"terrain": terrain})
    return dataclasses.replace(mission, scenario=scenario)
