"""How fast: ``python benchmarks/speed.py`` prints every figure of docs/performance.md but the voxels'."""

import os
import subprocess
import sys
import tempfile

import numpy as np
from machine import describe, median, table
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from skimage.graph import MCP_Geometric

import skyverse as sky
from skyverse.model.scenario import Lattice
from skyverse.search.lattice_astar import BYTES_PER_STATE, shortest_route
from skyverse.space.lattice import Grid

MAPS = ("map1", "map2", "map3")
MATLAB = {"map1": 13.5, "map2": 10.04, "map3": 17.76}


def main() -> None:
    print(f"{describe('scipy', 'scikit-image')}\n\nMedian wall-clock times.\n")
    metaheuristics()
    thesis_lattice()
    uniform_lattice()
    assignment()
    commands()


def metaheuristics(runs: int = 51) -> None:
    rows = []
    for name in MAPS:
        problem = sky.Problem(sky.read_scenario(name))
        row = [name]
        for planner in (sky.MVO(), sky.MVO(as_run=True)):
            seeds = iter(range(runs + 1))
            seconds = median(lambda p=planner, q=problem, s=seeds: p.plan(q, rng=next(s)), runs)
            row.append(f"{seconds * 1e3:.1f} ms")
        rows.append([*row, f"{MATLAB[name]:.1f} s"])
    print(f"MVO, 25 universes x 40 iterations, {runs} seeds")
    table(["map", "as described", "as run", "thesis, MATLAB"], rows)


def thesis_lattice(runs: int = 21) -> None:
    rows = []
    for name in MAPS:
        row = [name]
        for objective in ("thesis", "turns"):
            for connectivity in (6, 26):
                scenario = sky.read_scenario(name).model_dump() | {"objective": objective}
                scenario["lattice"]["connectivity"] = connectivity
                airspace = sky.Airspace(sky.Scenario.model_validate(scenario))
                problem = sky.Problem(airspace)
                seconds = median(lambda p=problem: sky.AStar().plan(p), runs if connectivity == 6 else 5)
                row.append(f"{seconds * 1e3:.1f} ms")
        rows.append(row)
    print("A* on the thesis's lattice (0.1 x 0.1 x 0.5 m)")
    table(["map", "6-connected", "26-connected", "6, turns priced", "26, turns priced"], rows)


def uniform_lattice() -> None:
    for name in MAPS:
        scenario = sky.read_scenario(name).model_copy(update={"lattice": Lattice(step=(0.1, 0.1, 0.1))})
        plain = sky.Problem(scenario)
        turns = sky.Problem(scenario.model_copy(update={"objective": sky.Objective(divergence=0.3, end=80)}))
        grid, pricing = plain.airspace.grid, plain.airspace.pricing
        nodes = len(grid.exits)
        length = shortest_route(grid, pricing, plain.source, plain.goal).price
        rows = [
            ["skyverse A*", "nodes", "1 path", f"{length:g}", f"{_search(plain, 9):.3f} s"],
            _scipy(grid, plain.source, plain.goal),
            _skimage(grid, plain.source, plain.goal),
            [
                "skyverse A*",
                "nodes + 0.3 x turns",
                "1 path",
                f"{turns.route.price:g}",
                f"{_search(turns, 9):.3f} s",
            ],
            _scipy_turns(grid, turns.source, turns.goal),
        ]
        print(
            f"{name}, uniform 0.1 m lattice: {nodes:,} nodes, {6 * nodes:,} states of node and direction, searched as "
            f"{3 * nodes:,} of node and axis at {BYTES_PER_STATE} bytes; {turns.route.expanded:,} expanded"
        )
        table(["what", "objective", "answer", "price", "median"], rows)


def _search(problem: sky.Problem, runs: int) -> float:
    grid, pricing = problem.airspace.grid, problem.airspace.pricing
    return median(lambda: shortest_route(grid, pricing, problem.source, problem.goal), runs)


def _edges(grid: Grid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return tail, head and move of every safe move."""
    tails, heads, moves = [], [], []
    for m, offset in enumerate(grid.offsets):
        tail = np.flatnonzero((grid.exits >> m) & 1)
        tails.append(tail)
        heads.append(tail + offset)
        moves.append(np.full(len(tail), m))
    return np.concatenate(tails), np.concatenate(heads), np.concatenate(moves)


def _scipy(grid: Grid, source: int, goal: int) -> list[str]:
    tails, heads, _ = _edges(grid)
    graph = csr_array((np.ones(len(tails)), (tails, heads)), shape=(len(grid.exits),) * 2)
    found = dijkstra(graph, indices=source)[goal] + 1
    return [
        "scipy dijkstra",
        "nodes",
        "all lengths",
        f"{found:g}",
        f"{median(lambda: dijkstra(graph, indices=source), 3):.3f} s",
    ]


def _scipy_turns(grid: Grid, source: int, goal: int) -> list[str]:
    """Price turns with scipy: a graph of node and axis, from every state to those a move leads to."""
    tails, heads, moves = _edges(grid)
    axes = len(grid.offsets) // 2
    first, last, price = [], [], []
    for axis in range(axes):
        first.append(tails * axes + axis)
        last.append(heads * axes + (moves >> 1))
        price.append(1.0 + 0.3 * ((moves >> 1) != axis))
    graph = csr_array(
        (np.concatenate(price), (np.concatenate(first), np.concatenate(last))), shape=(len(grid.exits) * axes,) * 2
    )
    del first, last, price

    def search() -> np.ndarray:
        return dijkstra(graph, indices=source * axes + np.arange(axes), min_only=True)

    found = search()[goal * axes + np.arange(axes)].min() + 1
    return ["scipy dijkstra", "nodes + 0.3 x turns", "all lengths", f"{found:g}", f"{median(search, 1):.3f} s"]


def _skimage(grid: Grid, source: int, goal: int) -> list[str]:
    costs = np.where(grid.exits > 0, 1.0, -1.0).reshape(tuple(grid.shape))
    begin, end = (tuple(int(i) for i in np.unravel_index(n, costs.shape)) for n in (source, goal))

    def search() -> float:
        return MCP_Geometric(costs, fully_connected=False).find_costs([begin], [end])[0][end]

    return ["scikit-image MCP_Geometric", "nodes", "1 path", f"{search() + 1:g}", f"{median(search, 3):.3f} s"]


def assignment() -> None:
    rng = np.random.default_rng(1)
    starts, targets = rng.uniform(0, 1000, (2, 1000, 3))
    rows = []
    for criterion in ("min-sum", "min-max"):
        seconds = median(lambda c=criterion: sky.assign(sky.straight_line(starts, targets), c), 5)
        rows.append([criterion, f"{seconds:.3f} s"])
    print("Assignment of 1,000 UAVs to 1,000 targets by straight lines, matrix included")
    table(["criterion", "median"], rows)


def commands() -> None:
    with tempfile.TemporaryDirectory() as folder:
        plan = ["plan", "map1", "-o", f"{folder}/map1.json", "--seed", "1"]
        cold = median_first(plan, folder)
        rows = [
            ["skyverse --help", f"{median(lambda: _run(['--help']), 7):.2f} s"],
            ["skyverse plan map1 (mission and page)", f"{median(lambda: _run(plan), 7):.2f} s"],
            ["skyverse plan map1, the first ever (compiles)", f"{cold:.1f} s"],
        ]
    print("Whole processes")
    table(["command", "median"], rows)


def median_first(plan: list[str], folder: str, runs: int = 3) -> float:
    caches = iter(range(runs + 1))
    return median(lambda: _run(plan, SKYVERSE_CACHE=f"{folder}/cache{next(caches)}"), runs)


def _run(words: list[str], **environment: str) -> None:
    command = [sys.executable, "-m", "skyverse", *words]
    subprocess.run(command, check=True, capture_output=True, env=os.environ | environment)


if __name__ == "__main__":
    main()
