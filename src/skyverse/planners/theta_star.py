"""Any-angle search over the lattice: Lazy Theta*, with the exact lattice path as its fallback."""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from skyverse.cost import make_pricing
from skyverse.exact import shortest_route
from skyverse.heap import make_heap, pop, push
from skyverse.kernel import Stopwatch, kernel
from skyverse.planners.base import Planner, Seed, planned_any_angle, provenance, unplanned
from skyverse.planners.sight import far, length_of, pull_tight, without_seams
from skyverse.problem import Problem
from skyverse.result import Effort, Floats, History, Result, Status, no_history
from skyverse.scenario import Objective, Scenario
from skyverse.space.lattice import Grid, Ints, position
from skyverse.space.world import Space, segment_free
from skyverse.stop import OnIteration, Stop


@dataclass(frozen=True, kw_only=True)
class ThetaStar(Planner):
    """Lazy Theta*: a short path of straight legs, found over the scenario's lattice, not bound to its moves.

    The search expands lattice nodes, but a node's parent is any node that sees it. What it finds, and the lattice's
    exact shortest path, both joined to the UAV's true start and target, are pulled tight: corners go where their
    neighbours see each other, and slide, off the lattice too, as long as that makes the path shorter. The shorter of
    the two is the answer. So it is never longer than the lattice's shortest path, and often, though not provably, near
    the shortest of all.

    Legs keep clear of the closed obstacles, as the lattice's moves do: they do not slip through the seam of two boxes
    that touch. Length alone is minimised; turns and other terms are reckoned, but not sought. Its bound is the straight
    line's cost, and one turn where the straight line is not safe. `NO_PATH` and the other refusals are about the
    lattice: there is none on it, at this step.

    It ends by itself; `stop`, `rng` and `on_iteration` are taken for the sake of one call for all planners.

    References
    ----------
    A. Nash, S. Koenig, C. Tovey, "Lazy Theta*: Any-Angle Path Planning and Path Length Analysis in 3D" (AAAI 2010).
    """

    def leaves_lattice(self, scenario: Scenario) -> bool:
        """Tell whether paths leave the lattice: always."""
        return True

    def plan(
        self,
        problem: Problem,
        *,
        stop: Stop | None = None,
        rng: Seed = None,
        on_iteration: OnIteration | None = None,
    ) -> Result:
        """Find a short path; see `Planner.plan`."""
        origin = provenance(repr(self), None, None)
        if problem.refusal is not None:
            return unplanned(problem, problem.refusal, origin)
        grid, world = problem.airspace.grid, problem.airspace.world
        metres = make_pricing(Objective(unit="metres"), grid.step)
        clock = Stopwatch()
        route = shortest_route(grid, metres, problem.source, problem.goal)
        if route is None:
            return unplanned(problem, Status.NO_PATH, origin)
        space = without_seams(world.space)
        corners, expanded = lazy_theta_star(grid, space, problem.source, problem.goal)
        reach = float(grid.step.max())
        ways = [pull_tight(space, reach, self._joined(problem, nodes)) for nodes in (corners, route.nodes)]
        path = min(ways, key=lambda way: length_of(way, len(way)))
        seconds = clock.seconds
        effort = Effort(generated_paths=2, generated_nodes=expanded + route.expanded, evaluations=2)
        objective = problem.scenario.objective
        straight = segment_free(world.space, problem.start, problem.end)
        bound = objective.fuel * math.dist(problem.start, problem.end) + objective.divergence * (not straight)
        result = planned_any_angle(problem, path, bound, effort, seconds, no_history(), "finished", origin)
        history = History(np.array([result.cost]), *(np.array([n]) for n in dataclasses.astuple(effort)))
        return dataclasses.replace(result, history=history)

    def _joined(self, problem: Problem, nodes: Ints) -> Floats:
        """Return the places of the nodes between the UAV's start and its target, none twice in a row."""
        if np.array_equal(problem.start, problem.end):
            return problem.start[None]
        path = np.vstack([problem.start, problem.places(nodes), problem.end])
        return path[np.r_[True, np.any(np.diff(path, axis=0) != 0.0, axis=1)]]


_SEEN = 1
_CLOSED = 2


@kernel
def lazy_theta_star(grid: Grid, space: Space, source: int, goal: int) -> tuple[Ints, int]:
    """Search from one node to another that the lattice joins to it.

    A node takes over the parent of the node from which it is reached, and only when it is expanded itself its parent
    has to see it: if not, the best of its expanded neighbours becomes its parent.

    Returns
    -------
    corners
        (n,) nodes, each seen from the one before.
    expanded
        How many nodes were.
    """
    flags = np.zeros(len(grid.exits), np.uint8)
    parent = np.empty(len(grid.exits), np.int64)
    g = np.empty(len(grid.exits), np.float64)
    here, above, beside, target = np.empty(3), np.empty(3), np.empty(3), position(grid, goal)
    steps = grid.moves * grid.step
    parent[source], g[source], flags[source] = source, 0.0, _SEEN
    heap = push(make_heap(1024), 0.0, source)
    expanded = 0
    while heap.size[0]:
        _, node = pop(heap)
        if flags[node] == _CLOSED:
            continue
        expanded += 1
        exits = grid.exits[node]
        _place(grid, node, here)
        _place(grid, parent[node], above)
        if node != source and not segment_free(space, above, here):
            g[node] = math.inf
            for m in range(len(grid.offsets)):
                beyond = node + grid.offsets[m]
                if (exits >> m) & 1 and flags[beyond] == _CLOSED:
                    length = g[beyond] + math.sqrt(steps[m, 0] ** 2 + steps[m, 1] ** 2 + steps[m, 2] ** 2)
                    if length < g[node]:
                        parent[node], g[node] = beyond, length
            _place(grid, parent[node], above)
        flags[node] = _CLOSED
        if node == goal:
            break
        up = parent[node]
        for m in range(len(grid.offsets)):
            beyond = node + grid.offsets[m]
            if not (exits >> m) & 1 or flags[beyond] == _CLOSED:
                continue
            for axis in range(3):
                beside[axis] = here[axis] + steps[m, axis]
            length = g[up] + far(above, beside)
            if flags[beyond] == _SEEN and length >= g[beyond]:
                continue
            parent[beyond], g[beyond], flags[beyond] = up, length, _SEEN
            heap = push(heap, length + far(beside, target), beyond)
    return _corners(parent, source, goal), expanded


@kernel
def _corners(parent: Ints, source: int, goal: int) -> Ints:
    """Return the nodes from the source to the goal, each the next one's parent."""
    count = 1
    node = goal
    while node != source:
        node = parent[node]
        count += 1
    corners = np.empty(count, np.int64)
    for i in range(count - 1, -1, -1):
        corners[i] = goal
        goal = parent[goal]
    return corners


@kernel
def _place(grid: Grid, node: int, place: Floats) -> None:
    """Write a node's place, metres, into (3,)."""
    rest = node
    for axis in range(2, -1, -1):
        place[axis] = grid.origin[axis] + (rest % grid.shape[axis]) * grid.step[axis]
        rest //= grid.shape[axis]
