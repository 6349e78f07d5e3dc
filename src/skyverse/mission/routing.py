"""The pure routing problem: numbers of vehicles and targets in, who visits what in which order out."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Literal, NamedTuple

import numpy as np

from skyverse._typing import Bools, Floats, Indices
from skyverse.errors import InputError, shown
from skyverse.numerics.tolerances import LENGTH_ROUNDING
from skyverse.stop import Stop

Tour = tuple[tuple[int, ...], ...]
Reason = Literal["nobody may", "no way", "capacity", "window", "battery", "left over"]
Bound = Literal["exact", "assignment"]


@dataclass(frozen=True, eq=False)
class TourVehicle:
    """The numbers of one UAV among n targets.

    Places 0 to n - 1 are the targets, n is where it begins, and n + 1 is its home. Every sortie but the last ends at
    home, and every sortie but the first begins there.

    Attributes
    ----------
    price
        (n + 2, n + 2) what is minimised; infinite where there is no way.
    seconds
        (n + 2, n + 2) of the flights.
    joules
        (n + 2, n + 2) of the flights.
    visit_joules
        (n,) of the stays.
    usable
        Joules that one battery gives; infinite without a battery.
    most_sorties
        How many batteries there are.
    swap
        Seconds between two sorties.
    capacity
        Kilograms that one sortie carries.
    allowed
        (n,) which targets it may visit.
    returns
        Whether its last sortie ends at home; otherwise it ends at its last target. Without targets it stays.
    waiting
        Watts while it waits for a window in the air; it waits on the ground as long as that delays nothing.
    """

    price: Floats
    seconds: Floats
    joules: Floats
    visit_joules: Floats
    usable: float
    most_sorties: int
    swap: float
    capacity: float
    allowed: Bools
    returns: bool
    waiting: float = 0.0

    def __post_init__(self) -> None:
        n = len(self.allowed)
        for name, shape in {
            "price": (n + 2,) * 2,
            "seconds": (n + 2,) * 2,
            "joules": (n + 2,) * 2,
            "visit_joules": (n,),
        }.items():
            _require_numbers(getattr(self, name), shape, name)
        for name in ("usable", "swap", "capacity", "waiting", "most_sorties"):
            if not getattr(self, name) >= (name == "most_sorties"):
                raise InputError(f"{name}: expected a number from 0 on, found {shown(getattr(self, name))}", field=name)

    def alike(self) -> tuple[object, ...]:
        """Return what two vehicles have in common if and only if all their numbers are equal."""
        own = (getattr(self, f.name) for f in fields(self))
        return tuple(x.tobytes() if isinstance(x, np.ndarray) else x for x in own)


@dataclass(frozen=True, eq=False)
class Work:
    """What is to be done at n targets.

    Attributes
    ----------
    stay
        (n,) seconds.
    window
        (n, 2) first and last second of the mission at which a stay may begin.
    demand
        (n,) kilograms.
    """

    stay: Floats
    window: Floats
    demand: Floats

    def __post_init__(self) -> None:
        n = len(self.stay)
        for name, shape in {"stay": (n,), "window": (n, 2), "demand": (n,)}.items():
            _require_numbers(getattr(self, name), shape, name)
        if np.any(self.window[:, 0] > self.window[:, 1]):
            raise InputError("window: expected windows that open before they close", field="window")

    @property
    def targets(self) -> int:
        """How many targets there are."""
        return len(self.stay)

    @property
    def windows(self) -> bool:
        """Whether any target has a window."""
        return bool(np.any(self.window != (0.0, math.inf)))


@dataclass(frozen=True, eq=False)
class Routes:
    """Who visits what, in which order, and when.

    Attributes
    ----------
    tours
        For each vehicle its sorties, each a tuple of targets.
    starts, finishes
        For each vehicle the seconds at which its sorties begin and end.
    unvisited
        Why each target that nobody visits is left out.
    price
        The sum over all vehicles.
    lower_bound
        What no routes with the same targets go below: of the price for min-sum, of the largest finish for min-max; 0
        where none was sought.
    bound
        Where the lower bound comes from.
    optimal
        Whether there are proven to be no better routes.
    interrupted
        Whether the search was cancelled, so that these are the best routes so far.
    """

    tours: tuple[Tour, ...]
    starts: tuple[tuple[float, ...], ...]
    finishes: tuple[tuple[float, ...], ...]
    unvisited: dict[int, Reason] = field(default_factory=dict)
    price: float = 0.0
    lower_bound: float = 0.0
    bound: Bound = "exact"
    optimal: bool = True
    interrupted: bool = False

    @property
    def swaps(self) -> int:
        """How many sorties there are beyond the first of each vehicle."""
        return sum(max(len(tour) - 1, 0) for tour in self.tours)

    @property
    def finish(self) -> float:
        """The seconds at which the last vehicle is done."""
        return max((finish for of_vehicle in self.finishes for finish in of_vehicle), default=0.0)


class RouteSearch(NamedTuple):
    """How routes are sought.

    Attributes
    ----------
    stop
        When to end, with more than ten targets. A search for ten or fewer is exact, and takes a second or two.
    seed
        Of the search.
    order
        All targets in an order that every vehicle keeps in its tour; ``None`` leaves it free.
    quick
        Whether the search takes a tenth of its time.
    tours
        Tours from which it begins, if it is given any that visit all targets.
    """

    stop: Stop | None = None
    seed: int = 0
    order: Sequence[int] | None = None
    quick: bool = False
    tours: Sequence[Tour] | None = None


class Totals(NamedTuple):
    """What sorties, or their beginnings, take: an array with one entry for each of them in every field.

    A sortie that may begin at `t` ends at ``max(early, t + seconds)``, and exists if that is at most `late`.
    """

    price: Floats
    joules: Floats
    early: Floats
    seconds: Floats
    late: Floats


class SortieLegs:
    """The legs of one vehicle, with what is done at their ends."""

    def __init__(self, vehicle: TourVehicle, work: Work) -> None:
        n = work.targets
        if len(vehicle.allowed) != n:
            raise InputError(f"expected vehicles of {n} targets, found one of {len(vehicle.allowed)}", field="vehicles")
        self.vehicle, self.home = vehicle, n + 1
        self._stay = np.append(work.stay, (0.0, 0.0))
        self._window = np.vstack([work.window, [(0.0, math.inf)] * 2])
        self._joules = vehicle.joules + np.append(vehicle.visit_joules, (0.0, 0.0))
        self._way = np.isfinite(vehicle.price) & np.isfinite(vehicle.seconds)

    def begin(self, count: int = 1) -> Totals:
        """Return the totals of so many sorties that have not begun."""
        return Totals(*(np.full(count, value) for value in (0.0, 0.0, 0.0, 0.0, math.inf)))

    def extend(self, totals: Totals, last: Indices, place: Indices) -> tuple[Totals, Bools]:
        """Return sorties one leg longer, and which of them keep to windows and battery.

        The arithmetic of segments is that of Vidal et al. (2013), Computers & Operations Research 40(1), 475-489.
        """
        seconds, stay = self.vehicle.seconds[last, place], self._stay[place]
        opens, closes = self._window[place].T
        arrival, latest = totals.early + seconds, totals.late + seconds
        wait = np.maximum(opens - latest, 0.0)
        joules = totals.joules + self._joules[last, place]
        if self.vehicle.waiting:
            joules = joules + self.vehicle.waiting * wait
        longer = Totals(
            totals.price + self.vehicle.price[last, place],
            joules,
            np.maximum(arrival, opens) + stay,
            totals.seconds + seconds + wait + stay,
            np.minimum(np.maximum(latest, opens), closes) + stay,
        )
        return longer, self._way[last, place] & (arrival <= closes) & (joules <= self.vehicle.usable)

    def follow(self, begin: int, places: Sequence[int]) -> Totals | None:
        """Return the totals of one sortie along the places, or ``None`` if it breaks a window or the battery."""
        totals, last = self.begin(), np.array([begin])
        for place in np.array(places, dtype=np.intp).reshape(-1, 1):
            totals, sound = self.extend(totals, last, place)
            if not sound[0]:
                return None
            last = place
        return totals


class Timed(NamedTuple):
    """A vehicle's tour with its price and times."""

    price: float
    starts: tuple[float, ...]
    finishes: tuple[float, ...]


def timed(vehicle: TourVehicle, work: Work, tour: Tour) -> Timed | None:
    """Return when the sorties of a tour begin and end, or ``None`` if it breaks a window, a battery or a capacity."""
    legs, now, price = SortieLegs(vehicle, work), 0.0, 0.0
    starts: list[float] = []
    finishes: list[float] = []
    if len(tour) > vehicle.most_sorties or any(not vehicle.allowed[list(sortie)].all() for sortie in tour):
        return None
    for k, sortie in enumerate(tour):
        ends = (legs.home,) if vehicle.returns or k + 1 < len(tour) else ()
        totals = legs.follow(legs.home if k else legs.home - 1, (*sortie, *ends))
        if totals is None or carried(work, sortie) > vehicle.capacity:
            return None
        early, seconds, late = (float(x[0]) for x in totals[2:])
        if now + seconds > late:
            return None
        starts.append(max(now, early - seconds))
        finishes.append(max(early, now + seconds))
        now, price = finishes[-1] + vehicle.swap, price + float(totals.price[0])
    return Timed(price, tuple(starts), tuple(finishes))


def carried(work: Work, sortie: Sequence[int]) -> float:
    """Return the kilograms of a sortie, rounded once, so that their order does not matter."""
    return math.fsum(work.demand[list(sortie)].tolist())


def why_unvisited(vehicles: Sequence[TourVehicle], work: Work, visited: Sequence[int]) -> dict[int, Reason]:
    """Return why each target that is not visited cannot be, told of the vehicle that comes nearest to it.

    A target that a vehicle could visit if there were no others is "left over".
    """
    order: tuple[Reason, ...] = ("nobody may", "no way", "capacity", "window", "battery", "left over")
    missing = sorted(set(range(work.targets)).difference(visited))
    if not missing:
        return {}
    level = np.zeros(work.targets, dtype=np.int64)
    for vehicle in {v.alike(): v for v in vehicles}.values():
        level = np.maximum(level, _obstacle(vehicle, work))
    return {j: order[level[j]] for j in missing}


def possible(vehicle: TourVehicle, work: Work) -> Bools:
    """Return which targets the vehicle could visit if there were no others, (n,); none is ruled out falsely."""
    return _obstacle(vehicle, work) == 5


def _obstacle(vehicle: TourVehicle, work: Work) -> np.ndarray:
    """Return for each target how many of the five reasons do not keep the vehicle away from it, (n,)."""
    n = work.targets
    way = np.isfinite(vehicle.price) & np.isfinite(vehicle.seconds)

    def nearest(matrix: Floats, back: bool = False) -> Floats:
        """Return the least sums from where a sortie may begin, or to where it may end, by Bellman and Ford."""
        legs = np.where(way, matrix, math.inf)
        legs, sums = legs.T if back else legs, np.full(n + 2, math.inf)
        sums[[n + 1] if back else [n, n + 1] if vehicle.most_sorties > 1 else [n]] = 0.0
        if back and not vehicle.returns:
            sums[:] = 0.0
        while np.any((nearer := np.minimum(sums, (sums[:, None] + legs).min(axis=0))) < sums):
            sums = nearer
        return sums[:n]

    seconds, back = nearest(vehicle.seconds), nearest(vehicle.seconds, back=True)
    joules = nearest(vehicle.joules) + nearest(vehicle.joules, back=True) + vehicle.visit_joules
    passed = (
        vehicle.allowed,
        np.isfinite(seconds) & np.isfinite(back),
        work.demand <= vehicle.capacity,
        seconds <= work.window[:, 1],
        joules * (1.0 - LENGTH_ROUNDING) <= vehicle.usable,  # the sums of a tour are rounded otherwise
    )
    return np.cumprod(passed, axis=0).sum(axis=0)


def _require_numbers(values: object, shape: tuple[int, ...], name: str) -> None:
    if not isinstance(values, np.ndarray) or values.shape != shape:
        raise InputError(f"{name}: expected an array of shape {shape}, found {shown(values)}", field=name)
    if not np.all(values >= 0):
        raise InputError(f"{name}: expected numbers from 0 on, found {values.min()}", field=name)
