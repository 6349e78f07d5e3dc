"""The way that a UAV would fly if nothing moved: the corners of its mission's flight, on to its target.

The ways that are tried from where a UAV is: on along its way, past a mover, and away from it.
"""

import math
from collections.abc import Iterator
from itertools import product
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
from skyverse.space.world import World, path_free
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
    best = blended_legs(world, path, limits_of(uav, -LIMIT_MARGIN, world.scenario.winds), TOLERANCE)
    points = best.legs.points
    return Way(points.copy(), blend_depths(best.legs, best.speeds), np.arange(len(points)))


def place_to_stay(place: Floats) -> Way:
    """Return the guidance of a UAV that is to stay at a place (3,)."""
    return Way(np.array([place, place]), np.zeros(2), np.arange(2))


SHARES = (1.0, 0.6, 0.3)
"""Shares of the largest speed at which ways are tried."""
AT_REST = 1.0
"""Metres ahead of a UAV at rest at which it gets back to its guidance."""
SKIPPED = 3
"""Points of the guidance that may be left out at once."""
GATE_SHARES = (1.0, 0.5)
"""Those at which gates are tried."""
GATE_SIZES = (1.1, 2.0)
"""How far gates are from where a mover is met, in units of what must be kept from it."""
GATE_BLEND = 0.5
"""How far a blend at a gate may be from it, as a share of the gate's size."""
ESCAPE_SIZES = (1.0, 0.4)
"""How far places to escape to are, in units of how far the UAV gets from rest to rest."""
DIRECTIONS = np.vstack([np.eye(3), -np.eye(3), np.array(tuple(product((-1.0, 1.0), repeat=3))) / np.sqrt(3.0)])
"""(14, 3) unit vectors towards the faces and the corners of a cube."""


def ways_ahead(guidance: Way, mark: int, place: Floats, lead: float) -> Iterator[Way]:
    """Yield ways to the target that get back to the guidance at several places.

    Parameters
    ----------
    guidance, mark
        The guidance, and the number of its next point.
    place
        (3,) metres: where the UAV is.
    lead
        Metres ahead of the UAV at which it can get back to the guidance.
    """
    last = len(guidance.points) - 1
    mark = min(mark, last)
    for k in range(mark, min(mark + SKIPPED, last) + 1):
        yield guidance.after(k)
    leg = guidance.points[mark] - guidance.points[mark - 1]
    size = math.hypot(*leg)
    if mark and size > 0.0:
        along = float(np.sum((place - guidance.points[mark - 1]) * leg)) / size + lead
        if 0.0 < along < size:
            yield guidance.after(mark).through(0, guidance.points[mark - 1] + along / size * leg, 0.25 * lead)


def sees_its_way(world: World, place: Floats, guidance: Way, mark: int) -> bool:
    """Tell whether a UAV at rest gets straight back to its guidance, by a way that `ways_ahead` yields."""
    ways = ways_ahead(guidance, mark, place, AT_REST)
    return any(path_free(world.space, np.vstack([place, way.points[:1]])) for way in ways)


def gates(way: Way, place: Floats, meeting: Floats, k: int, need: float) -> Iterator[Way]:
    """Yield ways that pass a place of a way on all sides.

    Parameters
    ----------
    way
        A way that meets a mover on its leg to point k.
    place, meeting
        (3,) metres: where the way begins, and where it meets the mover.
    need
        Metres that must be kept from the mover there.
    """
    course = meeting - (way.points[k - 1] if k else place)
    size = math.hypot(*course)
    course = course / size if size > 0.0 else np.array([1.0, 0.0, 0.0])
    aside = np.cross(course, [0.0, 0.0, 1.0] if abs(course[2]) < 0.9 else [1.0, 0.0, 0.0])
    aside /= math.hypot(*aside)
    upwards = np.cross(aside, course)
    for size in GATE_SIZES:
        for turn in np.arange(8) * (np.pi / 4.0):
            to = np.cos(turn) * aside + np.sin(turn) * upwards
            yield way.through(k, meeting + size * need * to, GATE_BLEND * size * need)


def escapes(way: Way, place: Floats, reach: float) -> Iterator[Way]:
    """Yield ways that first lead away from a place (3,) in all directions, by up to `reach` metres."""
    for size in ESCAPE_SIZES:
        for to in DIRECTIONS:
            yield way.through(0, place + size * reach * to, GATE_BLEND * size * reach)
