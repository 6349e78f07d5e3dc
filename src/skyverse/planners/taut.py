"""Shortest paths of any angle."""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Ints
from skyverse.cost import make_pricing, terms_of_legs
from skyverse.model.result import Effort, History, Provenance, Result, Status, no_history
from skyverse.model.scenario import Objective, Scenario
from skyverse.numerics.kernel import Stopwatch
from skyverse.planners.base import Planner, Seed, planned_any_angle, provenance, require, unplanned
from skyverse.problem import Problem
from skyverse.search.lattice_astar import shortest_route
from skyverse.search.taut.among_shapes import path_among_shapes
from skyverse.search.taut.taut_path import least_length, taut_path
from skyverse.space.lattice import Grid
from skyverse.space.world import only_boxes
from skyverse.stop import OnIteration, Stop


@dataclass(frozen=True, kw_only=True)
class Taut(Planner):
    """A shortest path of straight legs, free of the lattice, from the UAV's start to its target.

    Where a shortest path among boxes bends, it wraps around an edge of a grown one. A first way is found through the
    cells of a partition of free space, which is exact: if there is none, no path exists. It is then shortened window
    by window: A* over points sampled on the edges that a shorter path could touch, with lazy visibility; the bends
    slide along their edges to where the path is shortest; what that runs into gives further points; until nothing
    gets shorter. In a window that holds the whole problem that is, but for an unlucky sample, the shortest path.

    It prices length alone: turns and other terms are reckoned, but not sought. It ends by itself; `stop`, `rng` and
    `on_iteration` are taken for the sake of one call for all planners.

    Its `bound` is proven: the straight line's length, or, where few enough edges are near, the least cost of a way over
    intervals of edges in which every doubt is settled in the path's favour, raised by Lagrangian relaxation. It is to
    be read among paths that keep a ten-millionth of a metre of room: through the seam of touching obstacles goes none.

    The partition and the edges are made once an `Airspace`; its problems share them.

    Where there are other shapes than boxes and voxels, or a terrain, a few first ways are pulled tight along exact
    lines of sight, and the shortest is taken: the straight line lifted over all that it crosses, or past it on a side,
    and, unless that is within a thousandth of the straight line, Lazy Theta*'s and the shortest over the scenario's
    lattice. Nothing near the answer is shorter by more than about a thousandth,
    but another way around may be. `NO_PATH` then means that there is none over the lattice at this step, nor over the
    top or past a side; the bound is the straight line's length.

    Attributes
    ----------
    proof
        How many states the search for that bound may expand, about; 0 leaves it at the straight line.
    """

    proof: int = 300

    def __post_init__(self) -> None:
        require(self, "proof", 0)

    def leaves_lattice(self, scenario: Scenario) -> bool:
        """Tell whether paths leave the lattice: always."""
        return True

    def plan(
        self,
        problem: Problem,
        *,
        stop: Stop | None = None,
        rng: Seed = None,
        on_iteration: OnIteration | None = None,
    ) -> Result:
        """Find a shortest path; see `Planner.plan`."""
        origin = provenance(repr(self), None, None)
        refusal = problem.any_angle_refusal
        if refusal is not None:
            return unplanned(problem, refusal, origin)
        if not only_boxes(problem.airspace.world.space):
            return self._among_shapes(problem, origin)
        space, cells, edges = problem.airspace.world.space, problem.airspace.cells, problem.airspace.edges
        clock = Stopwatch()
        found = taut_path(space, cells, edges, problem.start, problem.end)
        least = least_length(space, edges, problem.start, problem.end, found.path, self.proof)
        seconds = clock.seconds
        if len(found.path) == 0:
            return unplanned(problem, Status.START_SHUT_IN if found.shut_in == 1 else Status.NO_PATH, origin)
        searches, expanded = (int(n) for n in found.spent)
        effort = Effort(generated_paths=searches, generated_nodes=expanded, evaluations=1)
        price = sum(terms_of_legs(problem.scenario, problem.airspace.rates, found.path, problem.end).values())
        history = History(np.array([price]), *(np.array([n]) for n in (searches, expanded, 1)))
        bound = least * problem.scenario.objective.fuel
        return planned_any_angle(problem, found.path, bound, effort, seconds, history, "finished", origin)

    def _among_shapes(self, problem: Problem, origin: Provenance) -> Result:
        """Find a way that nothing near it shortens, where there is more than boxes."""
        space, grid = problem.airspace.world.space, problem.airspace.grid
        nodes = problem.source, problem.goal
        clock = Stopwatch()
        path, expanded = path_among_shapes(
            space, grid, (problem.start, problem.end), nodes, lambda: _route(grid, *nodes)
        )
        seconds = clock.seconds
        if len(path) == 0:
            return unplanned(problem, problem.refusal or Status.NO_PATH, origin)
        effort = Effort(generated_paths=3, generated_nodes=expanded, evaluations=1)
        straight = problem.scenario.objective.fuel * math.dist(problem.start, problem.end)
        result = planned_any_angle(problem, path, straight, effort, seconds, no_history(), "finished", origin)
        history = History(np.array([result.cost]), *(np.array([n]) for n in dataclasses.astuple(effort)))
        return dataclasses.replace(result, history=history)


def _route(grid: Grid, source: int, goal: int) -> tuple[Ints, int]:
    """Return the nodes of a shortest route on the lattice, none where there is none, and how many were expanded."""
    route = shortest_route(grid, make_pricing(Objective(unit="metres"), grid.step), source, goal)
    return (np.empty(0, np.int64), 0) if route is None else (route.nodes, route.expanded)
