"""Our own planner: the Multi-Verse Optimizer with repairs for paths."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.model.result import Result
from skyverse.model.scenario import Scenario
from skyverse.planners.base import Planner, Seed
from skyverse.planners.hybrid_lattice import LatticeHybrid
from skyverse.planners.hybrid_straight import StraightHybrid
from skyverse.planners.multiverse import Multiverse
from skyverse.planners.settings import require_integer
from skyverse.problem import Problem
from skyverse.stop import OnIteration, Stop


@dataclass(frozen=True, kw_only=True)
class HybridMVO(Multiverse, Planner):
    """The Multi-Verse Optimizer with repairs, each of which can be switched off.

    As in `MVO`, universes are paths, and their inflation rate NI is their cost. They are sorted in every iteration. A
    white hole works with probability NI and comes from a rank that a roulette wheel chooses; a wormhole leads to the
    best universe with probability WEP (equation 3.8); TDR (3.9) bounds how far both cases travel; and a change is kept
    unless it costs more. Unlike in `MVO`, the best universe changes too. No exact search of the lattice helps, unless
    it is a seed.

    Universes are lattice paths where the objective counts nodes, and paths of straight legs where it is in metres. With
    straight legs, a change is a small move of a path's joints. A universe other than the best may then get a little
    dearer, by a share that falls with TDR, and ever more of the dearest universes are left alone as the budget is
    spent.

    With straight legs, up to half of the budget is first spent on a roadmap of 40 points, most of them beside a threat.
    Its paths are priced one by one: each time the cheapest, on the assumption that a leg that is in no priced path yet
    costs no more than its length. The prices of a priced path's legs are recorded, and the cheapest paths become
    universes.

    Attributes
    ----------
    universes
        The number of universes.
    straighten
        How often in an iteration each universe tries to join two of its nodes by at most three straight runs along
        moves of the lattice. A flight is also kept if it is as cheap as what it replaces, so that paths drift.
    tries
        How many via-points each universe may draw in an iteration, until a path through one of them could be as cheap
        as the universe. `MVO` draws 1.
    rejoin
        Whether a path returns from the via-point to a later node of itself. In `MVO` it continues to the goal.
    segments
        Whether a white hole takes over only those stretches between common nodes that are cheaper. In `MVO` it takes
        over the whole path.
    wormholes
        Whether, with probability WEP, the via-point is drawn within TDR of the best path instead of the universe's own.
    roam
        The share of via-points that are drawn anywhere, however small TDR is. As long as a universe does not reach the
        goal, the share is WEP if that is more. `MVO` has 0.
    wep_min, wep_max
        The wormhole existence probability at the start and at the end (equation 3.8).
    p
        The exploitation accuracy in TDR = 1 - (l/L)^(1/p) (equation 3.9).
    seeds
        Planners whose paths join the first population; on the lattice, only lattice paths do. Their effort and seconds
        count as the result's.
    legs
        ``"lattice"`` or ``"straight"``; ``None`` follows the objective's unit. `straighten`, `rejoin`, `segments`,
        `wormholes` and `roam` have an effect on the lattice only. With straight legs, `tries` is the mean number of
        small moves that a universe makes in an iteration.
    joints
        The largest number of joints of a path of straight legs, unless a seed has more.
    """

    legs: Literal["lattice", "straight"] | None = None
    joints: int = 12

    def __post_init__(self) -> None:
        super().__post_init__()
        require_integer(self, "joints", 1)
        if self.legs not in (None, "lattice", "straight"):
            raise InputError(f"HybridMVO's legs is 'lattice', 'straight' or None, not {self.legs!r}")

    def leaves_lattice(self, scenario: Scenario) -> bool:
        """Tell whether universes are paths of straight legs."""
        return (self.legs or ("lattice" if scenario.objective.unit == "nodes" else "straight")) == "straight"

    def plan(
        self, problem: Problem, *, stop: Stop | None = None, rng: Seed = None, on_iteration: OnIteration | None = None
    ) -> Result:
        """Plan one UAV's path; see `Planner.plan`.

        Without `stop` a run takes 40 iterations.

        Raises
        ------
        InputError
            If no counted rule stops the run: schedules follow counted budgets, never a clock.
        """
        straight = self.leaves_lattice(problem.scenario)
        engine = StraightHybrid(**self._shared, joints=self.joints) if straight else LatticeHybrid(**self._shared)
        return self._named(engine, engine.plan(problem, stop=stop, rng=rng, on_iteration=on_iteration))

    def evolve(
        self,
        problem: Problem,
        population: Sequence[ArrayLike] = (),
        *,
        stop: Stop | None = None,
        rng: Seed = None,
        on_iteration: OnIteration | None = None,
    ) -> tuple[Result, tuple[Floats, ...]]:
        """Plan one UAV's path beginning with given lattice paths, and return the population; see `MVO.evolve`.

        Raises
        ------
        InputError
            If universes are paths of straight legs, a path is no array (n, 3), or no counted rule stops the run.
        """
        if self.leaves_lattice(problem.scenario):
            raise InputError("a population is kept on the lattice only: HybridMVO(legs='lattice')", field="legs")
        engine = LatticeHybrid(**self._shared)
        result, kept = engine.evolve(problem, population, stop=stop, rng=rng, on_iteration=on_iteration)
        return self._named(engine, result), kept

    @property
    def _shared(self) -> dict[str, Any]:
        """The settings that both engines have."""
        return {f.name: getattr(self, f.name) for f in dataclasses.fields(Multiverse)}

    def _named(self, engine: Planner, result: Result) -> Result:
        """Return an engine's result with this planner in its provenance."""
        made_by = result.provenance.planner.replace(repr(engine), repr(self))
        return dataclasses.replace(result, provenance=dataclasses.replace(result.provenance, planner=made_by))
