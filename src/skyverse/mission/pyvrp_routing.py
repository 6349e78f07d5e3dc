"""Good routes to many targets, by PyVRP's iterated local search (Wouda, Lan and Kool 2024, INFORMS J. on Computing 36).

Each sortie is a vehicle of PyVRP's. Those beyond the first of a UAV have a fixed cost that no detour outweighs, and a
target that is left out costs more than all of them. The sorties are then given to UAVs; only there the times of UAVs
that fly several are looked after.
"""

import math
import time
import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from skyverse._typing import Floats, Indices, Ints
from skyverse.extras import require_libraries
from skyverse.interrupt import interrupted
from skyverse.mission.assignment import Criterion
from skyverse.mission.routing import RouteSearch, Tour, TourVehicle, Work, possible, timed
from skyverse.numerics.tolerances import WHOLE_UNITS
from skyverse.stop import Progress, is_cancelled

if TYPE_CHECKING:
    from pyvrp import ProblemData, Solution
    from pyvrp.stop import StoppingCriterion

_PATIENCE = 200, 8  # iterations without a better solution, and how many more for each target
_QUICK = 0.1  # the share of that which a quick search takes
_EFFORT = 10**8  # the most iterations, times the square of the targets
_DOUBTS = 150  # iterations after which a largest finish counts as out of reach
_LEVEL = 0.005  # how near the largest finish comes to one that is out of reach, as a share
_UNITS = 10**7  # in which PyVRP counts: of the prices of flying to each target alone, of a battery, of a capacity
_LATEST = 1 << 43


def pyvrp_tours(
    vehicles: Sequence[TourVehicle], work: Work, criterion: Criterion, search: RouteSearch
) -> tuple[tuple[Tour, ...], bool]:
    """Return a tour for each vehicle, and whether the search was cancelled; see `route`."""
    require_libraries(f"a route to more than ten places, here {work.targets},", "pyvrp", field="targets")
    clock = _Clock(search, work.targets)
    able = [possible(vehicle, work) for vehicle in {v.alike(): v for v in vehicles}.values()]
    held, times = np.flatnonzero(np.any(able, axis=0)), criterion == "min-max" or work.windows
    if not len(held):
        return ((),) * len(vehicles), clock.cancelled
    for required in (True, False):  # that all must be visited makes a quicker search, which may find nothing
        model = _Model(vehicles, work, search, held, timed=times, required=required)
        begun = search.tours if required and _visits_once(search.tours or (), held) else None
        tours = model.fleet(model.solved(clock.rule(clock.patience), tours=begun), clock, whole=required)
        if clock.cancelled or sum(len(sortie) for tour in tours for sortie in tour) == len(held):
            break
    if criterion == "min-max" and max(map(len, tours)) == 1:
        tours = _levelled(vehicles, work, search, tours, clock)
    return tours, clock.cancelled


def _visits_once(tours: Sequence[Tour], held: Indices) -> bool:
    """Tell whether tours of one sortie each visit all targets."""
    return sorted(chain(*chain(*tours))) == held.tolist() and max(map(len, tours), default=0) == 1


def _levelled(
    vehicles: Sequence[TourVehicle], work: Work, search: RouteSearch, tours: tuple[Tour, ...], clock: "_Clock"
) -> tuple[Tour, ...]:
    """Return tours with a smaller largest finish, found by bisection, and the least sum of prices under that."""
    visited = np.array(sorted(chain(*chain(*tours))))
    vehicles = [replace(vehicle, most_sorties=1) for vehicle in vehicles]
    model = _Model(vehicles, work, search, visited, timed=True, required=True)

    def finish(found: tuple[Tour, ...]) -> float:
        times = [timed(vehicle, work, tour) for vehicle, tour in zip(vehicles, found, strict=True)]
        whole = len(visited) == sum(len(sortie) for tour in found for sortie in tour) and None not in times
        return max(t.finishes[-1] for t in times if t and t.finishes) if whole else math.inf

    def within(cap: float, rule: "StoppingCriterion") -> tuple[tuple[Tour, ...], float]:
        found = model.fleet(model.solved(rule, cap, tours), clock, whole=True)
        return found, finish(found)

    low, high = 0.0, finish(tours)
    while high - low > _LEVEL * high and not clock.over():
        middle = (low + high) / 2
        found, level = within(middle, clock.rule(_DOUBTS, first=True))
        if level < high:
            tours, high = found, level
        else:
            low = middle
    found, level = within(high, clock.rule(clock.patience))
    return found if level <= high else tours


class _Clock:
    """Counts the iterations of all searches together, and knows when to end them."""

    def __init__(self, search: RouteSearch, targets: int) -> None:
        self._stop, self._begun, self._iterations = search.stop, time.perf_counter(), 0
        share = _QUICK if search.quick else 1.0
        self.patience = int(share * (_PATIENCE[0] + _PATIENCE[1] * targets))
        self._most = max(int(share * _EFFORT) // targets**2, 100)

    @property
    def cancelled(self) -> bool:
        return interrupted() or is_cancelled(self._stop)

    def over(self) -> bool:
        progress = Progress(iterations=self._iterations, seconds=time.perf_counter() - self._begun)
        return interrupted() or (self._stop is not None and self._stop.met(progress) is not None)

    def rule(self, patience: int, first: bool = False) -> "StoppingCriterion":
        """Return a rule of PyVRP's: it ends a search after so long without a better solution, or at the first one."""
        best, since, count = math.inf, 0, 0

        def met(best_cost: float) -> bool:
            nonlocal best, since, count
            best, since, count = min(best, best_cost), since + 1 if best_cost >= best else 0, count + 1
            self._iterations += 1
            sound = first and best_cost < np.iinfo(np.int64).max
            return sound or since >= patience or count > self._most or self.over()

        return met


class _Model:
    """What PyVRP is told of vehicles and targets, and how its answers become tours.

    PyVRP limits distances and prices distances and durations. With a battery, joules are its distances and durations
    are priced: the prices themselves where no time counts, otherwise seconds, which then stand for the prices.
    """

    def __init__(
        self,
        vehicles: Sequence[TourVehicle],
        work: Work,
        search: RouteSearch,
        held: Ints,
        *,
        timed: bool,
        required: bool,
    ) -> None:
        kinds: dict[object, list[int]] = {}
        for i, vehicle in enumerate(vehicles):
            kinds.setdefault(vehicle.alike(), []).append(i)
        self._vehicles, self._work, self._search, self._held = vehicles, work, search, held
        self._kinds = list(kinds.values())
        self._timed = timed
        self._rank = np.arange(work.targets) if search.order is None else np.argsort(search.order)
        firsts = [vehicles[members[0]] for members in self._kinds]
        prices, seconds = (
            sum(min(_alone(matrix, j, v) for v, matrix in zip(firsts, matrices, strict=True)) for j in held)
            for matrices in ([v.price for v in firsts], [v.seconds for v in firsts])
        )
        self._per_price, self._per_second = _scale(prices), _scale(seconds)
        extra = sum(min((v.most_sorties - 1) * len(k), len(held)) for v, k in zip(firsts, self._kinds, strict=True))
        self._prize = 0 if required else _UNITS * (extra + 2)
        self._data = self._problem(firsts)

    def _problem(self, firsts: Sequence[TourVehicle]) -> "ProblemData":
        from pyvrp import Client, Depot, Location, ProblemData, VehicleType

        n, work, held = len(self._held), self._work, self._held
        capacity = max((v.capacity for v in firsts if v.capacity < math.inf), default=math.inf)
        per_kilogram = _scale(capacity) if work.demand.any() and capacity < math.inf else 0.0
        clients = [
            Client(
                place,
                [_up(work.demand[j] * per_kilogram)] if per_kilogram else [],
                service_duration=_up(work.stay[j] * self._per_second) if self._timed else 0,
                tw_early=_up(work.window[j, 0] * self._per_second),
                tw_late=_down(work.window[j, 1] * self._per_second),
                prize=self._prize,
                required=self._prize == 0,
            )
            for place, j in enumerate(held)
        ]
        distances: list[Any] = []
        durations: list[Any] = []
        types = []
        self._roles: list[tuple[int, bool]] = []  # for each type which kind it is, and whether it is a first sortie
        for k, (v, members) in enumerate(zip(firsts, self._kinds, strict=True)):
            battery = v.usable < math.inf
            price, seconds = self._units(v, v.price * self._per_price), self._units(v, v.seconds * self._per_second)
            per_joule = _scale(v.usable)
            stays = v.joules + np.append(v.visit_joules, (0.0, 0.0))
            distances.append(self._units(v, stays * per_joule) if battery else price)
            durations.append(seconds if self._timed else price if battery else np.zeros_like(price))
            common: dict[str, Any] = {
                "capacity": [_down(v.capacity * per_kilogram)] if per_kilogram else [],
                "max_distance": _down(v.usable * per_joule),
                "unit_distance_cost": int(not battery),
                "unit_duration_cost": int(battery),
                "profile": k,
            }
            types.append(
                VehicleType(num_available=len(members), start_depot=0, end_depot=1 if v.returns else 2, **common)
            )
            self._roles.append((k, True))
            if v.most_sorties > 1:
                count = min((v.most_sorties - 1) * len(members), n)
                types.append(VehicleType(num_available=count, start_depot=1, end_depot=1, fixed_cost=_UNITS, **common))
                self._roles.append((k, False))
        places = [Location(0, 0)] * (n + 3)
        return ProblemData(places, clients, [Depot(n), Depot(n + 1), Depot(n + 2)], types, distances, durations)

    def _units(self, vehicle: TourVehicle, matrix: Floats) -> Ints:
        """Return whole numbers between the targets, the begin, home, and nowhere, where open tours end."""
        n, held = len(self._held), self._held
        rows = np.append(held, (self._work.targets, self._work.targets + 1))
        may = np.append(vehicle.allowed[held], (True, True))
        ways = np.isfinite(vehicle.price) & np.isfinite(vehicle.seconds)
        ways = ways[np.ix_(rows, rows)] & may[:, None] & may
        ways[:n, :n] &= self._rank[held][:, None] < self._rank[held] if self._search.order is not None else True
        closed = 4 * max(self._prize, _UNITS)
        units = np.zeros((n + 3, n + 3), dtype=np.int64)
        units[:-1, :-1] = np.where(ways, np.ceil(np.where(ways, matrix[np.ix_(rows, rows)], 0.0) - WHOLE_UNITS), closed)
        np.fill_diagonal(units, 0)
        return units

    def solved(
        self, rule: "StoppingCriterion", cap: float = math.inf, tours: Sequence[Tour] | None = None
    ) -> "Solution":
        """Return PyVRP's best solution with tours that finish by `cap`, sought from the given tours on."""
        from pyvrp import Route, Solution, solve
        from pyvrp.exceptions import PenaltyBoundWarning

        late = _down(cap * self._per_second)
        types = [kind.replace(tw_late=late, start_late=late) for kind in self._data.vehicle_types()]
        data, start = self._data.replace(vehicle_types=types), None
        if tours is not None:
            place = {int(j): at for at, j in enumerate(self._held)}
            roles = {i: self._roles.index((k, True)) for k, members in enumerate(self._kinds) for i in members}
            routes = [Route(data, [place[j] for j in tour[0]], roles[i]) for i, tour in enumerate(tours) if tour]
            start = Solution(data, routes)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PenaltyBoundWarning)
            return solve(data, rule, self._search.seed, collect_stats=False, initial_solution=start).best

    def fleet(self, solution: "Solution", clock: _Clock, whole: bool = False) -> tuple[Tour, ...]:
        """Return the sorties of a solution as tours of the UAVs, without what breaks a limit unless it is `whole`."""
        tours: list[Tour] = [()] * len(self._vehicles)
        left = {int(j) for j in self._held}
        routes = [(self._roles[route.vehicle_type()], route) for route in solution.routes()]
        for (kind, _), route in sorted(routes, key=lambda x: (not x[0][1], x[1].start_time(), -x[1].duration())):
            sortie = tuple(int(self._held[x.idx]) for x in route if x.is_client())
            if self._accept(tours, self._with_sortie(tours, sortie, self._kinds[kind])):
                left.difference_update(sortie)
        for j in sorted(left) if not whole else ():
            if clock.over():
                break
            self._accept(tours, chain(self._with_target(tours, j), self._with_sortie(tours, (j,))))
        return tuple(tours)

    def _with_sortie(
        self, tours: Sequence[Tour], sortie: tuple[int, ...], members: Iterable[int] | None = None
    ) -> Iterator[tuple[int, Tour]]:
        """Yield UAVs with tours that have one sortie more."""
        for i in range(len(tours)) if members is None else members:
            for at in range(len(tours[i]) + 1):
                yield i, (*tours[i][:at], sortie, *tours[i][at:])

    def _with_target(self, tours: Sequence[Tour], j: int) -> Iterator[tuple[int, Tour]]:
        """Yield UAVs with tours that have one target more in a sortie."""
        for i, tour in enumerate(tours):
            for k, sortie in enumerate(tour):
                for at in range(len(sortie) + 1):
                    yield i, (*tour[:k], (*sortie[:at], j, *sortie[at:]), *tour[k + 1 :])

    def _accept(self, tours: list[Tour], options: Iterable[tuple[int, Tour]]) -> bool:
        """Take the sound option with the fewest swaps, then the least price, then the earliest finish, if any is."""
        best: tuple[float, ...] = (math.inf,)
        chosen = None
        for i, tour in options:
            ranks = [self._rank[j] for sortie in tour for j in sortie]
            after = timed(self._vehicles[i], self._work, tour)
            before = timed(self._vehicles[i], self._work, tours[i])
            if after is None or before is None or (self._search.order is not None and ranks != sorted(ranks)):
                continue
            swaps = max(len(tour) - 1, 0) - max(len(tours[i]) - 1, 0)
            value = (swaps, round((after.price - before.price) * self._per_price), after.finishes[-1])
            if value < best:
                best, chosen = value, (i, tour)
        if chosen is not None:
            tours[chosen[0]] = chosen[1]
        return chosen is not None


def _scale(largest: float) -> float:
    """Return a power of ten that makes a number as large as `_UNITS` allow, so that short decimals stay exact."""
    return 10.0 ** math.floor(math.log10(_UNITS / largest)) if 0 < largest < math.inf else 1.0


def _alone(matrix: Floats, j: int, vehicle: TourVehicle) -> float:
    """Return what it takes to fly to one target only; infinite if the vehicle may not."""
    begin, home = len(matrix) - 2, len(matrix) - 1
    there = matrix[begin, j] + (matrix[j, home] if vehicle.returns else 0.0)
    return float(there) if vehicle.allowed[j] else math.inf


def _up(x: float) -> int:
    return min(math.ceil(x - WHOLE_UNITS), _LATEST)


def _down(x: float) -> int:
    return _LATEST if x > _LATEST else math.floor(x + WHOLE_UNITS)
