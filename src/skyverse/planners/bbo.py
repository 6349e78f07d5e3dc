"""Biogeography-Based Optimization (Simon 2008) for lattice paths."""

from dataclasses import dataclass

import numpy as np

from skyverse.numerics.kernel import kernel
from skyverse.planners.base import Run, require, require_between
from skyverse.planners.lattice import LatticeSearch
from skyverse.planners.moves import Desk, Paths, Task, adopt, begin_at, exhausted, graft, put, ranked, reroute


@dataclass(frozen=True, kw_only=True)
class BBO(LatticeSearch):
    """Biogeography-Based Optimization: habitats are paths, which exchange stretches by migration.

    The default is the algorithm *as described* in the original paper, on paths. In every generation the habitats are
    ranked; the best few, the elites, are left alone; each other habitat

    - **immigrates** with probability lambda, which falls linearly from the worst to the best: it takes over a stretch
      of another's path, drawn by a roulette wheel over mu = 1 - lambda, reached and left by the generator;
    - **mutates** with probability `mutation`: from a random point of the path through a random free point to the goal
      (Case 2 of the thesis).

    Whatever becomes of it is kept. The paper has migration variable by variable out of an unchanged population, and a
    mutation rate that depends on how likely a habitat's number of species is; here a habitat takes over one stretch,
    the worst habitats come first, so that the best emigrate as they were, and the mutation rate is the thesis's.

    With ``as_run=True`` it is what was run in the published experiments: habitats were never ranked, immigration (by
    index) collapsed the path to its start, and nothing but the archived best was kept.

    Attributes
    ----------
    habitats
        The population.
    as_run
        Whether to run what was run, not what is described.
    mutation
        The probability of a mutation.
    elites
        How many habitats are left alone.

    References
    ----------
    D. Simon, "Biogeography-Based Optimization", IEEE Transactions on Evolutionary Computation 12 (2008).
    """

    habitats: int = 25
    as_run: bool = False
    mutation: float = 0.1
    elites: int = 2

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "habitats", 2)
        require(self, "elites", 0)
        if self.elites >= self.habitats:
            raise ValueError(f"BBO's elites is a number below the {self.habitats} habitats, not {self.elites!r}")
        if not isinstance(self.as_run, bool):
            raise ValueError(f"BBO's as_run is True or False, not {self.as_run!r}")
        require_between(self, "mutation", 0, 1)

    @property
    def population(self) -> int:
        """How many habitats there are."""
        return self.habitats

    def step(self, run: Run, spent: float) -> None:
        """Do one generation."""
        task, desk, paths, best, rng = run.task, run.desk, run.paths, run.best, run.rng
        if self.as_run:
            _as_run(task, desk, paths, best, rng, self.mutation, self.repair_threshold, self.retries)
        else:
            _described(task, desk, paths, best, rng, self.mutation, self.elites, self.repair_threshold, self.retries)


@kernel
def _described(
    task: Task,
    desk: Desk,
    H: Paths,
    best: Paths,
    rng: np.random.Generator,
    mutation: float,
    elites: int,
    threshold: int,
    retries: int,
) -> None:
    n = len(H.length)
    order = ranked(H.cost)
    for rank in range(n - 1, elites - 1, -1):  # the worst first, so that the best emigrate as they were
        if exhausted(desk):
            return
        i = order[rank]
        length = 0
        if rng.random() < rank / n:  # lambda = 1 - k/n, k = n - rank species
            length = graft(task, desk, rng, H, i, order[_emigrant(n, rank, rng)], threshold)
            put(H, i, desk, length, H.cost[i])
        if rng.random() < mutation:
            length = reroute(task, desk, rng, H, i, threshold, retries)
        if length:
            adopt(task, desk, H, i, best, length)


@kernel
def _emigrant(n: int, host: int, rng: np.random.Generator) -> int:
    """Draw a rank other than the host's by a roulette wheel over mu = k/n, k = n - rank."""
    spin = rng.random() * (n * (n + 1) // 2 - (n - host))
    drawn = -1
    for rank in range(n):
        if rank != host and spin >= 0.0:
            spin -= n - rank
            drawn = rank
    return drawn


@kernel
def _as_run(
    task: Task,
    desk: Desk,
    H: Paths,
    best: Paths,
    rng: np.random.Generator,
    mutation: float,
    threshold: int,
    retries: int,
) -> None:
    n = len(H.length)
    for i in range(n):
        if exhausted(desk):
            return
        length = 0
        if rng.random() < i / (n - 1):  # lambda by index
            length = begin_at(desk, task.source)
            put(H, i, desk, length, H.cost[i])
        if rng.random() < mutation:
            length = reroute(task, desk, rng, H, i, threshold, retries)
        if length:
            adopt(task, desk, H, i, best, length)
