"""The exact answer as a planner."""

import time
from dataclasses import dataclass

import numpy as np

from skyverse import cost
from skyverse.model.result import Effort, History, Result, Status
from skyverse.planners.base import Planner, Seed, planned, provenance, unplanned
from skyverse.problem import Problem
from skyverse.search.lattice_astar import shortest_route
from skyverse.stop import OnIteration, Stop


@dataclass(frozen=True, kw_only=True)
class AStar(Planner):
    """A*: the cheapest path on the scenario's lattice under the whole objective, turns and soft terms included.

    It ends by itself; `stop`, `rng` and `on_iteration` are taken for the sake of one call for all planners.

    References
    ----------
    P. Hart, N. Nilsson, B. Raphael, "A Formal Basis for the Heuristic Determination of Minimum Cost Paths" (1968).
    """

    def plan(
        self,
        problem: Problem,
        *,
        stop: Stop | None = None,
        rng: Seed = None,
        on_iteration: OnIteration | None = None,
    ) -> Result:
        """Find a cheapest path; see `Planner.plan`."""
        origin = provenance(repr(self), None, None)
        if problem.refusal is not None:
            return unplanned(problem, problem.refusal, origin)
        if problem.route is None:  # asked for first, so that the kernel is compiled before the clock starts
            return unplanned(problem, Status.NO_PATH, origin)
        began = time.perf_counter()
        route = shortest_route(problem.airspace.grid, problem.airspace.pricing, problem.source, problem.goal)
        seconds = time.perf_counter() - began
        assert route is not None
        effort = Effort(generated_paths=1, generated_nodes=route.expanded, evaluations=1)
        price = cost.total(problem.airspace.grid, problem.airspace.pricing, route.nodes, problem.goal)
        history = History(np.array([price]), *(np.array([n]) for n in (1, route.expanded, 1)))
        return planned(problem, route.nodes, effort, seconds, history, "finished", origin)
