"""Cheap any-angle paths under a whole objective as a planner."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from skyverse import cost
from skyverse._typing import Floats
from skyverse.errors import require_whole
from skyverse.model.result import Effort, Provenance, Result, Status
from skyverse.model.scenario import Scenario
from skyverse.numerics.kernel import Stopwatch, writable
from skyverse.numerics.tolerances import OPTIMALITY_GAP
from skyverse.planners.astar import AStar
from skyverse.planners.base import DirectPlanner
from skyverse.planners.results import SearchRecord, any_angle_result
from skyverse.planners.straight_legs import joined_to_ends, straight_bound
from skyverse.planners.taut import Taut
from skyverse.planners.waypoint_own import WaypointMVO
from skyverse.problem import Problem
from skyverse.search.cheapest.cheapest_path import LEGS, PATHS, cheapest_path
from skyverse.search.cheapest.lower_bound import lower_bound
from skyverse.space.obstacles import Space
from skyverse.space.world import path_free
from skyverse.stop import MaxEvaluations

CHEAP_ENOUGH = 0.001
"""The proven gap, as a share of the bound, of a path beside which no other ways are sought."""

ANOTHER_START, EVALUATIONS = WaypointMVO(legs="straight", waypoints=3, greedy=True), MaxEvaluations(10_000)
"""What finds a further path before a search that begins anew."""


@dataclass(frozen=True, kw_only=True)
class Cheapest(DirectPlanner):
    """A cheap path of straight legs under the whole objective: metres, turns, altitude, risk and climb.

    It begins with the path of `Taut` and with the cheapest path on the lattice, that of `AStar`. Each is made cheaper
    by descent: joints are left out, moved, shifted in pairs and added, as long as that lowers the price, and legs stay
    free. Then other ways are tried. A roadmap holds places around obstacles and zones, random places, and the joints of
    good paths; ways over it, and random changes of the best path, are made cheaper by descent in turn. No other ways
    are tried beside a path that costs at most 0.1 % more than the straight line's length. So the answer is never dearer
    than the paths it begins with, and no small change makes it cheaper; a quite different path may be.

    Which other ways are found depends on the random numbers. With `restarts` the search begins anew so many times, with
    others and with a path of `WaypointMVO` over three waypoints too, and the cheapest path is the answer.

    Random numbers come from fixed seeds, so that the same problem has the same answer. It ends by itself: `stop`,
    `rng` and `on_iteration` have no effect. In its effort, an evaluation is a leg that was priced.

    Its `bound` is proven. It is the price of the straight line's length, or a greater one that counts how obstacles and
    zones make ways over the map dearer, and what paths pay for climbs outside the altitude band. One turn is added
    where the straight line is not free. A band above ground and the ground itself are not counted.

    Attributes
    ----------
    legs
        After about so many priced legs no other ways are tried, or earlier, where as many as before the last gain of
        0.05 %, and a fifth of all, were in vain. A million takes about a second over terrain.
    restarts
        How many times the search begins anew, each time with as many legs.
    proof
        About how many cells the lattice over the map has that proves the bound: about a fifth of a second for each
        100,000. With 0 the bound is that of the straight line.
    """

    legs: int = 1_000_000
    restarts: int = 0
    proof: int = 50_000

    def __post_init__(self) -> None:
        require_whole(self.legs, "legs", 0)
        require_whole(self.restarts, "restarts", 0)
        require_whole(self.proof, "proof", 0)

    def leaves_lattice(self, scenario: Scenario) -> bool:
        """Tell whether paths leave the lattice: always."""
        return True

    def find(self, problem: Problem, origin: Provenance) -> Result | Status:
        """Return a cheap path, or the status that says why there is none."""
        space, bound = problem.airspace.world.space, straight_bound(problem)
        clock = Stopwatch()
        found = [_as_legs(problem, planner.plan(problem)) for planner in (Taut(), AStar())]
        known = [path for path in found if len(path) > 1 and path_free(space, path)]
        if not known:
            return Taut(proof=0).find(problem, origin)
        rates = problem.airspace.rates
        least = min(float(cost.legs(rates, writable(path), problem.end).sum()) for path in known)
        needless = least <= bound * (1.0 + CHEAP_ENOUGH)
        searches = []
        for seed in range(1 if needless else 1 + self.restarts):
            rng = np.random.default_rng(seed)
            begin = known if seed == 0 else [*known, *_evolved(problem, space, rng)]
            searches.append(
                cheapest_path(
                    space,
                    rates,
                    np.concatenate(begin),
                    np.array([len(path) for path in begin]),
                    problem.airspace.grid.step,
                    bound,
                    0 if needless else self.legs,
                    rng,
                )
            )
        path = min((path for path, _ in searches), key=lambda path: float(cost.legs(rates, path, problem.end).sum()))
        spent = np.sum([spent for _, spent in searches], axis=0)
        effort = Effort(
            generated_paths=int(spent[PATHS]), generated_nodes=int(spent[LEGS]), evaluations=int(spent[LEGS])
        )
        bound = self._proven(problem, path, bound)
        return any_angle_result(problem, path, bound, SearchRecord(origin, effort, clock.seconds))

    def _proven(self, problem: Problem, path: Floats, bound: float) -> float:
        """Return a lower bound that is at least the given one, that of the straight line."""
        rates = problem.airspace.rates
        price = float(cost.legs(rates, path, problem.end).sum())
        if self.proof == 0 or rates.metre == 0.0 or price <= bound * (1.0 + OPTIMALITY_GAP):
            return bound
        turn = bound - rates.metre * math.dist(problem.start, problem.end)
        space = problem.airspace.world.space
        return max(bound, turn + lower_bound(space, rates, problem.start, problem.end, price - turn, self.proof))


def _evolved(problem: Problem, space: Space, rng: Generator) -> list[Floats]:
    """Return a path that a population finds, if it finds one."""
    result = ANOTHER_START.plan(problem, stop=EVALUATIONS, rng=rng)
    path = _as_legs(problem, result)
    return [path] if len(path) > 1 and path_free(space, path) else []


def _as_legs(problem: Problem, result: Result) -> Floats:
    """Return the path of a result from the problem's start to its end; empty if it does not get there."""
    if not result.status.reached:
        return np.empty((0, 3))
    return problem.without_lifts(result.path) if result.any_angle else joined_to_ends(problem, result.path)
