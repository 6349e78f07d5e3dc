"""When a UAV may hover at a place: the safe intervals between the flights that come too near to it."""

import numpy as np

from skyverse._typing import Floats
from skyverse.deconfliction.space_time.near_movers import near_until
from skyverse.deconfliction.space_time.others import Others, leaf_at, too_near
from skyverse.numerics.arrays import order_of
from skyverse.numerics.kernel import inner, inner_query

MOST_SPANS = 512
"""Spans in which flights come too near to one place that are told apart; with more, the place is never safe."""


@inner
def safe_intervals(others: Others, place: Floats, shortest: float) -> Floats:
    """Return the intervals (k, 2), seconds, in which nobody comes too near to a place; the last may be infinite.

    Intervals that are shorter than `shortest` are left out.
    """
    spans = np.empty((MOST_SPANS, 2))
    count = _near_spans(others, place, spans, np.empty(3))
    if count < 0:
        return np.empty((0, 2))
    order = order_of(spans[:count, 0].copy())
    found = np.empty((count + 1, 2))
    kept, now = 0, 0.0
    for k in range(count):
        since, until = spans[order[k], 0], spans[order[k], 1]
        if since - now > shortest:
            found[kept, 0], found[kept, 1] = now, since
            kept += 1
        now = max(now, until)
    if now < np.inf:
        found[kept, 0], found[kept, 1] = now, np.inf
        kept += 1
    return found[:kept]


@inner_query
def _near_spans(others: Others, place: Floats, spans: Floats, moved: Floats) -> int:
    """Write the spans in which anybody comes too near to a place, and return how many there are; -1 if too many."""
    count = 0
    final = len(others.slices) - 1
    for p in range(len(others.base)):
        opened = False
        for s in range(final + 1):
            if not too_near(others, p, others.slices[s, p], place, place):
                continue
            now = s * others.slice_seconds
            until = (s + 1) * others.slice_seconds if s < final else np.inf
            while now < until:
                row, after = leaf_at(others, p, now)
                after = min(after, until)
                if too_near(others, p, others.boxes[row], place, place):
                    if opened and spans[count - 1, 1] >= now:
                        spans[count - 1, 1] = after
                    elif count == MOST_SPANS:
                        return -1
                    else:
                        spans[count, 0], spans[count, 1] = now, after
                        count += 1
                        opened = True
                now = after
    for m in range(len(others.movers.kind)):
        now = 0.0
        while now < others.horizon:
            near, after = near_until(others.movers, m, place, now, 0.0, moved)
            if near and count > 0 and spans[count - 1, 1] == now:
                spans[count - 1, 1] = after
            elif near:
                if count == MOST_SPANS:
                    return -1
                spans[count, 0], spans[count, 1] = now, after
                count += 1
            now = after
    return count
