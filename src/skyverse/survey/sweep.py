"""Straight strips from which all of an area is seen, in the directions that make the whole route short."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import shapely

from skyverse._typing import Floats, Ints
from skyverse.errors import InputError
from skyverse.numerics.tolerances import SWEEP_CONTACT
from skyverse.survey.cell_directions import cells_of, choose_directions
from skyverse.survey.cells import cover_lines, cross_sections, lines_at, price_lines, turned, turned_back
from skyverse.survey.leg_time import LegTime
from skyverse.survey.lower_bound import SweepBound, any_strips_bound, these_strips_bound
from skyverse.survey.strip_order import StripOrder, order_strips
from skyverse.survey.visibility import outline, shortest_ways

Offsets = Callable[[Floats, Any, float, float], Floats]
_LAID_OUT, _ROUTED = 20, 6
"""Plans whose strips are laid out, and of those the ones whose routes are planned, by estimates."""
_MOST_LINES = 2000
_BASES = 2
"""Directions by whose cells several directions are tried."""
_CHOICES = 4
"""Directions that are tried for each cell."""
_CHANGES = (3.0, 8.0)
"""Seconds that each further group of cells with a direction of its own is taken to cost."""
_ROUNDS = (300, 2000)
"""Kicks when routes are compared, and for the route that is kept."""
_SPARED = 0.4
"""Of half a width squared: no part left open is larger than that, where borders are met at a slant."""
_OVERRUN = 3.0
"""Half widths by which a strip goes on at most so that its swath reaches over a slanted border."""

_LEAST_SHARE = 0.2
"""Of a strip that is left at least, however far it is seen beyond its ends."""


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
    unreached
        shapely Polygon or MultiPolygon: what of the area is farther than half a width from every strip; empty where the
        width was given by a function, which alone knows how far strips see.
    route
        The order and direction of the strips in one route, and its seconds, from where it was said to start and back.
    bound
        What no route is faster than.
    """

    strips: Floats
    cell: Ints
    directions: Floats
    unreached: Any
    route: StripOrder
    bound: SweepBound


@dataclass(frozen=True)
class _Task:
    """What all parts of a search share."""

    wanted: Any
    free: Any
    width: float | Offsets
    cost: LegTime
    ends: Literal["line", "swath"]
    start: Floats | None
    reach: float
    beside: bool
    flown: Any = field(init=False)
    terms: dict[tuple[float, float], tuple[float, float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        flown = self.wanted if self.free is None else self.wanted.intersection(self.free)
        object.__setattr__(self, "flown", _polygons(flown))

    @property
    def step(self) -> float:
        """A usual distance from line to line, metres."""
        return float(np.sqrt(self.flown.area)) / 30 if callable(self.width) else self.width


def sweep(
    wanted: Any,
    free: Any,
    width: float | Offsets,
    *,
    cost: LegTime,
    directions: Floats | None = None,
    ends: Literal["line", "swath"] = "swath",
    start: Floats | None = None,
    reach: float = 0.0,
    beside: bool = False,
) -> StripPlan:
    """Cover an area by straight strips so that one route along all of them takes little time.

    Parameters
    ----------
    wanted
        shapely Polygon or MultiPolygon of what is to be seen, metres.
    free
        shapely Polygon or MultiPolygon where the UAV may be; None: everywhere.
    width
        Metres from strip to strip at most; or a function of a unit vector along the strips, the polygons to cover, and
        the least and greatest offset across them, metres to the right of the vector, that returns the offsets of lines.
    cost
        What straight legs cost.
    directions
        Vectors (d, 2) along which strips may run; None: along the borders, and along and across what is longest.
    ends
        "line": a strip ends where its line leaves the area. "swath": it goes on until the area within half a width is
        passed, as far as it is free there.
    start
        Where the route starts and ends (2,), metres; None: wherever that costs nothing.
    reach
        Metres that are seen beyond the ends of a strip, which may end that much earlier if `ends` is "swath".
    beside
        Whether a corner between two offsets that no line cuts gets a strip beside it, if `width` is a function.

    Raises
    ------
    InputError
        Nothing of the area may be flown over, or the width is no length.
    """
    if not callable(width) and not (np.isfinite(width) and width > 0.0):
        raise InputError(f"The width of strips must be a length above 0 m, not {width}.", field="width")
    task = _Task(_polygons(wanted), None if free is None else _polygons(free), width, cost, ends, start, reach, beside)
    if task.flown.is_empty:
        raise InputError("Nothing of the area that is to be seen may be flown over.", field="free")
    across = 2 * float(shapely.minimum_bounding_radius(task.flown)) / task.step
    if across > _MOST_LINES:
        raise InputError(
            f"Strips {width} m apart would be about {across:.0f} side by side; the most is {_MOST_LINES}.",
            field="width",
        )
    tried = candidate_directions(task.flown) if directions is None else _units(np.asarray(directions, dtype=float))
    edges = outline(task.flown)
    order = [int(i) for i in np.argsort([_price(task, edges, way) for way in tried], kind="stable")]
    plans = [[(edges, tried[i])] for i in order[:_LAID_OUT]]
    if not callable(width):
        for i in order[:_BASES]:
            plans += _several_directions(task, tried, i)
    laid = [(plan, *_plan_strips(task, plan)) for plan in plans]
    laid.sort(key=lambda one: float(_flown(task, one[1])))
    prices = [_prices(task, strips) for _, strips, _ in laid[:_ROUTED]]
    best = int(np.argmin([_route(price, _ROUNDS[0]).cost for price in prices]))
    plan, strips, cell = laid[best]
    used = np.array([way for _, way in plan])
    pairs = np.arange(2 * len(strips)).reshape(-1, 2)
    unreached = _unreached(task, strips)
    seen = 0.0 if callable(width) or reach > 0.0 else float(task.flown.difference(unreached).area) / width
    bound = SweepBound(
        any_strips_bound(seen, float(shapely.minimum_bounding_radius(task.flown)) * 2, cost),
        these_strips_bound(prices[best], pairs, 2 * len(strips), 2 * len(strips)),
    )
    return StripPlan(strips, cell, used, unreached, _route(prices[best], _ROUNDS[1]), bound)


def _flown(task: _Task, strips: Floats) -> float:
    """Return the seconds that strips take, with a hop of the usual length from each to the next one."""
    legs = strips[:, 1] - strips[:, 0]
    across = np.stack([legs[:, 1], -legs[:, 0]], 1) / np.hypot(legs[:, 0], legs[:, 1])[:, None]
    return float(task.cost(legs).sum() + task.cost(across * task.step).sum())


def _several_directions(task: _Task, tried: Floats, base: int) -> Iterator[list[tuple[Floats, Floats]]]:
    """Yield the outlines of groups of cells and their directions, chosen for several prices of changing groups."""
    cells = cells_of(task.flown, tried[base])
    if len(cells.bounds) < 2:
        return
    choices = []
    for i in range(len(cells.bounds)):
        edges = cells.outline(frozenset([i]))
        choices.append([int(j) for j in np.argsort([_price(task, edges, way) for way in tried])[:_CHOICES]])
    seen = []
    for change in _CHANGES:

        def price(edges: Floats, i: int, change: float = change) -> float:
            return _price(task, edges, tried[i]) + change

        chosen = choose_directions(cells, base, choices, price)
        if len(set(chosen)) > 1 and chosen not in seen:
            seen.append(chosen)
            yield [
                (cells.outline(group), tried[i])
                for i in sorted(set(chosen))
                for group in cells.groups(frozenset(j for j, other in enumerate(chosen) if other == i))
            ]


def candidate_directions(area: Any) -> Floats:
    """Return unit vectors (d, 2) along the borders of an area and of its convex hull, and across them."""
    edges = np.concatenate([outline(area), outline(area.convex_hull)])
    along = edges[:, 2:] - edges[:, :2]
    long = np.hypot(along[:, 0], along[:, 1])
    along = along[np.argsort(-long, kind="stable")][: max(_MOST_BORDERS, 1)]
    return _units(np.concatenate([along, np.stack([-along[:, 1], along[:, 0]], 1)]))


_MOST_BORDERS = 120
_SAME_DIRECTION = 1e-3  # radians


def _units(vectors: Floats) -> Floats:
    """Return unit vectors in the upper half plane, each direction once."""
    units = vectors / np.hypot(vectors[:, 0], vectors[:, 1])[:, None]
    units = units * np.where((units[:, 1] < 0.0) | ((units[:, 1] == 0.0) & (units[:, 0] < 0.0)), -1.0, 1.0)[:, None]
    units = units[np.argsort(-units[:, 0], kind="stable")]
    turn = units[:-1, 0] * units[1:, 1] - units[:-1, 1] * units[1:, 0]
    return units[np.r_[True, turn > _SAME_DIRECTION]]


def _polygons(area: Any) -> Any:
    """Return the polygons of an area as one valid geometry, without lines and points."""
    area = shapely.make_valid(area) if not area.is_valid else area
    parts = shapely.get_parts(area, return_index=False)
    parts = shapely.get_parts(parts) if len(parts) else parts
    return shapely.union_all([part for part in parts if part.geom_type == "Polygon" and part.area > SWEEP_CONTACT])


def _terms(task: _Task, way: Floats) -> tuple[float, float, float]:
    """Return seconds per metre of a line along a direction, of its ramps, and of a hop to the next line."""
    key = (float(way[0]), float(way[1]))
    if key in task.terms:
        return task.terms[key]
    ramp = task.cost.speed**2 / task.cost.acceleration
    one, two, hop = task.cost(np.array([way * ramp, 2 * way * ramp, [way[1] * task.step, -way[0] * task.step]]))
    slope = float(two - one) / ramp
    task.terms[key] = slope, float(one) - slope * ramp, float(hop)
    return task.terms[key]


def _lines(task: _Task, edges: Floats, way: Floats) -> Floats:
    """Return lines (k, 3) in the frame turned along a direction: x, y0, y1."""
    sections = cross_sections(turned(edges, *way))
    if callable(task.width):
        offsets = task.width(way, task.flown, float(sections.x[0]), float(sections.x[-1]))
        lines = lines_at(sections.edges, offsets)
        return np.concatenate([lines, _beside_corners(task, offsets, lines, way)]) if task.beside else lines
    return cover_lines(sections, 0.5 * task.width, _terms(task, way))


def _price(task: _Task, edges: Floats, way: Floats) -> float:
    """Return about how many seconds the lines of an outline take."""
    if callable(task.width):
        lines = _lines(task, edges, way)
        hops = len(lines) * task.cost(np.array([way[1], -way[0]]) * task.step)
        return float(task.cost((lines[:, 2] - lines[:, 1])[:, None] * way).sum() + hops)
    half, direction = 0.5 * task.width, (float(way[0]), float(way[1]))
    return float(price_lines(edges, direction, half, _terms(task, way), _SPARED * half**2))


def _plan_strips(task: _Task, plan: list[tuple[Floats, Floats]]) -> tuple[Floats, Ints]:
    """Return the strips (m, 2, 2) of outlines with a direction each, and the number of the outline of each strip."""
    strips, cell = [np.empty((0, 2, 2))], [np.empty(0, dtype=np.int64)]
    for i, (edges, way) in enumerate(plan):
        both = [(_lines(task, edges, sign * way), sign * way) for sign in (1.0, -1.0)]
        lines, sense = min(both, key=lambda one: (len(one[0]), (one[0][:, 2] - one[0][:, 1]).sum()))
        if task.ends == "swath" and len(lines):
            lines = _overrun(task, lines, sense)
        lines = lines[lines[:, 2] - lines[:, 1] > SWEEP_CONTACT]
        strips.append(turned_back(_upright(lines), sense))
        cell.append(np.full(len(lines), i))
    laid = np.concatenate(strips)
    laid = np.concatenate([laid, _border_strips(task, laid, np.concatenate([edges for edges, _ in plan]))])
    laid = np.concatenate([laid, _gap_strips(task, laid)])
    which = np.concatenate([*cell, np.full(len(laid) - sum(map(len, cell)), -1)])
    return laid, which


def _beside_corners(task: _Task, offsets: Floats, lines: Floats, way: Floats) -> Floats:
    """Return lines (k, 3) beside what of the area is nearest to an offset at which no line cuts it."""
    area = _turned_area(task.flown, way)
    middles = np.r_[-1e9, 0.5 * (offsets[1:] + offsets[:-1]), 1e9]
    bands = shapely.intersection(shapely.box(middles[:-1], -1e9, middles[1:], 1e9), area)
    parts, which = shapely.get_parts(bands, return_index=True)
    cut, _ = shapely.STRtree(shapely.linestrings(_upright(lines))).query(
        parts, predicate="dwithin", distance=SWEEP_CONTACT
    )
    alone = np.setdiff1d(np.flatnonzero(shapely.area(parts) > SWEEP_CONTACT), cut)
    return np.column_stack([offsets[which[alone]], shapely.bounds(parts[alone])[:, 1::2]])


def _missing(task: _Task, strips: Floats) -> Any:
    """Return the parts of what may be flown over that strips leave open and that are not small."""
    if callable(task.width):
        return np.empty(0, dtype=object)
    half = 0.5 * task.width
    caps: Any = "flat" if task.ends == "line" else "round"
    swaths = shapely.buffer(shapely.linestrings(_reaching(task, strips)), half, cap_style=caps)
    seen = shapely.union_all(swaths, grid_size=SWEEP_CONTACT)
    missing = shapely.get_parts(task.flown.difference(seen))
    return missing[shapely.area(missing) > _SPARED * half**2]


def _gap_strips(task: _Task, strips: Floats) -> Floats:
    """Return strips (g, 2, 2) along gaps wherever they are."""
    out = [np.empty((0, 2, 2))]
    for part in _missing(task, strips):
        box = outline(part.minimum_rotated_rectangle)
        sides = box[:, 2:] - box[:, :2]
        way = _units(sides[np.argmax(np.hypot(sides[:, 0], sides[:, 1]))][None])[0]
        lines = _lines(task, outline(part), way)
        out.append(turned_back(_upright(lines[lines[:, 2] - lines[:, 1] > SWEEP_CONTACT]), way))
    return np.concatenate(out)


def _border_strips(task: _Task, strips: Floats, edges: Floats) -> Floats:
    """Return strips (b, 2, 2) along borders that lines meet at a slant, where they leave too much open."""
    missing = _missing(task, strips)
    if not len(missing):
        return np.empty((0, 2, 2))
    tree = shapely.STRtree(shapely.linestrings(edges.reshape(-1, 2, 2)))
    which, edge = tree.query(missing, predicate="dwithin", distance=SWEEP_CONTACT)
    near = shapely.intersection(shapely.buffer(missing[which], SWEEP_CONTACT), tree.geometries[edge])
    order = np.lexsort((-shapely.length(near), which))
    _, best = np.unique(which[order], return_index=True)
    which, edge = which[order][best], edge[order][best]
    out = []
    for e in np.unique(edge):
        origin, along = edges[e, :2], edges[e, 2:] - edges[e, :2]
        length = float(np.hypot(*along))
        along = along / length
        points, part = shapely.get_coordinates(missing[which[edge == e]], return_index=True)
        at = np.clip(np.einsum("ij,j->i", points - origin, along), 0.0, length)
        low, high = np.full(part.max() + 1, np.inf), np.full(part.max() + 1, -np.inf)
        np.minimum.at(low, part, at)
        np.maximum.at(high, part, at)
        inside = np.argsort(low)
        begin, end = low[inside[0]], high[inside[0]]
        for i in inside[1:]:
            if low[i] - end > 3 * task.step:
                out.append([origin + begin * along, origin + end * along])
                begin = low[i]
            end = max(end, high[i])
        out.append([origin + begin * along, origin + end * along])
    return np.array(out).reshape(-1, 2, 2)


def _overrun(task: _Task, lines: Floats, way: Floats) -> Floats:
    """Let lines go on until they reach the extremes of what their swaths are to see, as far as it is free."""
    half = _halves(task, lines)
    wanted, x = _turned_area(task.wanted, way), lines[:, 0]
    most = _OVERRUN * half
    boxes = shapely.box(x - half, lines[:, 1] - most, x + half, lines[:, 2] + most)
    parts, which = shapely.get_parts(shapely.intersection(boxes, wanted), return_index=True)
    on = shapely.distance(parts, shapely.linestrings(_upright(lines))[which]) <= SWEEP_CONTACT
    bounds = shapely.bounds(parts[on])
    low, high = lines[:, 1].copy(), lines[:, 2].copy()
    np.minimum.at(low, which[on], bounds[:, 1])
    np.maximum.at(high, which[on], bounds[:, 3])
    first, last = low + task.reach, high - task.reach
    if task.free is not None:
        grown = shapely.linestrings(_upright(np.stack([x, low, high], 1)))
        parts, which = shapely.get_parts(shapely.intersection(grown, _turned_area(task.free, way)), return_index=True)
        bounds = shapely.bounds(parts)
        middle = 0.5 * (lines[which, 1] + lines[which, 2])
        on = (bounds[:, 1] <= middle) & (bounds[:, 3] >= middle)
        low, high = lines[:, 1].copy(), lines[:, 2].copy()
        np.minimum.at(low, which[on], bounds[on, 1])
        np.maximum.at(high, which[on], bounds[on, 3])
    middle, least = 0.5 * (low + high), 0.5 * _LEAST_SHARE * (high - low)
    low, high = np.maximum(low, np.minimum(first, middle - least)), np.minimum(high, np.maximum(last, middle + least))
    return np.stack([x, low, high], 1)


def _reaching(task: _Task, strips: Floats) -> Floats:
    """Return strips from where to where they see."""
    if task.reach <= 0.0:
        return strips
    legs = strips[:, 1] - strips[:, 0]
    on = task.reach * legs / np.hypot(legs[:, 0], legs[:, 1])[:, None]
    return np.stack([strips[:, 0] - on, strips[:, 1] + on], 1)


def _halves(task: _Task, lines: Floats) -> Floats:
    """Return how far each line sees to both sides."""
    if not callable(task.width):
        return np.full(len(lines), 0.5 * task.width)
    x, at = np.unique(lines[:, 0], return_inverse=True)
    gaps = np.diff(x) if len(x) > 1 else np.ones(1)
    return 0.5 * np.maximum(np.r_[gaps[0], gaps], np.r_[gaps, gaps[-1]])[at] if len(x) > 1 else gaps[at]


def _upright(lines: Floats) -> Floats:
    return np.stack([lines[:, [0, 1]], lines[:, [0, 2]]], axis=1)


def _turned_area(area: Any, way: Floats) -> Any:
    ux, uy = way
    return shapely.transform(area, lambda p: np.stack([p[:, 0] * uy - p[:, 1] * ux, p[:, 0] * ux + p[:, 1] * uy], 1))


def _prices(task: _Task, strips: Floats) -> Floats:
    """Return the seconds (2 m + 1, 2 m + 1) from end to end of strips, and to where the route starts and ends."""
    places = strips.reshape(-1, 2)
    if task.start is not None:
        places = np.concatenate([places, np.asarray(task.start, dtype=float)[None]])
    price = shortest_ways(task.free, places, task.cost).price
    return np.pad(price, (0, 1)) if task.start is None else price


def _route(prices: Floats, rounds: int) -> StripOrder:
    m = len(prices) // 2
    return order_strips(prices, np.arange(2 * m).reshape(-1, 2), 2 * m, 2 * m, rounds=rounds)


def _unreached(task: _Task, strips: Floats) -> Any:
    if callable(task.width):
        return shapely.Polygon()
    seen = shapely.buffer(shapely.linestrings(_reaching(task, strips)), 0.5 * task.width)
    return task.wanted.difference(shapely.union_all(seen, grid_size=SWEEP_CONTACT))
