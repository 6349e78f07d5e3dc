"""The way that a UAV would fly if nothing moved: the corners of its mission's flight, on to its target."""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.cost import soft_terms
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.result import Result
from skyverse.model.scenario import Scenario
from skyverse.numerics.tolerances import LIMIT_MARGIN, MIN_PATH
from skyverse.planners.auto import Auto
from skyverse.planners.taut import Taut
from skyverse.problem import Airspace, Problem
from skyverse.trajectory.blended import blended_legs
from skyverse.trajectory.limits import limits_of
from skyverse.trajectory.path_to_trajectory import TOLERANCE, needed_waypoints
from skyverse.trajectory.straight_legs import blend_depths, without_repeats


class Way(NamedTuple):
    """Points to fly through one after another.

    Attributes
    ----------
    points
        (n, 3) metres.
    most
        (n,) metres that the blend at each point may be from it.
    marks
        (n,) which point of the guidance each of them is, -1 for others.
    """

    points: Floats
    most: Floats
    marks: Ints

    def after(self, k: int) -> "Way":
        """Return the way without its first k points."""
        return Way(self.points[k:], self.most[k:], self.marks[k:])

    def through(self, k: int, point: Floats, most: float) -> "Way":
        """Return the way with one more point before its k-th one."""
        points = np.concatenate([self.points[:k], point[None], self.points[k:]])
        allowed = np.concatenate([self.most[:k], [most], self.most[k:]])
        return Way(points, allowed, np.concatenate([self.marks[:k], [-1], self.marks[k:]]))


def mission_guidance(airspace: Airspace, mission: Mission, uav: int) -> Way:
    """Return the way of a UAV by its mission; without a path it stays at its start."""
    target, result = mission.assignment[uav], mission.results[uav]
    if target is None or result is None or not result.status.reached:
        return place_to_stay(np.array(mission.scenario.uavs[uav].start))
    return guidance(Problem(airspace, uav, target), result)


def planned_anew(scenario: Scenario, uav: int, target: int | None, place: Floats) -> Way | None:
    """Return another way of a UAV from a place (3,) to its target; ``None`` if there is none."""
    found = path_from(scenario, uav, target, place)
    return None if found is None else guidance(*found)


def path_from(scenario: Scenario, uav: int, target: int | None, place: Floats) -> tuple[Problem, Result] | None:
    """Return a path of a UAV from a place (3,) to its target, and its problem; ``None`` if there is none."""
    if target is None:
        return None
    uavs = list(scenario.uavs)
    uavs[uav] = derived(uavs[uav], start=tuple(place.tolist()))
    problem = Problem(derived(scenario, uavs=tuple(uavs)), uav, target)
    planner = Auto() if soft_terms(scenario) else Taut()  # in flight, the shorter search
    result = planner.plan(problem)
    return (problem, result) if result.status.reached else None


def guidance(problem: Problem, result: Result) -> Way:
    """Return the corners of a flight along a result's path, as far as blends at them are clear, from the start on."""
    world, uav = problem.airspace.world, problem.scenario.uavs[problem.uav]
    path = without_repeats(needed_waypoints(problem, result))
    if len(path) == 1 or np.linalg.norm(np.diff(path, axis=0), axis=1).sum() <= MIN_PATH:
        return place_to_stay(path[-1])
    best = blended_legs(world, path, limits_of(uav, -LIMIT_MARGIN), TOLERANCE)
    points = best.legs.points
    return Way(points.copy(), blend_depths(best.legs, best.speeds), np.arange(len(points)))


def place_to_stay(place: Floats) -> Way:
    """Return the guidance of a UAV that is to stay at a place (3,)."""
    return Way(np.array([place, place]), np.zeros(2), np.arange(2))
