"""Tours that keep a given order of targets: it is cut into sorties, and into stretches for UAVs (Prins 2004).

Source: C. Prins, A simple and effective evolutionary algorithm for the vehicle routing problem, Computers & Operations
Research 31(12), 1985-2002, whose `split` this is, with batteries, swaps and windows.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Ints
from skyverse.mission.routing import SortieLegs, Timed, Totals, Tour, TourVehicle, Work, carried, timed


class _Label(NamedTuple):
    """The beginning of tours: unvisited targets, swaps, price; when the UAV is ready, and its sorties so far."""

    unvisited: int
    swaps: int
    price: float
    ready: float
    sorties: int
    before: "_Label | None"
    flown: tuple[int, tuple[int, ...]] | None

    def surpasses(self, other: "_Label") -> bool:
        return self[:3] <= other[:3] and self.ready <= other.ready and self.sorties <= other.sorties


class _Sortie(NamedTuple):
    """The sortie that visits the targets from one to before another of the order."""

    start: int
    end: int
    home: bool
    price: float
    early: float
    seconds: float
    late: float


def stretches(vehicles: Sequence[TourVehicle], work: Work, order: Sequence[int]) -> tuple[Tour, ...]:
    """Return tours, each a stretch of the order in sorties; the UAVs take them in turn.

    Few targets stay unvisited, then few batteries are swapped, then the sum of the prices is small; for one UAV that
    can visit all, no other cut is better.
    """
    sequence = np.array(order, dtype=np.intp)
    windowed, count = work.windows, len(order)
    fronts: list[list[_Label]] = [[] for _ in range(count + 1)]
    fronts[0].append(_Label(0, 0, 0.0, 0.0, 0, None, None))
    known: dict[object, list[list[_Sortie]]] = {}
    for i, vehicle in enumerate(vehicles):
        if (kind := vehicle.alike()) not in known:
            known[kind] = [list(_sorties(vehicle, work, sequence, later)) for later in (False, True)]
        starting = [[[s for s in held if s.start == at] for at in range(count)] for held in known[kind]]
        fronts = [_front([x._replace(ready=0.0, sorties=0) for x in front]) for front in fronts]
        for at in range(count):
            for label in _front(fronts[at]):
                fronts[at + 1].append(label._replace(unvisited=label.unvisited + 1))
                for s in starting[label.sorties > 0][at] if label.sorties < vehicle.most_sorties else ():
                    begin = label.ready + vehicle.swap if label.sorties else label.ready
                    if begin == math.inf or begin + s.seconds > s.late:
                        continue
                    ready = max(s.early, begin + s.seconds) if s.home else math.inf
                    fronts[s.end].append(
                        _Label(
                            label.unvisited,
                            label.swaps + (label.sorties > 0),
                            label.price + s.price,
                            ready if windowed or not s.home else 0.0,
                            label.sorties + 1,
                            label,
                            (i, tuple(sequence[s.start : s.end].tolist())),
                        )
                    )
    at_end: _Label | None = min(fronts[count], key=lambda x: x[:3])
    tours: list[Tour] = [()] * len(vehicles)
    while at_end is not None:
        if at_end.flown is not None:
            tours[at_end.flown[0]] = (at_end.flown[1], *tours[at_end.flown[0]])
        at_end = at_end.before
    return tuple(tours)


def kept_to_limits(
    vehicles: Sequence[TourVehicle], work: Work, tours: Sequence[Tour], cut: Callable[[TourVehicle, Tour], Tour]
) -> tuple[tuple[Tour, ...], tuple[Timed, ...]]:
    """Return tours and their times; one that breaks a limit, as by a solver's mistake, is cut anew in its own order.

    What has no room in it then is left out, and so is all of it if the cut breaks a limit, too.
    """
    kept, times = list(tours), [timed(vehicle, work, tour) for vehicle, tour in zip(vehicles, tours, strict=True)]
    for k in [k for k, time in enumerate(times) if time is None]:
        kept[k] = cut(vehicles[k], tours[k])
        times[k] = timed(vehicles[k], work, kept[k])
        if times[k] is None:
            kept[k], times[k] = (), timed(vehicles[k], work, ())
    return tuple(kept), tuple(time for time in times if time is not None)


def _front(labels: list[_Label]) -> list[_Label]:
    kept: list[_Label] = []
    for label in sorted(labels, key=lambda x: x[:5]):
        if not any(other.surpasses(label) for other in kept):
            kept.append(label)
    return kept


def _sorties(vehicle: TourVehicle, work: Work, sequence: Ints, later: bool) -> Iterator[_Sortie]:
    """Yield all sorties of one vehicle, the shorter ones first, that begin at home if they are `later` ones."""
    legs = SortieLegs(vehicle, work)
    start, totals = np.arange(len(sequence)), legs.begin(len(sequence))
    last = np.full(len(sequence), legs.home if later else legs.home - 1)
    for length in range(len(sequence)):
        inside = start + length < len(sequence)
        start, last, totals = start[inside], last[inside], Totals(*(x[inside] for x in totals))
        place = sequence[start + length]
        totals, sound = legs.extend(totals, last, place)
        light = [carried(work, sequence[at : at + length + 1].tolist()) <= vehicle.capacity for at in start]
        sound &= vehicle.allowed[place] & np.array(light, dtype=bool)
        start, last, totals = start[sound], place[sound], Totals(*(x[sound] for x in totals))
        home, safe = legs.extend(totals, last, np.full_like(last, legs.home))
        for ended, held, homewards in ((home, safe, True), (totals, np.ones_like(safe), False)):
            if not homewards and vehicle.returns:
                continue
            for k in np.flatnonzero(held):
                values = (float(x[k]) for x in (ended.price, ended.early, ended.seconds, ended.late))
                yield _Sortie(int(start[k]), int(start[k]) + length + 1, homewards, *values)
