"""Make a path of straight legs cheaper by small changes, until none of them helps.

Joints are left out, moved, shifted together with their neighbours and added. A change is priced exactly, and only on
the legs and turns that it touches; it is made if it lowers the price and its legs are free.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.cost import Rates, leg_price, turn_price
from skyverse.numerics.kernel import by_reference, inner, kernel
from skyverse.numerics.norm import distance
from skyverse.numerics.tolerances import DESCENT_GAIN
from skyverse.space.obstacles import Space, in_bounds
from skyverse.space.world import segment_free

SIZE, SPENT = 0, 1
"""Where a draft counts its points, and the legs that were priced for it."""

DIRECTIONS = np.array(
    [
        *((math.cos(k * math.pi / 4), math.sin(k * math.pi / 4), 0.0) for k in range(8)),
        (0.0, 0.0, 1.0),
        (0.0, 0.0, -1.0),
        *((0.7 * x, 0.0, 0.7 * z) for x in (-1.0, 1.0) for z in (-1.0, 1.0)),
        *((0.0, 0.7 * y, 0.7 * z) for y in (-1.0, 1.0) for z in (-1.0, 1.0)),
    ]
)
"""In which directions joints move: the first axis is along the line between the joint's neighbours."""

LONGER, SHORTER = 1.6, 0.5
"""By how much a joint's step grows after a move that helps, and shrinks after none did."""

LARGEST_SHARE = 4.0
"""Steps of the lattice: the largest step of a joint."""

INSERTED_SHARES = np.array([0.5, 0.25, 0.75])
"""Where on a leg joints are added."""

INSERTED_STEPS = np.array([0.25, 0.06, 0.015, 0.004])
"""How far beside the leg, as shares of its length."""

MORE_GAIN = 10.0
"""How many times as much as a moved joint an added one must gain."""


@by_reference
class Draft(NamedTuple):
    """A path that changes.

    Attributes
    ----------
    points
        (c, 3) metres, of which the first ``counts[SIZE]`` are the path's.
    price
        (c,) the price of the leg that ends at each point.
    share
        (c,) the step of each joint, in steps of the lattice.
    counts
        (2,) see `SIZE` and `SPENT`.
    """

    points: Floats
    price: Floats
    share: Floats
    counts: Ints


@inner
def _bends(rates: Rates, draft: Draft, i: int, v: Floats, k: int, w: Floats) -> float:
    """Return the price of the turns at joints i - 1 to k + 1 with v in place of point i and w in place of point k."""
    if rates.turn == 0.0:
        return 0.0
    path, n = draft.points, draft.counts[SIZE]
    price = 0.0
    if i > 1:
        price += turn_price(rates, path[i - 2], path[i - 1], v)
    if k == i:
        price += turn_price(rates, path[i - 1], v, path[i + 1])
    else:
        price += turn_price(rates, path[i - 1], v, w) + turn_price(rates, v, w, path[k + 1])
    if k + 2 < n:
        price += turn_price(rates, w, path[k + 1], path[k + 2])
    return price


@inner
def _remove(draft: Draft, i: int) -> None:
    """Take point i out of the draft."""
    for k in range(i, draft.counts[SIZE] - 1):
        for axis in range(3):
            draft.points[k, axis] = draft.points[k + 1, axis]
        draft.price[k] = draft.price[k + 1]
        draft.share[k] = draft.share[k + 1]
    draft.counts[SIZE] -= 1


@inner
def _drop(space: Space, rates: Rates, draft: Draft, i: int, shares: Floats) -> float:
    """Leave joint i out if that is not dearer; return what is saved, or -1 where it stays."""
    path, n = draft.points, draft.counts[SIZE]
    a, b = path[i - 1], path[i + 1]
    if not segment_free(space, a, b):
        return -1.0
    draft.counts[SPENT] += 1
    direct = leg_price(rates, a, b, shares)
    saved = draft.price[i] + draft.price[i + 1] - direct + _bends(rates, draft, i, path[i], i, path[i])
    if i > 1:
        saved -= turn_price(rates, path[i - 2], a, b)
    if i + 2 < n:
        saved -= turn_price(rates, a, b, path[i + 2])
    if saved < 0.0:
        return -1.0
    _remove(draft, i)
    draft.price[i] = direct
    return saved


@inner
def _aside(draft: Draft, i: int, k: int, direction: Floats, steps: Floats, share: float, moved: Floats) -> None:
    """Write into `moved` the vector of a step of joints i to k, (3,) metres."""
    path = draft.points
    ux, uy = path[k + 1, 0] - path[i - 1, 0], path[k + 1, 1] - path[i - 1, 1]
    size = math.sqrt(ux * ux + uy * uy)
    ux, uy = (ux / size, uy / size) if size > 0.0 else (1.0, 0.0)
    moved[0] = share * steps[0] * (direction[0] * ux - direction[1] * uy)
    moved[1] = share * steps[1] * (direction[0] * uy + direction[1] * ux)
    moved[2] = share * steps[2] * direction[2]


@inner
def _move(
    space: Space, rates: Rates, draft: Draft, i: int, k: int, steps: Floats, least: float, memory: Floats
) -> float:
    """Move joints i to k, which are one or two, by the same step if that is cheaper; return what is saved."""
    path, price, share = draft.points, draft.price, draft.share[i]
    moved, v, w, shares = memory[0], memory[1], memory[2], memory[3]
    now = _bends(rates, draft, i, path[i], k, path[k])
    for j in range(i, k + 2):
        now += price[j]
    for turn in range(len(DIRECTIONS)):
        _aside(draft, i, k, DIRECTIONS[turn], steps, share, moved)
        for axis in range(3):
            v[axis], w[axis] = path[i, axis] + moved[axis], path[k, axis] + moved[axis]
        if not (in_bounds(space, v) and in_bounds(space, w)):
            continue
        between, after = rates.metre * distance(v, w), rates.metre * distance(w, path[k + 1])  # at least
        if rates.metre * distance(path[i - 1], v) + between + after >= now - least:
            continue
        draft.counts[SPENT] += 1
        before = leg_price(rates, path[i - 1], v, shares)
        if before + between + after >= now - least:
            continue
        draft.counts[SPENT] += 1
        after = leg_price(rates, w, path[k + 1], shares)
        if before + between + after >= now - least:
            continue
        if k > i:
            draft.counts[SPENT] += 1
            between = leg_price(rates, v, w, shares)
        saved = now - before - after - between - _bends(rates, draft, i, v, k, w)
        if (
            saved > least
            and segment_free(space, path[i - 1], v)
            and segment_free(space, w, path[k + 1])
            and (k == i or segment_free(space, v, w))
        ):
            for axis in range(3):
                path[i, axis], path[k, axis] = v[axis], w[axis]
            price[i], price[k + 1] = before, after
            if k > i:
                price[k] = between
            return saved
    return 0.0


@inner
def _insert(space: Space, rates: Rates, draft: Draft, i: int, least: float, memory: Floats) -> bool:
    """Add the best of some joints beside the leg that ends at point i if that is cheaper; tell whether it is."""
    path, n, shares = draft.points, draft.counts[SIZE], memory[3]
    a, b, v, found = path[i - 1], path[i], memory[1], memory[2]
    size = distance(a, b)
    if size == 0.0 or n == len(path):
        return False
    ux, uy = b[0] - a[0], b[1] - a[1]
    level = math.sqrt(ux * ux + uy * uy)
    ux, uy = (ux / level, uy / level) if level > 0.0 else (1.0, 0.0)
    now = draft.price[i]
    if i > 1:
        now += turn_price(rates, path[i - 2], a, b)
    if i + 1 < n:
        now += turn_price(rates, a, b, path[i + 1])
    best, first, second = least, 0.0, 0.0
    for at in INSERTED_SHARES:
        for step in INSERTED_STEPS:
            for side in range(4):
                sign = step * size * (1.0 if side % 2 else -1.0)
                v[0] = a[0] + at * (b[0] - a[0]) - (sign * uy if side < 2 else 0.0)
                v[1] = a[1] + at * (b[1] - a[1]) + (sign * ux if side < 2 else 0.0)
                v[2] = a[2] + at * (b[2] - a[2]) + (0.0 if side < 2 else 0.3 * sign)
                if not in_bounds(space, v):
                    continue
                after = rates.metre * distance(v, b)  # at least
                if rates.metre * distance(a, v) + after >= now - best:
                    continue
                draft.counts[SPENT] += 1
                before = leg_price(rates, a, v, shares)
                if before + after >= now - best:
                    continue
                draft.counts[SPENT] += 1
                after = leg_price(rates, v, b, shares)
                saved = now - before - after - turn_price(rates, a, v, b)
                if i > 1:
                    saved -= turn_price(rates, path[i - 2], a, v)
                if i + 1 < n:
                    saved -= turn_price(rates, v, b, path[i + 1])
                if saved > best and segment_free(space, a, v) and segment_free(space, v, b):
                    best, first, second = saved, before, after
                    for axis in range(3):
                        found[axis] = v[axis]
    if best == least:
        return False
    for k in range(n, i, -1):
        for axis in range(3):
            path[k, axis] = path[k - 1, axis]
        draft.price[k], draft.share[k] = draft.price[k - 1], draft.share[k - 1]
    for axis in range(3):
        path[i, axis] = found[axis]
    draft.price[i], draft.price[i + 1], draft.share[i] = first, second, 1.0
    draft.counts[SIZE] += 1
    return True


@kernel
def descend(
    space: Space, rates: Rates, path: Floats, steps: Floats, finest: float, spend: int
) -> tuple[Floats, float, int]:
    """Make a free path cheaper, and no worse.

    Parameters
    ----------
    space, rates
        What must be kept clear of, and what is priced.
    path
        (n, 3) metres.
    steps
        (3,) metres: the steps of the lattice, by which joints move at first.
    finest
        The smallest step, as a share of those.
    spend
        After so many priced legs it ends.

    Returns
    -------
    path
        (k, 3) metres, with the same ends.
    price
        Its price, but for the metres between its end and a goal.
    spent
        How many legs were priced.
    """
    capacity = 2 * len(path) + 64
    draft = Draft(np.empty((capacity, 3)), np.zeros(capacity), np.ones(capacity), np.zeros(2, np.int64))
    memory = np.zeros((4, 3))
    draft.counts[SIZE] = len(path)
    draft.points[: len(path)] = path
    for i in range(1, len(path)):
        draft.price[i] = leg_price(rates, path[i - 1], path[i], memory[3])
    while draft.counts[SPENT] < spend:
        least = DESCENT_GAIN * draft.price[: draft.counts[SIZE]].sum()
        coarse = _round(space, rates, draft, steps, finest, least, memory)
        if coarse:
            continue
        added = False
        i = 1
        while i < draft.counts[SIZE]:
            if _insert(space, rates, draft, i, MORE_GAIN * least, memory):
                added = True
                i += 1
            i += 1
        if not added:
            break
        for i in range(1, draft.counts[SIZE] - 1):
            draft.share[i] = max(draft.share[i], 0.25)
    n = draft.counts[SIZE]
    total = draft.price[1:n].sum()
    for i in range(1, n - 1):
        total += turn_price(rates, draft.points[i - 1], draft.points[i], draft.points[i + 1])
    return draft.points[:n].copy(), total, draft.counts[SPENT]


@inner
def _round(
    space: Space, rates: Rates, draft: Draft, steps: Floats, finest: float, least: float, memory: Floats
) -> bool:
    """Try to drop, move and shift each joint once; tell whether any has a step that is not too fine yet."""
    coarse = False
    i = 1
    while i < draft.counts[SIZE] - 1:
        if _drop(space, rates, draft, i, memory[3]) >= 0.0:
            coarse = True
            continue
        if draft.share[i] >= finest:
            coarse = True
            saved = _move(space, rates, draft, i, i, steps, least, memory)
            if i + 2 < draft.counts[SIZE]:
                saved += _move(space, rates, draft, i, i + 1, steps, least, memory)
            if saved > 0.0:
                draft.share[i] = min(LONGER * draft.share[i], LARGEST_SHARE)
            else:
                draft.share[i] *= SHORTER
        i += 1
    return coarse
