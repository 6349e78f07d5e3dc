"""Small surveys of every kind, planned for exports: fixed ones, and random ones."""

import numpy as np

import skyverse as sky
from flown_surveys import ORIGIN

WING = {"fixed_wing": {"speed": 14.0, "turn_radius": 30.0, "climb": 10.0}, "max_speed": 16.0, "max_acceleration": 12.0}
COPTER = {"max_speed": 10.0, "max_acceleration": 3.0}
OF_STRUCTURES = ("facade", "orbit", "viewpoints")
KINDS = ("flat", "hills", "two", "cross", "oblique", "corridor", "facade", "orbit", "viewpoints", "point", "time")


def _hills(rng):
    x = np.arange(-300.0, 501.0, 20.0)
    a, b, c = rng.uniform(40, 80), rng.uniform(40, 80), rng.uniform(5, 15)
    ground = 20.0 + c * np.sin(x / a)[:, None] * np.cos(x / b)[None]
    return sky.Terrain(origin=(-300, -300), step=(20, 20), heights=ground)


def planned_survey(kind, seed=0, **fields):
    """Return a mission of a small survey: its shape, overlap and heights are of the seed."""
    rng = np.random.default_rng([seed, 36])
    wide, high = rng.uniform(70, 150, 2) * (2.5 if seed % 4 == 3 and kind in ("flat", "hills", "two") else 1.0)
    lean = rng.uniform(-20, 20, 4)
    area = [(0.0, lean[0]), (wide + lean[1], 0.0), (wide, high), (lean[2], high + lean[3])]
    asked = {"camera": "mavic-3e", "gsd": float(rng.uniform(0.012, 0.025)), "overlap": (75, 65)}
    world = {}
    if kind in OF_STRUCTURES:
        low, size = rng.uniform(30, 50, 2), rng.uniform(12, 35, 2)
        (x, y), (u, v), top = low, low + size, float(rng.uniform(10, 25))
        outline = ((x, y), (u, y), (u, v), (x, v))
        world = {"obstacles": (sky.Prism(name="house", vertices=outline, low=0.0, high=top),), "clearance": 3.0}
        asked |= {"structures": ("house",), "gsd": None, "height": 15.0, "pattern": kind, "overlap": (70, 60)}
    elif kind == "corridor":
        line = np.r_[np.zeros((1, 2)), np.cumsum(rng.uniform((10, -50), (110, 50), (3, 2)), axis=0)]
        asked |= {"line": [tuple(place) for place in line.tolist()], "width": 50.0, "pattern": kind}
    else:
        asked |= {"area": area, "pattern": kind if kind in ("cross", "oblique") else "strips"}
    if kind == "hills":
        world = {"terrain": _hills(rng), "clearance": 2.0}
    if kind in ("point", "time"):
        asked["trigger"] = kind
    apart = {"separation": 5.0} if kind == "two" else {}
    rise = 3.0 if kind == "hills" else 0.0
    ground = float(world["terrain"].heights[14, 13]) if kind == "hills" else 0.0
    uavs = [
        {"name": f"uav-{k + 1}", "start": (-20.0 - 40.0 * k, -40.0, ground + rise), "end": "home"} | COPTER | apart
        for k in range(2 if kind == "two" else 1)
    ]
    if kind == "wing":
        uavs = [{"name": "wing", "start": (-40.0, -80.0, 60.0), "end": "home"} | WING]
    made = {
        "name": f"{kind} {seed}",
        "bounds": {"min": (-300, -300, 0), "max": (500, 500, 200)},
        "clearance": 0.0,
        "uavs": uavs,
        "surveys": [sky.Survey(**asked)],
        "frame": sky.Frame(origin=ORIGIN),
    }
    options = sky.MissionOptions(criterion="min-max") if kind == "two" else sky.MissionOptions()
    return sky.plan_mission(sky.Scenario.model_validate(made | world | fields), rng=seed, options=options)


def home_of(mission, uav):
    """Return where a UAV stands before it starts: on the ground below its start, which is a sample of the terrain."""
    (x, y, z), terrain = mission.scenario.uavs[uav].start, mission.scenario.terrain
    if terrain is None:
        return x, y, z
    i, j = ((np.array([x, y]) - terrain.origin) / terrain.step).astype(int)
    return x, y, float(terrain.heights[i, j])
