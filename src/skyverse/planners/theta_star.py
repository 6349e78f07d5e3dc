"""Any-angle search over the lattice: Lazy Theta*, with the exact lattice path as its fallback."""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.cost import make_pricing
from skyverse.model.result import Effort, History, Result, Status, no_history
from skyverse.model.scenario import Objective, Scenario
from skyverse.numerics.kernel import Stopwatch
from skyverse.numerics.norm import length_of
from skyverse.planners.base import Planner, Seed, planned_any_angle, provenance, unplanned
from skyverse.problem import Problem
from skyverse.search.lattice_astar import shortest_route
from skyverse.search.lazy_theta_star import lazy_theta_star
from skyverse.search.path_shortening.shorten_by_steps import shorten_by_steps
from skyverse.space.world import segment_free, without_seams
from skyverse.stop import OnIteration, Stop


@dataclass(frozen=True, kw_only=True)
class ThetaStar(Planner):
    """Lazy Theta*: a short path of straight legs, found over the scenario's lattice, not bound to its moves.

    The search expands lattice nodes, but a node's parent is any node that sees it. What it finds, and the lattice's
    exact shortest path, both joined to the UAV's true start and target, are pulled tight: corners go where their
    neighbours see each other, and slide, off the lattice too, as long as that makes the path shorter. The shorter of
    the two is the answer. So it is never longer than the lattice's shortest path, and often, though not provably, near
    the shortest of all.

    Legs keep clear of the closed obstacles, as the lattice's moves do: they do not slip through the seam of two boxes
    that touch. Length alone is minimised; turns and other terms are reckoned, but not sought. Its bound is the straight
    line's cost, and one turn where the straight line is not safe. `NO_PATH` and the other refusals are about the
    lattice: there is none on it, at this step.

    It ends by itself; `stop`, `rng` and `on_iteration` are taken for the sake of one call for all planners.

    References
    ----------
    A. Nash, S. Koenig, C. Tovey, "Lazy Theta*: Any-Angle Path Planning and Path Length Analysis in 3D" (AAAI 2010).
    """

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
        """Find a short path; see `Planner.plan`."""
        origin = provenance(repr(self), None, None)
        if problem.refusal is not None:
            return unplanned(problem, problem.refusal, origin)
        grid, world = problem.airspace.grid, problem.airspace.world
        metres = make_pricing(Objective(unit="metres"), grid.step)
        clock = Stopwatch()
        route = shortest_route(grid, metres, problem.source, problem.goal)
        if route is None:
            return unplanned(problem, Status.NO_PATH, origin)
        space = without_seams(world.space)
        corners, expanded = lazy_theta_star(grid, space, problem.source, problem.goal, math.inf)
        reach = float(grid.step.max())
        paths = [shorten_by_steps(space, reach, self._joined(problem, nodes)) for nodes in (corners, route.nodes)]
        path = min(paths, key=length_of)
        seconds = clock.seconds
        effort = Effort(generated_paths=2, generated_nodes=expanded + route.expanded, evaluations=2)
        objective = problem.scenario.objective
        straight = segment_free(world.space, problem.start, problem.end)
        bound = objective.fuel * math.dist(problem.start, problem.end) + objective.divergence * (not straight)
        result = planned_any_angle(problem, path, bound, effort, seconds, no_history(), "finished", origin)
        history = History(np.array([result.cost]), *(np.array([n]) for n in dataclasses.astuple(effort)))
        return dataclasses.replace(result, history=history)

    def _joined(self, problem: Problem, nodes: Ints) -> Floats:
        """Return the places of the nodes between the UAV's start and its target, none twice in a row."""
        if np.array_equal(problem.start, problem.end):
            return problem.start[None]
        path = np.vstack([problem.start, problem.places(nodes), problem.end])
        return path[np.r_[True, np.any(np.diff(path, axis=0) != 0.0, axis=1)]]
