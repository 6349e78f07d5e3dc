"""Functions of the map that nowhere rise faster than a price: they prove what every way over the map costs at least.

A function u of the map whose slope is at most the price of a metre everywhere rises along a way by no more than the way
costs. The best such function is the least cost from the start; it solves the eikonal equation |grad u| = price. Here u
is the quadratic B-spline whose coefficients are the values at the nodes of a lattice. Each node is the middle of a
square cell, in which the spline is a polynomial, so that its slope is bounded by that of its Bernstein coefficients.

Fast sweeping (H. Zhao, Mathematics of Computation 74, 2005) finds the values by upwind differences. Where their spline
rises too fast, the nodes to which it rises are given a lower price, and it is solved again.
"""

import math

import numpy as np

from skyverse._typing import Bools, Floats
from skyverse.numerics.kernel import inner
from skyverse.numerics.tolerances import SWEEP_CONVERGED

SWEEPS = 400
"""The largest number of sweeps, over all directions by turns."""


@inner
def sweep(values: Floats, price: Floats, fixed: Bools, step: float) -> None:
    """Lower the values (n, m) at nodes until they solve the eikonal equation by upwind differences.

    Parameters
    ----------
    values
        At first those at the fixed nodes, and infinity at all others.
    price
        (n, m) the price of a metre at each node.
    fixed
        (n, m) whether a node keeps its value.
    step
        Metres between nodes.
    """
    rows, columns = values.shape
    waits = ~fixed
    for turn in range(SWEEPS):
        lowered = False
        for row in range(rows):
            i = rows - 1 - row if turn & 1 else row
            for column in range(columns):
                j = columns - 1 - column if turn & 2 else column
                if not waits[i, j]:
                    continue
                waits[i, j] = False
                value = _upwind(values, i, j, step * price[i, j])
                if value < values[i, j] * (1.0 - SWEEP_CONVERGED):
                    values[i, j] = value
                    lowered = True
                    for side in range(4):
                        k, h = i + (side == 0) - (side == 1), j + (side == 2) - (side == 3)
                        if 0 <= k < rows and 0 <= h < columns and not fixed[k, h] and values[k, h] > value:
                            waits[k, h] = True
        if not lowered and turn >= 3:
            return


@inner
def _upwind(values: Floats, i: int, j: int, rise: float) -> float:
    """Return the value at a node from the lower ones of its neighbours, where the spline rises by `rise` in a step."""
    rows, columns = values.shape
    a = min(values[max(i - 1, 0), j], values[min(i + 1, rows - 1), j])
    b = min(values[i, max(j - 1, 0)], values[i, min(j + 1, columns - 1)])
    if min(a, b) + rise <= max(a, b):
        return min(a, b) + rise
    return (a + b + math.sqrt(2.0 * rise * rise - (a - b) ** 2)) / 2.0


@inner
def steepness(values: Floats, price: Floats, free: Bools, step: float, blame: Floats) -> float:
    """Return the largest ratio of the spline's slope to the price in any free cell.

    Parameters
    ----------
    values, price
        (n, m) at nodes, and of a metre in cells.
    free
        (n, m) whether a path may lead through the cell; never at the rim.
    step
        Metres between nodes.
    blame
        (n, m) where the largest ratio of the cells whose slope rises to each node is written.
    """
    rows, columns = values.shape
    along_x, along_y = np.empty((3, 3)), np.empty((3, 3))
    worst = 0.0
    blame[:] = 0.0
    for i in range(1, rows - 1):
        for j in range(1, columns - 1):
            if not free[i, j]:
                continue
            for k in range(3):
                _differences(values[i - 1, j + k - 1], values[i, j + k - 1], values[i + 1, j + k - 1], along_x[:, k])
                _differences(values[i + k - 1, j - 1], values[i + k - 1, j], values[i + k - 1, j + 1], along_y[k])
            for k in range(3):
                _average(along_x[k])
                _average(along_y[:, k])
            square = 0.0
            for k in range(3):
                for h in range(3):
                    square = max(square, along_x[k, h] ** 2 + along_y[k, h] ** 2)
            ratio = math.sqrt(square) / (step * price[i, j])
            worst = max(worst, ratio)
            for k in range(i - 1, i + 2):
                for h in range(j - 1, j + 2):
                    if values[k, h] >= values[i, j]:
                        blame[k, h] = max(blame[k, h], ratio)
    return worst


@inner
def _differences(a: float, b: float, c: float, out: Floats) -> None:
    """Write the Bernstein coefficients (3,) of the derivative of the spline in the cell around b, a step long."""
    out[0], out[1], out[2] = b - a, (c - a) / 2.0, c - b


@inner
def _average(values: Floats) -> None:
    """Replace the values (3,) at three nodes by the Bernstein coefficients of their spline in the middle cell."""
    a, b, c = values[0], values[1], values[2]
    values[0], values[2] = (a + b) / 2.0, (b + c) / 2.0
