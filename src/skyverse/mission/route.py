"""Routes: who visits which targets in which order, exactly for few targets, by PyVRP for more."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from typing import get_args

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, require_choice, shown
from skyverse.mission.assignment import Criterion
from skyverse.mission.exact_routing import MOST_TARGETS, exact_tours
from skyverse.mission.given_order import kept_to_limits, stretches
from skyverse.mission.pyvrp_routing import pyvrp_tours
from skyverse.mission.routing import Routes, RouteSearch, Tour, TourVehicle, Work, possible, timed, why_unvisited
from skyverse.stop import require_stop

_SEARCH = RouteSearch()


def route(
    vehicles: Sequence[TourVehicle],
    work: Work,
    criterion: Criterion = "min-sum",
    search: RouteSearch = _SEARCH,
) -> Routes:
    """Decide who visits which targets in which order.

    As few targets as possible stay unvisited; among such routes the batteries are swapped as seldom as possible; among
    those the price is the least.

    Parameters
    ----------
    vehicles, work
        The UAVs, and what is to be done.
    criterion
        ``"min-sum"`` minimises the sum of the prices; ``"min-max"`` the time at which the last vehicle is done, and
        then the sum.
    search
        How they are sought.

    Raises
    ------
    InputError
        If the numbers do not fit together, or there are more than ten targets and PyVRP is not installed.
    """
    require_choice(criterion, get_args(Criterion), "criterion")
    require_stop(search.stop)
    order = search.order
    if order is not None and sorted(order) != list(range(work.targets)):
        raise InputError(f"expected every target once, found {shown(order)}", field="order")
    if work.targets == 0 or not vehicles:
        return told(vehicles, work, ((),) * len(vehicles), criterion, optimal=True)
    if work.targets <= MOST_TARGETS:
        return told(vehicles, work, exact_tours(vehicles, work, criterion, order), criterion, optimal=True)
    if order is not None and max(vehicle.most_sorties for vehicle in vehicles) > 1:
        return _cut(vehicles, work, criterion, search)
    tours, interrupted = pyvrp_tours(vehicles, work, criterion, search)
    return replace(told(vehicles, work, tours, criterion, optimal=False), interrupted=interrupted)


def retold(vehicles: Sequence[TourVehicle], work: Work, routes: Routes, criterion: Criterion) -> Routes | None:
    """Return routes with the numbers of other vehicles; ``None`` where these cannot fly them."""
    if any(timed(vehicle, work, tour) is None for vehicle, tour in zip(vehicles, routes.tours, strict=True)):
        return None
    return replace(told(vehicles, work, routes.tours, criterion, optimal=False), interrupted=routes.interrupted)


def _cut(vehicles: Sequence[TourVehicle], work: Work, criterion: Criterion, search: RouteSearch) -> Routes:
    """Return routes in the given order with several sorties: in stretches, or shared without batteries and then cut."""
    able = np.any([possible(vehicle, work) for vehicle in vehicles], axis=0)
    order = [j for j in search.order or () if able[j]]
    found = [told(vehicles, work, stretches(vehicles, work, order), criterion, optimal=False)]
    if len(vehicles) > 1:
        whole = [replace(v, most_sorties=1, usable=math.inf, capacity=math.inf) for v in vehicles]
        shared, interrupted = pyvrp_tours(whole, work, criterion, search._replace(tours=None))
        cut = [stretches([v], work, tour[0])[0] if tour else () for v, tour in zip(vehicles, shared, strict=True)]
        found.append(replace(told(vehicles, work, cut, criterion, optimal=False), interrupted=interrupted))

    def value(routes: Routes) -> tuple[float, ...]:
        return (len(routes.unvisited), routes.swaps, routes.price if criterion == "min-sum" else routes.finish)

    return replace(min(found, key=value), interrupted=found[-1].interrupted)


def told(
    vehicles: Sequence[TourVehicle], work: Work, tours: Sequence[Tour], criterion: Criterion, *, optimal: bool
) -> Routes:
    """Return routes with their times, their price, what is left out, and a lower bound."""
    kept, times = kept_to_limits(vehicles, work, tours, lambda v, tour: stretches([v], work, [*chain(*tour)])[0])
    optimal = optimal and kept == tuple(tours)
    visited = sorted(j for tour in kept for sortie in tour for j in sortie)
    starts, finishes = tuple(t.starts for t in times), tuple(t.finishes for t in times)
    unvisited = why_unvisited(vehicles, work, visited)
    routes = Routes(kept, starts, finishes, unvisited, math.fsum(t.price for t in times), optimal=optimal)
    bound = routes.price if criterion == "min-sum" else routes.finish
    if not optimal:
        bound = min(bound, lower_bound(vehicles, work, visited, criterion))
    return replace(routes, lower_bound=bound, bound="exact" if optimal else "assignment")


def lower_bound(vehicles: Sequence[TourVehicle], work: Work, visited: Sequence[int], criterion: Criterion) -> float:
    """Return what no routes to the targets go below: their price, or for min-max the largest finish.

    Each target is left once and reached once, and each sortie leaves and reaches home once (an assignment problem);
    whether the legs make tours, and all limits, are ignored.
    """
    seconds = _assigned(vehicles, [v.seconds for v in vehicles], visited) if criterion == "min-max" else 0.0
    if criterion == "min-sum":
        return _assigned(vehicles, [v.price for v in vehicles], visited)
    return (seconds + math.fsum(work.stay[list(visited)].tolist())) / len(vehicles)


def _assigned(vehicles: Sequence[TourVehicle], matrices: Sequence[Floats], visited: Sequence[int]) -> float:
    """Return the least sum of legs such that each target is left once and reached once."""
    if not visited:
        return 0.0
    from scipy.optimize import linear_sum_assignment

    n, held = len(matrices[0]) - 2, np.array(visited)
    among, out, back = (np.full(shape, math.inf) for shape in ((len(held),) * 2, len(held), len(held)))
    for vehicle, matrix in zip(vehicles, matrices, strict=True):
        legs = np.where(vehicle.allowed[:, None] & vehicle.allowed, matrix[:n, :n], math.inf)[np.ix_(held, held)]
        may = vehicle.allowed[held]
        begins = np.minimum(matrix[n, held], matrix[n + 1, held] if vehicle.most_sorties > 1 else math.inf)
        among, out = np.minimum(among, legs), np.minimum(out, np.where(may, begins, math.inf))
        back = np.minimum(back, np.where(may, matrix[held, n + 1] if vehicle.returns else 0.0, math.inf))
    np.fill_diagonal(among, math.inf)
    square = np.full((2 * len(held),) * 2, math.inf)  # each target may be the last, or the first, of a sortie
    square[: len(held), : len(held)] = among
    square[len(held) :, len(held) :] = 0.0
    np.fill_diagonal(square[: len(held), len(held) :], back)
    np.fill_diagonal(square[len(held) :, : len(held)], out)
    rows, columns = linear_sum_assignment(square)
    return float(square[rows, columns].sum())
