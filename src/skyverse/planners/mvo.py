"""The Multi-Verse Optimizer (Mirjalili, Mirjalili, Hatamlou 2016) for lattice paths, the thesis's Algorithm 3."""

import math
from dataclasses import dataclass

import numpy as np

from skyverse.numerics.kernel import inner, kernel
from skyverse.planners.base import Run, require, require_between
from skyverse.planners.lattice import LatticeSearch
from skyverse.planners.moves import (
    Desk,
    Paths,
    Places,
    Task,
    adopt,
    begin_at,
    begin_with,
    copy_in,
    cut_loops,
    exhausted,
    generate,
    judge,
    put,
    rank_wheel,
    ranked,
    reroute,
)
from skyverse.space.lattice import Grid


@dataclass(frozen=True, kw_only=True)
class MVO(LatticeSearch):
    """The Multi-Verse Optimizer: universes are paths, their inflation rate is the cost.

    The default is the algorithm *as described* in the thesis's sections 3.2 to 3.4. Where the text is silent:

    - **order**: universes are sorted anew in every iteration, as in the original paper, and the first is left alone;
    - **white hole** (equation 3.6): a universe takes over a whole path with probability NI = its cost over the L2 norm
      of all costs; the roulette wheel runs over ranks, since one over costs always or never picks the best;
    - **wormhole, Case 1** (r2 < WEP): the common point is drawn among all that universe and best share (the start is
      always one); the universe follows the best from there to a random later point, goes on by the generator to a
      point of the best at most TDR of its length further, and takes the best's tail. While the best does not reach
      the goal, the generator goes for the goal instead;
    - **no wormhole, Case 2**: from a random point of the universe to a random free point at most TDR of the bounds
      away from it, then on to the goal, by the generator;
    - **acceptance**: a changed path replaces the old one unless it costs more.

    So TDR (equation 3.9) sets how far both cases travel, and shrinks as the budget is spent.

    With ``as_run=True`` it is what was run in the published experiments, which differs (see the documentation):
    white holes have no effect, a wormhole collapses the path to its start, Case 2 goes through a point anywhere, TDR
    is unused, and every change is accepted.

    Attributes
    ----------
    universes
        The population.
    as_run
        Whether to run what was run, not what is described.
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
    wep_min: float = 0.2
    wep_max: float = 1.0
    p: float = 6.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "universes", 2)
        if not isinstance(self.as_run, bool):
            raise ValueError(f"MVO's as_run is True or False, not {self.as_run!r}")
        require_between(self, "wep_min", 0, 1)
        require_between(self, "wep_max", self.wep_min, 1)
        require_between(self, "p", 1e-3, 1e3)

    @property
    def population(self) -> int:
        """How many universes there are."""
        return self.universes

    def step(self, run: Run, spent: float) -> None:
        """Do one iteration of Algorithm 3's outer loop."""
        wep = self.wep_min + spent * (self.wep_max - self.wep_min)  # (3.8)
        tdr = 1.0 - spent ** (1.0 / self.p)  # (3.9)
        if self.as_run:
            _as_run(run.task, run.desk, run.paths, run.best, run.rng, wep, self.repair_threshold, self.retries)
        else:
            _described(
                run.task,
                run.desk,
                run.paths,
                run.best,
                run.rng,
                wep,
                tdr,
                self.repair_threshold,
                self.retries,
            )


@kernel
def _described(
    task: Task,
    desk: Desk,
    U: Paths,
    best: Paths,
    rng: np.random.Generator,
    wep: float,
    tdr: float,
    threshold: int,
    retries: int,
) -> None:
    n = len(U.length)
    order = ranked(U.cost)
    squares = 0.0
    for cost in U.cost:
        squares += cost**2
    norm = math.sqrt(squares)
    for black_hole in range(1, n):
        if exhausted(desk):
            return
        i = order[black_hole]
        if rng.random() * norm < U.cost[i]:  # r1 < NI(U_i), (3.6); all costs may be 0
            k = order[rank_wheel(n, rng)]
            length = begin_with(desk, U, k, U.length[k])
            put(U, i, desk, length, U.cost[k])
        if rng.random() < wep:  # r2 < WEP, (3.7)
            length = _wormhole(task, desk, U, i, best, rng, tdr, threshold)
        else:
            length = begin_with(desk, U, i, 1 + int(rng.random() * U.length[i]))
            length = _travel(task, desk, rng, length, tdr, threshold, retries)
            length = generate(task, desk, rng, length, task.goal, threshold)
        length = cut_loops(desk, 0, length)
        price = judge(task, desk, length)
        if price <= U.cost[i]:
            put(U, i, desk, length, price)
            if price < best.cost[0]:
                put(best, 0, desk, length, price)


@inner
def _wormhole(
    task: Task,
    desk: Desk,
    U: Paths,
    i: int,
    best: Paths,
    rng: np.random.Generator,
    tdr: float,
    threshold: int,
) -> int:
    """Case 1: draw up what universe i becomes through a wormhole to the best; return the draft's length."""
    place = desk.place
    shared = _places(place, U, i, best)
    skip = int(rng.random() * shared)
    a = -1
    while skip >= 0:
        a += 1
        skip -= place[U.nodes[i, a]] >= 0
    b = place[U.nodes[i, a]]
    size = best.length[0]
    p = b + int(rng.random() * (size - b))
    length = begin_with(desk, U, i, a)
    length = copy_in(desk, length, best, 0, b, p + 1)
    if best.nodes[0, size - 1] != task.goal:
        return generate(task, desk, rng, length, task.goal, threshold)
    q = min(size - 1, p + 1 + int(rng.random() * max(1.0, tdr * size)))
    length = generate(task, desk, rng, length, best.nodes[0, q], threshold)
    if desk.draft[length - 1] == best.nodes[0, q]:
        length = copy_in(desk, length, best, 0, q + 1, size)
    return length


@inner
def _places(place: Places, U: Paths, i: int, best: Paths) -> int:
    """Write down where the best visits each node of universe i (-1: nowhere); return how many it shares."""
    for j in range(U.length[i]):
        place[U.nodes[i, j]] = -1
    for j in range(best.length[0]):
        place[best.nodes[0, j]] = j
    shared = 0
    for j in range(U.length[i]):
        shared += place[U.nodes[i, j]] >= 0
    return shared


@inner
def _travel(
    task: Task, desk: Desk, rng: np.random.Generator, length: int, tdr: float, threshold: int, retries: int
) -> int:
    """Case 2: walk from the draft's end to a free point drawn at most TDR of the bounds away; try again if need be."""
    for _ in range(retries + 1):
        node = _node_near(task.grid, rng, desk.draft[length - 1], tdr)
        reached = generate(task, desk, rng, length, node, threshold)
        if desk.draft[reached - 1] == node:
            return reached
    return length


@kernel
def _node_near(grid: Grid, rng: np.random.Generator, node: int, tdr: float) -> int:
    """Draw a free node within TDR of the bounds' extent from a node, on every axis."""
    nx, ny, nz = grid.shape[0], grid.shape[1], grid.shape[2]
    i, j, k = node // (ny * nz), (node // nz) % ny, node % nz
    for _ in range(100):
        x = min(max(i + round((2.0 * rng.random() - 1.0) * tdr * (nx - 1)), 0), nx - 1)
        y = min(max(j + round((2.0 * rng.random() - 1.0) * tdr * (ny - 1)), 0), ny - 1)
        z = min(max(k + round((2.0 * rng.random() - 1.0) * tdr * (nz - 1)), 0), nz - 1)
        near = (x * ny + y) * nz + z
        if grid.exits[near]:
            return near
    return node


@kernel
def _as_run(
    task: Task,
    desk: Desk,
    U: Paths,
    best: Paths,
    rng: np.random.Generator,
    wep: float,
    threshold: int,
    retries: int,
) -> None:
    for i in range(1, len(U.length)):
        if exhausted(desk):
            return
        if rng.random() < wep:
            length = begin_at(desk, task.source)
        else:
            length = reroute(task, desk, rng, U, i, threshold, retries)
        adopt(task, desk, U, i, best, length)
