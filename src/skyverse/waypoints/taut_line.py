"""The shortest line between two heights that keeps between a lower and an upper limit along its way."""

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats


def taut_line(along: Floats, low: Floats, high: Floats, begin: float, end: float) -> list[tuple[float, float]]:
    """Return the bends of the shortest line in a corridor, (distance, height) each, its ends included.

    Parameters
    ----------
    along
        (n,) metres, increasing: where the limits are known.
    low, high
        (n,) metres: the limits there, of which none is above the other.
    begin, end
        The heights of the line's ends, which lie between the limits.

    Notes
    -----
    Gates are passed one by one with a funnel whose sides are the taut lines to the lower and to the upper end of the
    last gate (Lee and Preparata, Euclidean shortest paths in the presence of rectilinear barriers, Networks, 1984).
    """
    apex = (float(along[0]), begin)
    line, lower, upper = [apex], deque[tuple[float, float]](), deque[tuple[float, float]]()
    gates = [(float(s), float(a), float(b)) for s, a, b in zip(along[1:-1], low[1:-1], high[1:-1], strict=True)]
    for s, a, b in [*gates, (float(along[-1]), end, end)]:
        for side, other, point, sign in ((lower, upper, (s, a), 1.0), (upper, lower, (s, b), -1.0)):
            while side and _turn(side[-2] if len(side) > 1 else line[-1], side[-1], point) * sign >= 0:
                side.pop()
            if not side:  # the new side may cross the other one: then the other's bends belong to the line
                while other and _turn(line[-1], other[0], point) * sign > 0:
                    line.append(other.popleft())
            side.append(point)
    rest = list(lower)
    return [*line, *rest]


def with_fewer_bends(
    line: Sequence[tuple[float, float]], along: Floats, high: Floats, longer: float
) -> list[tuple[float, float]]:
    """Return a line above another one with fewer bends: neighbours upwards become one where the legs beside them meet.

    Parameters
    ----------
    line
        Its bends, (distance, height) each.
    along, high
        (n,) metres: where the upper limits are known, and these.
    longer
        Metres by which the line may become longer.
    """
    bends = list(line)
    while True:
        found: list[tuple[float, int, tuple[float, float]]] = []
        for k in range(1, len(bends) - 2):
            a, b, c, d = bends[k - 1 : k + 3]
            if max(_turn(a, b, c), _turn(b, c, d)) >= 0:
                continue
            up, down = (b[1] - a[1]) / (b[0] - a[0]), (d[1] - c[1]) / (d[0] - c[0])
            s = (c[1] - b[1] + up * b[0] - down * c[0]) / (up - down)
            met = (s, b[1] + up * (s - b[0]))
            between = (along >= b[0]) & (along <= c[0])
            line_there = np.interp(along[between], *np.transpose([b, met, c]))
            if met[1] <= np.interp(s, along, high) and (line_there <= high[between]).all():
                found.append((math.dist(b, met) + math.dist(met, c) - math.dist(b, c), k, met))
        more, k, met = min(found, default=(math.inf, 0, (0.0, 0.0)))
        if more > longer:
            return bends
        longer -= more
        bends[k : k + 2] = [met]


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """Return above 0 where the way from a over b to c bends to the left, that is upwards."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
