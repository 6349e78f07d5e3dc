"""The plane cut along one direction: cross-sections between corners, cells of them, and the fewest lines that cover.

All is done in a frame that is turned so that lines run along y; x is across. Between two corners of the outline the
cross-sections of an area keep their shape, so an area is a graph of slabs of cross-sections. A line flown at x covers
the cross-sections that are connected to its own within half a width; lines are placed as late as that allows.
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import SWEEP_CONTACT


class CrossSections(NamedTuple):
    """The slabs of an area between its corners, in the turned frame.

    Attributes
    ----------
    edges
        Outline (n, 4) as x0, y0, x1, y1 with x0 < x1, metres.
    x
        Where slabs begin and end (m + 1,), metres.
    first
        The number of the first cross-section of each slab (m + 1,).
    low, high
        The edges below and above each cross-section.
    """

    edges: Floats
    x: Floats
    first: Ints
    low: Ints
    high: Ints


@kernel
def turned(edges: Floats, ux: float, uy: float) -> Floats:
    """Return edges (n, 4) in the frame whose y runs along a direction, ordered by x0 < x1; upright ones are left out.

    x is across to the right of the direction.
    """
    out = np.empty_like(edges)
    count = 0
    for e in range(len(edges)):
        x0, y0 = edges[e, 0] * uy - edges[e, 1] * ux, edges[e, 0] * ux + edges[e, 1] * uy
        x1, y1 = edges[e, 2] * uy - edges[e, 3] * ux, edges[e, 2] * ux + edges[e, 3] * uy
        if abs(x1 - x0) > SWEEP_CONTACT:
            swap = x0 > x1
            out[count, 0], out[count, 1] = (x1, y1) if swap else (x0, y0)
            out[count, 2], out[count, 3] = (x0, y0) if swap else (x1, y1)
            count += 1
    return out[np.argsort(out[:count, 0].copy())]


def turned_back(points: Floats, direction: Floats) -> Floats:
    """Return points (..., 2) of the turned frame in the plane."""
    ux, uy = direction
    return np.stack([points[..., 0] * uy + points[..., 1] * ux, points[..., 1] * uy - points[..., 0] * ux], -1)


@kernel
def cross_sections(edges: Floats) -> CrossSections:
    """Cut the area that turned edges enclose (even-odd) into slabs between its corners."""
    corners = np.sort(edges[:, ::2].copy().ravel())
    x = np.zeros(max(len(corners), 1))
    count = 0
    for corner in corners:
        if count == 0 or corner - x[count - 1] > SWEEP_CONTACT:
            x[count] = corner
            count += 1
    x = x[: max(count, 1)].copy()
    first, low, high = _sections(edges, x)
    return CrossSections(edges, x, first, low, high)


def lines_at(edges: Floats, x: Floats) -> Floats:
    """Return the lines (k, 3) at given x inside turned edges (even-odd), as x, y0, y1."""
    x = np.asarray(x, dtype=float)
    crossed = (edges[:, 0] <= x[:, None]) & (edges[:, 2] > x[:, None])
    slope = (edges[:, 3] - edges[:, 1]) / (edges[:, 2] - edges[:, 0])
    y = np.sort(np.where(crossed, edges[:, 1] + (x[:, None] - edges[:, 0]) * slope, np.inf), axis=1)
    y = y[:, : 2 * (int(crossed.sum(axis=1).max(initial=0)) // 2)].reshape(len(x), -1, 2)
    at, piece = np.nonzero(np.isfinite(y[..., 1]) & (y[..., 1] > y[..., 0] + SWEEP_CONTACT))
    return np.column_stack([x[at], y[at, piece]])


@inner
def _sections(edges: Floats, x: Floats) -> tuple[Ints, Ints, Ints]:
    """Return the first cross-section of each slab, and the edges below and above each."""
    n, slabs = len(edges), len(x) - 1
    first = np.zeros(slabs + 1, dtype=np.int64)
    low, high = np.empty(4 * n + 4, dtype=np.int64), np.empty(4 * n + 4, dtype=np.int64)
    active, height = np.empty(n, dtype=np.int64), np.empty(n)
    waiting = np.empty(n, dtype=np.int64)
    begun, alive, count = 0, 0, 0
    for k in range(slabs):
        middle = 0.5 * (x[k] + x[k + 1])
        while begun < n and edges[begun, 0] < middle:
            waiting[alive] = begun
            alive += 1
            begun += 1
        kept = 0
        for a in range(alive):  # those that still cross the slab, ordered by height
            e = waiting[a]
            if edges[e, 2] <= middle:
                continue
            waiting[kept] = e
            y = _y_at(edges, e, middle)
            b = kept
            while b > 0 and height[b - 1] > y:
                height[b], active[b] = height[b - 1], active[b - 1]
                b -= 1
            height[b], active[b] = y, e
            kept += 1
        alive = kept
        if count + kept > len(low):
            low, high = _longer(low), _longer(high)
        for a in range(0, kept - 1, 2):
            if height[a + 1] - height[a] <= SWEEP_CONTACT:
                continue
            if count > first[k] and height[a] - _y_at(edges, high[count - 1], middle) <= SWEEP_CONTACT:
                high[count - 1] = active[a + 1]
            else:
                low[count], high[count] = active[a], active[a + 1]
                count += 1
        first[k + 1] = count
    return first, low[:count].copy(), high[:count].copy()


@inner
def _longer(array: Ints) -> Ints:
    out = np.empty(2 * len(array) + 16, dtype=np.int64)
    out[: len(array)] = array
    return out


@inner
def _y_at(edges: Floats, e: int, x: float) -> float:
    x0, y0, x1, y1 = edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3]
    return y0 + (y1 - y0) * min(max((x - x0) / (x1 - x0), 0.0), 1.0)


@inner
def _shared(edges: Floats, low: Ints, high: Ints, i: int, j: int, x: float) -> float:
    """Return the length that two cross-sections of neighbouring slabs share at x."""
    top = min(_y_at(edges, high[i], x), _y_at(edges, high[j], x))
    return top - max(_y_at(edges, low[i], x), _y_at(edges, low[j], x))


@kernel
def number_cells(sections: CrossSections) -> Ints:
    """Return the boustrophedon cell of each cross-section: one goes on for as long as nothing splits or meets."""
    edges, x, first, low, high = sections
    cell = np.full(len(low), -1, dtype=np.int64)
    cells = 0
    for k in range(len(x) - 1):
        for j in range(first[k], first[k + 1]):
            before, single = 0, -1
            if k > 0:
                for i in range(first[k - 1], first[k]):
                    if _shared(edges, low, high, i, j, x[k]) > SWEEP_CONTACT:
                        before, single = before + 1, i
            if before == 1:
                after = 0
                for other in range(first[k], first[k + 1]):
                    after += _shared(edges, low, high, single, other, x[k]) > SWEEP_CONTACT
                if after == 1:
                    cell[j] = cell[single]
            if cell[j] < 0:
                cell[j] = cells
                cells += 1
    return cell


@kernel
def cover_lines(sections: CrossSections, half: float, terms: tuple[float, float, float]) -> Floats:
    """Return few lines (k, 3) as x, y0, y1 whose swaths of half a width to both sides cover an area.

    Along each chain of cross-sections a line is placed as late as what lies behind lets it. Where a chain splits, ends
    or meets another, a line may stand at that very corner instead, if that saves time: a metre that is covered later
    costs what its lines cost on average. A line of length l costs ``terms[0] * l + terms[1]`` seconds, and a hop of
    ``terms[2]`` seconds to the next one.
    """
    return _cover(sections, half, terms)[:, :3].copy()


@kernel
def price_lines(
    outline: Floats, direction: tuple[float, float], half: float, terms: tuple[float, float, float], least: float
) -> float:
    """Return about how many seconds it takes to cover an outline by lines along a direction.

    That includes strips along borders that lines meet at such a slant that they leave more than `least` m2 open.
    """
    sections = cross_sections(turned(outline, direction[0], direction[1]))
    lines = _cover(sections, half, terms)
    edges = sections.edges
    from_x, to_x = np.full(len(edges), np.inf), np.full(len(edges), -np.inf)
    seconds = 0.0
    for i in range(len(lines)):
        seconds += _seconds(lines[i, 2] - lines[i, 1], terms)
        for side in range(3, 5):
            e = int(lines[i, side])
            from_x[e], to_x[e] = min(from_x[e], lines[i, 0]), max(to_x[e], lines[i, 0])
    for e in range(len(edges)):
        dx, dy = edges[e, 2] - edges[e, 0], abs(edges[e, 3] - edges[e, 1])
        if to_x[e] > -np.inf and 0.5 * dy / dx * min(half, dx) ** 2 > least:
            reach = min(edges[e, 2], to_x[e] + half) - max(edges[e, 0], from_x[e] - half)
            seconds += _seconds(reach * np.hypot(dx, dy) / dx, terms)
    return seconds


@inner
def _seconds(length: float, terms: tuple[float, float, float]) -> float:
    slope, ramp, hop = terms
    if length * slope < ramp:
        return 2.0 * np.sqrt(length * slope * ramp) + hop
    return length * slope + ramp + hop


@inner
def _cover(sections: CrossSections, half: float, terms: tuple[float, float, float]) -> Floats:
    """Return what `cover_lines` does, and the edges below and above each line, as rows (k, 5)."""
    edges, x, first, low, high = sections
    slope, fixed = terms[0], terms[1] + terms[2]
    open_from = np.empty(len(low))
    out = np.empty((64, 5))
    count = 0
    for k in range(len(x) - 1):
        begin, end = x[k], x[k + 1]
        for j in range(first[k], first[k + 1]):  # what is uncovered goes on from the slab before
            start, shared = np.inf, 0.0
            if k > 0:
                for i in range(first[k - 1], first[k]):
                    common = _shared(edges, low, high, i, j, begin)
                    if common > SWEEP_CONTACT:
                        start, shared = min(start, open_from[i]), shared + common
            length = _length(edges, low[j], high[j], begin)
            wall = length - shared
            if shared == 0.0 or (
                (start - begin) * wall > spared(half)
                and (start - begin) * (slope * length + fixed) < 2 * half * (slope * wall + fixed)
            ):
                start = begin  # nothing has passed along what lies behind a wall that ends here
            while start + half <= end:
                place = max(start + half, begin)
                out, count = _put(out, count, edges, low[j], high[j], place)
                start = place + half
            open_from[j] = start
        for i in range(first[k], first[k + 1]):  # corners at the slab's end
            if open_from[i] >= end - SWEEP_CONTACT:
                continue
            length = _length(edges, low[i], high[i], end)
            shared, branches, rate, meets = 0.0, 0, 0.0, -1
            if k + 2 < len(x):
                for j in range(first[k + 1], first[k + 2]):
                    common = _shared(edges, low, high, i, j, end)
                    if common > SWEEP_CONTACT:
                        shared, branches, meets = shared + common, branches + 1, j
                        rate += (slope * _length(edges, low[j], high[j], end) + fixed) / (2 * half)
            place, later = np.inf, (open_from[i] + half - end) * rate
            wall = length - shared
            if branches == 0:
                place = max(begin, end - half)
                other = max(begin, 0.5 * (max(open_from[i], begin) + end))
                if _length(edges, low[i], high[i], other) < 0.999 * _length(edges, low[i], high[i], place):
                    place = other
            elif wall * (end - open_from[i]) > spared(half) and later < slope * wall + fixed * branches:
                place = end  # part of it is closed by a wall
            elif branches > 1 and later < fixed * (branches - 1):
                place = end
            elif branches == 1:
                next_open = end + half
                for j in range(first[k], first[k + 1]):
                    if j != i and _shared(edges, low, high, j, meets, end) > SWEEP_CONTACT:
                        next_open = min(next_open, open_from[j])
                if next_open < end + half and (next_open - open_from[i]) * rate > slope * length + fixed:
                    place = end
            if place < np.inf:
                out, count = _put(out, count, edges, low[i], high[i], place)
                open_from[i] = place + half
    return out[:count].copy()


@inner
def spared(half: float) -> float:
    """Return the area beside a line's end that may stay open, m2: the triangle at a border that is 45 degrees off."""
    return 0.5 * half * half


@inner
def _length(edges: Floats, low: int, high: int, x: float) -> float:
    return _y_at(edges, high, x) - _y_at(edges, low, x)


@inner
def _put(out: Floats, count: int, edges: Floats, low: int, high: int, x: float) -> tuple[Floats, int]:
    if count == len(out):
        longer = np.empty((2 * count, 5))
        longer[:count] = out
        out = longer
    out[count, 0], out[count, 1], out[count, 2] = x, _y_at(edges, low, x), _y_at(edges, high, x)
    out[count, 3], out[count, 4] = low, high
    return out, count + 1
