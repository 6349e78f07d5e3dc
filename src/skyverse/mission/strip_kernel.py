"""Strips shared among sorties by ruin and recreate, in compiled code: many strips in a second or two.

Source: J. Christiaens and G. Vanden Berghe, Slack Induction by String Removals for Vehicle Routing Problems,
Transportation Science 54(2), 2020, 417-433. Strips near one another are taken out of their sorties and put back where
they cost least, in either direction; simulated annealing decides whether that stays.

A node is a strip flown in one direction, or a target. Places n, n + 1 and n + 2 of the matrices of n nodes are where
a vehicle begins, its home, and nowhere, where open tours end.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from skyverse._typing import Bools, Floats, Ints
from skyverse.mission.routing import Tour
from skyverse.numerics.kernel import inner, kernel

NO_WAY = 1e15
"""What a leg costs where there is no way: far more than all flights, and finite, so that differences are numbers."""
_BALANCE = 0.5  # what the mean of the finishes counts beside the largest one
_TAKEN = 10.0  # strips that are taken out at a time, in the mean
_LONGEST = 10  # and at most in a row
_BLINK = 0.01  # the share of places that are overlooked when a strip is put back
_SPLIT = 0.5  # how often a strip in the middle of those that are taken out stays


class StripFleet(NamedTuple):
    """The numbers of a search: k kinds of vehicles, v vehicles, n nodes, m strips.

    Attributes
    ----------
    cost, joules, seconds
        (k, n + 3, n + 3) with what is done at the second place; the seconds are without its stay.
    kind, most, swap, usable, capacity, waiting, returns
        (v,) of the vehicles.
    stay, opens, closes
        (n + 3,) seconds.
    strip
        (n,) which strip each node is.
    nodes
        (m, 2) of each strip, twice the same where there is one only.
    demand
        (m,) kilograms.
    near
        (m, q) the strips nearest to each one.
    keys
        (3, m) by which strips are put back in turn.
    rules
        Whether the largest finish counts, whether there are windows, and how many swaps there may be.
    left
        What a strip that is left out costs.
    """

    cost: Floats
    joules: Floats
    seconds: Floats
    kind: Ints
    most: Ints
    swap: Floats
    usable: Floats
    capacity: Floats
    waiting: Floats
    returns: Bools
    stay: Floats
    opens: Floats
    closes: Floats
    strip: Ints
    nodes: Ints
    demand: Floats
    near: Ints
    keys: Floats
    rules: Ints
    left: float


class StripSorties(NamedTuple):
    """Sorties: rows s * i to s * i + s - 1 are those of vehicle i, of which the first `used` ones are not empty.

    Attributes
    ----------
    rows, size
        (s * v, m) nodes, and how many there are in each row.
    used
        (v,) sorties.
    row
        (m,) where each strip is, or -1.
    cost, joules, load
        (s * v,) of the sorties; a vehicle's windows are not looked at.
    finish
        (v,) cost of all sorties with swaps, or when the vehicle is done.
    """

    rows: Ints
    size: Ints
    used: Ints
    row: Ints
    cost: Floats
    joules: Floats
    load: Floats
    finish: Floats


def sorties_of(fleet: StripFleet, most: int, tours: Sequence[Tour] = ()) -> StripSorties:
    """Return tours of at most so many sorties, which are not measured; empty ones if none are given."""
    v, m = len(fleet.kind), len(fleet.nodes)
    rows, numbers = np.zeros((most * v, m), dtype=np.int64), np.zeros((4, most * v))
    size, used, row = (np.zeros(count, dtype=np.int64) for count in (most * v, v, m))
    row -= 1
    for i, tour in enumerate(tours):
        used[i] = len(tour)
        for at, nodes in enumerate(tour, i * most):
            rows[at, : len(nodes)], size[at] = nodes, len(nodes)
            row[fleet.strip[list(nodes)]] = at
    return StripSorties(rows, size, used, row, numbers[0], numbers[1], numbers[2], np.zeros(v))


@kernel
def ruin_and_recreate(
    fleet: StripFleet,
    states: tuple[StripSorties, StripSorties, StripSorties],
    values: Floats,
    rng: Generator,
    heats: Floats,
    complete: bool,
) -> None:
    """Change the present sorties, the first state, at falling temperatures, and keep the best ones, the second state.

    Parameters
    ----------
    states
        The present ones, the best ones, and room for others.
    values
        What the present ones cost in the search, and the best ones' rank; changed in place.
    heats
        The temperature of each change.
    complete
        Whether to end as soon as no strip is left out.
    """
    now, best, trial = states
    strips = len(fleet.nodes)
    taken = np.empty(strips, dtype=np.int64)
    if values[0] == math.inf:
        for i in range(len(now.used)):
            _measure(fleet, now, i)
        recreate(fleet, now, taken, _left_out(now, taken), rng)
        values[0], values[1] = _value(fleet, now)
        _copy(now, best)
    for heat in heats:
        if complete and values[1] < fleet.left:
            return
        _copy(now, trial)
        ruin(fleet, trial, rng)
        recreate(fleet, trial, taken, _left_out(trial, taken), rng)
        value, rank = _value(fleet, trial)
        if value < values[0] - heat * math.log(1.0 - rng.random()):
            values[0] = value
            _copy(trial, now)
            if rank < values[1]:
                values[1] = rank
                _copy(trial, best)


@inner
def _copy(source: StripSorties, target: StripSorties) -> None:
    for row in range(len(source.size)):
        target.size[row] = source.size[row]
        for i in range(source.size[row]):
            target.rows[row, i] = source.rows[row, i]
        target.cost[row], target.joules[row] = source.cost[row], source.joules[row]
        target.load[row] = source.load[row]
    target.used[:], target.row[:], target.finish[:] = source.used, source.row, source.finish


@inner
def _left_out(sorties: StripSorties, taken: Ints) -> int:
    """Write down the strips that no sortie has, and return how many there are."""
    count = 0
    for strip in range(len(sorties.row)):
        if sorties.row[strip] < 0:
            taken[count] = strip
            count += 1
    return count


@inner
def _value(fleet: StripFleet, sorties: StripSorties) -> tuple[float, float]:
    """Return what sorties cost in the search, and what counts in the end."""
    most, out, total, largest = len(sorties.size) // len(sorties.used), 0, 0.0, 0.0
    for strip in range(len(sorties.row)):
        out += sorties.row[strip] < 0
    for i in range(len(sorties.used)):
        total += sorties.finish[i]
        largest = max(largest, sorties.finish[i])
        for row in range(i * most, i * most + sorties.used[i]):
            if sorties.joules[row] > fleet.usable[i]:
                return math.inf, math.inf
    if fleet.rules[0]:
        mean = total / len(sorties.used)
        return out * fleet.left + largest + _BALANCE * mean, out * fleet.left + largest
    return out * fleet.left + total, out * fleet.left + total


@inner
def _ends(fleet: StripFleet, sorties: StripSorties, i: int, row: int) -> tuple[int, int]:
    """Return where a sortie of vehicle i begins and ends."""
    n, at = len(fleet.strip), row - i * (len(sorties.size) // len(sorties.used))
    return (n + 1 if at else n), (n + 1 if fleet.returns[i] or at + 1 < sorties.used[i] else n + 2)


@inner
def _measure(fleet: StripFleet, sorties: StripSorties, i: int) -> None:
    """Put down the totals of vehicle i's sorties, of which those that have become empty are closed up."""
    most, k, count = len(sorties.size) // len(sorties.used), fleet.kind[i], 0
    for at in range(i * most, i * most + most):
        row = i * most + count
        if sorties.size[at] == 0:
            continue
        if at != row:
            for j in range(sorties.size[at]):
                sorties.rows[row, j] = sorties.rows[at, j]
                sorties.row[fleet.strip[sorties.rows[row, j]]] = row
            sorties.size[row], sorties.size[at] = sorties.size[at], 0
        count += 1
    sorties.used[i] = count
    sorties.finish[i] = max(count - 1, 0) * fleet.swap[i] if fleet.rules[0] else 0.0
    for row in range(i * most, i * most + count):
        last, end = _ends(fleet, sorties, i, row)
        cost, joules, load = 0.0, 0.0, 0.0
        for j in range(sorties.size[row]):
            node = sorties.rows[row, j]
            cost += fleet.cost[k, last, node]
            joules += fleet.joules[k, last, node]
            load += fleet.demand[fleet.strip[node]]
            last = node
        sorties.cost[row], sorties.load[row] = cost + fleet.cost[k, last, end], load
        sorties.joules[row] = joules + fleet.joules[k, last, end]
        sorties.finish[i] += sorties.cost[row]
    if fleet.rules[1]:
        finish = _timed(fleet, sorties, i)
        if fleet.rules[0] or finish == math.inf:
            sorties.finish[i] = finish


@inner
def _timed(fleet: StripFleet, sorties: StripSorties, i: int) -> float:
    """Return when vehicle i is done; infinite if it misses a window or a battery. See `SortieLegs.extend`."""
    most, k, now = len(sorties.size) // len(sorties.used), fleet.kind[i], 0.0
    for row in range(i * most, i * most + sorties.used[i]):
        last, end = _ends(fleet, sorties, i, row)
        early, seconds, late, joules = 0.0, 0.0, math.inf, 0.0
        for j in range(sorties.size[row] + 1):
            place = sorties.rows[row, j] if j < sorties.size[row] else end
            leg = fleet.seconds[k, last, place]
            wait = max(fleet.opens[place] - late - leg, 0.0)
            joules += fleet.joules[k, last, place] + fleet.waiting[i] * wait
            if early + leg > fleet.closes[place] or joules > fleet.usable[i]:
                return math.inf
            early = max(early + leg, fleet.opens[place]) + fleet.stay[place]
            seconds += leg + wait + fleet.stay[place]
            late = min(max(late + leg, fleet.opens[place]), fleet.closes[place]) + fleet.stay[place]
            last = place
        if now + seconds > late:
            return math.inf
        now = max(early, now + seconds) + fleet.swap[i]
    return now - fleet.swap[i] if sorties.used[i] else 0.0


@inner
def ruin(fleet: StripFleet, sorties: StripSorties, rng: Generator) -> None:
    """Take strings of strips out of sorties, all near one strip."""
    strips = len(sorties.row)
    mean, count = 0.0, 0
    for row in range(len(sorties.size)):
        mean += sorties.size[row]
        count += sorties.size[row] > 0
    longest = min(float(_LONGEST), mean / max(count, 1))
    strings = int(1.0 + rng.random() * (4.0 * _TAKEN / (1.0 + longest) - 1.0))
    seed = int(rng.random() * strips)
    for at in range(-1, fleet.near.shape[1]):
        strip = fleet.near[seed, at] if at >= 0 else seed
        row = sorties.row[strip]
        if row < 0:
            continue
        size = sorties.size[row]
        length = int(1.0 + rng.random() * min(float(size), longest))
        kept = 1 if length < size and length > 1 and rng.random() < _SPLIT else 0
        span = length + kept
        where = 0
        while fleet.strip[sorties.rows[row, where]] != strip:
            where += 1
        first = max(where - span + 1, 0)
        first += int(rng.random() * (min(where, size - span) - first + 1))
        spared = first + 1 + int(rng.random() * (span - 2)) if kept else -1
        to = first
        for j in range(first, size):
            node = sorties.rows[row, j]
            if j < first + span and j != spared:
                sorties.row[fleet.strip[node]] = -1
            else:
                sorties.rows[row, to] = node
                to += 1
        sorties.size[row] = to
        strings -= 1
        if strings == 0:
            break
    for i in range(len(sorties.used)):
        _measure(fleet, sorties, i)


@inner
def recreate(fleet: StripFleet, sorties: StripSorties, taken: Ints, count: int, rng: Generator) -> None:
    """Put strips back, each where it costs least."""
    key = int(rng.random() * 6.0)
    if key >= len(fleet.keys):
        for i in range(count - 1, 0, -1):
            j = int(rng.random() * (i + 1))
            taken[i], taken[j] = taken[j], taken[i]
    else:
        for i in range(1, count):
            strip, j = taken[i], i
            while j > 0 and fleet.keys[key, taken[j - 1]] > fleet.keys[key, strip]:
                taken[j] = taken[j - 1]
                j -= 1
            taken[j] = strip
    largest = 0.0
    for i in range(len(sorties.used)):
        largest = max(largest, sorties.finish[i])
    for i in range(count):
        _put_back(fleet, sorties, taken[i], largest, rng)


@inner
def _put_back(fleet: StripFleet, sorties: StripSorties, strip: int, largest: float, rng: Generator) -> None:
    """Put one strip where it costs least, if it may be anywhere."""
    most, vehicles, swaps = len(sorties.size) // len(sorties.used), len(sorties.used), 0
    for i in range(vehicles):
        swaps += max(sorties.used[i] - 1, 0)
    cheapest, chosen, at_row, at, node = math.inf, -1, -1, -1, -1
    blink = int(math.log(1.0 - rng.random()) / math.log(1.0 - _BLINK))
    for i in range(vehicles):
        k, used = fleet.kind[i], sorties.used[i]
        new = 1 if used < min(most, fleet.most[i]) and (used == 0 or swaps < fleet.rules[2]) else 0
        for row in range(i * most, i * most + used + new):
            if (sorties.load[row] if row < i * most + used else 0.0) + fleet.demand[strip] > fleet.capacity[i]:
                continue
            fresh = row == i * most + used
            sorties.used[i] += fresh
            begin, end = _ends(fleet, sorties, i, row)
            size = 0 if fresh else sorties.size[row]
            more, held = 0.0, 0.0 if fresh else sorties.joules[row]
            if fresh and used and not fleet.returns[i]:  # the sortie before ends at home then
                tail = sorties.rows[row - 1, sorties.size[row - 1] - 1]
                more = fleet.cost[k, tail, len(fleet.strip) + 1]
                if sorties.joules[row - 1] + fleet.joules[k, tail, len(fleet.strip) + 1] > fleet.usable[i]:
                    sorties.used[i] -= 1
                    continue
            if fresh and used and fleet.rules[0]:
                more += fleet.swap[i]
            a = begin
            for j in range(size + 1):
                b = sorties.rows[row, j] if j < size else end
                blink -= 1
                if blink < 0:
                    blink = int(math.log(1.0 - rng.random()) / math.log(1.0 - _BLINK))
                    a = b
                    continue
                saved = fleet.cost[k, a, b] if size else 0.0
                for side in range(1 + (fleet.nodes[strip, 0] != fleet.nodes[strip, 1])):
                    x = fleet.nodes[strip, side]
                    cost = fleet.cost[k, a, x] + fleet.cost[k, x, b] - saved + more
                    if fleet.rules[0]:
                        cost = max(sorties.finish[i] + cost - largest, 0.0) + cost * _BALANCE / vehicles
                    if cost >= cheapest:
                        continue
                    joules = fleet.joules[k, a, x] + fleet.joules[k, x, b] - (fleet.joules[k, a, b] if size else 0.0)
                    if held + joules > fleet.usable[i]:
                        continue
                    if fleet.rules[1]:
                        _insert(sorties, row, j, x)
                        finish = _timed(fleet, sorties, i)
                        _remove(sorties, row, j)
                        if finish == math.inf:
                            continue
                    cheapest, chosen, at_row, at, node = cost, i, row, j, x
                a = b
            sorties.used[i] = used
    if chosen >= 0 and cheapest < NO_WAY / 2:
        if at_row == chosen * most + sorties.used[chosen]:
            sorties.size[at_row] = 0
        _insert(sorties, at_row, at, node)
        sorties.row[strip] = at_row
        _measure(fleet, sorties, chosen)


@inner
def _insert(sorties: StripSorties, row: int, at: int, node: int) -> None:
    for j in range(sorties.size[row], at, -1):
        sorties.rows[row, j] = sorties.rows[row, j - 1]
    sorties.rows[row, at] = node
    sorties.size[row] += 1


@inner
def _remove(sorties: StripSorties, row: int, at: int) -> None:
    sorties.size[row] -= 1
    for j in range(at, sorties.size[row]):
        sorties.rows[row, j] = sorties.rows[row, j + 1]
