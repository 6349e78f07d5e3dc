"""Few sets that together have all of some elements, by a local search that weighs elements which are hard to have.

Source: C. Gao, T. Weise, J. Li, "An efficient local search heuristic with row weighting for the unicost set covering
problem", European Journal of Operational Research 246 (2015).
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import inner, kernel

STEPS = 30_000
"""Exchanges of one set for another that are tried."""


class SetTable(NamedTuple):
    """Numbers in rows of unequal length: row i is ``numbers[first[i] : first[i + 1]]``."""

    first: Ints
    numbers: Ints


def table_of(rows: Ints, numbers: Ints, count: int) -> SetTable:
    """Return a table of so many rows from pairs of a row and a number."""
    order = np.lexsort((numbers, rows))
    first = np.searchsorted(rows[order], np.arange(count + 1))
    return SetTable(first.astype(np.int64), np.ascontiguousarray(numbers[order], dtype=np.int64))


def few_sets(sets: Ints, elements: Ints, steps: int = STEPS, seed: int = 0) -> Ints:
    """Return few sets that have all the elements that any of them has, in rising order.

    Parameters
    ----------
    sets, elements
        (n,) the numbers of a set and of an element that it has; no pair occurs twice.
    steps
        How many exchanges are tried.
    seed
        Of the choice among what is equally good.
    """
    if len(sets) == 0:
        return np.zeros(0, dtype=np.int64)
    elements = np.unique(elements, return_inverse=True)[1].astype(np.int64)
    used, sets = np.unique(sets, return_inverse=True)
    sets = sets.astype(np.int64)
    of_set = table_of(sets, elements, len(used))
    of_element = table_of(elements, sets, int(elements.max()) + 1)
    return used[np.flatnonzero(_search(of_set, of_element, steps, np.random.default_rng(seed)))]


@inner
def _cheapest(chosen: Ints, score: Floats, moved: Ints, tabu: int) -> int:
    """Return the chosen set whose loss weighs least, of equals the one that has been there for longest, or -1."""
    found = -1
    for one in range(len(chosen)):
        if not chosen[one] or one == tabu:
            continue
        if found < 0 or score[one] > score[found] or (score[one] == score[found] and moved[one] < moved[found]):
            found = one
    return found


@inner
def _change(
    of_set: SetTable, of_element: SetTable, one: int, chosen: Ints, score: Floats, weight: Floats, times: Ints
) -> int:
    """Choose a set or give it up, keep the scores, and return how many elements are had more."""
    gained = 0
    adds = 1 - 2 * chosen[one]
    chosen[one] += adds
    score[one] = -score[one]
    for k in range(of_set.first[one], of_set.first[one + 1]):
        element = of_set.numbers[k]
        before = times[element]
        times[element] = before + adds
        if before == 0 or times[element] == 0:
            gained += adds
        for n in range(of_element.first[element], of_element.first[element + 1]):
            other = of_element.numbers[n]
            if other == one:
                continue
            if adds > 0 and before == 0:
                score[other] -= weight[element]
            elif (adds > 0 and before == 1 and chosen[other]) or (adds < 0 and before == 1):
                score[other] += weight[element]
            elif adds < 0 and before == 2 and chosen[other]:
                score[other] -= weight[element]
    return gained


@kernel
def _search(of_set: SetTable, of_element: SetTable, steps: int, rng: np.random.Generator) -> Ints:
    """Return whether each set is chosen, 1 or 0.

    The score of a set that is not chosen is the weight of what it would add, of one that is chosen minus the weight of
    what only it has. Whenever all is had, one more set is given up; then sets are exchanged, and what is not had grows
    in weight.
    """
    sets, elements = len(of_set.first) - 1, len(of_element.first) - 1
    weight, times = np.ones(elements), np.zeros(elements, np.int64)
    chosen, moved = np.zeros(sets, np.int64), np.zeros(sets, np.int64)
    score = (of_set.first[1:] - of_set.first[:-1]).astype(np.float64)
    missing = elements
    while missing > 0:
        missing -= _change(of_set, of_element, int(np.argmax(score)), chosen, score, weight, times)
    best, tabu = chosen.copy(), -1
    for step in range(1, steps + 1):
        while missing == 0:
            best[:] = chosen
            missing -= _change(of_set, of_element, _cheapest(chosen, score, moved, -1), chosen, score, weight, times)
        left = _cheapest(chosen, score, moved, tabu)
        if left < 0:
            break
        missing -= _change(of_set, of_element, left, chosen, score, weight, times)
        moved[left] = step
        wanted = rng.integers(0, missing)
        element = 0
        while True:
            if times[element] == 0:
                if wanted == 0:
                    break
                wanted -= 1
            element += 1
        taken = -1
        for k in range(of_element.first[element], of_element.first[element + 1]):
            one = of_element.numbers[k]
            if one == left and of_element.first[element + 1] - of_element.first[element] > 1:
                continue
            if taken < 0 or score[one] > score[taken] or (score[one] == score[taken] and moved[one] < moved[taken]):
                taken = one
        missing -= _change(of_set, of_element, taken, chosen, score, weight, times)
        moved[taken] = step
        tabu = taken
        for element in range(elements):
            if times[element] == 0:
                weight[element] += 1.0
                for k in range(of_element.first[element], of_element.first[element + 1]):
                    score[of_element.numbers[k]] += 1.0
    return best
