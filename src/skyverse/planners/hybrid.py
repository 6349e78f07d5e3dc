"""Our own multiverse: the Multi-Verse Optimizer, repaired where lattice paths ask for it."""

import dataclasses
from dataclasses import dataclass
from typing import Literal

from skyverse.model.result import Result
from skyverse.model.scenario import Scenario
from skyverse.planners.base import Planner, Seed, require
from skyverse.planners.hybrid_lattice import LatticeHybrid
from skyverse.planners.hybrid_straight import StraightHybrid
from skyverse.planners.multiverse import Multiverse
from skyverse.problem import Problem
from skyverse.stop import OnIteration, Stop


@dataclass(frozen=True, kw_only=True)
class HybridMVO(Multiverse, Planner):
    """The Multi-Verse Optimizer with repairs, each of which can be switched off.

    As in `MVO`: universes are paths, their inflation rate NI is their cost; they are sorted in every iteration; white
    holes work with probability NI and come from a rank drawn by a roulette wheel, wormholes lead to the best with
    probability WEP (equation 3.8), TDR (3.9) bounds how far both cases travel, and a change is kept unless it costs
    more. Unlike there, the best universe changes too. No exact search of the lattice helps, unless it is a seed.

    Universes are lattice paths where the objective counts nodes, paths of straight legs where it is in metres. There,
    changes are small moves of a path's joints; a universe other than the best may get a little dearer, by a share that
    falls with TDR; and the last universes are left alone, ever more as the budget is spent.

    With straight legs, up to half the budget first surveys the field: of 40 places, most of them beside a threat, the
    ways between are priced one by one, each time the one that is cheapest if legs that no path has shown yet cost only
    their length. What a priced path shows of its legs is remembered; the cheapest paths become universes.

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
    seeds
        Planners whose paths join the first population; on the lattice, only lattice paths do. Their effort and seconds
        are part of the result's.
    legs
        ``"lattice"`` or ``"straight"``; ``None`` follows the objective's unit. `straighten`, `rejoin`, `segments`,
        `wormholes` and `roam` are about the lattice. With straight legs `tries` is how many small moves a universe
        makes in an iteration, on average.
    joints
        The most joints of a path of straight legs; more only where a seed has more.
    """

    legs: Literal["lattice", "straight"] | None = None
    joints: int = 12

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "joints", 1)
        if self.legs not in (None, "lattice", "straight"):
            raise ValueError(f"HybridMVO's legs is 'lattice', 'straight' or None, not {self.legs!r}")

    def leaves_lattice(self, scenario: Scenario) -> bool:
        """Tell whether universes are paths of straight legs."""
        return (self.legs or ("lattice" if scenario.objective.unit == "nodes" else "straight")) == "straight"

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
        straight = self.leaves_lattice(problem.scenario)
        engine = StraightHybrid(**settings, joints=self.joints) if straight else LatticeHybrid(**settings)
        result = engine.plan(problem, stop=stop, rng=rng, on_iteration=on_iteration)
        origin = dataclasses.replace(result.provenance, planner=repr(self))
        return dataclasses.replace(result, provenance=origin)
