"""The best routes to few targets, by dynamic programming over sets of targets.

Sorties grow target by target (Held and Karp 1962, Journal of SIAM 10(1), 196-210); of those that visit the same
targets and end at the same one, all are kept that no other surpasses in every respect. Sorties then make tours, and
tours are given to vehicles. Sets of targets are integers with one bit for each target.
"""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices, Ints
from skyverse.mission.assignment import Criterion
from skyverse.mission.routing import SortieLegs, Totals, Tour, TourVehicle, Work, carried

MOST_TARGETS = 10
_CHUNK = 1 << 22  # how many pairs are looked at at once


class _Grown(NamedTuple):
    """Beginnings of sorties: their sets and totals, their last targets, and which one each of them prolongs."""

    sets: Ints
    totals: Totals
    last: Indices
    before: Indices

    def visits(self, label: int) -> tuple[int, ...]:
        """Return the targets of one in their order."""
        found: list[int] = []
        while label >= 0:
            found.append(int(self.last[label]))
            label = int(self.before[label])
        return tuple(found[::-1])


class _Sorties(NamedTuple):
    """Sorties that are worth keeping, and the beginnings that they end."""

    sets: Ints
    totals: Totals
    label: Indices
    grown: _Grown


class _Tours(NamedTuple):
    """Tours of one vehicle: their sets, prices and finishes, the labels of their last sorties, and the tours before."""

    sets: Ints
    price: Floats
    finish: Floats
    sortie: Indices
    before: Indices


def exact_tours(
    vehicles: Sequence[TourVehicle],
    work: Work,
    criterion: Criterion,
    order: Sequence[int] | None,
    groups: Sequence[int] | None = None,
) -> tuple[Tour, ...]:
    """Return the best tour of each vehicle; see `route`. Time and memory grow exponentially with the targets.

    With `groups`, of targets that have the same number, from 0 on, one is visited; such targets have the same demand.
    """
    known: dict[object, _Fleet] = {}
    for vehicle in vehicles:
        if (kind := vehicle.alike()) not in known:
            known[kind] = _Fleet(vehicle, work, criterion, order, groups)
    fleets, cap = [known[vehicle.alike()] for vehicle in vehicles], math.inf
    if criterion == "min-max":
        _, cap = _shared(fleets, cap, largest=True)
    chosen, _ = _shared(fleets, cap, largest=False)
    return tuple(fleet.tour(entry) for fleet, entry in zip(fleets, chosen, strict=True))


class _Fleet:
    """The tours that are worth keeping of a vehicle, and of all that are like it.

    Attributes
    ----------
    sets, price, finish, swaps
        One entry for each tour; tours of the same set have the same, least, number of swaps.
    """

    def __init__(
        self,
        vehicle: TourVehicle,
        work: Work,
        criterion: Criterion,
        order: Sequence[int] | None,
        groups: Sequence[int] | None,
    ) -> None:
        n = work.targets
        self._vehicle, self._work, self._legs, self._ordered = (
            vehicle,
            work,
            SortieLegs(vehicle, work),
            order is not None,
        )
        bits = np.empty(n, dtype=np.int64)
        bits[np.arange(n) if order is None else list(order)] = 1 << np.array(range(n) if groups is None else groups)
        self._bits, self._sets = bits, 2 * int(bits.max())
        self._timed = criterion == "min-max" or work.windows
        self._segments = work.windows and (vehicle.most_sorties > 1 or vehicle.waiting > 0)
        first = later = self._grown(n)
        if vehicle.most_sorties > 1 and any(
            np.any(m[n, :n] != m[n + 1, :n]) for m in (vehicle.price, vehicle.seconds, vehicle.joules)
        ):
            later = self._grown(n + 1)
        self._between = [self._ended(grown, home=True) for grown in (first, later)]
        self._final = self._between if vehicle.returns else [self._ended(grown, home=False) for grown in (first, later)]
        self._going = [_Tours(*(np.zeros(1, dtype=kind) for kind in (np.int64, float, float, np.intp, np.intp)))]
        self._done, new = list(self._going), np.zeros(1, dtype=np.intp)
        found, self._rows = np.arange(self._sets) == 0, [np.zeros(1, dtype=np.intp)]
        everything = int(np.bitwise_or.reduce(bits[vehicle.allowed]))
        while len(self._done) <= min(vehicle.most_sorties, n) and len(self._going[-1].sets) and not found[everything]:
            k = len(self._done)
            self._done.append(self._joined(self._going[-1], self._final[k > 1], k))
            self._going.append(
                self._done[-1] if vehicle.returns else self._joined(self._going[-1], self._between[k > 1], k)
            )
            new = np.flatnonzero(~found[self._done[-1].sets])
            self._rows.append(new)
            found[self._done[-1].sets] = True
        kept = [(tours, rows) for tours, rows in zip(self._done, self._rows, strict=True)]
        self.sets = np.concatenate([tours.sets[rows] for tours, rows in kept])
        self.price = np.concatenate([tours.price[rows] for tours, rows in kept])
        self.finish = np.concatenate([tours.finish[rows] for tours, rows in kept])
        self._sorties = np.repeat(np.arange(len(kept)), [len(rows) for _, rows in kept])
        self.swaps = np.maximum(self._sorties - 1.0, 0.0)

    def tour(self, entry: int) -> Tour:
        """Return the tour of one entry."""
        k = int(self._sorties[entry])
        row = int(self._rows[k][entry - np.searchsorted(self._sorties, k)])
        tours, sorties, told = self._done, self._final, []
        for at in range(k, 0, -1):
            told.append(sorties[at > 1].grown.visits(int(tours[at].sortie[row])))
            row, tours, sorties = int(tours[at].before[row]), self._going, self._between
        return tuple(told[::-1])

    def _grown(self, begin: int) -> _Grown:
        """Return the beginnings of sorties from one place that are worth keeping."""
        light = self._light()
        sets, totals = np.zeros(1, dtype=np.int64), self._legs.begin()
        last, before = np.array([begin]), np.array([-1])
        layers: list[_Grown] = []
        counted = 0
        for _ in range(self._work.targets):
            rows, place = np.nonzero(
                self._vehicle.allowed
                & (sets[:, None] < self._bits if self._ordered else sets[:, None] & self._bits == 0)
            )
            longer, sound = self._legs.extend(Totals(*(x[rows] for x in totals)), last[rows], place)
            new_sets = sets[rows] | self._bits[place]
            fit = np.flatnonzero(sound & light[new_sets])
            kept = fit[self._front(new_sets[fit] * self._work.targets + place[fit], longer, fit, battery=True)]
            before = counted - len(sets) + rows[kept] if layers else np.full(len(kept), -1)
            sets, totals, last = new_sets[kept], Totals(*(x[kept] for x in longer)), place[kept]
            layers.append(_Grown(sets, totals, last, before))
            counted += len(sets)
        every = Totals(*(np.concatenate(column) for column in zip(*(layer.totals for layer in layers), strict=True)))
        columns = [np.concatenate(column) for column in zip(*((x.sets, x.last, x.before) for x in layers), strict=True)]
        return _Grown(columns[0], every, columns[1], columns[2])

    def _light(self) -> np.ndarray:
        """Return which sets one sortie can carry."""
        if self._vehicle.capacity == math.inf or not self._work.demand.any():
            return np.ones(self._sets, dtype=bool)
        one = np.unique(self._bits, return_index=True)[1]
        members = [one[self._bits[one] & held > 0].tolist() for held in range(self._sets)]
        return np.array([carried(self._work, held) <= self._vehicle.capacity for held in members])

    def _ended(self, grown: _Grown, home: bool) -> _Sorties:
        totals, sound = grown.totals, np.ones(len(grown.sets), dtype=bool)
        if home:
            totals, sound = self._legs.extend(totals, grown.last, np.full_like(grown.last, self._legs.home))
        rows = np.flatnonzero(sound)
        if not self._segments:
            rows = rows[self._front(grown.sets[rows], totals, rows, battery=False)]
        return _Sorties(grown.sets[rows], Totals(*(x[rows] for x in totals)), rows, grown)

    def _front(self, key: Ints, totals: Totals, rows: Indices, battery: bool) -> Indices:
        """Return which rows' sorties no other with the same key surpasses."""
        respects = [totals.price]
        if battery and self._vehicle.usable < math.inf:
            respects.append(totals.joules)
        if self._timed:
            respects.append(totals.early)
        if self._segments:
            respects += [totals.seconds, -totals.late]
        return _front(key, *(x[rows] for x in respects))

    def _joined(self, tours: _Tours, sorties: _Sorties, k: int) -> _Tours:
        """Return tours with a k-th sortie."""
        ready = tours.finish + (self._vehicle.swap if k > 1 else 0.0)
        if self._segments:
            sorties = self._reachable(sorties, tours.sets, ready)
        found = []
        for i, s in _pairs(tours.sets, sorties.sets, self._ordered):
            finish = ready[i] + sorties.totals.seconds[s]
            sound = finish <= sorties.totals.late[s]
            i, s, finish = i[sound], s[sound], np.maximum(finish, sorties.totals.early[s])[sound]
            found.append(
                (tours.sets[i] | sorties.sets[s], tours.price[i] + sorties.totals.price[s], finish, sorties.label[s], i)
            )
        sets, price, finish, s, i = (np.concatenate(column) for column in zip(*found, strict=True))
        kept = _front(sets, price, *([finish] if self._timed else []))
        return _Tours(sets[kept], price[kept], finish[kept], s[kept], i[kept])

    def _reachable(self, sorties: _Sorties, before: Ints, ready: Floats) -> _Sorties:
        """Return the sorties that no other surpasses at any time at which tours without their targets are ready."""
        everything = self._sets - 1
        times = np.full((2, everything + 1), np.inf)  # the first time, and less the last one, for all subsets of a set
        np.minimum.at(times[0], before, ready)
        np.minimum.at(times[1], before, -ready)
        for bit in self._bits.tolist():
            halves = times.reshape(2, -1, 2, bit)
            halves[:, :, 1] = np.minimum(halves[:, :, 1], halves[:, :, 0])
        first, last = times[:, everything ^ sorties.sets] * [[1.0], [-1.0]]
        totals = sorties.totals
        begin = np.minimum(totals.late - totals.seconds, last)
        rows = np.flatnonzero(first <= begin)
        early, seconds = (
            np.maximum(totals.early, first + totals.seconds),
            np.maximum(totals.seconds, totals.early - last),
        )
        kept = rows[_front(sorties.sets[rows], *(x[rows] for x in (totals.price, early, seconds, -begin)))]
        return _Sorties(sorties.sets[kept], Totals(*(x[kept] for x in totals)), sorties.label[kept], sorties.grown)


def _pairs(sets: Ints, others: Ints, ordered: bool) -> Iterator[tuple[Indices, Indices]]:
    """Yield pairs without a common target, in which all targets of the second come later if they are `ordered`."""
    rows = max(1, _CHUNK // max(len(others), 1))
    for at in range(0, max(len(sets), 1), rows):
        own = sets[at : at + rows, None]
        i, s = np.nonzero(own < (others & -others) if ordered else own & others == 0)
        yield i + at, s


def _front(key: Ints, *respects: Floats) -> Indices:
    """Return the rows that no other with the same key surpasses, or equals and comes before, in every respect."""
    order, kept = np.lexsort((*respects[::-1], key)), [np.zeros(0, dtype=np.intp)]
    while len(order):
        held = key[order]
        begins = np.append(True, held[1:] != held[:-1])
        kept.append(order[begins])
        leader = order[begins][np.cumsum(begins) - 1]
        beaten = np.ones(len(order), dtype=bool)
        for respect in respects:
            beaten &= respect[leader] <= respect[order]
        order = order[~beaten]
    return np.concatenate(kept)


def _shared(fleets: Sequence[_Fleet], cap: float, largest: bool) -> tuple[list[int], float]:
    """Return which entry each vehicle gets, and the largest finish, or the sum of the prices.

    Most targets come first, then fewest swaps, then that value, among tours that finish by `cap`.
    """
    best = np.zeros(1, dtype=np.int64), np.zeros(1), np.zeros(1)
    steps: list[tuple[Ints, Indices, Indices]] = []
    for fleet in fleets:
        sets, swaps, values = best
        of_fleet = fleet.finish if largest else fleet.price
        entries = np.flatnonzero(fleet.finish <= cap)
        entries = entries[_front(fleet.sets[entries], of_fleet[entries])]
        found = []
        for i, e in _pairs(sets, fleet.sets[entries], ordered=False):
            e = entries[e]
            value = np.maximum(values[i], of_fleet[e]) if largest else values[i] + of_fleet[e]
            united, total = sets[i] | fleet.sets[e], swaps[i] + fleet.swaps[e]
            order = np.lexsort((value, total, united))
            order = order[np.append(True, np.diff(united[order]) != 0)]
            found.append((united[order], total[order], value[order], i[order], e[order]))
        united, total, value, i, e = (np.concatenate(column) for column in zip(*found, strict=True))
        order = np.lexsort((value, total, united))
        order = order[np.append(True, np.diff(united[order]) != 0)]
        best = united[order], total[order], value[order]
        steps.append((united[order], i[order], e[order]))
    visited = np.array([int(held).bit_count() for held in best[0]])
    row = int(np.lexsort((best[2], best[1], -visited))[0])
    chosen, value = [], float(best[2][row])
    for _, before, entry in reversed(steps):
        chosen.append(int(entry[row]))
        row = int(before[row])
    return chosen[::-1], value
