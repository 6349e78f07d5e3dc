"""The result of a path that no planner of ours has found."""

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.errors import InputError, shown
from skyverse.model.result import Result
from skyverse.model.short_lines import told_point
from skyverse.numerics.tolerances import SAME_PLACE
from skyverse.planners.base import points_of, provenance, require_problem
from skyverse.planners.results import SearchRecord, any_angle_result
from skyverse.planners.straight_legs import straight_bound
from skyverse.problem import Problem
from skyverse.space.world import World

PLACES_ON_A_LEG = 101
"""Places of a leg at which is asked what it meets."""


def result_of_path(problem: Problem, path: ArrayLike) -> Result:
    """Return the result of a path of one's own: priced as a path of any angle, and compared with the straight line.

    Planners of one's own return it, `fly_along` makes a trajectory of it, and the referee judges it as any other.

    Parameters
    ----------
    problem
        What the path is for.
    path
        (n, 3) metres: the corners of straight legs from where the UAV is. A path that does not end at the target is
        incomplete.

    Raises
    ------
    InputError
        If the path begins elsewhere, or a leg of it meets an obstacle, the ground or the bounds, with clearance.
    """
    require_problem(problem)
    points = points_of(path, "path")
    for end, place, top in ((0, problem.uav_place, problem.start), (-1, problem.target_place, problem.end)):
        if np.abs(points[end] - place).max() <= SAME_PLACE:
            points[end] = top  # in the column between them the UAV goes straight up or down
    if np.abs(points[0] - problem.start).max() > SAME_PLACE:
        places = f"{told_point(problem.uav_place)}, where the UAV is, found {told_point(points[0])}"
        raise InputError(f"expected it to begin at {places}", field="path")
    points[0] = problem.start
    if np.abs(points[-1] - problem.end).max() <= SAME_PLACE:
        points[-1] = problem.end
    _require_free(problem.airspace.world, points)
    origin = provenance("a path of one's own", None, None)
    return any_angle_result(problem, points, straight_bound(problem), SearchRecord(origin))


def _require_free(world: World, path: Floats) -> None:
    """Raise `InputError` for a path (n, 3) that meets something; the message names the leg, and a place on it."""
    if len(path) == 1:
        path = np.vstack([path, path])
    free = world.segments_free(path[:-1], path[1:])
    if free.all():
        return
    leg = int(np.argmin(free))
    on_it = path[leg] + np.linspace(0.0, 1.0, PLACES_ON_A_LEG)[:, None] * (path[leg + 1] - path[leg])
    why = ((place, world.why_unsafe(place)) for place in on_it)
    place, said = next((pair for pair in why if pair[1]), (path[leg], "meets something"))
    raise InputError(f"leg {leg} is not free: {told_point(place)} {said}", field="path")


def require_result(found: object) -> Result:
    """Return what a planner has answered, or raise `InputError` where that is no result."""
    if not isinstance(found, Result):
        said = f"expected it to return a Result, found {shown(found)}; result_of_path(...) makes one of a path"
        raise InputError(said, field="planner")
    return found
