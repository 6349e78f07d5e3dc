"""A metaheuristic asked at every observation, which begins with the population of its last answer."""

from dataclasses import dataclass

from skyverse.errors import InputError
from skyverse.live.policies.planner_policy import PlannerPolicy, planned, problem_now
from skyverse.live.policies.policy import Found, Situation
from skyverse.planners.base import Planner
from skyverse.planners.hybrid import HybridMVO
from skyverse.planners.lattice import LatticeSearch
from skyverse.stop import MaxPaths


@dataclass(frozen=True, kw_only=True)
class KeptPopulation(PlannerPolicy):
    """A metaheuristic asked at every observation, which begins with the population of its last answer.

    All paths that were kept are followed from where the UAV would come to rest, repaired where something new stands,
    and priced anew; that counts as effort. `FromScratch` with the same settings is the same search without memory.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        self._search()

    def find(self, situation: Situation) -> Found:
        """Return the way of the best path."""
        problem = problem_now(situation, self.sweep, self.timed)
        kept = situation.memory if isinstance(situation.memory, tuple) else ()
        result, population = self._search().evolve(problem, kept, stop=MaxPaths(self.paths), rng=situation.rng)
        return Found(*planned(problem, result), population)

    def _search(self) -> LatticeSearch | HybridMVO:
        """Return the planner, or raise `ValueError` if it keeps no population of lattice paths."""
        made: Planner = self.made()
        if not isinstance(made, LatticeSearch | HybridMVO):
            raise InputError(f"planner is a metaheuristic on lattice paths, such as 'mvo', not {self.planner!r}")
        return made
