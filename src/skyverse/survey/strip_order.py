"""One UAV's order of strips, and which way round it flies each.

A local search in compiled code: turning round a part of the route, moving up to three strips in a row elsewhere either
way round, and kicks that exchange two neighbouring parts (iterated local search with double bridges; Martin, Otto and
Felten 1991). Prices may differ by direction: sums along the route both ways give what a turned part costs at once.
"""

from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from skyverse._typing import Bools, Floats, Ints
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import GAIN_ROUNDING

_NO_WAY = 1e9
"""Seconds that stand for no way at all, finite so that differences are numbers."""
_MOVED = 3
"""The most strips in a row that are moved at once."""
_KICK = 30
"""The most strips of each of the two parts that a kick exchanges."""


class StripOrder(NamedTuple):
    """The order of strips in one route.

    Attributes
    ----------
    order
        Strips in the order flown (m,).
    flipped
        Of each in that order, whether it is flown from its second end to its first (m,).
    cost
        What the route costs, strips included; infinite if there is none.
    """

    order: Ints
    flipped: Bools
    cost: float


def order_strips(
    costs: Floats, strips: Ints, start: int, end: int | None, *, seed: int = 0, rounds: int = 1000
) -> StripOrder:
    """Order strips, and choose the direction of each, so that the whole route costs little.

    Parameters
    ----------
    costs
        What it costs to go from place to place (n, n), infinite where there is no way. From a strip's first end to its
        second, and back, it is what flying the strip costs.
    strips
        The places (m, 2) at which each strip has its first and second end.
    start, end
        The places where the route begins and ends; no end: wherever the last strip does.
    seed, rounds
        Of the kicks, and how many there are.
    """
    strips = np.asarray(strips, dtype=np.int64).reshape(-1, 2)
    places = np.r_[strips.ravel(), start, start if end is None else end]
    price = np.minimum(costs[np.ix_(places, places)], _NO_WAY)
    if end is None:
        price[:, -1] = 0.0
    visits = np.empty(len(strips), dtype=np.int64)
    cost = float(_order(np.ascontiguousarray(price), visits, np.random.default_rng(seed), rounds))
    return StripOrder(visits // 2, visits % 2 == 1, cost if cost < _NO_WAY else np.inf)


@kernel
def _order(price: Floats, visits: Ints, rng: Generator, rounds: int) -> float:
    """Write visits (2 * strip, + 1 if flipped) and return their cost.

    A visit is also the row of the end at which it begins; it ends at the row whose last bit differs. Places 2 m and
    2 m + 1 are where the route begins and ends.
    """
    m = len(visits)
    _nearest_first(price, visits)
    ahead, behind = np.empty(m), np.empty(m)
    dirty = np.ones(2 * m, dtype=np.bool_)
    best = _improve(price, visits, ahead, behind, dirty)
    kept, spare = visits.copy(), visits.copy()
    for _ in range(rounds if m > 2 else 0):
        i = int(rng.random() * (m - 1))
        j = i + int(rng.random() * min(_KICK, m - 1 - i))
        k = j + 1 + int(rng.random() * min(_KICK, m - 1 - j))
        dirty[:] = False
        for at in (i - 1, i, j, j + 1, k, k + 1):
            if 0 <= at < m:
                dirty[visits[at] // 2] = True
        spare[:] = visits
        visits[i : i + k - j] = spare[j + 1 : k + 1]
        visits[i + k - j : k + 1] = spare[i : j + 1]
        cost = _improve(price, visits, ahead, behind, dirty)
        if cost <= best:
            best = cost
            kept[:] = visits
        else:
            visits[:] = kept
    return best


@inner
def _nearest_first(price: Floats, visits: Ints) -> None:
    m = len(visits)
    left = np.ones(m, dtype=np.bool_)
    at = 2 * m
    for i in range(m):
        nearest, chosen = np.inf, -1
        for visit in range(2 * m):
            if left[visit // 2] and price[at, visit] < nearest:
                nearest, chosen = price[at, visit], visit
        visits[i] = chosen
        left[chosen // 2] = False
        at = chosen ^ 1


@inner
def _sums(price: Floats, visits: Ints, ahead: Floats, behind: Floats) -> float:
    """Put down what the route costs before each visit, flown as it is and, between visits, the other way round."""
    m = len(visits)
    ahead[0] = behind[0] = 0.0
    for i in range(m - 1):
        u, w = visits[i], visits[i + 1]
        ahead[i + 1] = ahead[i] + price[u, u ^ 1] + price[u ^ 1, w]
        behind[i + 1] = behind[i] + price[u ^ 1, u] + price[w, u ^ 1]
    last = visits[m - 1]
    return price[2 * m, visits[0]] + ahead[m - 1] + price[last, last ^ 1] + price[last ^ 1, 2 * m + 1]


@inner
def _part(price: Floats, visits: Ints, ahead: Floats, behind: Floats, i: int, j: int) -> tuple[float, float]:
    """Return what visits i to j cost as they are, and turned round."""
    u = visits[j]
    return ahead[j] - ahead[i] + price[u, u ^ 1], behind[j] - behind[i] + price[u ^ 1, u]


@inner
def _improve(price: Floats, visits: Ints, ahead: Floats, behind: Floats, dirty: Bools) -> float:
    """Change the route while that saves anything beside strips that are dirty, and return its cost."""
    m = len(visits)
    if m == 0:
        return price[0, 1]
    cost = _sums(price, visits, ahead, behind)
    looking = True
    while looking:
        looking = False
        for p in range(m):
            if not dirty[visits[p] // 2]:
                continue
            saved, i, j, to, turn = _best_change(price, visits, ahead, behind, p)
            if saved <= GAIN_ROUNDING * cost:
                dirty[visits[p] // 2] = False
                continue
            looking = True
            for at in (i - 1, i, j, j + 1, to, to + 1):
                if 0 <= at < m:
                    dirty[visits[at] // 2] = True
            _change(visits, i, j, to, turn)
            cost = _sums(price, visits, ahead, behind)
    return cost


@inner
def _best_change(
    price: Floats, visits: Ints, ahead: Floats, behind: Floats, p: int
) -> tuple[float, int, int, int, bool]:
    """Return the best saving by visit p: visits i to j go behind visit `to` (i - 1: they stay), turned round or not."""
    m = len(visits)
    best, bi, bj, bto, bturn = 0.0, 0, 0, -1, False
    for q in range(m):  # visits between p and q are turned round
        i, j = min(p, q), max(p, q)
        before = visits[i - 1] ^ 1 if i > 0 else 2 * m
        after = visits[j + 1] if j + 1 < m else 2 * m + 1
        plain, turned = _part(price, visits, ahead, behind, i, j)
        u, w = visits[i], visits[j]
        saved = price[before, u] + plain + price[w ^ 1, after] - price[before, w ^ 1] - turned - price[u, after]
        if saved > best:
            best, bi, bj, bto, bturn = saved, i, j, i - 1, True
    for size in range(1, _MOVED + 1):
        for side in range(2 if size > 1 else 1):
            i = p if side == 0 else p - size + 1
            j = i + size - 1
            if i < 0 or j >= m:
                continue
            before = visits[i - 1] ^ 1 if i > 0 else 2 * m
            after = visits[j + 1] if j + 1 < m else 2 * m + 1
            plain, turned = _part(price, visits, ahead, behind, i, j)
            u, w = visits[i], visits[j]
            gone = price[before, u] + plain + price[w ^ 1, after] - price[before, after]
            if gone <= best:
                continue
            for to in range(-1, m):
                if i - 1 <= to <= j:
                    continue
                left = visits[to] ^ 1 if to >= 0 else 2 * m
                right = visits[to + 1] if to + 1 < m else 2 * m + 1
                held = gone + price[left, right]
                saved = held - price[left, u] - plain - price[w ^ 1, right]
                if saved > best:
                    best, bi, bj, bto, bturn = saved, i, j, to, False
                saved = held - price[left, w ^ 1] - turned - price[u, right]
                if saved > best:
                    best, bi, bj, bto, bturn = saved, i, j, to, True
    return best, bi, bj, bto, bturn


@inner
def _change(visits: Ints, i: int, j: int, to: int, turn: bool) -> None:
    """Put visits i to j behind visit `to`, turned round or not."""
    part = visits[i : j + 1].copy()
    if turn:
        for k in range(len(part)):
            part[k] = visits[j - k] ^ 1
    if to > j:
        for k in range(j + 1, to + 1):
            visits[k - len(part)] = visits[k]
        visits[to + 1 - len(part) : to + 1] = part
    else:
        for k in range(i - 1, to, -1):
            visits[k + len(part)] = visits[k]
        visits[to + 1 : to + 1 + len(part)] = part
