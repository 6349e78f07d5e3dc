"""The Multi-Verse Optimizer (Mirjalili, Mirjalili, Hatamlou 2016) for lattice paths, the thesis's Algorithm 3."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from skyverse.errors import require_flag, require_whole
from skyverse.numerics.kernel import inner_query, query
from skyverse.planners.base import require_schedules, wep_and_tdr
from skyverse.planners.lattice import LatticeSearch
from skyverse.planners.metaheuristic import LatticeRun
from skyverse.planners.moves import (
    LatticeTask,
    Paths,
    Positions,
    Workspace,
    adopt,
    begin_at,
    begin_with,
    copy_in,
    cut_loops,
    exhausted,
    generate,
    put,
    random_node_near,
)
from skyverse.planners.path_changes import rank_wheel, ranked, reroute


@dataclass(frozen=True, kw_only=True)
class MVO(LatticeSearch):
    """The Multi-Verse Optimizer: universes are paths, their inflation rate is the cost.

    The default is the algorithm *as described* in the thesis's sections 3.2 to 3.4. Where the text is silent:

    - **order**: the universes are sorted anew in every iteration, as in the original paper, and the best is left alone;
    - **white hole** (equation 3.6): a universe takes over a whole path with probability NI, which is its cost divided
      by the L2 norm of all costs. The roulette wheel runs over ranks, because a wheel over costs always or never picks
      the best;
    - **wormhole, Case 1** (r2 < WEP): one of the nodes that the universe and the best share is drawn (the start is
      always one). The universe follows the best from there to a random later node, continues by the generator to a
      node of the best that is at most TDR of the best's length farther on, and takes the rest of the best. As long as
      the best does not reach the goal, the generator continues to the goal instead;
    - **no wormhole, Case 2**: the universe is followed to a random node. From there the generator continues to a random
      free node, which is at most TDR of the bounds away, and then to the goal.

    A changed path replaces the old one, whether it is better or not: "This would be our universe" (Case 2).

    So TDR (equation 3.9) sets how far both cases travel, and it shrinks as the budget is spent.

    With ``as_run=True`` the planner does what was run in the published experiments, which differs (see the
    documentation): white holes have no effect, a wormhole reduces the path to its start, Case 2 leads through a free
    node anywhere, TDR is not used, and every change is accepted.

    Attributes
    ----------
    universes
        The number of universes.
    as_run
        Whether to do what was run, instead of what is described.
    greedy
        Whether a changed path that costs more is discarded, which the thesis does not do; not as run.
    wep_min, wep_max
        The wormhole existence probability at the start and at the end (equation 3.8).
    p
        The exploitation accuracy in TDR = 1 - (l/L)^(1/p) (equation 3.9).

    References
    ----------
    S. Mirjalili, S. M. Mirjalili, A. Hatamlou, "Multi-Verse Optimizer", Neural Computing and Applications 27 (2016).
    """

    universes: int = 25
    as_run: bool = False
    greedy: bool = False
    wep_min: float = 0.2
    wep_max: float = 1.0
    p: float = 6.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require_whole(self.universes, "universes", 2)
        require_flag(self.as_run, "as_run")
        require_flag(self.greedy, "greedy")
        require_schedules(self)

    @property
    def population(self) -> int:
        """How many universes there are."""
        return self.universes

    def step(self, run: LatticeRun, spent: float) -> None:
        """Do one iteration of Algorithm 3's outer loop."""
        wep, tdr = wep_and_tdr(self, spent)
        if self.as_run:
            _as_run(run.task, run.workspace, run.paths, run.best, run.rng, wep)
        else:
            _described(run.task, run.workspace, run.paths, run.best, run.rng, wep, tdr, self.greedy)


@query
def _described(
    task: LatticeTask,
    workspace: Workspace,
    U: Paths,
    best: Paths,
    rng: Generator,
    wep: float,
    tdr: float,
    greedy: bool,
) -> None:
    n = len(U.length)
    order = ranked(U.cost)
    squares = 0.0
    for cost in U.cost:
        squares += cost**2
    norm = math.sqrt(squares)
    for black_hole in range(1, n):
        if exhausted(workspace):
            return
        i = order[black_hole]
        if rng.random() * norm < U.cost[i]:  # r1 < NI(U_i), (3.6), without a division, because all costs may be 0
            k = order[rank_wheel(n, rng)]
            length = begin_with(workspace, U, k, U.length[k])
            put(U, i, workspace, length, U.cost[k])
        if rng.random() < wep:  # r2 < WEP, (3.7)
            length = _wormhole(task, workspace, U, i, best, rng, tdr)
        else:
            length = begin_with(workspace, U, i, 1 + int(rng.random() * U.length[i]))
            length = _travel(task, workspace, rng, length, tdr)
            length = generate(task, workspace, rng, length, task.goal, task.repair_threshold)
        adopt(task, workspace, U, i, best, cut_loops(workspace, 0, length), greedy)


@inner_query
def _wormhole(
    task: LatticeTask, workspace: Workspace, U: Paths, i: int, best: Paths, rng: Generator, tdr: float
) -> int:
    """Draft Case 1, universe i after a wormhole to the best; return the draft's length."""
    position, own = workspace.position, U.nodes[i]
    shared = _locate_in_best(position, U, i, best)
    skip = int(rng.random() * shared)
    a = -1
    while skip >= 0:
        a += 1
        skip -= position[own[a]] >= 0
    b = position[own[a]]
    size = best.length[0]
    p = b + int(rng.random() * (size - b))
    length = begin_with(workspace, U, i, a)
    length = copy_in(workspace, length, best, 0, b, p + 1)
    if best.nodes[0, size - 1] != task.goal:
        return generate(task, workspace, rng, length, task.goal, task.repair_threshold)
    q = min(size - 1, p + 1 + int(rng.random() * max(1.0, tdr * size)))
    length = generate(task, workspace, rng, length, best.nodes[0, q], task.repair_threshold)
    if workspace.draft[length - 1] == best.nodes[0, q]:
        length = copy_in(workspace, length, best, 0, q + 1, size)
    return length


@inner_query
def _locate_in_best(position: Positions, U: Paths, i: int, best: Paths) -> int:
    """Set each node's position in the best, -1 for those of universe i alone; return how many nodes both share."""
    own, row = U.nodes[i, : U.length[i]], best.nodes[0, : best.length[0]]
    for node in own:
        position[np.uint64(node)] = -1
    for j in range(len(row)):
        position[np.uint64(row[j])] = j
    shared = 0
    for node in own:
        shared += position[np.uint64(node)] >= 0
    return shared


@inner_query
def _travel(task: LatticeTask, workspace: Workspace, rng: Generator, length: int, tdr: float) -> int:
    """Continue the draft to a random free node at most TDR of the bounds away (Case 2); return its new length.

    A walk that gives up is replaced by one to another node, at most `retries` times; then the draft stays as it was.
    """
    grid = task.grid
    nx, ny, nz = grid.shape[0], grid.shape[1], grid.shape[2]
    for _ in range(task.retries + 1):
        node = random_node_near(grid.exits, nx, ny, nz, rng, workspace.draft[length - 1], tdr, 0.0)
        reached = generate(task, workspace, rng, length, node, task.repair_threshold)
        if workspace.draft[reached - 1] == node:
            return reached
    return length


@query
def _as_run(task: LatticeTask, workspace: Workspace, U: Paths, best: Paths, rng: Generator, wep: float) -> None:
    for i in range(1, len(U.length)):
        if exhausted(workspace):
            return
        if rng.random() < wep:
            length = begin_at(workspace, task.source)
        else:
            length = reroute(task, workspace, rng, U, i)
        adopt(task, workspace, U, i, best, length)
