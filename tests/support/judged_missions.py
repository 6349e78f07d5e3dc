"""A valid mission of three UAVs among two obstacles, and what changes it."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

import skyverse as sky
from skyverse.model.mission import Mission
from skyverse.model.result import Effort, History, Provenance, Result, Status, no_history
from skyverse.model.scenario import Bounds, Lattice, Objective, Scenario, Target
from skyverse.model.shapes import Box
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV

MADE_BY = Provenance("0", "by hand", "", None, "")


def mission_of(problem, result):
    """The mission of one UAV that flies along the path of a result."""
    return sky.Mission(problem.scenario, (0,), (result,), (sky.fly_along(problem, result),), (), MADE_BY)


def quintic(start, end, seconds, speed_in=(0, 0, 0), speed_out=(0, 0, 0), bend_in=(0, 0, 0), bend_out=(0, 0, 0)):
    """p0 + (p1 - p0) * (10 s^3 - 15 s^4 + 6 s^5), s = t / T, and what given speeds and accelerations add."""
    start, end, v, w, a, b = (np.array(value, float) for value in (start, end, speed_in, speed_out, bend_in, bend_out))
    d, T = end - start, seconds
    return np.array(
        [
            start,
            v,
            a / 2,
            (10 * d - (6 * v + 4 * w) * T + (b - 3 * a) / 2 * T**2) / T**3,
            (-15 * d + (8 * v + 7 * w) * T + (3 * a - 2 * b) / 2 * T**2) / T**4,
            (6 * d - (3 * v + 3 * w) * T + (b - a) / 2 * T**2) / T**5,
        ]
    )


def stops(waypoints, seconds=3.0, start=0.0):
    """A trajectory that stops at every waypoint."""
    pieces = [quintic(a, b, seconds) for a, b in pairwise(waypoints)]
    return Trajectory(start + seconds * np.arange(len(waypoints)), np.array(pieces))


def row(first, *legs):
    """Lattice nodes from `first` on, a metre apart; a leg is ("x", 3) or ("z", -1)."""
    path = [np.array(first, float)]
    for axis, count in legs:
        step = np.eye(3)["xyz".index(axis)] * np.sign(count)
        path += [path[-1] + step * k for k in range(1, abs(count) + 1)]
    return np.array(path)


def result(path, fuel, divergence=0.0, end=0.0, **other):
    path = np.array(path, float)
    fields = {
        "status": Status.COMPLETE,
        "path": path,
        "cost": fuel + divergence + end,
        "terms": {"fuel": float(fuel), "divergence": divergence, "end": end},
        "bound": None,
        "start": path[0],
        "goal": path[-1],
        "effort": Effort(),
        "seconds": 0.0,
        "history": no_history(),
        "stopped_by": "finished",
        "provenance": MADE_BY,
    }
    return Result(**(fields | other))


def no_result(status=Status.NO_PATH, **other):
    nowhere = np.zeros((1, 3))
    return replace(result(nowhere, 0), status=status, path=np.zeros((0, 3)), cost=np.inf, terms={}, **other)


def history(*cost):
    none = np.zeros(len(cost), np.int64)
    return History(np.array(cost, float), none, none, none)


SCENARIO = Scenario(
    name="two ways past a block",
    bounds=Bounds(min=(0, 0, 0), max=(10, 6, 4)),
    obstacles=(Box(min=(4, 0, 0), max=(5, 3, 3)), Box(min=(0, 0, 3.5), max=(1, 1, 4))),
    clearance=0.25,
    lattice=Lattice(step=(1, 1, 1)),
    objective=Objective(fuel=1, divergence=0.3, end=80, unit="nodes"),
    uavs=(
        UAV(name="alpha", start=(0.2, 4.1, 1.2), hover_power=120),
        UAV(name="bravo", start=(1.1, 5.2, 3.1)),
        UAV(name="charlie", start=(9, 1, 0.5)),
    ),
    targets=(
        Target(position=(8.9, 5.1, 3)),
        Target(position=(9.3, 4.2, 2.4)),
    ),
)


ALPHA, BEND, ALPHA_ENDS = (0.2, 4.1, 1.2), (4.7, 4.15, 1.8), (9.3, 4.2, 2.4)
VALID = Mission(
    scenario=SCENARIO,
    assignment=(1, 0, None),
    results=(
        result(row((0, 4, 1), ("x", 9), ("z", 1)), 11, 0.3, bound=10.0, history=history(90.5, 11.3, 11.3)),
        result(row((1, 5, 3), ("x", 8)), 9, status=Status.OPTIMAL, bound=9.0),
        None,
    ),
    trajectories=(stops([ALPHA, BEND, ALPHA_ENDS]), stops([(1.1, 5.2, 3.1), (5, 5, 3), (8.9, 5.1, 3)]), None),
    violations=(),
    provenance=MADE_BY,
)


def put(column, uav, value):
    return (*column[:uav], value, *column[uav + 1 :])


def flying(trajectory, uav=0, mission=VALID):
    return replace(mission, trajectories=put(mission.trajectories, uav, trajectory))


def resulting(changed, uav=0, mission=VALID):
    return replace(mission, results=put(mission.results, uav, changed))


def alpha(**changes):
    """Alpha's result with other fields."""
    return resulting(replace(VALID.results[0], **changes))


def walking(path, fuel, divergence=0.0, end=0.0, **other):
    """Alpha on another path, honestly priced."""
    fields = {"start": VALID.results[0].start, "goal": VALID.results[0].goal} | other
    return resulting(result(path, fuel, divergence, end, **fields))


def grounded(mission):
    """The same without alpha's trajectory."""
    return flying(None, mission=mission)


def given_uav(uav, **changes):
    """The valid mission for a scenario in which a UAV is another."""
    changed = SCENARIO.uavs[uav].model_copy(update=changes)
    return replace(VALID, scenario=SCENARIO.model_copy(update={"uavs": put(SCENARIO.uavs, uav, changed)}))


def coefficients(index, value, uav=0):
    changed = VALID.trajectories[uav].coefficients.copy()
    changed[index] = value
    return flying(replace(VALID.trajectories[uav], coefficients=changed), uav)


def knots(*values):
    return flying(replace(VALID.trajectories[0], knots=np.array(values, float)))


STRAIGHT = VALID.results[0].path
HOVER = Trajectory(np.array([0.0, 1.0]), np.array([[[9.0, 1.0, 0.5]]]))
SHORT = row((0, 4, 1), ("x", 9))
METRES = SCENARIO.model_copy(update={"objective": Objective(fuel=2, divergence=1, end=10, unit="metres")})


def in_metres(alphas):
    bravos = result(VALID.results[1].path, 16, status=Status.OPTIMAL, bound=16)
    return replace(VALID, scenario=METRES, results=(alphas, bravos, None))
