"""How far strips go on at borders, and strips along what they leave open there."""

from typing import Any

import numpy as np
import shapely

from skyverse._typing import Floats
from skyverse.numerics.tolerances import SWEEP_CONTACT
from skyverse.survey.cells import turned_back
from skyverse.survey.sweep_lines import LEFT_OPEN, SweepTask, across, lines_across, units, upright, widest_gaps
from skyverse.survey.visibility import outline

_OVERRUN = 3.0
"""Half widths by which a strip goes on at most so that its swath reaches over a slanted border."""
_LEFT_AT_LEAST = 0.2
"""Of a strip that is left at least, however far it is seen beyond its ends."""


def overrun(task: SweepTask, lines: Floats, way: Floats) -> Floats:
    """Let lines go on until they reach the extremes of what their swaths are to see, as far as it is free."""
    half = _halves(task, lines)
    wanted, x = across(task.wanted, way), lines[:, 0]
    most = _OVERRUN * half
    boxes = shapely.box(x - half, lines[:, 1] - most, x + half, lines[:, 2] + most)
    parts, which = shapely.get_parts(shapely.intersection(boxes, wanted), return_index=True)
    on = shapely.distance(parts, shapely.linestrings(upright(lines))[which]) <= SWEEP_CONTACT
    bounds = shapely.bounds(parts[on])
    low, high = lines[:, 1].copy(), lines[:, 2].copy()
    np.minimum.at(low, which[on], bounds[:, 1])
    np.maximum.at(high, which[on], bounds[:, 3])
    first, last = low + task.reach, high - task.reach
    grown = shapely.linestrings(upright(np.stack([x, low, high], 1)))
    parts, which = shapely.get_parts(shapely.intersection(grown, across(task.free, way)), return_index=True)
    bounds = shapely.bounds(parts)
    middle = 0.5 * (lines[which, 1] + lines[which, 2])
    on = (bounds[:, 1] <= middle) & (bounds[:, 3] >= middle)
    low, high = lines[:, 1].copy(), lines[:, 2].copy()
    np.minimum.at(low, which[on], bounds[on, 1])
    np.maximum.at(high, which[on], bounds[on, 3])
    middle, least = 0.5 * (low + high), 0.5 * _LEFT_AT_LEAST * (high - low)
    low, high = np.maximum(low, np.minimum(first, middle - least)), np.minimum(high, np.maximum(last, middle + least))
    return np.stack([x, low, high], 1)


def _halves(task: SweepTask, lines: Floats) -> Floats:
    """Return how far each line sees to both sides."""
    if not callable(task.width):
        return np.full(len(lines), 0.5 * task.width)
    return 0.5 * widest_gaps(lines[:, 0], 2.0)


def gap_strips(task: SweepTask, strips: Floats) -> Floats:
    """Return strips (g, 2, 2) along gaps wherever they are."""
    out = [np.empty((0, 2, 2))]
    for part in _missing(task, strips):
        box = outline(part.minimum_rotated_rectangle)
        sides = box[:, 2:] - box[:, :2]
        way = units(sides[np.argmax(np.hypot(sides[:, 0], sides[:, 1]))][None])[0]
        lines = lines_across(task, outline(part), way)
        out.append(turned_back(upright(lines[lines[:, 2] - lines[:, 1] > SWEEP_CONTACT]), way))
    return np.concatenate(out)


def border_strips(task: SweepTask, strips: Floats, edges: Floats) -> Floats:
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


def _missing(task: SweepTask, strips: Floats) -> Any:
    """Return the parts of what may be flown over that strips leave open and that are not small."""
    if callable(task.width):
        return np.empty(0, dtype=object)
    half = 0.5 * task.width
    caps: Any = "flat" if task.ends == "line" else "round"
    swaths = shapely.buffer(shapely.linestrings(_reaching(task, strips)), half, cap_style=caps)
    seen = shapely.union_all(swaths, grid_size=SWEEP_CONTACT)
    missing = shapely.get_parts(task.flown.difference(seen))
    return missing[shapely.area(missing) > LEFT_OPEN * half**2]


def _reaching(task: SweepTask, strips: Floats) -> Floats:
    """Return strips from where to where they see."""
    legs = strips[:, 1] - strips[:, 0]
    on = task.reach * legs / np.hypot(legs[:, 0], legs[:, 1])[:, None]
    return np.stack([strips[:, 0] - on, strips[:, 1] + on], 1)
