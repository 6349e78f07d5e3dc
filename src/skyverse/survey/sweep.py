"""Straight strips from which all of an area is seen, in the directions that make the whole route short."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.tolerances import SWEEP_CONTACT
from skyverse.survey.cell_directions import cells_of, choose_directions
from skyverse.survey.cells import turned_back
from skyverse.survey.leg_time import LegTime
from skyverse.survey.strip_order import order_strips
from skyverse.survey.sweep_ends import border_strips, gap_strips, overrun
from skyverse.survey.sweep_lines import (
    Ends,
    Offsets,
    SweepTask,
    candidate_directions,
    lines_across,
    polygons,
    price,
    units,
    upright,
)
from skyverse.survey.visibility import outline, way_prices

_LAID_OUT, _ROUTED = 20, 6
"""Plans whose strips are laid out, and of those the ones whose routes are planned, by estimates."""
_BASES = 2
"""Directions by whose cells several directions are tried."""
_CHOICES = 4
"""Directions that are tried for each cell."""
_CHANGES = (3.0, 8.0)
"""Seconds that each further group of cells with a direction of its own is taken to cost."""
_ROUNDS = 300
"""Kicks when routes are compared."""


@dataclass(frozen=True, eq=False)
class StripPlan:
    """Strips that cover an area.

    Attributes
    ----------
    strips
        Their ends (m, 2, 2), metres.
    cell
        The cell that each strip belongs to (m,); -1 where it runs along a border or a gap.
    directions
        The unit vector along the strips of each cell (c, 2).
    """

    strips: Floats
    cell: Ints
    directions: Floats


def sweep(
    wanted: Any,
    free: Any,
    width: float | Offsets,
    *,
    cost: LegTime,
    directions: Floats | None = None,
    ends: Ends = "swath",
    start: Floats | None = None,
    reach: float = 0.0,
) -> StripPlan:
    """Cover an area by straight strips so that one route along all of them takes little time.

    Parameters
    ----------
    wanted
        shapely Polygon or MultiPolygon of what is to be seen, metres.
    free
        shapely Polygon or MultiPolygon where the UAV may be, with something of what is wanted.
    width
        Metres from strip to strip at most; or a function of a unit vector along the strips, the polygons to cover, and
        the least and greatest offset across them, metres to the right of the vector, that returns the offsets of lines.
    cost
        What straight legs cost.
    directions
        Vectors (d, 2) along which strips may run; None: along the borders, and along and across what is longest.
    ends
        "line": a strip ends where its line leaves the area. "swath": it goes on until the area within half a width is
        passed, as far as it is free there. "corners": that, and corners between offsets that no line cuts get strips
        beside them, if `width` is a function.
    start
        Where the route starts and ends (2,), metres; None: wherever that costs nothing.
    reach
        Metres that are seen beyond the ends of a strip, which may end that much earlier unless `ends` is "line".
    """
    task = SweepTask(polygons(wanted), polygons(free), width, cost, ends, start, reach)
    tried = candidate_directions(task.flown) if directions is None else units(np.asarray(directions, dtype=float))
    edges = outline(task.flown)
    order = [int(i) for i in np.argsort([price(task, edges, way) for way in tried], kind="stable")]
    plans = [[(edges, tried[i])] for i in order[:_LAID_OUT]]
    if not callable(width):
        for i in order[:_BASES]:
            plans += _several_directions(task, tried, i)
    laid = [(plan, *_plan_strips(task, plan)) for plan in plans]
    laid.sort(key=lambda one: float(_flown(task, one[1])))
    best = laid[:_ROUTED]
    plan, strips, cell = min(best, key=lambda one: _routed(task, one[1])) if len(best) > 1 else best[0]
    return StripPlan(strips, cell, np.array([way for _, way in plan]))


def _flown(task: SweepTask, strips: Floats) -> float:
    """Return the seconds that strips take, with a hop of the usual length from each to the next one."""
    legs = strips[:, 1] - strips[:, 0]
    across = np.stack([legs[:, 1], -legs[:, 0]], 1) / np.hypot(legs[:, 0], legs[:, 1])[:, None]
    return float(task.cost(legs).sum() + task.cost(across * task.step).sum())


def _several_directions(task: SweepTask, tried: Floats, base: int) -> Iterator[list[tuple[Floats, Floats]]]:
    """Yield the outlines of groups of cells and their directions, chosen for several prices of changing groups."""
    cells = cells_of(task.flown, tried[base])
    if len(cells.bounds) < 2:
        return
    choices = []
    for i in range(len(cells.bounds)):
        edges = cells.outline(frozenset([i]))
        choices.append([int(j) for j in np.argsort([price(task, edges, way) for way in tried])[:_CHOICES]])
    seen = []
    for change in _CHANGES:

        def with_change(edges: Floats, i: int, change: float = change) -> float:
            return price(task, edges, tried[i]) + change

        chosen = choose_directions(cells, base, choices, with_change)
        if len(set(chosen)) > 1 and chosen not in seen:
            seen.append(chosen)
            yield [
                (cells.outline(group), tried[i])
                for i in sorted(set(chosen))
                for group in cells.groups(frozenset(j for j, other in enumerate(chosen) if other == i))
            ]


def _plan_strips(task: SweepTask, plan: list[tuple[Floats, Floats]]) -> tuple[Floats, Ints]:
    """Return the strips (m, 2, 2) of outlines with a direction each, and the number of the outline of each strip."""
    strips, cell = [np.empty((0, 2, 2))], [np.empty(0, dtype=np.int64)]
    for i, (edges, way) in enumerate(plan):
        both = [(lines_across(task, edges, sign * way), sign * way) for sign in (1.0, -1.0)]
        lines, sense = min(both, key=lambda one: (len(one[0]), (one[0][:, 2] - one[0][:, 1]).sum()))
        if task.ends != "line" and len(lines):
            lines = overrun(task, lines, sense)
        lines = lines[lines[:, 2] - lines[:, 1] > SWEEP_CONTACT]
        strips.append(turned_back(upright(lines), sense))
        cell.append(np.full(len(lines), i))
    laid = np.concatenate(strips)
    laid = np.concatenate([laid, border_strips(task, laid, np.concatenate([edges for edges, _ in plan]))])
    laid = np.concatenate([laid, gap_strips(task, laid)])
    which = np.concatenate([*cell, np.full(len(laid) - sum(map(len, cell)), -1)])
    return laid, which


def _routed(task: SweepTask, strips: Floats) -> float:
    """Return the seconds of a route along strips, from where it starts and back."""
    m, places = len(strips), strips.reshape(-1, 2)
    if task.start is not None:
        places = np.concatenate([places, np.asarray(task.start, dtype=float)[None]])
    prices = way_prices(task.free, places, task.cost)
    prices = np.pad(prices, (0, 1)) if task.start is None else prices
    return order_strips(prices, np.arange(2 * m).reshape(-1, 2), 2 * m, 2 * m, rounds=_ROUNDS).cost
