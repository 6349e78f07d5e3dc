"""pathfinding3d: its A* and Theta* over a grid of unit cells, which are the nodes of a uniform lattice."""

import time
from functools import partial
from typing import Any

import numpy as np
from problems import between_ends, length, on_lattice

import skyverse as sky

STEP = 0.25
"""Metres: the side of the grid's cubic cells. The cells of the thesis's lattices are not cubes."""


def find(finder: str, scenario: sky.Scenario, seed: int, seconds: float, better: Any) -> tuple[Any, dict[str, Any]]:
    from pathfinding3d.core.diagonal_movement import DiagonalMovement
    from pathfinding3d.core.grid import Grid
    from pathfinding3d.finder.a_star import AStarFinder
    from pathfinding3d.finder.theta_star import ThetaStarFinder

    problem = sky.Problem(on_lattice(scenario, 26, STEP))
    lattice = problem.airspace.grid
    source, goal = (np.unravel_index(node, tuple(lattice.shape)) for node in (problem.source, problem.goal))
    began = time.perf_counter()
    grid = Grid(matrix=(lattice.exits > 0).astype(int).reshape(tuple(lattice.shape)))
    set_up = time.perf_counter() - began
    no_corners = DiagonalMovement.only_when_no_obstacle
    kind, rule = {"A*": (AStarFinder, no_corners), "Theta*": (ThetaStarFinder, DiagonalMovement.always)}[finder]
    search = kind(diagonal_movement=rule, time_limit=4 * seconds, max_runs=10**9)
    began = time.process_time()
    try:
        nodes, _ = search.find_path(*(grid.node(*map(int, node)) for node in (source, goal)), grid)
    except Exception as trouble:  # its way to say that the time is up
        return None, {"set_up": set_up, "note": f"{type(trouble).__name__}: {trouble}"}
    taken = time.process_time() - began
    facts = {"set_up": set_up, "any_angle": finder != "A*"}
    if not nodes:
        return None, facts
    cells = np.array([(node.x, node.y, node.z) for node in nodes], dtype=np.float64)
    path = between_ends(problem, lattice.origin + cells * lattice.step)
    better(taken, length(path))
    return path, facts


CONTENDERS = {
    f"pathfinding3d {finder}": {"kind": "grid", "run": partial(find, finder), "cities": 0, "needs": "pathfinding3d"}
    for finder in ("A*", "Theta*")
}
