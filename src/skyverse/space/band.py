"""How far outside a band of heights above ground a segment is on average, exactly."""

import math

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner_query
from skyverse.space.ground import Ground, bilinear


@inner_query
def outside(ground: Ground, low: float, high: float, a: Floats, b: Floats) -> float:
    """Return the mean over the segment a-b of the metres that its height above ground is outside low to high.

    Over each cell of the ground, with the share s of the segment's part in it, the height above ground is

        begin + (end - begin - curved) s + curved s^2,   curved = -twist du dv

    where `twist` is the cell's mixed difference of heights and du, dv are the part's extents in steps. Beyond the
    terrain, its outermost cells are continued.
    """
    u, v = (a[0] - ground.origin[0]) / ground.step[0], (a[1] - ground.origin[1]) / ground.step[1]
    du, dv = (b[0] - a[0]) / ground.step[0], (b[1] - a[1]) / ground.step[1]
    rise = b[2] - a[2]
    rows, columns = ground.heights.shape[0] - 1, ground.heights.shape[1] - 1
    h = ground.heights
    row, column = _line_ahead(u, du), _line_ahead(v, dv)
    a_row, a_column = _share_of_a_step(du), _share_of_a_step(dv)
    total = 0.0
    at = 0.0
    begin = math.nan
    while at < 1.0:
        across, along = _reached(row, u, a_row), _reached(column, v, a_column)
        to = min(1.0, min(across, along))
        if across <= to:
            row += 1.0 if du > 0.0 else -1.0
        if along <= to:
            column += 1.0 if dv > 0.0 else -1.0
        if to <= at:
            continue
        middle = (at + to) / 2
        i = min(max(math.floor(u + middle * du), 0), rows - 1)
        j = min(max(math.floor(v + middle * dv), 0), columns - 1)
        twist = h[i, j] + h[i + 1, j + 1] - h[i + 1, j] - h[i, j + 1]
        if at == 0.0:
            begin = a[2] - bilinear(ground, i, j, u - i, v - j)
        end = a[2] + to * rise - bilinear(ground, i, j, u + to * du - i, v + to * dv - j)
        curved = -twist * du * dv * (to - at) ** 2
        slope = end - begin - curved
        under = _mean_above_zero(low - begin, -slope, -curved)
        total += (to - at) * (under + _mean_above_zero(begin - high, slope, curved))
        at, begin = to, end
    return total


@inner_query
def _line_ahead(at: float, d: float) -> float:
    """Return the first line of the terrain's grid ahead of a place, in steps."""
    return math.floor(at) + 1.0 if d > 0.0 else math.ceil(at) - 1.0


@inner_query
def _share_of_a_step(d: float) -> float:
    """Return the share of the segment in which it gets one step further; infinite if it never does."""
    return 1.0 / d if d != 0.0 else math.inf


@inner_query
def _reached(line: float, at: float, share: float) -> float:
    """Return the share of the segment at which it reaches a line of the grid, given its share of a step."""
    return (line - at) * share if share != math.inf else math.inf


@inner_query
def _mean_above_zero(c0: float, c1: float, c2: float) -> float:
    """Return the mean of max(0, c0 + c1 s + c2 s^2) for s from 0 to 1."""
    least = min(c0, c0 + c1 + c2)
    most = max(c0, c0 + c1 + c2)
    if least >= 0.0 and c2 <= 0.0:
        return c0 + c1 / 2 + c2 / 3
    if most <= 0.0 and c2 >= 0.0:
        return 0.0
    one = other = 0.0  # the roots
    square = c1 * c1 - 4.0 * c0 * c2
    if square > 0.0:
        q = -(c1 + math.copysign(math.sqrt(square), c1)) / 2
        one = c0 / q if q != 0.0 else 0.0
        other = q / c2 if abs(q) < 1e12 * abs(c2) else 0.0
    elif c1 != 0.0 and c2 == 0.0:
        one = -c0 / c1
    first, last = min(max(min(one, other), 0.0), 1.0), min(max(max(one, other), 0.0), 1.0)
    total = 0.0
    for part in range(3):
        s, t = (0.0, first) if part == 0 else (first, last) if part == 1 else (last, 1.0)
        m = (s + t) / 2
        if t > s and c0 + m * (c1 + m * c2) > 0.0:
            total += (t - s) * (c0 + m * c1 + c2 * (s * s + s * t + t * t) / 3)
    return total
