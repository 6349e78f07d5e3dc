"""Routes along strips as numbers: who flies them in which rows, and what that costs.

A node is a strip flown in one direction, or a place of its own. Places n, n + 1 and n + 2 of the matrices of n nodes
are where a vehicle begins, its home, and nowhere, where open routes end. A row is a sortie of a vehicle; the last row
holds what is left on the ground. All rows stand in one line, one after the other, each behind a mark, which is n.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Bools, Floats, Ints
from skyverse.numerics.kernel import by_reference, inner, inner_query


@by_reference
class StripFleet(NamedTuple):
    """The numbers of a search: k kinds of vehicles, v vehicles, n nodes, r rows.

    Attributes
    ----------
    cost, joules, seconds
        (k, n + 3, n + 3) with what is done at the second place; the seconds are without its stay.
    kind, returns
        (v,) of the vehicles.
    limits
        (v, 4) seconds of a swap, joules of a battery, kilograms of a sortie, and watts while a vehicle waits.
    partner
        (n,) the node that flies the same strip the other way; of a place itself.
    does
        (n + 3, 4) seconds of a stay, first and last second at which it may begin, and kilograms.
    owner
        (r,) whose rows these are, in turn; v of the last one.
    left, broken
        What a strip costs that is left on the ground, and what routes cost beside that break a rule.
    squares
        How often finishes are squared before their mean is taken; 0 if costs count.
    swaps
        How many there may be.
    simple
        Whether what a change of rows costs follows from its legs alone.
    """

    cost: Floats
    joules: Floats
    seconds: Floats
    kind: Ints
    returns: Bools
    limits: Floats
    partner: Ints
    does: Floats
    owner: Ints
    left: float
    broken: float
    squares: int
    swaps: int
    simple: bool

    def tours(self, line: Ints) -> list[tuple[tuple[int, ...], ...]]:
        """Return the sorties of each vehicle that are not empty."""
        rows = [tuple(row[1:].tolist()) for row in np.split(line, np.flatnonzero(line == len(self.partner)))[1:]]
        owned = list(zip(rows, self.owner, strict=True))
        return [tuple(row for row, of in owned if row and of == i) for i in range(len(self.kind))]


@by_reference
class StripRows(NamedTuple):
    """All rows, m strips behind r marks, and sums along them.

    Attributes
    ----------
    line
        (m + r,) nodes, and n where a row begins.
    row
        (m + r,) of each.
    first
        (r + 1,) where each row begins.
    ahead, behind
        (k, m + r) costs of the legs before each node as they are flown, and as they would be the other way round.
    begin, end
        (r,) the places between which rows are flown.
    shut
        (r,) empty rows that must stay so, or that are like another one.
    finish
        (2, v + 1) what the rows of a vehicle cost, or when it is done; and the same without waiting.
    """

    line: Ints
    row: Ints
    first: Ints
    ahead: Floats
    behind: Floats
    begin: Ints
    end: Ints
    shut: Bools
    finish: Floats


def strip_rows(fleet: StripFleet, line: Ints) -> StripRows:
    """Return rows that are not measured."""
    rows, sums = np.zeros((3, len(fleet.owner) + 1), dtype=np.int64), np.zeros((2, len(fleet.cost), len(line)))
    empty, finish = np.zeros(len(fleet.owner), dtype=np.bool_), np.zeros((2, len(fleet.kind) + 1))
    return StripRows(line.copy(), np.zeros_like(line), rows[0], sums[0], sums[1], rows[1], rows[2], empty, finish)


@inner_query
def power(base: float, squares: int) -> float:
    """Return a number squared so many times."""
    for _ in range(squares):
        base *= base
    return base


@inner_query
def root(power: float, squares: int) -> float:
    """Return the number that is this power."""
    for _ in range(squares):
        power = math.sqrt(power)
    return power


@inner
def measure(fleet: StripFleet, rows: StripRows) -> float:
    """Put down the sums of rows, and return their value."""
    row, n, vehicles = -1, len(fleet.partner), len(fleet.kind)
    for at in range(len(rows.line)):
        if rows.line[at] == n:
            row += 1
            rows.first[row] = at
        rows.row[at] = row
        for k in range(len(fleet.cost)):
            rows.ahead[k, at] = rows.behind[k, at] = 0.0
            if at > rows.first[row] + 1:
                u, w = rows.line[at - 1], rows.line[at]
                rows.ahead[k, at] = rows.ahead[k, at - 1] + fleet.cost[k, u, w]
                rows.behind[k, at] = rows.behind[k, at - 1] + fleet.cost[k, fleet.partner[w], fleet.partner[u]]
    rows.first[row + 1] = len(rows.line)
    value, swaps, total, latest = fleet.left * (len(rows.line) - rows.first[row] - 1), 0, 0.0, 0.0
    for i in range(vehicles):
        used, sound = _flown(fleet, rows, i)
        value += 0.0 if sound else fleet.broken
        swaps += max(used - 1, 0)
        latest = max(latest, rows.finish[0, i])
        total += rows.finish[0, i]
    for r in range(row):
        rows.shut[r] = rows.first[r] + 1 == rows.first[r + 1] and (
            (r > 0 and fleet.owner[r - 1] == fleet.owner[r] and rows.first[r - 1] + 1 == rows.first[r])
            or (rows.begin[r] > n and swaps >= fleet.swaps)
        )
    if fleet.squares and latest > 0.0:
        total = 0.0
        for i in range(vehicles):
            total += power(rows.finish[0, i] / latest, fleet.squares)
        total = latest * root(total / vehicles, fleet.squares)
    return value + total + (fleet.broken if swaps > fleet.swaps else 0.0)


@inner
def _flown(fleet: StripFleet, rows: StripRows, i: int) -> tuple[int, bool]:
    """Put down what vehicle i does; return how many sorties it flies, and whether it keeps to all rules.

    The arithmetic of segments is that of Vidal et al. (2013), Computers & Operations Research 40(1), 475-489.
    """
    n, k, used, sound, now, price, before = len(fleet.partner), fleet.kind[i], 0, True, 0.0, 0.0, -1
    swap, battery, capacity, waiting = fleet.limits[i, 0], fleet.limits[i, 1], fleet.limits[i, 2], fleet.limits[i, 3]
    final = n + 1 if fleet.returns[i] else n + 2
    for row in range(len(fleet.owner)):
        if fleet.owner[row] != i:
            continue
        rows.begin[row], rows.end[row] = n + min(used, 1), final
        if rows.first[row] + 1 < rows.first[row + 1]:
            if before >= 0:
                rows.end[before] = n + 1
            before = row
            used += 1
    last_row, used = before, 0
    for row in range(len(fleet.owner)):
        if fleet.owner[row] != i or rows.first[row] + 1 == rows.first[row + 1]:
            continue
        used += 1
        last, early, seconds, late, joules, kilograms = rows.begin[row], 0.0, 0.0, math.inf, 0.0, 0.0
        for at in range(rows.first[row] + 1, rows.first[row + 1] + 1):
            place = rows.line[at] if at < rows.first[row + 1] else rows.end[row]
            stay, opens, closes = fleet.does[place, 0], fleet.does[place, 1], fleet.does[place, 2]
            leg = fleet.seconds[k, last, place]
            wait = max(opens - late - leg, 0.0)
            price += fleet.cost[k, last, place]
            joules += fleet.joules[k, last, place] + waiting * wait
            kilograms += fleet.does[place, 3]
            sound = sound and early + leg <= closes and joules <= battery
            early = max(early + leg, opens) + stay
            seconds += leg + wait + stay
            late = min(max(late + leg, opens), closes) + stay
            last = place
        sound = sound and kilograms <= capacity and now + seconds <= late
        now = max(early, now + seconds)
        if row != last_row:
            now, price = now + swap, price + (swap if fleet.squares else 0.0)
    rows.finish[1, i] = price
    rows.finish[0, i] = now if fleet.squares else price
    return used, sound
