"""Our own multiverse: the Multi-Verse Optimizer, repaired where lattice paths ask for it."""

import dataclasses
from dataclasses import dataclass

from skyverse.planners.base import Planner, Seed
from skyverse.planners.hybrid_lattice import LatticeHybrid
from skyverse.planners.multiverse import Multiverse
from skyverse.problem import Problem
from skyverse.result import Result
from skyverse.stop import OnIteration, Stop


@dataclass(frozen=True, kw_only=True)
class HybridMVO(Multiverse, Planner):
    """The Multi-Verse Optimizer with repairs, each of which can be switched off.

    As in `MVO`: universes are paths, their inflation rate NI is their cost; they are sorted in every iteration; white
    holes work with probability NI and come from a rank drawn by a roulette wheel, wormholes lead to the best with
    probability WEP (equation 3.8), TDR (3.9) bounds how far both cases travel, and a change is kept unless it costs
    more. Unlike there, the best universe changes too. No exact search helps.

    Attributes
    ----------
    universes
        The population.
    straighten
        How often in an iteration each universe tries to fly straight between two of its points, by at most three runs
        along moves of the lattice. Flights as cheap as what they replace are taken, so that paths drift.
    tries
        How many via-points each universe may draw in an iteration, until one is found that a path could go through
        without costing more than now. 1 is MVO's.
    rejoin
        Whether a path goes from the via-point back to a later point of itself. MVO goes on to the goal.
    segments
        Whether a white hole takes over only those stretches between common nodes that are cheaper. MVO's takes over
        the whole path.
    wormholes
        Whether, with probability WEP, the via-point is drawn within TDR of the best's path instead of its own.
    roam
        The share of via-points drawn anywhere, however small TDR is; while a universe does not reach the goal, WEP
        if that is more. 0 is MVO's.
    wep_min, wep_max
        The wormhole existence probability at the start and at the end (equation 3.8).
    p
        The exploitation accuracy in TDR = 1 - (l/L)^(1/p) (equation 3.9).
    """

    def plan(
        self,
        problem: Problem,
        *,
        stop: Stop | None = None,
        rng: Seed = None,
        on_iteration: OnIteration | None = None,
    ) -> Result:
        """Plan one UAV's path; see `Planner.plan`.

        Without `stop` a run takes 40 iterations.

        Raises
        ------
        InputError
            If no counted rule stops the run: schedules follow counted budgets, never a clock.
        """
        settings = {f.name: getattr(self, f.name) for f in dataclasses.fields(Multiverse)}
        result = LatticeHybrid(**settings).plan(problem, stop=stop, rng=rng, on_iteration=on_iteration)
        origin = dataclasses.replace(result.provenance, planner=repr(self))
        return dataclasses.replace(result, provenance=origin)
