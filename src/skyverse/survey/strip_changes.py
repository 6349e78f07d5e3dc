"""Changes of routes along strips, and what they save.

Every change exchanges two parts of rows, each turned round or not: a part turned where it is, up to three strips in a
row put elsewhere, the ends of two rows exchanged, two strips exchanged. Sums along the rows both ways give what a part
costs at once.
"""

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import inner, inner_query
from skyverse.numerics.tolerances import GAIN_ROUNDING
from skyverse.survey.strip_fleet import StripFleet, StripRows, measure, power, root

_MOVED = 3
"""The most strips in a row that are moved at once."""

Part = tuple[int, int, int, int, int, int]
"""Nodes i to j and whether they are turned round, and the same of k to l, with which they change places.

A part without nodes is the place before node i = j + 1.
"""


@inner
def exchange(fleet: StripFleet, line: Ints, to: Ints, part: Ints) -> None:
    """Write a line in which two parts (see `Part`) have changed places."""
    i, j, turn, k, l, other = part[0], part[1], part[2], part[3], part[4], part[5]  # noqa: E741
    if k < i:
        i, j, turn, k, l, other = k, l, other, i, j, turn  # noqa: E741
    at, to[:] = i, line
    for first, last, turned in ((k, l, other), (j + 1, k - 1, 0), (i, j, turn)):
        for x in range(last - first + 1):
            to[at] = fleet.partner[line[last - x]] if turned else line[first + x]
            at += 1


@inner
def best_change(fleet: StripFleet, rows: StripRows, trial: StripRows, p: int, value: float, part: Ints) -> None:
    """Write down the best change by node p, if there is any for the better."""
    row, ground, best = rows.row[p], len(fleet.owner) - 1, np.array((value, -GAIN_ROUNDING * abs(value)))
    first, last, at = rows.first[row] + 1, rows.first[row + 1] - 1, fleet.owner[row]
    for q in range(first, last + 1 if row < ground else first):  # nodes between p and q are turned round
        i, j = min(p, q), max(p, q)
        before = rows.begin[row] if i == first else rows.line[i - 1]
        after = rows.end[row] if j == last else rows.line[j + 1]
        one = _way(fleet, rows, row, before, i, j, True, after) - _way(fleet, rows, row, before, i, j, False, after)
        change = _worth(fleet, rows, at, at, one, 0.0)
        if change < best[1]:
            _try(fleet, rows, trial, (i, j, 1, j + 1, j, 0), change, best, part)
    for other in range(ground):
        if rows.shut[other]:
            continue
        for size in range(1, _MOVED + 1 if row < ground else 2):
            for i in range(p, p - size, -max(size - 1, 1)):
                if i >= first and i + size - 1 <= last:
                    _move(fleet, rows, trial, i, i + size - 1, other, best, part)
        if row not in (ground, other):
            _exchange_rows(fleet, rows, trial, p, other, best, part)


@inner
def _move(
    fleet: StripFleet, rows: StripRows, trial: StripRows, i: int, j: int, other: int, best: Floats, part: Ints
) -> None:
    """Try to put nodes i to j elsewhere in a row, either way round."""
    n, row, line, one = len(fleet.partner), rows.row[i], rows.line, -fleet.left
    if row < len(fleet.owner) - 1:
        before = line[i - 1] if line[i - 1] < n else rows.begin[row]
        after = line[j + 1] if j + 1 < rows.first[row + 1] else rows.end[row]
        one = _way(fleet, rows, row, before, j + 1, j, False, after)
        one -= _way(fleet, rows, row, before, i, j, False, after)
    k, first, last = fleet.kind[fleet.owner[other]], rows.first[other], rows.first[other + 1] - 1
    a, b = fleet.owner[row], fleet.owner[other]
    cost, u, w, x, y = fleet.cost, line[i], line[j], fleet.partner[line[j]], fleet.partner[line[i]]
    ahead, behind = rows.ahead[k, j] - rows.ahead[k, i], rows.behind[k, j] - rows.behind[k, i]
    for to in range(first, last + 1):
        if i - 1 <= to <= j:
            continue
        left = line[to] if to > first else rows.begin[other]
        right = line[to + 1] if to < last else rows.end[other]
        link = cost[k, left, right] if first < last else 0.0
        two = cost[k, left, u] + ahead + cost[k, w, right] - link
        change = _worth(fleet, rows, a, b, one, two)
        if change < best[1]:
            _try(fleet, rows, trial, (i, j, 0, to + 1, to, 0), change, best, part)
        two = cost[k, left, x] + behind + cost[k, y, right] - link
        change = _worth(fleet, rows, a, b, one, two)
        if change < best[1]:
            _try(fleet, rows, trial, (i, j, 1, to + 1, to, 0), change, best, part)


@inner
def _exchange_rows(
    fleet: StripFleet, rows: StripRows, trial: StripRows, p: int, other: int, best: Floats, part: Ints
) -> None:
    """Try to exchange what comes behind node p, or the node itself, with parts of another row."""
    a, b = fleet.owner[rows.row[p]], fleet.owner[other]
    row, line, start, stop = rows.row[p], rows.line, rows.first[other], rows.first[other + 1] - 1
    last, end, final = rows.first[row + 1] - 1, rows.end[row], rows.end[other]
    before = line[p - 1] if p - 1 > rows.first[row] else rows.begin[row]
    after = line[p + 1] if p < last else end
    tail = _way(fleet, rows, row, line[p], p + 1, last, False, end)
    held = _way(fleet, rows, row, before, p, p, False, after)
    for to in range(start, stop + 1):
        here, right = line[to] if to > start else rows.begin[other], line[to + 1] if to < stop else final
        one = _way(fleet, rows, row, line[p], to + 1, stop, False, end) - tail
        two = _way(fleet, rows, other, here, p + 1, last, False, final)
        two -= _way(fleet, rows, other, here, to + 1, stop, False, final)
        change = _worth(fleet, rows, a, b, one, two)
        if change < best[1]:
            _try(fleet, rows, trial, (p + 1, last, 0, to + 1, stop, 0), change, best, part)
        one = _way(fleet, rows, row, line[p], start + 1, to, True, end) - tail
        two = _way(fleet, rows, other, rows.begin[other], p + 1, last, True, right)
        two -= _way(fleet, rows, other, rows.begin[other], start + 1, to, False, right)
        change = _worth(fleet, rows, a, b, one, two)
        if change < best[1]:
            _try(fleet, rows, trial, (p + 1, last, 1, start + 1, to, 1), change, best, part)
        if to == start:
            continue
        left = line[to - 1] if to - 1 > start else rows.begin[other]
        now = _way(fleet, rows, other, left, to, to, False, right)
        for turn in range(2):
            two = _way(fleet, rows, other, left, p, p, turn == 1, right) - now
            for turned in range(2):
                one = _way(fleet, rows, row, before, to, to, turned == 1, after) - held
                change = _worth(fleet, rows, a, b, one, two)
                if change < best[1]:
                    _try(fleet, rows, trial, (p, p, turn, to, to, turned), change, best, part)


@inner_query
def _way(fleet: StripFleet, rows: StripRows, row: int, before: int, i: int, j: int, turned: bool, after: int) -> float:
    """Return what it costs a row's vehicle from a place along nodes i to j of the line, or none, to another place."""
    k, n = fleet.kind[fleet.owner[row]], len(fleet.partner)
    if i > j:
        return 0.0 if before >= n and after >= n else fleet.cost[k, before, after]
    u, w = rows.line[i], rows.line[j]
    if turned:
        inside = rows.behind[k, j] - rows.behind[k, i]
        return fleet.cost[k, before, fleet.partner[w]] + inside + fleet.cost[k, fleet.partner[u], after]
    return fleet.cost[k, before, u] + rows.ahead[k, j] - rows.ahead[k, i] + fleet.cost[k, w, after]


@inner
def _try(
    fleet: StripFleet, rows: StripRows, trial: StripRows, held: Part, change: float, best: Floats, part: Ints
) -> None:
    """Keep a change if it is the best so far; it may be worse than it looks by waits, swaps and rules."""
    if not fleet.simple:
        exchange(fleet, rows.line, trial.line, np.array(held))
        change = measure(fleet, trial) - best[0]
    if change < best[1]:
        best[1] = change
        part[0], part[1], part[2], part[3], part[4], part[5] = held


@inner_query
def _worth(fleet: StripFleet, rows: StripRows, a: int, b: int, one: float, two: float) -> float:
    """Return by how much the value changes at least if the rows of two vehicles cost so much more.

    For finishes, if it rises, anything that is not below zero.
    """
    vehicles, finish = len(fleet.kind), rows.finish
    if fleet.squares == 0:
        return one + two
    if a == b:
        one, two = one + two, 0.0
    ends = finish[1, a] + one, finish[1, b] + (one if a == b else two)
    waits = finish[0, a] - finish[1, a] + finish[0, b] - finish[1, b]
    if one + two >= waits and max(ends[0], ends[1]) >= max(finish[0, a], finish[0, b]) and a < vehicles:
        return 0.0  # what is no less in sum, and ends no earlier, is no better
    total, former, scale = 0.0, 0.0, max(finish[0, b], ends[1])
    for i in range(vehicles):
        scale = max(scale, finish[0, i])
    for i in range(vehicles):
        former += power(finish[0, i] / scale, fleet.squares)
        total += power((ends[0] if i == a else ends[1] if i == b else finish[0, i]) / scale, fleet.squares)
    change = scale * (root(total / vehicles, fleet.squares) - root(former / vehicles, fleet.squares))
    return change + one if a == vehicles else change
