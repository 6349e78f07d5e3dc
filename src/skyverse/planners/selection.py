"""Selection among candidates by cost: their ranks, and a roulette wheel on which better ranks have more weight."""

import numpy as np
from numpy.random import Generator

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import kernel, query


@kernel
def ranked(costs: Floats) -> Ints:
    """Return the indices of candidates in order of cost, (n,); those of equal cost keep their order."""
    order = np.empty(len(costs), np.int64)
    for i in range(len(costs)):
        j = i
        while j > 0 and costs[order[j - 1]] > costs[i]:
            order[j] = order[j - 1]
            j -= 1
        order[j] = i
    return order


@query
def rank_wheel(n: int, rng: Generator) -> int:
    """Return a random rank from 0 to n - 1 by a roulette wheel, on which rank r has the weight n - r."""
    spin = rng.random() * (n * (n + 1) // 2)
    rank = 0
    while rank < n - 1 and spin >= n - rank:
        spin -= n - rank
        rank += 1
    return rank
