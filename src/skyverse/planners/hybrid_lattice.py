"""The hybrid multiverse on lattice paths."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skyverse import cost
from skyverse._typing import Floats, Ints
from skyverse.model.result import Effort, History, Provenance, Result
from skyverse.numerics.kernel import inner, kernel
from skyverse.planners.base import Run
from skyverse.planners.lattice import LatticeSearch
from skyverse.planners.moves import (
    EVALUATIONS,
    Desk,
    Paths,
    Task,
    adopt,
    begin_with,
    copy_in,
    cut_loops,
    generate,
    judge,
    put,
    rank_wheel,
    ranked,
)
from skyverse.planners.multiverse import Multiverse, charge
from skyverse.planners.stretches import Exits, cut_out, flight_price, fly, gain_of, plain, price_of, put_in
from skyverse.problem import Problem
from skyverse.stop import Stop


class Rules(NamedTuple):
    """The settings of one iteration; see `HybridMVO`."""

    wep: float
    tdr: float
    straighten: int
    tries: int
    rejoin: bool
    segments: bool
    wormholes: bool
    roam: float
    threshold: int


@dataclass(frozen=True, kw_only=True)
class LatticeHybrid(Multiverse, LatticeSearch):
    """The engine of `HybridMVO` for lattice paths."""

    def open_run(self, problem: Problem, stop: Stop, rng: np.random.Generator, origin: Provenance) -> Run | Result:
        """Lay out what a run needs, and let the seeds plan: their lattice paths wait in the population."""
        run = super().open_run(problem, stop, rng, origin)
        if isinstance(run, Result):
            return run
        results = self.plan_seeds(problem, rng)
        grid, U = run.task.grid, run.paths
        ways = [result.path for result in results if result.status.reached and not result.any_angle]
        ways = [way for way in ways if len(way) <= U.nodes.shape[1]]
        for i, way in enumerate(ways[: self.universes]):
            indices = np.rint((way - grid.origin) / grid.step).astype(np.int64)
            U.nodes[i, : len(way)] = np.ravel_multi_index(tuple(indices.T), tuple(grid.shape))
            U.length[i] = len(way)
        return charge(run, results)

    def close_run(
        self,
        problem: Problem,
        run: Run,
        effort: Effort,
        seconds: float,
        history: History,
        stopped_by: str,
        origin: Provenance,
    ) -> Result:
        """Return the result of the archived best; its seconds are also those of the seeds."""
        return super().close_run(problem, run, effort, seconds + run.memory, history, stopped_by, origin)

    def begin(self, run: Run) -> object:
        """Generate the first population, in which the seeds' paths take the first places."""
        ways = [run.paths.nodes[i, :n].copy() for i, n in enumerate(run.paths.length) if n]
        super().begin(run)
        for i, way in enumerate(ways):
            run.desk.draft[: len(way)] = way
            adopt(run.task, run.desk, run.paths, i, run.best, len(way))
        return run.memory

    def step(self, run: Run, spent: float) -> None:
        """Do one iteration."""
        rules = Rules(
            self.wep(spent),
            self.tdr(spent),
            self.straighten,
            self.tries,
            self.rejoin,
            self.segments,
            self.wormholes,
            float(self.roam),
            self.repair_threshold,
        )
        _iterate(run.task, run.desk, run.paths, run.best, run.rng, rules)


@kernel
def _iterate(task: Task, desk: Desk, U: Paths, best: Paths, rng: np.random.Generator, rules: Rules) -> None:
    n = len(U.length)
    order = ranked(U.cost)
    squares = 0.0
    for price in U.cost:
        squares += price**2
    norm = math.sqrt(squares)
    arrived = best.nodes[0, best.length[0] - 1] == task.goal
    for rank in range(n):
        i = order[rank]
        if rank and rng.random() * norm < U.cost[i] and not _over(desk.spent, desk.limit):  # r1 < NI(U_i), (3.6)
            _white_hole(task, desk, U, i, order[rank_wheel(n, rng)], rules.segments)
        near_best = rules.wormholes and arrived and rng.random() < rules.wep  # r2 < WEP, (3.7)
        _travel(task, desk, U, i, best, rng, rules, near_best)
        _straighten(task, desk, U, i, rng, rules.straighten)
        if U.cost[i] < best.cost[0] - 1e-9:
            length = cut_loops(desk, 0, begin_with(desk, U, i, U.length[i]))
            price = cost.total(task.grid, task.pricing, desk.draft[:length], task.goal)
            put(U, i, desk, length, price)
            put(best, 0, desk, length, price)
        if _over(desk.spent, desk.limit):
            return


@inner
def _white_hole(task: Task, desk: Desk, U: Paths, i: int, k: int, segments: bool) -> None:
    """Let universe i take over the cheaper stretches of a better universe k between the nodes that they share."""
    n, m = U.length[i], U.length[k]
    if U.cost[k] >= U.cost[i] or n + m > len(desk.draft):
        return
    p, q, place = U.nodes[i], U.nodes[k], desk.place
    grid, pricing = task.grid, task.pricing
    by_nodes = plain(pricing)
    for j in range(n):
        place[p[j]] = -1
    for j in range(m):
        place[q[j]] = j
    a, b = 0, 0  # where both paths were at the node last shared
    length = begin_with(desk, U, i, 1)
    for j in range(1, n if segments else 0):
        at = place[p[j]]
        if at <= b:
            continue
        if j == a + 1 and at == b + 1:
            desk.draft[length] = p[j]
            length += 1
        elif (
            at - b < j - a
            if by_nodes
            else price_of(grid, pricing, q[b : at + 1]) < price_of(grid, pricing, p[a : j + 1])
        ):
            length = copy_in(desk, length, U, k, b + 1, at + 1)
        else:
            length = copy_in(desk, length, U, i, a + 1, j + 1)
        a, b = j, at
    if cost.total(grid, pricing, q[b:m], task.goal) < cost.total(grid, pricing, p[a:n], task.goal):
        length = copy_in(desk, length, U, k, b + 1, m)
    else:
        length = copy_in(desk, length, U, i, a + 1, n)
    length = cut_loops(desk, 0, length)
    price = judge(task, desk, length)
    if price <= U.cost[i]:
        put(U, i, desk, length, price)


@inner
def _travel(
    task: Task, desk: Desk, U: Paths, i: int, best: Paths, rng: np.random.Generator, rules: Rules, near_best: bool
) -> None:
    """Lead a stretch of universe i through a point near itself, or near the best, and back to a later point of it.

    A path that arrives is led straight, another by the generator.
    """
    grid, pricing, draft, spent, limit = task.grid, task.pricing, desk.draft, desk.spent, desk.limit
    exits, offsets, moves = grid.exits, grid.offsets, grid.moves
    nx, ny, nz = grid.shape[0], grid.shape[1], grid.shape[2]
    diagonal, by_nodes = len(offsets) > 6, plain(pricing)
    row, n = U.nodes[i], U.length[i]
    arrived = row[n - 1] == task.goal
    roam = rules.roam if arrived or rules.roam == 0.0 else max(rules.roam, rules.wep)
    for _ in range(rules.tries):
        if _over(spent, limit):
            return
        a, b = int(rng.random() * n), n - 1
        if arrived and rules.rejoin:
            b = min(b, a + 1 + int(rng.random() * (b - a)))
        near = row[a]
        if near_best:
            near = best.nodes[0, min(best.length[0] - 1, int((a + rng.random() * (b - a)) * best.length[0] / n))]
        via = _node_near(exits, nx, ny, nz, rng, near, 1.0 if rng.random() < roam else rules.tdr)
        length = cut_out(draft, row, a)
        if arrived:
            price = pricing.first * (b - a) if by_nodes else price_of(grid, pricing, row[a : b + 1])
            least = flight_price(pricing.steps, ny, nz, diagonal, row[a], via)
            if least + flight_price(pricing.steps, ny, nz, diagonal, via, row[b]) > price + 1e-9:
                continue
            length = fly(exits, offsets, moves, ny, nz, draft, spent, int(rng.random() * 6), length, via)
            if length:
                length = fly(exits, offsets, moves, ny, nz, draft, spent, int(rng.random() * 6), length, row[b])
        else:
            length = generate(task, desk, rng, length, via, rules.threshold)
            if draft[length - 1] != via:
                continue
            length = cut_loops(desk, min(1, a), generate(task, desk, rng, length, task.goal, rules.threshold))
        if 0 < length < len(draft):
            spent[EVALUATIONS] += 1
            if by_nodes and draft[length - 1] == row[b]:
                gain = pricing.first * (b - a + 1 + min(1, a) - length)
            else:
                gain = gain_of(task, row, n, a, b, draft, length)
            _accept(U.length, U.cost, i, row, a, b, draft, length, gain)
            return


@inner
def _over(spent: Ints, limit: Ints) -> bool:
    return bool(spent[0] >= limit[0] or spent[1] >= limit[1] or spent[2] >= limit[2])


@inner
def _accept(
    lengths: Ints, costs: Floats, i: int, row: Ints, a: int, b: int, draft: Ints, length: int, gain: float
) -> None:
    """Let the draft take the place of nodes a to b of universe i, unless that is dearer."""
    n = lengths[i]
    if gain > -1e-12 and n + length - (b - a + 1) <= len(row):
        lengths[i] = put_in(row, n, a, b, draft, length)
        costs[i] -= gain


@inner
def _node_near(exits: Exits, nx: int, ny: int, nz: int, rng: np.random.Generator, node: int, tdr: float) -> int:
    """Draw a free node within TDR of the bounds' extent from a node, and at least a step, on every axis."""
    i, j, k = node // (ny * nz), (node // nz) % ny, node % nz
    for _ in range(100):
        x = min(max(i + round((2.0 * rng.random() - 1.0) * max(1.0, tdr * (nx - 1))), 0), nx - 1)
        y = min(max(j + round((2.0 * rng.random() - 1.0) * max(1.0, tdr * (ny - 1))), 0), ny - 1)
        z = min(max(k + round((2.0 * rng.random() - 1.0) * max(1.0, tdr * (nz - 1))), 0), nz - 1)
        near = (x * ny + y) * nz + z
        if exits[near]:
            return near
    return node


@inner
def _straighten(task: Task, desk: Desk, U: Paths, i: int, rng: np.random.Generator, count: int) -> None:
    """Fly straight between two points of universe i, so many times; equally cheap flights let a path drift."""
    grid, pricing, draft, spent, limit = task.grid, task.pricing, desk.draft, desk.spent, desk.limit
    exits, offsets, moves, ny, nz = grid.exits, grid.offsets, grid.moves, grid.shape[1], grid.shape[2]
    diagonal, by_nodes = len(offsets) > 6, plain(pricing)
    row = U.nodes[i]
    order = int(rng.random() * 6)  # one for all: turns wander to one end, where they meet and vanish
    for _ in range(count):
        n = U.length[i]
        if n < 3 or _over(spent, limit):
            return
        a = int(rng.random() * (n - 2))
        b = min(n - 1, a + 2 + int(rng.random() * 0.3 * n))
        price = pricing.first * (b - a) if by_nodes else price_of(grid, pricing, row[a : b + 1])
        if flight_price(pricing.steps, ny, nz, diagonal, row[a], row[b]) > price + 1e-9:
            continue
        length = fly(exits, offsets, moves, ny, nz, draft, spent, order, cut_out(draft, row, a), row[b])
        if length:
            spent[EVALUATIONS] += 1
            if by_nodes:
                gain = pricing.first * (b - a + 1 + min(1, a) - length)
            else:
                gain = gain_of(task, row, n, a, b, draft, length)
            _accept(U.length, U.cost, i, row, a, b, draft, length, gain)
