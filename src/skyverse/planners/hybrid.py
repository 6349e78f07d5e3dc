"""Our own planner: the Multi-Verse Optimizer with repairs for paths."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from numpy.random import Generator

from skyverse import cost
from skyverse._typing import Ints
from skyverse.errors import require_flag, require_number, require_whole
from skyverse.numerics.kernel import by_reference, inner, kernel
from skyverse.numerics.tolerances import DETOUR_GAIN, GAIN_ROUNDING, NOT_DEARER
from skyverse.planners.base import require_schedules, wep_and_tdr
from skyverse.planners.contact import contact_of, without_movers
from skyverse.planners.lattice import LatticeSearch
from skyverse.planners.metaheuristic import LatticeRun
from skyverse.planners.moves import (
    EVALUATIONS,
    LatticeTask,
    Paths,
    Workspace,
    begin_with,
    copy_in,
    cut_loops,
    generate,
    judge,
    keep_if_best,
    limit_reached,
    put,
    random_node_near,
)
from skyverse.planners.path_changes import rank_wheel, ranked
from skyverse.planners.subpaths import (
    begin_stretch,
    counts_nodes_only,
    flight_price,
    fly,
    gain_of,
    price_of,
    replace_stretch,
)
from skyverse.problem import Problem


@by_reference
class Repairs(NamedTuple):
    """MVO's two schedules at one iteration, and the repairs; see `HybridMVO`."""

    wep: float
    tdr: float
    straighten: int
    tries: int
    rejoin: bool
    segments: bool
    wormholes: bool
    roam: float


@dataclass(frozen=True, kw_only=True)
class HybridMVO(LatticeSearch):
    """The Multi-Verse Optimizer with repairs, each of which can be switched off.

    As in `MVO`, universes are lattice paths, and their inflation rate NI is their cost. They are sorted in every
    iteration. A white hole works with probability NI and comes from a rank that a roulette wheel chooses; a wormhole
    leads to the best universe with probability WEP (equation 3.8); TDR (3.9) bounds how far both cases travel; and a
    change is kept unless it costs more. Unlike in `MVO`, the best universe changes too. No exact search of the lattice
    helps.

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
    """

    universes: int = 25
    straighten: int = 5
    tries: int = 4
    rejoin: bool = True
    segments: bool = True
    wormholes: bool = True
    roam: float = 0.2
    wep_min: float = 0.2
    wep_max: float = 1.0
    p: float = 6.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require_whole(self.universes, "universes", 2)
        require_whole(self.straighten, "straighten", 0)
        require_whole(self.tries, "tries", 1)
        for name in ("rejoin", "segments", "wormholes"):
            require_flag(getattr(self, name), name)
        require_number(self.roam, "roam", least=0, most=1)
        require_schedules(self)

    @property
    def population(self) -> int:
        """How many universes there are."""
        return self.universes

    def task(self, problem: Problem) -> LatticeTask:
        """Return what is sought: contact has no price, since a change of one stretch moves the rest in time."""
        return super().task(problem)._replace(contact=without_movers(contact_of(problem)))

    def step(self, run: LatticeRun, spent: float) -> None:
        """Do one iteration."""
        wep, tdr = wep_and_tdr(self, spent)
        repairs = self.straighten, self.tries, self.rejoin, self.segments, self.wormholes, float(self.roam)
        _iterate(run.task, run.workspace, run.paths, run.best, run.rng, Repairs(wep, tdr, *repairs))


@kernel
def _iterate(task: LatticeTask, workspace: Workspace, U: Paths, best: Paths, rng: Generator, repairs: Repairs) -> None:
    n = len(U.length)
    order = ranked(U.cost)
    squares = 0.0
    for price in U.cost:
        squares += price**2
    norm = math.sqrt(squares)
    arrived = best.nodes[0, best.length[0] - 1] == task.goal
    for rank in range(n):
        i = order[rank]
        # r1 < NI(U_i), (3.6)
        if rank and rng.random() * norm < U.cost[i] and not limit_reached(workspace.spent, workspace.limit):
            _white_hole(task, workspace, U, i, order[rank_wheel(n, rng)], repairs.segments)
        near_best = repairs.wormholes and arrived and rng.random() < repairs.wep  # r2 < WEP, (3.7)
        _travel(task, workspace, U, i, best, rng, repairs, near_best)
        _straighten(task, workspace, U, i, rng, repairs.straighten)
        if U.cost[i] < best.cost[0] - DETOUR_GAIN:
            length = cut_loops(workspace, 0, begin_with(workspace, U, i, U.length[i]))
            price = cost.total(task.grid, task.pricing, workspace.draft[:length], task.goal)
            put(U, i, workspace, length, price)
            keep_if_best(workspace, best, length, price)
        if limit_reached(workspace.spent, workspace.limit):
            return


@inner
def _white_hole(task: LatticeTask, workspace: Workspace, U: Paths, i: int, k: int, segments: bool) -> None:
    """Let universe i take over stretches of a better universe k that are cheaper between nodes that both share.

    Without `segments` it takes over the whole path.
    """
    n, m = U.length[i], U.length[k]
    if U.cost[k] >= U.cost[i] or n + m > len(workspace.draft):
        return
    p, q, position = U.nodes[i], U.nodes[k], workspace.position
    grid, pricing = task.grid, task.pricing
    by_nodes = counts_nodes_only(pricing)
    for j in range(n):
        position[p[j]] = -1
    for j in range(m):
        position[q[j]] = j
    a, b = 0, 0  # the positions in p and q of the last node that both share
    length = begin_with(workspace, U, i, 1)
    for j in range(1, n if segments else 0):
        at = position[p[j]]
        if at <= b:
            continue
        if j == a + 1 and at == b + 1:
            workspace.draft[length] = p[j]
            length += 1
        elif (
            at - b < j - a
            if by_nodes
            else price_of(grid, pricing, q[b : at + 1]) < price_of(grid, pricing, p[a : j + 1])
        ):
            length = copy_in(workspace, length, U, k, b + 1, at + 1)
        else:
            length = copy_in(workspace, length, U, i, a + 1, j + 1)
        a, b = j, at
    if cost.total(grid, pricing, q[b:m], task.goal) < cost.total(grid, pricing, p[a:n], task.goal):
        length = copy_in(workspace, length, U, k, b + 1, m)
    else:
        length = copy_in(workspace, length, U, i, a + 1, n)
    length = cut_loops(workspace, 0, length)
    price = judge(task, workspace, length)
    if price <= U.cost[i]:
        put(U, i, workspace, length, price)


@inner
def _travel(
    task: LatticeTask,
    workspace: Workspace,
    U: Paths,
    i: int,
    best: Paths,
    rng: Generator,
    repairs: Repairs,
    near_best: bool,
) -> None:
    """Lead a stretch of universe i through a random node near itself or near the best, unless that makes it dearer.

    A path that reaches the goal flies to the node and back to a later node of itself by straight runs. Any other path
    walks to the node and on to the goal by the generator.
    """
    grid, pricing, draft, spent, limit = task.grid, task.pricing, workspace.draft, workspace.spent, workspace.limit
    nx, ny, nz = grid.shape[0], grid.shape[1], grid.shape[2]
    diagonal, by_nodes = len(grid.offsets) > 6, counts_nodes_only(pricing)
    row, n = U.nodes[i], U.length[i]
    arrived = row[n - 1] == task.goal
    roam = repairs.roam if arrived or repairs.roam == 0.0 else max(repairs.roam, repairs.wep)
    for _ in range(repairs.tries):
        if limit_reached(spent, limit):
            return
        a, b = int(rng.random() * n), n - 1
        if arrived and repairs.rejoin:
            b = min(b, a + 1 + int(rng.random() * (b - a)))
        near = row[a]
        if near_best:
            near = best.nodes[0, min(best.length[0] - 1, int((a + rng.random() * (b - a)) * best.length[0] / n))]
        via = random_node_near(grid.exits, nx, ny, nz, rng, near, 1.0 if rng.random() < roam else repairs.tdr, 1.0)
        length = begin_stretch(draft, row, a)
        if arrived:
            price = pricing.first * (b - a) if by_nodes else price_of(grid, pricing, row[a : b + 1])
            least = flight_price(pricing.steps, ny, nz, diagonal, row[a], via)
            if least + flight_price(pricing.steps, ny, nz, diagonal, via, row[b]) > price + NOT_DEARER:
                continue
            length = fly(grid, draft, spent, int(rng.random() * 6), length, via)
            if length:
                length = fly(grid, draft, spent, int(rng.random() * 6), length, row[b])
        else:
            length = generate(task, workspace, rng, length, via, task.repair_threshold)
            if draft[length - 1] != via:
                continue
            length = cut_loops(
                workspace, min(1, a), generate(task, workspace, rng, length, task.goal, task.repair_threshold)
            )
        if 0 < length < len(draft):
            spent[EVALUATIONS] += 1
            if by_nodes and draft[length - 1] == row[b]:
                gain = pricing.first * (b - a + 1 + min(1, a) - length)
            else:
                gain = gain_of(task, row, n, a, b, draft, length)
            _accept(U, i, a, b, draft, length, gain)
            return


@inner
def _accept(U: Paths, i: int, a: int, b: int, draft: Ints, length: int, gain: float) -> None:
    """Replace nodes a to b of universe i by the draft, unless that makes the universe dearer."""
    row, n = U.nodes[i], U.length[i]
    if gain > -GAIN_ROUNDING and n + length - (b - a + 1) <= len(row):
        U.length[i] = replace_stretch(row, n, a, b, draft, length)
        U.cost[i] -= gain


@inner
def _straighten(task: LatticeTask, workspace: Workspace, U: Paths, i: int, rng: Generator, count: int) -> None:
    """Try `count` times to join two nodes of universe i by straight runs that make it no dearer."""
    grid, pricing, draft, spent, limit = task.grid, task.pricing, workspace.draft, workspace.spent, workspace.limit
    ny, nz = grid.shape[1], grid.shape[2]
    diagonal, by_nodes = len(grid.offsets) > 6, counts_nodes_only(pricing)
    row = U.nodes[i]
    # one order for all flights, so that turns move to one end of the path, where they merge
    order = int(rng.random() * 6)
    for _ in range(count):
        n = U.length[i]
        if n < 3 or limit_reached(spent, limit):
            return
        a = int(rng.random() * (n - 2))
        b = min(n - 1, a + 2 + int(rng.random() * 0.3 * n))
        price = pricing.first * (b - a) if by_nodes else price_of(grid, pricing, row[a : b + 1])
        if flight_price(pricing.steps, ny, nz, diagonal, row[a], row[b]) > price + NOT_DEARER:
            continue
        length = fly(grid, draft, spent, order, begin_stretch(draft, row, a), row[b])
        if length:
            spent[EVALUATIONS] += 1
            if by_nodes:
                gain = pricing.first * (b - a + 1 + min(1, a) - length)
            else:
                gain = gain_of(task, row, n, a, b, draft, length)
            _accept(U, i, a, b, draft, length, gain)
