"""A proven lower bound for the price of all paths among obstacles and zones that depend on altitude.

A path pays for its way over the map, and for its climbs. What it pays for its way is bounded by a function of the map
whose slope is nowhere more than the least price of a metre at any altitude, see `eikonal`. What it pays for its climbs
is bounded by `altitude_gain`.
"""

import math

import numpy as np

from skyverse._typing import Bools, Floats
from skyverse.cost import Rates
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import PROOF_ROUNDING
from skyverse.search.cheapest.altitude_gain import altitude_gain
from skyverse.search.cheapest.eikonal import steepness, sweep
from skyverse.search.cheapest.map_price import MapLattice, make_map_lattice
from skyverse.space.obstacles import Space

NEAR = 3
"""Up to how many steps ahead and aside from the start nodes have their exact values."""
ROUNDS = 24
"""How often prices are lowered where the spline is too steep, at most."""
STEEP = 1.002
"""The bound is divided by how much too steep the spline is somewhere; so much is not mended."""
RECOVERY = 0.5
"""A price that was lowered too far rises again by this power of what it was too low."""
WALL = 10.0
"""The price at nodes that no path comes near to, as a multiple of the price of a metre."""


@kernel
def lower_bound(space: Space, rates: Rates, start: Floats, goal: Floats, known: float, cells: int) -> float:
    """Return what every path costs at least, turns not counted.

    Parameters
    ----------
    space, rates
        What must be kept clear of, and what is priced; a metre must have a price.
    start, goal
        (3,) metres.
    known
        The price of a path that is known.
    cells
        About how many cells the lattice over the map has, more than 0.
    """
    across = math.sqrt((goal[0] - start[0]) ** 2 + (goal[1] - start[1]) ** 2)
    if across == 0.0:
        return 0.0
    bands = rates.altitude > 0.0 and not rates.above
    if not bands and len(space.boxes) + len(space.solids.kind) + len(rates.zones.kind) == 0:
        return rates.metre * across
    gained = 0.0
    if bands:
        gained = altitude_gain(rates, start[2], goal[2], across, rates.metre * across) - rates.metre * across
    longest = (known - gained) / rates.metre
    if longest <= across:
        return known * (1.0 - PROOF_ROUNDING)
    lattice = make_map_lattice(space, rates, start, goal, longest, cells, NEAR + 1)
    bound = max(_map_bound(rates, lattice, across), rates.metre * across)
    if bands:
        bound = altitude_gain(rates, start[2], goal[2], across, bound)
    return min(bound, known) * (1.0 - PROOF_ROUNDING)


@inner
def _map_bound(rates: Rates, lattice: MapLattice, across: float) -> float:
    """Return what each way over the map costs at least."""
    step, metre = lattice.step, rates.metre
    si, sj = -lattice.first[0], -lattice.first[1]
    ti = si + round(across / step)
    shape = lattice.price.shape
    fixed = np.zeros(shape, np.bool_)
    exact = np.full(shape, math.inf)
    free = lattice.free.copy()
    for i in range(si - NEAR, si + NEAR + 1):
        for j in range(sj - NEAR, sj + NEAR + 1):
            fixed[i, j] = True
            free[i, j] = False
            exact[i, j] = metre * step * math.sqrt((i - si) ** 2 + (j - sj) ** 2)
    least = _least_around(lattice.price, free, WALL * metre)
    price = least.copy()
    blame = np.empty(shape)
    best = 0.0
    for _ in range(ROUNDS):
        values = exact.copy()
        sweep(values, price, fixed, step)
        worst = max(1.0, steepness(values, lattice.price, free, step, blame))
        best = max(best, (_at_node(values, ti, sj) - _excess(values, lattice.free, si, sj, metre * step)) / worst)
        if worst <= STEEP:
            break
        for i in range(shape[0]):
            for j in range(shape[1]):
                ratio = blame[i, j] / STEEP
                price[i, j] = min(least[i, j], price[i, j] / (ratio if ratio > 1.0 else max(ratio, 0.5) ** RECOVERY))
    return best


@inner
def _least_around(price: Floats, free: Bools, wall: float) -> Floats:
    """Return the least price (n, m) of the free cells at and around each node, or `wall` where none is."""
    rows, columns = price.shape
    least = np.full(price.shape, wall)
    for i in range(1, rows - 1):
        for j in range(1, columns - 1):
            if free[i, j]:
                for k in range(i - 1, i + 2):
                    for h in range(j - 1, j + 2):
                        least[k, h] = min(least[k, h], price[i, j])
    return least


@inner
def _at_node(values: Floats, i: int, j: int) -> float:
    """Return the spline's value at a node."""
    total = 0.0
    for k in range(-1, 2):
        for h in range(-1, 2):
            total += (0.75 if k == 0 else 0.125) * (0.75 if h == 0 else 0.125) * values[i + k, j + h]
    return total


@inner
def _excess(values: Floats, free: Bools, si: int, sj: int, rise: float) -> float:
    """Return how far the spline is above the straight line's price, at most, where paths leave the start's square.

    Within that square, only the straight line's price is counted. On each edge of a cell the price is at least what its
    tangent in the middle says, and the difference is at most its greatest Bernstein coefficient.
    """
    excess = -math.inf
    for side in range(4):
        for k in range(-NEAR, NEAR + 1):
            di, dj = NEAR if side < 2 else k, k if side < 2 else NEAR
            if side & 1:
                di, dj = -di, -dj
            oi = (di > 0) - (di < 0) if side < 2 else 0
            oj = 0 if side < 2 else (dj > 0) - (dj < 0)
            i, j = si + di, sj + dj
            if not free[i + oi, j + oj]:
                continue
            a, b, c = 0.0, 0.0, 0.0
            for m in range(2):
                p, q = i + m * oi, j + m * oj
                a += values[p - abs(oj), q - abs(oi)] / 2.0
                b += values[p, q] / 2.0
                c += values[p + abs(oj), q + abs(oi)] / 2.0
            along, out = abs(oj) * di + abs(oi) * dj, NEAR + 0.5
            away = math.sqrt(along * along + out * out)
            tilt = rise * along / away / 2.0
            level = rise * away
            excess = max(excess, (a + b) / 2.0 - (level - tilt), b - level, (b + c) / 2.0 - (level + tilt))
    return excess
