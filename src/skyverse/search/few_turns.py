"""A shortest lattice path with few turns, found by going straight on: its price cuts off the search for a cheapest."""

import math

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.cost import Pricing, add_soft
from skyverse.numerics.kernel import inner
from skyverse.numerics.tolerances import PRICE_ROUNDING
from skyverse.space.lattice import Grid, position

SEEN = 64
CLOSED = 128

ORIGIN = 31
"""In place of a move or an axis: the search began here."""


@inner
def price_with_few_turns(grid: Grid, pricing: Pricing, info: NDArray[np.uint8], g: Floats, node: int) -> float:
    """Return the full price of a path of the least length left, g, from a node to the origin, with few turns.

    It goes straight on as long as that loses nothing; where it has to turn, it takes the move that it can repeat most.
    """
    offsets = grid.offsets
    price, move = 0.0, -1
    while info[node] & ORIGIN != ORIGIN:
        if move < 0 or not _is_tight(grid, pricing, info, g, node, move):
            turned, longest = move >= 0, 0
            for m in range(len(offsets)):
                run, at = 0, node
                while info[at] & ORIGIN != ORIGIN and _is_tight(grid, pricing, info, g, at, m):
                    at += offsets[m]
                    run += 1
                if run > longest:
                    move, longest = m, run
            if longest == 0:
                return math.inf
            price += pricing.turn if turned else 0.0
        price += _move_price(grid, pricing, node, move)
        node += offsets[move]
    return price


@inner
def _is_tight(grid: Grid, pricing: Pricing, info: NDArray[np.uint8], g: Floats, node: int, move: int) -> bool:
    """Tell whether a move leads along a path of the least length left, g, of those seen so far."""
    if not (grid.exits[node] >> move) & 1:
        return False
    beyond = node + grid.offsets[move]
    if not info[beyond] & SEEN or g[beyond] >= g[node]:
        return False
    return g[beyond] + _move_price(grid, pricing, node, move) <= g[node] + PRICE_ROUNDING * g[node]


@inner
def _move_price(grid: Grid, pricing: Pricing, node: int, move: int) -> float:
    """Return the price of a move from a node, soft terms included."""
    dx, dy, dz = grid.moves[move, 0], grid.moves[move, 1], grid.moves[move, 2]
    price = pricing.steps[abs(dx) + 2 * abs(dy) + 4 * abs(dz)]
    if pricing.rates.soft:
        shares = np.zeros(3)
        add_soft(pricing.rates, position(grid, node), position(grid, node + grid.offsets[move]), shares)
        price += shares.sum()
    return price
