"""The search for good routes along many strips: how many batteries they take, and then the best routes with so many."""

import math
import time
from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.mission.assignment import Criterion
from skyverse.mission.routing import RouteSearch, Tour, TourVehicle, Work, possible
from skyverse.mission.strip_kernel import NO_WAY, StripFleet, StripSorties, no_sorties, ruin_and_recreate
from skyverse.stop import Progress

_CHANGES = 40_000, 400  # of a search, and how many more for each strip
_QUICK = 0.1  # the share of them in a quick search, and in one that only asks how many batteries are needed
_AT_ONCE = 2_000_000  # changes of one strip between two looks at the clock
_HEAT = 0.1, 0.0005  # the first and the last temperature, of the mean cost of a strip
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
        while True:
            best, left = self._run(swaps, int(_QUICK * changes), complete=True)
            if not left or swaps >= extra or self._over():
                break
            flown = max(int(best.size.sum()), 1)
            swaps = min(extra, swaps + 1 + left * int(best.used.sum()) // (2 * flown))
        best, _ = self._run(swaps, changes)
        most = len(best.size) // len(best.used)
        found = [
            tuple(
                tuple(self._able[best.rows[row, : best.size[row]]].tolist())
                for row in range(i * most, i * most + int(best.used[i]))
            )
            for i in range(len(best.used))
        ]
        return found, self._cancelled

    def _run(self, swaps: int, changes: int, complete: bool = False) -> tuple[StripSorties, int]:
        """Return the best sorties with so many swaps that a search finds, and how many strips they leave out."""
        fleet = self._fleet._replace(rules=np.array([*self._fleet.rules[:2], swaps]))
        now, best, other = (no_sorties(fleet, min(swaps + 1, int(fleet.most.max()))) for _ in range(3))
        values = np.full(2, math.inf)
        ruin_and_recreate(fleet, (now, best, other), values, self._rng, np.empty(0), complete)
        mean = float(now.finish.sum()) / len(fleet.nodes)
        heats = mean * np.geomspace(*_HEAT, changes)
        step = max(_AT_ONCE // len(fleet.nodes), 1)
        for at in range(0, changes, step):
            if self._over() or (complete and np.all(best.row >= 0)):
                break
            ruin_and_recreate(fleet, (now, best, other), values, self._rng, heats[at : at + step], complete)
            self._iterations += len(heats[at : at + step])
        return best, int(np.sum(best.row < 0))

    @property
    def _cancelled(self) -> bool:
        return self._search.stop is not None and self._search.stop.cancelled

    def _over(self) -> bool:
        progress = Progress(iterations=self._iterations, seconds=time.perf_counter() - self._begun)
        return self._search.stop is not None and self._search.stop.met(progress) is not None


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
