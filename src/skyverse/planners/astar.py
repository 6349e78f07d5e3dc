"""The exact optimum on the lattice as a planner."""

from dataclasses import dataclass

from skyverse.model.result import Effort, Provenance, Result, Status
from skyverse.numerics.kernel import Stopwatch
from skyverse.planners.base import DirectPlanner
from skyverse.planners.results import SearchRecord, lattice_result
from skyverse.problem import Problem
from skyverse.search.lattice_astar import shortest_route


@dataclass(frozen=True, kw_only=True)
class AStar(DirectPlanner):
    """A*: the cheapest path on the scenario's lattice under the whole objective, turns and soft terms included.

    It ends by itself: `stop`, `rng` and `on_iteration` have no effect.

    References
    ----------
    P. Hart, N. Nilsson, B. Raphael, "A Formal Basis for the Heuristic Determination of Minimum Cost Paths" (1968).
    """

    def find(self, problem: Problem, origin: Provenance) -> Result | Status:
        """Return a cheapest path, or the status that says why there is none."""
        if problem.refusal is not None:
            return problem.refusal
        if problem.route is None:  # asked for first, so that the kernel is loaded before the clock starts
            return Status.NO_PATH
        clock = Stopwatch()
        route = shortest_route(problem.airspace.grid, problem.airspace.pricing, problem.source, problem.goal)
        seconds = clock.seconds
        assert route is not None
        effort = Effort(generated_paths=1, generated_nodes=route.expanded, evaluations=1)
        return lattice_result(problem, route.nodes, SearchRecord(origin, effort, seconds))
