"""Missions that fly for a second or two, made by hand."""

import numpy as np

from skyverse.model.mission import Mission
from skyverse.model.result import Provenance
from skyverse.model.scenario import Bounds, Lattice, Scenario, Target
from skyverse.model.shapes import Box
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV


def straight(start, end, seconds, begin=0.0):
    """Return the minimum-jerk flight from rest to rest."""
    a, b = np.array(start, dtype=float), np.array(end, dtype=float)
    rows = np.zeros((1, 6, 3))
    rows[0, 0] = a
    for power, share in ((3, 10.0), (4, -15.0), (5, 6.0)):
        rows[0, power] = share * (b - a) / seconds**power
    return Trajectory(np.array([begin, begin + seconds]), rows)


def hall(size, uavs=(), targets=(), step=1.0, **more):
    """Return the scenario of an empty hall of a size, (3,) metres; UAVs and targets may be given as mere places."""
    given = {
        "name": "hall",
        "bounds": {"min": (0, 0, 0), "max": size},
        "clearance": 0.001,
        "lattice": {"step": (step, step, step), "connectivity": 26},
        "objective": {"unit": "metres"},
        "uavs": [uav if isinstance(uav, UAV | dict) else {"start": uav} for uav in uavs],
        "targets": [place if isinstance(place, Target | dict) else {"position": place} for place in targets],
    }
    return Scenario.model_validate(given | more)


def mission(*trajectories, boxes=(), clearance=0.25, separation=0.5, **limits):
    """Return a mission of these trajectories, ``None`` for a UAV that stays, in a space of 20 m."""
    starts = [(0.0, 15.0, 5.0) if t is None else tuple(t.at(t.start).position[0].tolist()) for t in trajectories]
    ends = [tuple(t.at(t.end).position[0].tolist()) for t in trajectories if t is not None]
    scenario = Scenario(
        name="by hand",
        bounds=Bounds(min=(-20, -20, 0), max=(20, 20, 10)),
        obstacles=tuple(Box(min=low, max=high) for low, high in boxes),
        clearance=clearance,
        lattice=Lattice(step=(1, 1, 1)),
        uavs=tuple(UAV(start=start, separation=separation, **limits) for start in starts),
        targets=tuple(Target(position=end) for end in ends),
    )
    made = iter(range(len(ends)))
    assignment = tuple(None if t is None else next(made) for t in trajectories)
    nothing = (None,) * len(trajectories)
    return Mission(scenario, assignment, nothing, trajectories, (), Provenance("", "by hand", "", 0, ""))
