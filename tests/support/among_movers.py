"""Missions of one UAV among movers and zones at times, made by hand, and what the referee says of them."""

import numpy as np

import skyverse as sky

MADE_BY = sky.Provenance("0", "by hand", "", None, "")
AGILE = {"max_speed": 1e3, "max_acceleration": 1e4, "max_jerk": 1e6, "max_tilt": 89.9, "thrust_to_weight": 1e3}
REST_TO_REST = np.array([0, 0, 0, 10, -15, 6.0])
BALL = sky.Sphere(centre=(0, 0, 0), radius=1.0)


def flight(a, b, seconds, start=0.0):
    """From rest at a to rest at b."""
    rows = (REST_TO_REST / seconds ** np.arange(6))[:, None] * (np.array(b, float) - a)
    rows[0] = a
    return sky.Trajectory(np.array([start, start + seconds]), rows[None])


def among(*movers, flown, zones=(), clearance=0.5, **fields):
    """A mission of one UAV among movers and zones."""
    a, b = (flown.at(t).position[0] for t in (flown.start, flown.end))
    scenario = sky.Scenario(
        name="movers",
        bounds=sky.Bounds(min=(-1e3, -1e3, -1e3), max=(1e3, 1e3, 1e3)),
        clearance=clearance,
        lattice=sky.Lattice(step=(100, 100, 100)),
        movers=movers,
        zones=zones,
        uavs=(sky.UAV(start=a, **(AGILE | fields)),),
        targets=(sky.Target(position=b),),
    )
    return sky.Mission(scenario, (0,), (None,), (flown,), (), MADE_BY)


def through(*zones, **more):
    return among(zones=zones, **more)


def verdict(mission):
    """What the referee says of the only UAV."""
    return sky.certify(mission.scenario, mission).trajectories[0]
