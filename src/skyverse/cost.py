"""The objective's terms, one kernel each (thesis, equations 3.2 to 3.4), over lattice paths given as nodes."""

import math
from typing import NamedTuple

import numpy as np

from skyverse.kernel import kernel
from skyverse.result import Floats
from skyverse.scenario import Objective
from skyverse.space.lattice import Grid, Ints, position


class Pricing(NamedTuple):
    """An objective compiled for one lattice; every number is weighted.

    Attributes
    ----------
    steps
        (8,) the price of a move by the axes that it changes, ``ex + 2 ey + 4 ez``.
    first
        The price of the path's first node.
    turn, end
        The price of a turn, and of a metre between path's end and goal.
    """

    steps: Floats
    first: float
    turn: float
    end: float


def make_pricing(objective: Objective, step: Floats) -> Pricing:
    """Compile an objective's weights for a lattice with these metres per step, (3,)."""
    axes = [(e & 1, (e >> 1) & 1, e >> 2) for e in range(8)]
    lengths = [math.hypot(*(a * s for a, s in zip(used, step, strict=True))) for used in axes]
    by_nodes = objective.unit == "nodes"
    steps = np.array([objective.fuel * (1.0 if by_nodes else length) for length in lengths])
    steps[0] = 0.0
    return Pricing(steps, objective.fuel if by_nodes else 0.0, objective.divergence, objective.end)


@kernel
def _moved(grid: Grid, a: int, b: int) -> tuple[int, int, int]:
    ny, nz = grid.shape[1], grid.shape[2]
    return b // (ny * nz) - a // (ny * nz), (b // nz) % ny - (a // nz) % ny, b % nz - a % nz


@kernel
def fuel(grid: Grid, pricing: Pricing, nodes: Ints) -> float:
    """Return alpha_1 C_fuel, equation 3.2: the path's nodes, start included, or its length."""
    if pricing.steps[1] == pricing.steps[7] and pricing.first > 0.0:
        return pricing.first * len(nodes)
    total = pricing.first
    for i in range(1, len(nodes)):
        dx, dy, dz = _moved(grid, nodes[i - 1], nodes[i])
        total += pricing.steps[abs(dx) + 2 * abs(dy) + 4 * abs(dz)]
    return total


@kernel
def divergence(grid: Grid, pricing: Pricing, nodes: Ints) -> float:
    """Return alpha_2 C_divergence: the number of non-zero cross products of consecutive steps."""
    turns = 0
    if pricing.turn > 0.0 and len(nodes) > 2:
        ax, ay, az = _moved(grid, nodes[0], nodes[1])
        for i in range(2, len(nodes)):
            bx, by, bz = _moved(grid, nodes[i - 1], nodes[i])
            if ay * bz != az * by or az * bx != ax * bz or ax * by != ay * bx:
                turns += 1
            ax, ay, az = bx, by, bz
    return pricing.turn * turns


@kernel
def end(grid: Grid, pricing: Pricing, nodes: Ints, goal: int) -> float:
    """Return alpha_3 C_end, equation 3.3: the Euclidean metres from the path's end to the goal."""
    last = nodes[-1]
    if last == goal:
        return 0.0
    a, b = position(grid, last), position(grid, goal)
    return pricing.end * math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@kernel
def total(grid: Grid, pricing: Pricing, nodes: Ints, goal: int) -> float:
    """Return C, equation 3.4."""
    return fuel(grid, pricing, nodes) + divergence(grid, pricing, nodes) + end(grid, pricing, nodes, goal)


def any_angle_terms(objective: Objective, path: Floats, goal: Floats) -> dict[str, float]:
    """Return the terms of a path (n, 3) of straight legs, metres: its fuel is its length, whatever the unit."""
    length, turns = _length_and_turns(path)
    return {
        "fuel": objective.fuel * length,
        "divergence": objective.divergence * turns,
        "end": objective.end * math.dist(path[-1], goal),
    }


@kernel
def _length_and_turns(path: Floats) -> tuple[float, int]:
    """Measure a path (n, 3), and count the joints at which it does not go straight on."""
    length = 0.0
    turns = 0
    before = np.zeros(3)
    size_before = 0.0
    for i in range(1, len(path)):
        step = path[i] - path[i - 1]
        size = math.sqrt(step[0] ** 2 + step[1] ** 2 + step[2] ** 2)
        length += size
        if i > 1:
            cx = before[1] * step[2] - before[2] * step[1]
            cy = before[2] * step[0] - before[0] * step[2]
            cz = before[0] * step[1] - before[1] * step[0]
            turns += math.sqrt(cx**2 + cy**2 + cz**2) > 1e-9 * size_before * size
        before = step
        size_before = size
    return length, turns
