"""Routes along strips: who flies which strips, in which order and direction, and in which sorties.

A strip is flown in one direction or the other. Each way of flying it is a target of its own here, with the flight
along the strip in every leg that leads there, and of the two exactly one is visited (a generalised routing problem;
Noon and Bean 1993, INFOR 31(1), 39-44).
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats, Ints
from skyverse.errors import InputError, shown
from skyverse.mission.assignment import Criterion
from skyverse.mission.exact_routing import exact_tours
from skyverse.mission.fleet_search import FleetSearch
from skyverse.mission.given_order import kept_to_limits, stretches
from skyverse.mission.routing import Reason, Routes, RouteSearch, Tour, TourVehicle, Work, timed, why_unvisited
from skyverse.numerics.tolerances import LENGTH_ROUNDING

MOST_EXACT = 8
"""How many strips and targets are routed exactly."""
_SEARCH = RouteSearch()


def route_strips(
    vehicles: Sequence[TourVehicle],
    strips: ArrayLike,
    work: Work,
    criterion: Criterion = "min-sum",
    search: RouteSearch = _SEARCH,
) -> Routes:
    """Decide who flies which strips in which order and direction.

    As few strips as possible stay unflown; among such routes the batteries are swapped as seldom as possible; among
    those the price is the least. With up to eight strips and targets the routes are the best there are.

    Parameters
    ----------
    vehicles, work
        The UAVs, and what is to be done at the places. The legs between the ends of a strip are flights along it, and
        infinite in a direction in which it must not be flown.
    strips
        (m, 2) the places at the ends of each strip, without windows and of no other one; twice the same for a target.
        Other places are not visited.
    criterion
        ``"min-sum"`` minimises the sum of the prices; ``"min-max"`` the time at which the last vehicle is done.
    search
        How they are sought; its `order` must be free.

    Returns
    -------
    Routes
        With sorties of places: both ends of each strip in the order in which they are passed, one place of a target.

    Raises
    ------
    InputError
        If they are to be flown in an order that is given.
    """
    if search.order is not None:
        raise InputError(f"expected strips in free order, found {shown(search.order)}", field="order")
    ends = np.array(strips, dtype=np.int64).reshape(-1, 2)
    nodes = StripNodes.along(ends)
    whole, seen = [nodes.vehicle(v, work) for v in vehicles], nodes.work(work)
    tours: list[Tour] = [()] * len(vehicles)
    optimal, interrupted = len(ends) <= MOST_EXACT, False
    for share in (1.0, 1.0 - LENGTH_ROUNDING) if len(ends) and vehicles else ():
        fleet = [replace(v, usable=v.usable * share) for v in whole]  # sums of legs may be rounded otherwise
        if optimal:
            found = list(exact_tours(fleet, seen, criterion, None, groups=nodes.strip.tolist()))
        else:
            found, interrupted = FleetSearch(fleet, seen, nodes.strip, criterion, search).tours()
        tours = [tuple(nodes.passed(sortie) for sortie in tour) for tour in found]
        if all(timed(v, work, tour) is not None for v, tour in zip(vehicles, tours, strict=True)):
            break
    room = 1.0 - LENGTH_ROUNDING
    kept, times = kept_to_limits(
        vehicles, work, tours, lambda v, tour: nodes.cut(replace(v, usable=v.usable * room), work, tour)
    )
    starts, finishes = tuple(t.starts for t in times), tuple(t.finishes for t in times)
    routes = Routes(
        kept,
        starts,
        finishes,
        nodes.why_unvisited(vehicles, work, kept),
        math.fsum(t.price for t in times),
        optimal=optimal and kept == tuple(tours),
        interrupted=interrupted,
    )
    exact = routes.price if criterion == "min-sum" else routes.finish
    return replace(routes, lower_bound=exact if routes.optimal else 0.0)


class StripNodes(NamedTuple):
    """The ways of flying strips: where each enters, where it leaves, and of which strip it is one, (n,)."""

    enter: Ints
    leave: Ints
    strip: Ints

    @classmethod
    def along(cls, ends: Ints) -> "StripNodes":
        """Return both ways of flying each strip, and one of visiting each target."""
        both = np.flatnonzero(ends[:, 0] != ends[:, 1])
        ways = np.concatenate([ends, ends[both, ::-1]])
        return cls(ways[:, 0], ways[:, 1], np.concatenate([np.arange(len(ends)), both]))

    def vehicle(self, vehicle: TourVehicle, work: Work) -> TourVehicle:
        """Return the numbers of a vehicle among these nodes."""
        home = np.array((work.targets, work.targets + 1))

        def legs(matrix: Floats) -> Floats:
            among = matrix[np.ix_(np.append(self.leave, home), np.append(self.enter, home))]
            among[:, : len(self.strip)] += np.where(self.enter == self.leave, 0.0, matrix[self.enter, self.leave])
            return among

        return replace(
            vehicle,
            price=legs(vehicle.price),
            seconds=legs(vehicle.seconds),
            joules=legs(vehicle.joules),
            visit_joules=self._both(vehicle.visit_joules),
            allowed=vehicle.allowed[self.enter] & vehicle.allowed[self.leave],
        )

    def work(self, work: Work) -> Work:
        """Return what is to be done at these nodes."""
        return Work(self._both(work.stay), work.window[self.enter], self._both(work.demand))

    def passed(self, nodes: Sequence[int]) -> tuple[int, ...]:
        """Return the places that nodes lead over."""
        ends = [sorted({int(self.enter[x]), int(self.leave[x])}, key=int(self.enter[x]).__ne__) for x in nodes]
        return tuple(place for pair in ends for place in pair)

    def why_unvisited(self, vehicles: Sequence[TourVehicle], work: Work, tours: Sequence[Tour]) -> dict[int, Reason]:
        """Return why places that tours leave out cannot be visited, at both ends of each strip."""
        flown = np.isin(self.enter, [place for tour in tours for sortie in tour for place in sortie])
        whole, unvisited = [self.vehicle(v, work) for v in vehicles], dict[int, Reason]()
        for node, reason in why_unvisited(whole, self.work(work), np.flatnonzero(flown).tolist()).items():
            for place in (int(self.enter[node]), int(self.leave[node])):
                unvisited[place] = max(unvisited.get(place, reason), reason, key=get_args(Reason).index)
        return dict(sorted(unvisited.items()))

    def cut(self, vehicle: TourVehicle, work: Work, tour: Tour) -> Tour:
        """Return a tour of places in the same order, cut into the best sorties, without what none has room for."""
        entered = {int(place): node for node, place in enumerate(self.enter)}
        places, order = [*itertools.chain(*tour)], list[int]()
        while places:
            order.append(entered[places[0]])
            del places[: 1 if self.enter[order[-1]] == self.leave[order[-1]] else 2]
        found = stretches([self.vehicle(vehicle, work)], self.work(work), order)[0]
        return tuple(self.passed(sortie) for sortie in found)

    def _both(self, values: Floats) -> Floats:
        return values[self.enter] + np.where(self.enter == self.leave, 0.0, values[self.leave])
