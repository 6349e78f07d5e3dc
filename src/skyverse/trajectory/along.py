"""A result's path flown: the trajectory that a mission carries."""

from typing import Literal

import numpy as np

from skyverse.cost import soft_terms
from skyverse.problem import Problem
from skyverse.result import Result, Trajectory
from skyverse.trajectory.quintic import rest_to_rest
from skyverse.trajectory.shortcut import drop_collinear, shortcut

Shape = Literal["minimum-snap", "minimum-jerk", "stop-and-go"]


def fly_along(problem: Problem, result: Result, shape: Shape = "minimum-snap") -> Trajectory | None:
    """Turn a result's path into a trajectory from the UAV's true start to its true target, or ``None``.

    Nodes on a straight line go, a line-of-sight shortcut leaves what is needed (unless the objective prices altitude,
    risk or climb, which it would not heed), and rest-to-rest quintics fly it.
    """
    if not result.status.reached:
        return None
    uav = problem.scenario.uavs[problem.uav]
    target = problem.scenario.targets[problem.target]
    waypoints = drop_collinear(np.vstack([uav.start, result.path, target.position]))
    if soft_terms(problem.scenario):  # a shortcut may be safe and yet lead through a zone, or out of the band
        return rest_to_rest(waypoints, uav)
    return rest_to_rest(shortcut(problem.airspace.world, waypoints), uav)
