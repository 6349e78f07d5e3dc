"""The search for good routes along many strips: how many batteries they take, and then the best routes with so many."""

import math
import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats, Ints
from skyverse.mission.assignment import Criterion
from skyverse.mission.given_order import stretches
from skyverse.mission.routing import RouteSearch, Tour, TourVehicle, Work, possible
from skyverse.mission.strip_kernel import NO_WAY, StripFleet, StripSorties, ruin_and_recreate, sorties_of
from skyverse.stop import Progress
from skyverse.survey.strip_order import order_strips

_CHANGES = 40_000, 400  # of a search, and how many more for each strip
_QUICK = 0.1  # the share of them in a quick search, and in one that only asks how many batteries are needed
_AT_ONCE = 2_000_000  # changes of one strip between two looks at the clock
_HEAT = 0.1, 0.0005  # the first and the last temperature, of the mean cost of a strip
_COOL = 0.1  # how much cooler a search begins that begins from good sorties
_SHARES = 0.5, 0.25, 0.25  # of the changes, between which each sortie's order is improved
_KICKS = 500  # of one route along all strips, and of each sortie's
_ROUTES = 4  # along all strips, from which a search begins
_NEAR = 100  # strips that count as near one


class StripSearch:
    """A search for the tours of vehicles among nodes, of which each strip has one or two."""

    def __init__(
        self,
        vehicles: Sequence[TourVehicle],
        work: Work,
        strip: Ints,
        criterion: Criterion,
        search: RouteSearch,
    ) -> None:
        kinds = {vehicle.alike(): vehicle for vehicle in vehicles}
        self._able = np.flatnonzero(np.any([possible(vehicle, work) for vehicle in kinds.values()], axis=0))
        self._search, self._rng = search, np.random.default_rng(search.seed)
        self._iterations, self._begun = 0, time.perf_counter()
        self._vehicles, self._work = vehicles, work
        self._fleet = _numbers(vehicles, work, self._able, strip[self._able], criterion)

    def tours(self) -> tuple[list[Tour], bool]:
        """Return a tour of nodes for each vehicle, and whether the search was cancelled."""
        fleet, m = self._fleet, len(self._fleet.nodes)
        if not m:
            return [()] * len(fleet.kind), self._cancelled
        extra = int(np.minimum(fleet.most - 1, m).sum())
        least = fleet.joules[:, :-1, : len(fleet.strip)].min(axis=(0, 1))[fleet.nodes].min(axis=1).sum()
        swaps = min(extra, max(0, math.ceil(float(least) / float(fleet.usable.max())) - len(fleet.kind)))
        changes = int((_QUICK if self._search.quick else 1.0) * (_CHANGES[0] + _CHANGES[1] * m))
        begin = self._cut() if not fleet.rules[1] else None
        enough = extra if begin is None else min(extra, _swaps(begin))
        while swaps < enough:
            best, left = self._run(swaps, int(_QUICK * changes), complete=True)
            if not left or self._over():
                break
            flown = max(int(best.size.sum()), 1)
            swaps = min(enough, swaps + 1 + left * int(best.used.sum()) // (2 * flown))
        begin = begin if swaps == enough else None
        found = begin
        for share in _SHARES:
            found = self._told(self._run(swaps, int(share * changes), begin=found)[0])
            for i, tour in enumerate(found if not fleet.rules[1] else ()):
                found[i] = tuple(self._polished(i, sortie, at, len(tour)) for at, sortie in enumerate(tour))
        assert found is not None
        return [tuple(tuple(self._able[list(sortie)].tolist()) for sortie in tour) for tour in found], self._cancelled

    def _told(self, best: StripSorties) -> list[Tour]:
        most = len(best.size) // len(best.used)
        rows = [best.rows[row, : best.size[row]].tolist() for row in range(len(best.size))]
        return [tuple(map(tuple, rows[i * most : i * most + int(used)])) for i, used in enumerate(best.used)]

    def _run(
        self, swaps: int, changes: int, *, complete: bool = False, begin: Sequence[Tour] | None = None
    ) -> tuple[StripSorties, int]:
        """Return the best sorties with so many swaps that a search finds, and how many strips they leave out."""
        fleet = self._fleet._replace(rules=np.array([*self._fleet.rules[:2], swaps]))
        most = min(swaps + 1, int(fleet.most.max()))
        states = sorties_of(fleet, most, begin or ()), sorties_of(fleet, most), sorties_of(fleet, most)
        values = np.full(2, math.inf)
        ruin_and_recreate(fleet, states, values, self._rng, np.empty(0), complete)
        mean = float(states[0].finish.sum()) / len(fleet.nodes)
        heats = mean * np.geomspace(_HEAT[0] * (1.0 if begin is None else _COOL), _HEAT[1], changes)
        step = max(_AT_ONCE // len(fleet.nodes), 1)
        for at in range(0, changes, step):
            if self._over() or (complete and np.all(states[1].row >= 0)):
                break
            ruin_and_recreate(fleet, states, values, self._rng, heats[at : at + step], complete)
            self._iterations += len(heats[at : at + step])
        return states[1], int(np.sum(states[1].row < 0))

    def _route(self, kind: int, nodes: Ints, begin: int, end: int, seed: int = 0) -> Ints:
        """Return nodes in a good order, each as it is or its strip flown the other way."""
        fleet = self._fleet
        visits = fleet.nodes[fleet.strip[nodes]].ravel()  # twice the same of a target
        turned = np.arange(len(visits)) ^ 1
        price = np.zeros((len(visits) + 2,) * 2)
        cost = fleet.cost[kind]
        price[turned, : len(visits)] = cost[np.ix_(visits, np.append(visits, (begin, end)))][:, : len(visits)]
        price[turned, -1] = cost[visits, end]
        price[-2, : len(visits)] = cost[begin, visits]
        price[np.arange(len(visits)), turned] = 0.0
        count = len(visits)
        order = order_strips(price, np.arange(count), count, count + 1, seed=self._search.seed + seed, rounds=_KICKS)
        return visits[2 * order.order + order.flipped]

    def _polished(self, i: int, sortie: tuple[int, ...], at: int, sorties: int) -> tuple[int, ...]:
        """Return one of a vehicle's sorties in an order that costs less, if one is found that its battery gives."""
        fleet, home = self._fleet, len(self._fleet.strip) + 1
        begin, end = home - (at == 0), home + (at + 1 == sorties and not fleet.returns[i])
        k = int(fleet.kind[i])
        other = self._route(k, np.array(sortie), begin, end)

        def summed(matrix: Floats, nodes: ArrayLike) -> float:
            places = np.concatenate([[begin], nodes, [end]])
            return float(matrix[k, places[:-1], places[1:]].sum())

        better = (
            summed(fleet.cost, other) < summed(fleet.cost, sortie) and summed(fleet.joules, other) <= fleet.usable[i]
        )
        return tuple(other.tolist()) if better else sortie

    def _cut(self) -> list[Tour] | None:
        """Return the best of the sorties into which some routes along all strips are cut."""
        found = [tours for seed in range(_ROUTES) if (tours := self._cut_from_one(seed)) is not None]
        return min(found, key=lambda tours: (_swaps(tours), self._value(tours)), default=None)

    def _value(self, tours: Sequence[Tour]) -> float:
        """Return what tours without windows cost, or the largest of their finishes."""
        fleet, most = self._fleet, max(map(len, tours))
        states = sorties_of(fleet, most, tours), sorties_of(fleet, most), sorties_of(fleet, most)
        values = np.full(2, math.inf)
        ruin_and_recreate(fleet, states, values, self._rng, np.empty(0), False)
        return float(values[1])

    def _cut_from_one(self, seed: int) -> list[Tour] | None:
        """Return the sorties into which one route along all strips is cut, if they fly all of them."""
        fleet, n = self._fleet, len(self._fleet.strip)
        one = self._route(int(fleet.kind[0]), fleet.nodes[:, 0], n, n + 1, seed)
        if fleet.rules[0]:
            parts = zip(self._vehicles, self._even(one), strict=True)
            tours = [stretches([v], self._work, self._able[part].tolist())[0] for v, part in parts]
        else:
            tours = list(stretches(self._vehicles, self._work, self._able[one].tolist()))
        if sum(len(sortie) for tour in tours for sortie in tour) < len(one):
            return None
        number = {int(node): k for k, node in enumerate(self._able)}
        return [tuple(tuple(number[x] for x in sortie) for sortie in tour) for tour in tours]

    def _even(self, route: Ints) -> list[Ints]:
        """Return parts of a route, one for each vehicle, that take about as long, with the ways out and home."""
        fleet, n = self._fleet, len(self._fleet.strip)
        cost = fleet.cost[fleet.kind[0]]
        out, back = cost[n, route], cost[route, n + 1]
        ways = np.concatenate([[0.0], np.cumsum(cost[route[:-1], route[1:]])])
        low, high = 0.0, float(out[0] + ways[-1] + back[-1])
        best = [route, *[route[:0]] * (len(fleet.kind) - 1)]
        for _ in range(30):
            most, parts, at = 0.5 * (low + high), list[Ints](), 0
            while at < len(route) and len(parts) <= len(best):
                fits = np.flatnonzero(out[at] + ways[at:] - ways[at] + back[at:] <= most)
                to = at + (int(fits[-1]) + 1 if len(fits) else 0)
                if to == at:
                    break
                parts.append(route[at:to])
                at = to
            sound = at == len(route) and len(parts) <= len(best)
            if sound:
                best = [*parts, *[route[:0]] * (len(best) - len(parts))]
            low, high = (low, most) if sound else (most, high)
        return best

    @property
    def _cancelled(self) -> bool:
        return self._search.stop is not None and self._search.stop.cancelled

    def _over(self) -> bool:
        progress = Progress(iterations=self._iterations, seconds=time.perf_counter() - self._begun)
        return self._search.stop is not None and self._search.stop.met(progress) is not None


def _swaps(tours: Sequence[Tour]) -> int:
    return sum(max(len(tour) - 1, 0) for tour in tours)


def _numbers(vehicles: Sequence[TourVehicle], work: Work, able: Ints, strip: Ints, criterion: Criterion) -> StripFleet:
    """Return the numbers of a search among the nodes that are able to be flown."""
    kinds, timed = {vehicle.alike(): vehicle for vehicle in vehicles}, criterion == "min-max"
    places, names = np.append(able, (work.targets, work.targets + 1)), list(kinds)

    def legs(matrix: Floats, there: Floats, way: Floats) -> Floats:
        """Return the legs with what is done at their ends, and with nowhere as one more place."""
        found = np.zeros((len(places) + 1,) * 2)
        found[:-1, :-1] = np.where(way, matrix + np.append(there, (0.0, 0.0)), NO_WAY)[np.ix_(places, places)]
        return found

    free, matrices = np.zeros(work.targets), []
    for v in kinds.values():
        may = np.append(v.allowed, (True, True))
        way = np.isfinite(v.price) & np.isfinite(v.seconds) & may[:, None] & may
        cost = legs(v.seconds, work.stay, way) if timed else legs(v.price, free, way)
        matrices.append((cost, legs(v.joules, v.visit_joules, way), legs(v.seconds, free, way)))
    cost, joules, seconds = (np.array(of_kinds) for of_kinds in zip(*matrices, strict=True))
    _, strip = np.unique(strip, return_inverse=True)
    order = np.argsort(strip, kind="stable")
    nodes = order[
        np.stack([np.searchsorted(strip[order], np.unique(strip), side) for side in ("left", "right")], 1) - (0, 1)
    ]
    least = cost.min(axis=0)
    own = least[:, :-3].min(axis=0)
    among = (least[:-3, :-3] - own)[nodes[:, :, None, None], nodes].min(axis=(1, 3))
    home = np.minimum(least[-3, :-3], least[-2, :-3])[nodes].min(axis=1)
    swap = np.array([v.swap for v in vehicles])
    return StripFleet(
        cost=cost,
        joules=joules,
        seconds=seconds,
        kind=np.array([names.index(v.alike()) for v in vehicles]),
        most=np.array([v.most_sorties for v in vehicles]),
        swap=swap,
        usable=np.array([v.usable for v in vehicles]),
        capacity=np.array([v.capacity for v in vehicles]),
        waiting=np.array([v.waiting for v in vehicles]),
        returns=np.array([v.returns for v in vehicles]),
        stay=np.append(work.stay[able], (0.0,) * 3),
        opens=np.append(work.window[able, 0], (0.0,) * 3),
        closes=np.append(work.window[able, 1], (math.inf,) * 3),
        strip=strip,
        nodes=nodes,
        demand=work.demand[able][nodes[:, 0]],
        near=np.argsort(among + np.diag(np.full(len(nodes), -NO_WAY)), axis=1, kind="stable")[:, 1 : _NEAR + 1],
        keys=np.array([home, -home, -own[nodes].min(axis=1)]),
        rules=np.array([timed, work.windows, 0]),
        left=4.0 * (float(cost[cost < NO_WAY].max()) + float(swap.max())) + 1.0,
    )
