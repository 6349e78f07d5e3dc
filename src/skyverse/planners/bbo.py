"""Biogeography-Based Optimization (Simon 2008) for lattice paths."""

from dataclasses import dataclass

from numpy.random import Generator

from skyverse.errors import InputError, require_flag, require_number, require_whole
from skyverse.numerics.kernel import kernel
from skyverse.planners.lattice import LatticeSearch
from skyverse.planners.metaheuristic import LatticeRun
from skyverse.planners.moves import LatticeTask, Paths, Workspace, adopt, begin_at, exhausted, put
from skyverse.planners.path_changes import graft, ranked, reroute


@dataclass(frozen=True, kw_only=True)
class BBO(LatticeSearch):
    """Biogeography-Based Optimization: habitats are paths that exchange stretches by migration.

    The default is the algorithm *as described* in the original paper, on paths. In every generation the habitats are
    ranked, and the best few, the elites, are left alone. Every other habitat

    - **immigrates** with probability lambda, which falls linearly from the worst to the best: it takes over a stretch
      of another habitat's path, which a roulette wheel over mu = 1 - lambda chooses. The generator joins the stretch to
      the rest of the path;
    - **mutates** with probability `mutation`: the generator continues from a random node of the path through a random
      free node to the goal (Case 2 of the thesis).

    The changed path is kept even if it is dearer, unless ``greedy``. In the paper, migration copies single variables
    out of an unchanged population, and the mutation rate depends on how likely a habitat's number of species is. Here a
    habitat takes over one stretch, the worst habitats come first, so that the best ones emigrate unchanged, and the
    mutation rate is the thesis's. `WaypointBBO` is the paper's.

    With ``as_run=True`` the planner does what was run in the published experiments: habitats are never ranked,
    immigration (by index) reduces the path to its start, and only the best path is kept.

    Attributes
    ----------
    habitats
        The number of habitats.
    as_run
        Whether to do what was run, instead of what is described.
    greedy
        Whether a changed path that costs more is discarded, which the paper does not do; not as run.
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
    greedy: bool = False
    mutation: float = 0.1
    elites: int = 2

    def __post_init__(self) -> None:
        super().__post_init__()
        require_whole(self.habitats, "habitats", 2)
        require_whole(self.elites, "elites", 0)
        if self.elites >= self.habitats:
            raise InputError(f"BBO's elites is a number below the {self.habitats} habitats, not {self.elites!r}")
        require_flag(self.as_run, "as_run")
        require_flag(self.greedy, "greedy")
        require_number(self.mutation, "mutation", least=0, most=1)

    @property
    def population(self) -> int:
        """How many habitats there are."""
        return self.habitats

    def step(self, run: LatticeRun, spent: float) -> None:
        """Do one generation."""
        task, workspace, paths, best, rng = run.task, run.workspace, run.paths, run.best, run.rng
        if self.as_run:
            _as_run(task, workspace, paths, best, rng, self.mutation)
        else:
            _described(task, workspace, paths, best, rng, self.mutation, self.elites, self.greedy)


@kernel
def _described(
    task: LatticeTask,
    workspace: Workspace,
    H: Paths,
    best: Paths,
    rng: Generator,
    mutation: float,
    elites: int,
    greedy: bool,
) -> None:
    n = len(H.length)
    order = ranked(H.cost)
    for rank in range(n - 1, elites - 1, -1):  # the worst come first, so that the best emigrate unchanged
        if exhausted(workspace):
            return
        i = order[rank]
        length = 0
        if rng.random() < rank / n:  # lambda = 1 - k/n with k = n - rank species
            length = graft(task, workspace, rng, H, i, order[_emigrant(n, rank, rng)])
            if greedy:
                adopt(task, workspace, H, i, best, length, greedy)
                if exhausted(workspace):
                    return
                length = 0
            else:
                put(H, i, workspace, length, H.cost[i])  # it is priced once, after the mutation
        if rng.random() < mutation:
            length = reroute(task, workspace, rng, H, i)
        if length:
            adopt(task, workspace, H, i, best, length, greedy)


@kernel
def _emigrant(n: int, host: int, rng: Generator) -> int:
    """Return a random rank other than the host's by a roulette wheel over mu = k/n, k = n - rank."""
    spin = rng.random() * (n * (n + 1) // 2 - (n - host))
    drawn = -1
    for rank in range(n):
        if rank != host and spin >= 0.0:
            spin -= n - rank
            drawn = rank
    return drawn


@kernel
def _as_run(task: LatticeTask, workspace: Workspace, H: Paths, best: Paths, rng: Generator, mutation: float) -> None:
    n = len(H.length)
    for i in range(n):
        if exhausted(workspace):
            return
        length = 0
        if rng.random() < i / (n - 1):  # lambda follows the index, not the rank
            length = begin_at(workspace, task.source)
            put(H, i, workspace, length, H.cost[i])
        if rng.random() < mutation:
            length = reroute(task, workspace, rng, H, i)
        if length:
            adopt(task, workspace, H, i, best, length)
