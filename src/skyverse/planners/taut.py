"""Shortest any-angle paths as a planner."""

import math
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Ints
from skyverse.cost import make_pricing
from skyverse.errors import require_whole
from skyverse.model.result import Effort, Provenance, Result, Status
from skyverse.model.scenario import Objective, Scenario
from skyverse.numerics.kernel import Stopwatch
from skyverse.planners.base import DirectPlanner
from skyverse.planners.results import SearchRecord, any_angle_result
from skyverse.problem import Problem
from skyverse.search.lattice_astar import shortest_route
from skyverse.search.taut.among_shapes import path_among_shapes
from skyverse.search.taut.taut_path import taut_path
from skyverse.space.lattice import Grid
from skyverse.space.obstacles import only_boxes


@dataclass(frozen=True, kw_only=True)
class Taut(DirectPlanner):
    """A shortest path of straight legs, independent of the lattice, from the UAV's start to its target.

    Where a shortest path among boxes bends, it wraps around an edge of a grown box. A first path is found through the
    cells of a partition of free space, which is exact: if there is no such path, no path exists. It is then shortened
    window by window. In each window, A* searches over points that are sampled on the edges that a shorter path could
    touch, with lazy visibility. The bends then slide along their edges to where the path is shortest. Obstacles that
    block the new path add further points, and the search is repeated until the path gets no shorter. Unless the bound
    proves that little can be gained, other ways round are then sought over all edges that a shorter path could touch:
    over the middles of their intervals, which are halved again and again. The result is the shortest path, unless the
    middles happen to miss it or the search over many edges ends early.

    It minimises length alone; turns and other terms are priced but not minimised. It ends by itself: `stop`, `rng` and
    `on_iteration` have no effect.

    Its `bound` is proven. It is the length of the straight line or, where few enough edges are near, that of a path
    over intervals of edges, where every doubt is decided in favour of a shorter path. Intervals that no shorter path
    touches are struck out and the others halved, until a gap of 2 % and then one of 0.005 % is proven. Where boxes
    reach through the whole space along an axis, such as buildings through the ceiling, the bound is at least the exact
    shortest length among their projections. The bound and `NO_PATH_EXISTS` hold for all paths that keep
    the whole clearance.

    The partition and the edges are computed once for each `Airspace`, and its problems share them.

    Where there are other shapes than boxes and voxels, or a terrain, a few first paths are shortened along exact lines
    of sight, and the shortest is the answer. They are the straight line lifted over all that it crosses or led past it
    on a side and, unless the best of these is within a thousandth of the straight line, the path of Lazy Theta* and the
    shortest path on the scenario's lattice. No path near the answer is shorter by more than about a thousandth, but a
    path around the other side of an obstacle may be. `NO_PATH` then means that there is no path on the lattice at this
    step, and none over the top or past a side. The bound is the length of the straight line.

    Attributes
    ----------
    proof
        About how many thousand pairs of intervals the search for the bound and for other ways round may look at, less
        where the gap to a simpler bound is small. With 0 no other ways are sought, and the bound is that of the
        straight line.
    """

    proof: int = 400

    def __post_init__(self) -> None:
        require_whole(self.proof, "proof", 0)

    def leaves_lattice(self, scenario: Scenario) -> bool:
        """Tell whether paths leave the lattice: always."""
        return True

    def find(self, problem: Problem, origin: Provenance) -> Result | Status:
        """Return a shortest path, or the status that says why there is none."""
        refusal = problem.any_angle_refusal
        if refusal is not None:
            return refusal
        if not only_boxes(problem.airspace.world.space):
            return self._among_shapes(problem, origin)
        space, cells, edges = problem.airspace.world.space, problem.airspace.cells, problem.airspace.edges
        clock = Stopwatch()
        found = taut_path(space, cells, edges, problem.start, problem.end, 1000 * self.proof)
        seconds = clock.seconds
        if len(found.path) == 0:
            return Status.START_SHUT_IN if found.shut_in == 1 else Status.NO_PATH_EXISTS
        searches, expanded = (int(n) for n in found.spent)
        effort = Effort(generated_paths=searches, generated_nodes=expanded, evaluations=1)
        bound = found.least * problem.scenario.objective.fuel
        return any_angle_result(problem, found.path, bound, SearchRecord(origin, effort, seconds))

    def _among_shapes(self, problem: Problem, origin: Provenance) -> Result | Status:
        """Return a path that no small change shortens, where there are other obstacles than boxes and voxels."""
        space, grid = problem.airspace.world.space, problem.airspace.grid
        nodes = problem.source, problem.goal
        clock = Stopwatch()
        path, expanded = path_among_shapes(
            space, grid, (problem.start, problem.end), nodes, lambda: _route(grid, *nodes)
        )
        seconds = clock.seconds
        if len(path) == 0:
            shut_in = problem.refusal is Status.START_SHUT_IN  # other refusals are of the lattice, not of the ends
            return Status.START_SHUT_IN if shut_in else Status.NO_PATH
        effort = Effort(generated_paths=3, generated_nodes=expanded, evaluations=1)
        straight = problem.scenario.objective.fuel * math.dist(problem.start, problem.end)
        return any_angle_result(problem, path, straight, SearchRecord(origin, effort, seconds))


def _route(grid: Grid, source: int, goal: int) -> tuple[Ints, int]:
    """Return the nodes of a shortest path on the lattice, none where there is no path, and how many were expanded."""
    route = shortest_route(grid, make_pricing(Objective(unit="metres"), grid.step), source, goal)
    return (np.empty(0, np.int64), 0) if route is None else (route.nodes, route.expanded)
