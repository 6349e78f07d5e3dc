"""Routes by looking at every order, every cut into sorties, and every way to share targets; plain loops, for few."""

import itertools
import math

import numpy as np

from skyverse.mission.routing import TourVehicle, Work


def flown(vehicle: TourVehicle, work: Work, tour) -> tuple[float, list[float], list[float]] | None:
    """Return the price, the starts and the finishes of a tour flown leg by leg, or None if it breaks a limit."""
    n, now, price = work.targets, 0.0, 0.0
    starts, finishes = [], []
    for k, sortie in enumerate(tour):
        places = [n + 1 if k else n, *sortie]
        if vehicle.returns or k + 1 < len(tour):
            places.append(n + 1)
        legs = list(itertools.pairwise(places))
        if any(vehicle.price[leg] == math.inf or vehicle.seconds[leg] == math.inf for leg in legs):
            return None
        if sum(work.demand[j] for j in sortie) > vehicle.capacity + 1e-9:
            return None
        ready, clock, begun = now, now, {}
        for a, b in legs:  # as early as possible
            clock += vehicle.seconds[a, b]
            if b < n:
                clock = max(clock, work.window[b, 0])
                if clock > work.window[b, 1] + 1e-9:
                    return None
                begun[b] = clock
                clock += work.stay[b]
        late = math.inf  # then as late as delays nothing at the end
        finish = clock
        last_place = places[-1]
        late = finish if last_place >= n else begun[last_place]
        for a, b in reversed(legs):
            late -= vehicle.seconds[a, b]
            if a < n:
                late = min(late - work.stay[a], work.window[a, 1])
        depart = max(ready, late)
        moving = sum(vehicle.seconds[leg] for leg in legs) + sum(work.stay[j] for j in sortie)
        joules = sum(vehicle.joules[leg] for leg in legs) + sum(vehicle.visit_joules[j] for j in sortie)
        joules += vehicle.waiting * (finish - depart - moving)
        if joules > vehicle.usable + 1e-9:
            return None
        price += sum(vehicle.price[leg] for leg in legs)
        starts.append(depart)
        finishes.append(finish)
        now = finish + vehicle.swap
    return price, starts, finishes


def cuts(order):
    """Yield every cut of an order into sorties that are not empty."""
    for at in itertools.product((False, True), repeat=max(len(order) - 1, 0)):
        tour, sortie = [], [order[0]]
        for cut, j in zip(at, order[1:], strict=True):
            if cut:
                tour.append(tuple(sortie))
                sortie = []
            sortie.append(j)
        yield (*tour, tuple(sortie))


def best(vehicles, work: Work, criterion: str, order=None) -> tuple[float, ...]:
    """Return how many stay unvisited, the swaps, (the largest finish,) and the price of the best routes."""
    n = work.targets
    of_vehicle = []
    for vehicle in vehicles:
        table = {frozenset(): [(0, 0.0, 0.0)]}
        may = [j for j in (range(n) if order is None else order) if vehicle.allowed[j]]
        for size in range(1, len(may) + 1):
            for held in itertools.combinations(may, size):
                found = set()
                for sequence in itertools.permutations(held) if order is None else [held]:
                    for tour in cuts(sequence):
                        if len(tour) <= vehicle.most_sorties and (one := flown(vehicle, work, tour)):
                            found.add((len(tour) - 1, one[0], one[2][-1]))
                if found:
                    table[frozenset(held)] = list(found)
        of_vehicle.append(table)
    answers = {frozenset(): {(0, 0.0, 0.0)}}
    for table in of_vehicle:
        new: dict = {}
        for held, values in answers.items():
            for more, others in table.items():
                if not held & more:
                    found = new.setdefault(held | more, set())
                    found.update(
                        (a + x, max(c, z), b + y)
                        for a, b, c in ((v[0], v[2], v[1]) for v in values)
                        for x, y, z in others
                    )
        answers = {held: _undominated(found) for held, found in new.items()}
    ranked = [
        (n - len(held), swaps, *((finish, price) if criterion == "min-max" else (price,)))
        for held, values in answers.items()
        for swaps, finish, price in values
    ]
    return min(ranked)


def _undominated(found):
    return {a for a in found if not any(b != a and all(x <= y for x, y in zip(b, a, strict=True)) for b in found)}


def random_case(rng: np.random.Generator, n: int, fleet: int, alike: bool = False):
    """Return vehicles and work on a random map, with whatever limits chance gives."""
    square = rng.random((n + 2, 2)) * 100.0
    if rng.random() < 0.3:
        square[rng.integers(n + 2)] = square[rng.integers(n + 2)]
    windows = np.tile((0.0, math.inf), (n, 1))
    if rng.random() < 0.5:
        some = rng.random(n) < 0.6
        opens = rng.random(n) * 200
        windows[some] = np.stack([opens, opens + rng.random(n) * 150], axis=1)[some]
    work = Work(
        stay=np.round(rng.random(n) * 10) * (rng.random() < 0.6),
        window=windows,
        demand=np.round(rng.random(n) * 5) * (rng.random() < 0.5),
    )

    def vehicle() -> TourVehicle:
        places = square.copy()
        if rng.random() < 0.7:
            places[n + 1] = places[n] = rng.random(2) * 100
        metres = np.linalg.norm(places[:, None] - places[None], axis=2)
        seconds = metres / rng.uniform(0.5, 2.0) * (1 + 0.3 * rng.random(metres.shape) * (rng.random() < 0.5))
        price = seconds if rng.random() < 0.5 else metres.copy()
        if rng.random() < 0.3:
            price = np.where(rng.random(metres.shape) < 0.15, np.inf, price)
        battery = rng.random() < 0.5
        return TourVehicle(
            price=price,
            seconds=seconds,
            joules=(metres if rng.random() < 0.5 else metres * (1 + rng.random(metres.shape))) * battery,
            visit_joules=work.stay * battery,
            usable=rng.uniform(100, 350) if battery else math.inf,
            most_sorties=int(rng.integers(1, 4)),
            swap=rng.choice([0.0, 20.0]),
            capacity=rng.uniform(2, 15) if rng.random() < 0.5 else math.inf,
            allowed=rng.random(n) < rng.choice([0.7, 1.0]),
            returns=bool(rng.random() < 0.6),
            waiting=rng.choice([0.0, 1.0]) * battery,
        )

    one = vehicle()
    return [one] * fleet if alike else [one, *(vehicle() for _ in range(fleet - 1))], work
