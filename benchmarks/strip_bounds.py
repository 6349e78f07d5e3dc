"""What no routes along strips go below.

Routes of several vehicles are bounded by a linear programme whose cuts leave no tour apart from home. For one of them
there are two quick bounds. With straight strips in whatever places and directions, a strip of length l sees l times the
width at most, and takes at least as long per metre as the longest one that fits. With given strips, hops pair the ends
of strips, the start and the end with one another, so that they cost no less than the cheapest such pairs; half the cost
of an assignment is a bound of that.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment, linprog
from scipy.sparse import csr_array, vstack
from scipy.sparse.csgraph import connected_components

from skyverse._typing import Bools, Floats, Ints
from skyverse.mission.assignment import Criterion
from skyverse.mission.routing import Routes, TourVehicle, Work
from skyverse.mission.strip_routing import StripNodes
from skyverse.numerics.tolerances import PROOF_ROUNDING
from skyverse.survey.leg_time import LegTime

_NO_WAY = 1e9  # seconds that stand for no way at all

_MOST_STRIPS = 150  # with more, only legs are assigned
_ROUNDS = 60
_COLUMNS = 8  # legs from each node, and to it, from which the programme begins
_LEVELS = 0.01, 0.25, 0.5, 0.75, 0.95  # of the flows that join strips where tours apart are looked for
_VIOLATED = 1e-3  # how much of a flow is missing where a cut is worth it


def any_strips_bound(length: float, longest: float, cost: LegTime) -> float:
    """Return a bound for routes along any straight strips that see an area, of its size over the width that they see.

    The time of a leg over its length falls with the length, so that no strip is faster per metre than the longest one.
    """
    return length / longest * float(cost(np.array([longest, 0.0])))


def these_strips_bound(costs: Floats, strips: Ints, start: int, end: int) -> float:
    """Return a bound for routes along given strips, from a place to a place; parameters are those of `order_strips`."""
    count = 2 * len(strips)
    places = np.r_[np.ravel(strips), start, end]
    price = costs[np.ix_(places, places)]
    price = np.minimum(np.minimum(price, price.T), _NO_WAY)
    ends = np.arange(count + 2)
    flown = price[ends[:-2:2], ends[1:-2:2]].sum()
    price[ends, ends] = price[ends, ends ^ 1] = 2 * _NO_WAY  # no hop from a strip to itself, or from start to end
    bound = float(flown + 0.5 * price[linear_sum_assignment(price)].sum())
    return bound if bound < _NO_WAY else np.inf


def routes_bound(
    vehicles: Sequence[TourVehicle], strips: Ints, work: Work, routes: Routes, criterion: Criterion = "min-sum"
) -> float:
    """Return what no routes along the strips that `routes` fly go below: the price, or with min-max the finish."""
    nodes = StripNodes.along(np.asarray(strips).reshape(-1, 2))
    flown = np.isin(nodes.enter, [place for tour in routes.tours for sortie in tour for place in sortie])
    whole, held = [nodes.vehicle(v, work) for v in vehicles], np.where(flown, nodes.strip, -1)
    value = routes.price if criterion == "min-sum" else routes.finish
    return min(_strip_bound(whole, nodes.work(work), held, criterion), value)


def _strip_bound(vehicles: Sequence[TourVehicle], work: Work, strip: Ints, criterion: Criterion) -> float:
    """Return what no routes go below among n nodes, of which each is a way of flying a strip (n,), or -1 for none."""
    held = np.flatnonzero(strip >= 0)
    if not len(held):
        return 0.0
    _, groups = np.unique(strip[held], return_inverse=True)
    timed, fleet = criterion == "min-max", len(vehicles)
    legs = _least(vehicles, [v.seconds if timed else v.price for v in vehicles], held)
    joules = (
        _least(vehicles, [v.joules for v in vehicles], held)[:, :-1].min(axis=0)
        + np.min([v.visit_joules for v in vehicles], axis=0)[held]
    )
    legs[:, :-1] += work.stay[held] if timed else 0.0
    usable = max(v.usable for v in vehicles)
    need = max(1, math.ceil(_by_group(np.minimum, joules, groups).sum() * (1.0 - PROOF_ROUNDING) / usable))
    programme = _Programme(legs, groups)
    if not timed:
        return programme.bound(need)
    swaps = max(need - fleet, 0) * min(v.swap for v in vehicles) / fleet
    shared = programme.bound(max(need, fleet)) / fleet
    if fleet > 1:  # or one of them stays at home
        shared = min(shared, programme.bound(need) / (fleet - 1))
    alone = _by_group(np.minimum, legs[-1, :-1] + legs[:-1, -1], groups).max()
    return max(shared + swaps, float(alone) * (1.0 - PROOF_ROUNDING))


def _least(vehicles: Sequence[TourVehicle], matrices: Sequence[Floats], held: Ints) -> Floats:
    """Return the least legs of any vehicle among nodes, and from and to home as the last row and column."""
    least = np.full((len(held) + 1,) * 2, math.inf)
    n = len(matrices[0]) - 2
    for v, matrix in zip(vehicles, matrices, strict=True):
        way = np.where(np.isfinite(v.price) & np.isfinite(v.seconds), matrix, math.inf)
        legs = np.full_like(least, math.inf)
        legs[:-1, :-1] = way[np.ix_(held, held)]
        legs[-1, :-1] = np.minimum(way[n, held], way[n + 1, held] if v.most_sorties > 1 else math.inf)
        legs[:-1, -1] = way[held, n + 1] if v.returns else 0.0
        may = np.append(v.allowed[held], True)
        least = np.minimum(least, np.where(may[:, None] & may, legs, math.inf))
    return least


def _by_group(least: np.ufunc, values: Floats, groups: Ints) -> Floats:
    """Return the least value of each group."""
    found = np.full(groups.max() + 1, math.inf)
    least.at(found, groups, values)
    return found


class _Programme:
    """The least flows over legs: into one node of each strip and on from it, with cuts.

    Only legs that may matter are columns; others join when their reduced costs are negative. Every dual solution
    gives a bound, whatever the solver's tolerances are.
    """

    def __init__(self, legs: Floats, groups: Ints) -> None:
        n = len(groups)
        ends = np.append(groups, -1)
        self._legs, self._groups = np.where(ends[:, None] == ends, math.inf, legs), groups
        few = min(_COLUMNS, n)
        cheap = np.sort(self._legs, axis=0)[few], np.sort(self._legs, axis=1)[:, few, None]
        self._columns: Bools = (self._legs <= cheap[0]) | (self._legs <= cheap[1])
        self._columns[-1], self._columns[:, -1] = True, True
        self._columns &= np.isfinite(self._legs)
        self._cuts = np.zeros((0, n), dtype=bool)

    def bound(self, degree: int) -> float:
        """Return what flows that leave home at least so often cost at least."""
        best = 0.0
        for _ in range(_ROUNDS if len(self._groups) <= 2 * _MOST_STRIPS else 1):
            flow, reduced, value = self._solved(degree)
            if flow is None:
                break
            strips = _by_group(np.minimum, reduced[:, :-1].min(axis=0), self._groups)
            back = _by_group(np.minimum, reduced[:-1, -1], self._groups)
            best = max(best, value + float(np.minimum(strips, 0.0).sum() + np.minimum(back, 0.0).sum()))
            dear = reduced < -_VIOLATED * value / len(self._groups)
            if np.any(dear & ~self._columns):
                self._columns |= dear
                continue
            if not self._cut(flow):
                break
        return best * (1.0 - PROOF_ROUNDING)

    def _solved(self, degree: int) -> tuple[Floats | None, Floats, float]:
        """Return the flows, the reduced costs of all legs, and the value."""
        n, m = len(self._groups), int(self._groups.max()) + 1
        tail, head = np.nonzero(self._columns)
        legs, count = self._legs[tail, head], len(tail)
        into, out, each = head < n, tail < n, np.arange(count)
        rows = np.concatenate([self._groups[head[into]], m + head[into], m + tail[out]])
        columns = np.concatenate([each[into], each[into], each[out]])
        values = np.concatenate([np.ones(into.sum()), np.ones(into.sum()), -np.ones(out.sum())])
        equal: Any = csr_array((values, (rows, columns)), shape=(m + n, count))
        inside = np.pad(self._cuts, ((0, 0), (0, 1)))
        crossing = inside[:, tail] & ~inside[:, head]
        least: Any = vstack([csr_array(-crossing.astype(float)), csr_array(-(tail == n).astype(float)[None])])
        right = np.append(-np.ones(len(inside)), -float(degree))
        found = linprog(
            legs, least, right, equal, np.append(np.ones(m), np.zeros(n)), bounds=(0.0, None), method="highs"
        )
        if found.status != 0:
            return None, self._legs, 0.0
        into_strip, through = found.eqlin.marginals[:m], np.append(found.eqlin.marginals[m:], 0.0)
        cut = np.maximum(-found.ineqlin.marginals, 0.0)
        dual = np.append(into_strip[self._groups], 0.0) + through - through[:, None]
        dual[-1, :] += cut[-1]
        dual += np.einsum("c,cu,cv->uv", cut[:-1], inside.astype(float), (~inside).astype(float), optimize=True)
        flow = np.zeros_like(self._legs)
        flow[tail, head] = found.x
        value = float(into_strip.sum() + cut[:-1].sum() + cut[-1] * degree)
        return flow, self._legs - dual, value

    def _cut(self, flow: Floats) -> bool:
        """Add cuts around strips that are joined to one another more than to others; tell whether there are any."""
        groups, n = self._groups, len(self._groups)
        joined = np.zeros((groups.max() + 1,) * 2)
        np.add.at(joined, (groups[:, None], groups), flow[:n, :n])
        found = []
        for level in _LEVELS:
            count, label = connected_components(joined + joined.T > level, directed=False)
            for part in range(count):
                inside = label == part
                out = flow[:n][inside[groups]][:, ~np.append(inside[groups], False)].sum()
                if inside.sum() > 1 and out < 1.0 - _VIOLATED:
                    found.append(inside[groups])
        cuts = np.unique(np.vstack([self._cuts, *found]), axis=0) if found else self._cuts
        grown = len(cuts) > len(self._cuts)
        self._cuts = cuts
        return grown
