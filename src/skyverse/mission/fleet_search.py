"""The search for good routes along many strips: how many batteries they take, and then the best routes with so many."""

import math
import time
from collections.abc import Sequence

import numpy as np

from skyverse._typing import Ints
from skyverse.interrupt import interrupted
from skyverse.mission.assignment import Criterion
from skyverse.mission.routing import RouteSearch, Tour, TourVehicle, Work, possible
from skyverse.stop import Progress, is_cancelled
from skyverse.survey.strip_fleet import StripFleet
from skyverse.survey.strip_search import StripSearch

_KICKS = 2_000, 30  # of a search, and how many more for each strip
_QUICK = 0.1  # the share of them in a quick search, and in each of those that come first
_AT_ONCE = 20_000  # kicks of one strip between two looks at the clock
_SQUARES = 5  # by which late finishes count more
_STARTS = 4  # searches of which the best goes on


class FleetSearch:
    """A search for the tours of vehicles among nodes, of which each strip has one or two."""

    def __init__(
        self, vehicles: Sequence[TourVehicle], work: Work, strip: Ints, criterion: Criterion, search: RouteSearch
    ) -> None:
        kinds = {vehicle.alike(): vehicle for vehicle in vehicles}
        able = np.any([possible(vehicle, work) for vehicle in kinds.values()], axis=0)
        self._able, self._vehicles = np.flatnonzero(able), vehicles
        self._search, self._rng = search, np.random.default_rng(search.seed)
        self._kicks, self._begun = 0, time.perf_counter()
        self._fleet = _numbers(vehicles, work, self._able, strip[self._able], criterion)
        self._strips = len(np.unique(strip[self._able]))

    def tours(self) -> tuple[list[Tour], bool]:
        """Return a tour of nodes for each vehicle, and whether the search was cancelled."""
        v = len(self._vehicles)
        if not self._strips:
            return [()] * v, self._cancelled
        kicks = int((_QUICK if self._search.quick else 1.0) * (_KICKS[0] + _KICKS[1] * self._strips))
        extra = sum(min(vehicle.most_sorties, self._strips) - 1 for vehicle in self._vehicles)
        swaps = min(extra, max(0, self._least_sorties() - v))
        while True:
            best = self._begun_with(swaps, int(_QUICK * kicks))
            rows = [row for tour in best.tours for row in tour]
            left = self._strips - sum(map(len, rows))
            if not left or swaps == extra or self._over():
                break
            swaps = min(extra, swaps + 1 + left * len(rows) // (2 * max(self._strips - left, 1)))
        others = [self._begun_with(swaps, int(_QUICK * kicks)) for _ in range(_STARTS - 1)]
        best = min(best, *others, key=lambda one: one.value)
        self._go_on(best, kicks)
        return [tuple(tuple(self._able[list(row)].tolist()) for row in tour) for tour in best.tours], self._cancelled

    def _begun_with(self, swaps: int, kicks: int) -> StripSearch:
        """Return a search for routes with so many swaps at most."""
        rooms = [min(vehicle.most_sorties, swaps + 1) for vehicle in self._vehicles]
        fleet = self._fleet._replace(
            owner=np.repeat(np.arange(len(rooms) + 1), [*rooms, 1]),
            swaps=swaps,
            simple=self._fleet.simple and not swaps,
        )
        search = StripSearch(fleet, self._rng)
        self._go_on(search, kicks)
        return search

    def _go_on(self, search: StripSearch, kicks: int) -> None:
        step = max(_AT_ONCE // self._strips, 1)
        search.run(0)
        for at in range(0, kicks, step):
            if self._over():
                break
            search.run(min(step, kicks - at))
            self._kicks += min(step, kicks - at)

    def _least_sorties(self) -> int:
        """Return how many sorties the batteries need at least."""
        partner, n = self._fleet.partner, len(self._fleet.partner)
        least = self._fleet.joules[:, : n + 2, :n].min(axis=(0, 1))
        each = np.minimum(least, least[partner])[np.arange(n) <= partner]
        return math.ceil(float(each.sum()) / float(self._fleet.limits[:, 1].max()))

    @property
    def _cancelled(self) -> bool:
        return interrupted() or is_cancelled(self._search.stop)

    def _over(self) -> bool:
        progress = Progress(iterations=self._kicks, seconds=time.perf_counter() - self._begun)
        return interrupted() or (self._search.stop is not None and self._search.stop.met(progress) is not None)


def _numbers(vehicles: Sequence[TourVehicle], work: Work, able: Ints, strip: Ints, criterion: Criterion) -> StripFleet:
    """Return the numbers of a search among the nodes that are able to be flown, with one row for each vehicle."""
    kinds, timed, n = {vehicle.alike(): vehicle for vehicle in vehicles}, criterion == "min-max", len(able)
    places, free = np.append(able, (work.targets, work.targets + 1)), np.zeros(work.targets)
    cost, joules, seconds = np.full((3, len(kinds), n + 3, n + 3), np.inf)
    for k, v in enumerate(kinds.values()):
        may = np.append(v.allowed, (True, True))
        sound = np.isfinite(v.price) & np.isfinite(v.seconds) & may[:, None] & may
        priced = (v.seconds, work.stay) if timed else (v.price, free)
        matrices = (cost, *priced), (joules, v.joules, v.visit_joules), (seconds, v.seconds, free)
        for to, legs, there in matrices:
            full = np.where(sound, legs + np.append(there, (0.0, 0.0)), np.inf)
            to[k, :-1, :-1], to[k, :, -1] = full[np.ix_(places, places)], 0.0
    limits = np.array([(v.swap, v.usable, v.capacity, v.waiting) for v in vehicles])
    left = 4.0 * (float(cost[np.isfinite(cost)].max()) + float(limits[:, 0].max())) + 1.0
    no_way = 10.0 * (n + 1) * left
    order = np.argsort(strip, kind="stable")
    pairs, partner = order[:-1][np.diff(strip[order]) == 0], np.arange(n)
    others = order[1:][np.diff(strip[order]) == 0]
    partner[pairs], partner[others] = others, pairs
    return StripFleet(
        cost=np.minimum(cost, no_way),
        joules=np.where(np.isfinite(joules), joules, no_way),
        seconds=np.minimum(seconds, no_way),
        kind=np.array([list(kinds).index(v.alike()) for v in vehicles]),
        returns=np.array([v.returns for v in vehicles]),
        limits=limits,
        partner=partner,
        does=np.vstack([np.c_[work.stay, work.window, work.demand][able], np.tile((0.0, 0.0, math.inf, 0.0), (3, 1))]),
        owner=np.arange(len(vehicles) + 1),
        squares=_SQUARES if timed else 0,
        swaps=0,
        simple=not (work.windows or np.isfinite(limits[:, 1:3]).any()),
        left=left,
        broken=no_way,
    )
