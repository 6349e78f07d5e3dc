"""The hybrid multiverse on lattice paths."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from skyverse import cost
from skyverse._typing import Floats, Ints
from skyverse.model.result import Provenance, Result
from skyverse.numerics.kernel import by_reference, inner, kernel
from skyverse.numerics.tolerances import DETOUR_GAIN, GAIN_ROUNDING, NOT_DEARER
from skyverse.planners.contact import contact_of, without_movers
from skyverse.planners.lattice import LatticeSearch
from skyverse.planners.moves import (
    EVALUATIONS,
    LatticeTask,
    Paths,
    Workspace,
    adopt,
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
from skyverse.planners.multiverse import Multiverse, charge_seeds
from skyverse.planners.run import LatticeRun
from skyverse.planners.selection import rank_wheel, ranked
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
from skyverse.stop import Stop


@by_reference
class LatticeSettings(NamedTuple):
    """The settings of one iteration; see `HybridMVO`."""

    wep: float
    tdr: float
    straighten: int
    tries: int
    rejoin: bool
    segments: bool
    wormholes: bool
    roam: float


@dataclass(frozen=True, kw_only=True)
class LatticeHybrid(Multiverse, LatticeSearch):
    """The engine of `HybridMVO` for lattice paths."""

    def open_run(self, problem: Problem, stop: Stop, rng: Generator, origin: Provenance) -> LatticeRun | Result:
        """Return a run that holds the seeds' lattice paths, or the result where nothing is to be searched."""
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
        return charge_seeds(run, results)

    def task(self, problem: Problem) -> LatticeTask:
        """Return what is sought: contact has no price, since a change of one stretch moves the rest in time."""
        return super().task(problem)._replace(contact=without_movers(contact_of(problem)))

    def begin(self, run: LatticeRun) -> None:
        """Generate the first population, in which the seeds' paths take the places after those that were given."""
        ways = [run.paths.nodes[i, :n].copy() for i, n in enumerate(run.paths.length) if n]
        super().begin(run)
        first = min(len(run.given), self.universes - len(ways))
        for i, way in enumerate(ways, first):
            run.workspace.draft[: len(way)] = way
            adopt(run.task, run.workspace, run.paths, i, run.best, len(way))

    def step(self, run: LatticeRun, spent: float) -> None:
        """Do one iteration."""
        repairs = self.straighten, self.tries, self.rejoin, self.segments, self.wormholes, float(self.roam)
        settings = LatticeSettings(self.wep(spent), self.tdr(spent), *repairs)
        _iterate(run.task, run.workspace, run.paths, run.best, run.rng, settings)


@kernel
def _iterate(
    task: LatticeTask, workspace: Workspace, U: Paths, best: Paths, rng: Generator, settings: LatticeSettings
) -> None:
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
            _white_hole(task, workspace, U, i, order[rank_wheel(n, rng)], settings.segments)
        near_best = settings.wormholes and arrived and rng.random() < settings.wep  # r2 < WEP, (3.7)
        _travel(task, workspace, U, i, best, rng, settings, near_best)
        _straighten(task, workspace, U, i, rng, settings.straighten)
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
    settings: LatticeSettings,
    near_best: bool,
) -> None:
    """Lead a stretch of universe i through a random node near itself or near the best, unless that makes it dearer.

    A path that reaches the goal flies to the node and back to a later node of itself by straight runs. Any other path
    walks to the node and on to the goal by the generator.
    """
    grid, pricing, draft, spent, limit = task.grid, task.pricing, workspace.draft, workspace.spent, workspace.limit
    exits, offsets, moves = grid.exits, grid.offsets, grid.moves
    nx, ny, nz = grid.shape[0], grid.shape[1], grid.shape[2]
    diagonal, by_nodes = len(offsets) > 6, counts_nodes_only(pricing)
    row, n = U.nodes[i], U.length[i]
    arrived = row[n - 1] == task.goal
    roam = settings.roam if arrived or settings.roam == 0.0 else max(settings.roam, settings.wep)
    for _ in range(settings.tries):
        if limit_reached(spent, limit):
            return
        a, b = int(rng.random() * n), n - 1
        if arrived and settings.rejoin:
            b = min(b, a + 1 + int(rng.random() * (b - a)))
        near = row[a]
        if near_best:
            near = best.nodes[0, min(best.length[0] - 1, int((a + rng.random() * (b - a)) * best.length[0] / n))]
        via = random_node_near(exits, nx, ny, nz, rng, near, 1.0 if rng.random() < roam else settings.tdr, 1.0)
        length = begin_stretch(draft, row, a)
        if arrived:
            price = pricing.first * (b - a) if by_nodes else price_of(grid, pricing, row[a : b + 1])
            least = flight_price(pricing.steps, ny, nz, diagonal, row[a], via)
            if least + flight_price(pricing.steps, ny, nz, diagonal, via, row[b]) > price + NOT_DEARER:
                continue
            length = fly(exits, offsets, moves, ny, nz, draft, spent, int(rng.random() * 6), length, via)
            if length:
                length = fly(exits, offsets, moves, ny, nz, draft, spent, int(rng.random() * 6), length, row[b])
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
            _accept(U.length, U.cost, i, row, a, b, draft, length, gain)
            return


@inner
def _accept(
    lengths: Ints, costs: Floats, i: int, row: Ints, a: int, b: int, draft: Ints, length: int, gain: float
) -> None:
    """Replace nodes a to b of universe i by the draft, unless that makes the universe dearer."""
    n = lengths[i]
    if gain > -GAIN_ROUNDING and n + length - (b - a + 1) <= len(row):
        lengths[i] = replace_stretch(row, n, a, b, draft, length)
        costs[i] -= gain


@inner
def _straighten(task: LatticeTask, workspace: Workspace, U: Paths, i: int, rng: Generator, count: int) -> None:
    """Try `count` times to join two nodes of universe i by straight runs that make it no dearer."""
    grid, pricing, draft, spent, limit = task.grid, task.pricing, workspace.draft, workspace.spent, workspace.limit
    exits, offsets, moves, ny, nz = grid.exits, grid.offsets, grid.moves, grid.shape[1], grid.shape[2]
    diagonal, by_nodes = len(offsets) > 6, counts_nodes_only(pricing)
    row = U.nodes[i]
    order = int(
        rng.random() * 6
    )  # one order for all flights, so that turns move to one end of the path, where they merge
    for _ in range(count):
        n = U.length[i]
        if n < 3 or limit_reached(spent, limit):
            return
        a = int(rng.random() * (n - 2))
        b = min(n - 1, a + 2 + int(rng.random() * 0.3 * n))
        price = pricing.first * (b - a) if by_nodes else price_of(grid, pricing, row[a : b + 1])
        if flight_price(pricing.steps, ny, nz, diagonal, row[a], row[b]) > price + NOT_DEARER:
            continue
        length = fly(exits, offsets, moves, ny, nz, draft, spent, order, begin_stretch(draft, row, a), row[b])
        if length:
            spent[EVALUATIONS] += 1
            if by_nodes:
                gain = pricing.first * (b - a + 1 + min(1, a) - length)
            else:
                gain = gain_of(task, row, n, a, b, draft, length)
            _accept(U.length, U.cost, i, row, a, b, draft, length, gain)
