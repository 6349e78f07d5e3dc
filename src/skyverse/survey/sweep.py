"""Straight strips from which all of an area is seen, in the directions that make the whole route short."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import shapely

from skyverse._typing import Floats, Ints
from skyverse.errors import InputError
from skyverse.numerics.tolerances import SWEEP_CONTACT
from skyverse.survey.cells import cover_lines, cross_sections, lines_at, turned, turned_back
from skyverse.survey.strip_order import StripOrder, order_strips
from skyverse.survey.visibility import outline, shortest_ways

Offsets = Callable[[Floats, Any, float, float], Floats]
_TRIED = 6
"""Directions whose routes are really planned; the others are worse by a quick estimate."""
_ROUNDS = (300, 2000)
"""Kicks when routes are compared, and for the route that is kept."""
_SPARED = 0.4
"""Of half a width squared: no part left open is larger than that, where borders are met at a slant."""
_OVERRUN = 3.0
"""Half widths by which a strip goes on at most so that its swath reaches over a slanted border."""


@dataclass(frozen=True)
class LegTime:
    """What straight legs cost: from rest to rest, in seconds.

    Attributes
    ----------
    speed
        m/s, the fastest one.
    acceleration
        m/s2, speeding up and braking.
    turn
        Seconds that each leg takes besides.
    ground_speed
        Gives for unit vectors (..., 2) the speed over ground in m/s, where that differs by direction (wind); None:
        `speed` everywhere.
    """

    speed: float
    acceleration: float
    turn: float = 0.0
    ground_speed: Callable[[Floats], Floats] | None = None

    def __call__(self, legs: Floats) -> Floats:
        """Return the seconds that legs (..., 2), in metres, take: l / v + v / a, or 2 sqrt(l / a) if they are short."""
        length = np.hypot(legs[..., 0], legs[..., 1])
        speed: Any = self.speed
        if self.ground_speed is not None:
            speed = self.ground_speed(legs / np.maximum(length, SWEEP_CONTACT)[..., None])
        short = length < speed**2 / self.acceleration
        ramps = np.where(short, 2 * np.sqrt(length / self.acceleration), length / speed + speed / self.acceleration)
        return np.where(length > 0.0, ramps + self.turn, 0.0)


@dataclass(frozen=True, eq=False)
class StripPlan:
    """Strips that cover an area.

    Attributes
    ----------
    strips
        Their ends (m, 2, 2), metres.
    cell
        The cell that each strip belongs to (m,).
    directions
        The unit vector along the strips of each cell (c, 2).
    unreached
        shapely Polygon or MultiPolygon: what of the area is farther than half a width from every strip.
    route
        The order and direction of the strips in one route, and its seconds, from where it was said to start and back.
    """

    strips: Floats
    cell: Ints
    directions: Floats
    unreached: Any
    route: StripOrder


@dataclass(frozen=True)
class _Task:
    """What all parts of a search share."""

    wanted: Any
    free: Any
    width: float | Offsets
    cost: LegTime
    ends: Literal["line", "swath"]
    start: Floats | None
    flown: Any = field(init=False)

    def __post_init__(self) -> None:
        flown = self.wanted if self.free is None else self.wanted.intersection(self.free)
        object.__setattr__(self, "flown", _polygons(flown))


def sweep(
    wanted: Any,
    free: Any,
    width: float | Offsets,
    *,
    cost: LegTime,
    directions: Floats | None = None,
    ends: Literal["line", "swath"] = "swath",
    start: Floats | None = None,
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

    Raises
    ------
    InputError
        Nothing of the area may be flown over, or the width is no length.
    """
    if not callable(width) and not (np.isfinite(width) and width > 0.0):
        raise InputError(f"The width of strips must be a length above 0 m, not {width}.", field="width")
    task = _Task(_polygons(wanted), None if free is None else _polygons(free), width, cost, ends, start)
    if task.flown.is_empty:
        raise InputError("Nothing of the area that is to be seen may be flown over.", field="free")
    edges = outline(task.flown)
    tried = candidate_directions(task.flown) if directions is None else _units(np.asarray(directions, dtype=float))
    tried = np.concatenate([tried, -tried])
    found = [(_lines(task, edges, way), way) for way in tried]
    order = np.argsort([_estimate(task, lines, way) for lines, way in found], kind="stable")[: 2 * _TRIED]
    routed = []
    for i in order[:_TRIED]:
        strips = _strips(task, *found[i])
        routed.append((_route(task, strips, _ROUNDS[0]), strips, found[i][1]))
    _, strips, way = min(routed, key=lambda candidate: candidate[0].cost)
    cell = np.zeros(len(strips), dtype=np.int64)
    return StripPlan(strips, cell, way[None], _unreached(task, strips), _route(task, strips, _ROUNDS[1]))


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


def _lines(task: _Task, edges: Floats, way: Floats) -> Floats:
    """Return lines (k, 3) in the frame turned along a direction: x, y0, y1."""
    sections = cross_sections(turned(edges, way))
    if callable(task.width):
        return lines_at(sections.edges, task.width(way, task.flown, float(sections.x[0]), float(sections.x[-1])))
    ramp = task.cost(np.stack([way, 2 * way]) * task.cost.speed**2 / task.cost.acceleration)
    hop = float(task.cost(np.array([way[1], -way[0]]) * task.width))
    slope = float(ramp[1] - ramp[0]) * task.cost.acceleration / task.cost.speed**2
    fixed = float(ramp[0]) - slope * task.cost.speed**2 / task.cost.acceleration
    return cover_lines(*sections, 0.5 * task.width, (slope, fixed + hop))


def _estimate(task: _Task, lines: Floats, way: Floats) -> float:
    """Return about how many seconds lines take, with a hop to the next one each."""
    spacing = np.median(np.diff(np.unique(lines[:, 0]))) if len(lines) > 1 else 0.0
    hop = task.cost(np.array([way[1], -way[0]]) * spacing)
    return float(task.cost((lines[:, 2] - lines[:, 1])[:, None] * way).sum() + len(lines) * hop)


def _strips(task: _Task, lines: Floats, way: Floats) -> Floats:
    """Return strips (m, 2, 2) along lines; with ends by swath they go on over slanted borders."""
    if task.ends == "swath" and len(lines):
        lines = _overrun(task, lines, way)
    lines = lines[lines[:, 2] - lines[:, 1] > SWEEP_CONTACT]
    strips = turned_back(_upright(lines), way)
    return np.concatenate([strips, _border_strips(task, strips)])


def _border_strips(task: _Task, strips: Floats) -> Floats:
    """Return strips (b, 2, 2) along borders that lines meet at a slant, where they leave too much open."""
    if callable(task.width):
        return np.empty((0, 2, 2))
    half = 0.5 * task.width
    caps: Any = "flat" if task.ends == "line" else "round"
    seen = shapely.union_all(shapely.buffer(shapely.linestrings(strips), half, cap_style=caps))
    missing = shapely.get_parts(task.flown.difference(seen))
    missing = missing[shapely.area(missing) > _SPARED * half**2]
    if not len(missing):
        return np.empty((0, 2, 2))
    edges = outline(task.flown)
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
            if low[i] - end > 3 * task.width:
                out.append([origin + begin * along, origin + end * along])
                begin = low[i]
            end = max(end, high[i])
        out.append([origin + begin * along, origin + end * along])
    return np.array(out)


def _overrun(task: _Task, lines: Floats, way: Floats) -> Floats:
    """Let lines go on over the extremes of what their swaths are to see, as far as it is free."""
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
    if task.free is not None:
        grown = shapely.linestrings(_upright(np.stack([x, low, high], 1)))
        parts, which = shapely.get_parts(shapely.intersection(grown, _turned_area(task.free, way)), return_index=True)
        bounds = shapely.bounds(parts)
        middle = 0.5 * (lines[which, 1] + lines[which, 2])
        on = (bounds[:, 1] <= middle) & (bounds[:, 3] >= middle)
        low, high = lines[:, 1].copy(), lines[:, 2].copy()
        np.minimum.at(low, which[on], bounds[on, 1])
        np.maximum.at(high, which[on], bounds[on, 3])
    return np.stack([x, low, high], 1)


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


def _route(task: _Task, strips: Floats, rounds: int) -> StripOrder:
    """Order the strips for one route by the cheapest ways among what is not free."""
    places = strips.reshape(-1, 2)
    if task.start is not None:
        places = np.concatenate([places, np.asarray(task.start, dtype=float)[None]])
    price = shortest_ways(task.free, places, task.cost).price
    if task.start is None:
        price = np.pad(price, (0, 1))
    m = len(strips)
    return order_strips(price, np.arange(2 * m).reshape(-1, 2), 2 * m, 2 * m, rounds=rounds)


def _unreached(task: _Task, strips: Floats) -> Any:
    half = 0.5 * task.width if not callable(task.width) else 0.0
    return task.wanted.difference(shapely.union_all(shapely.buffer(shapely.linestrings(strips), half)))
