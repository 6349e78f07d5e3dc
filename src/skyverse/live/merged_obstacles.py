"""Obstacles that are reported anew, a little differently each time, as one that holds all that was reported."""

import math
from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.model.quantities import derived
from skyverse.model.shapes import Box, Cylinder, Shape, Sphere

SAME = 0.05
"""Metres by which no number of two reports of one obstacle differs by more."""
_MEASURES: dict[type[Shape], tuple[str, ...]] = {
    Box: ("min", "max"),
    Cylinder: ("centre", "radius", "low", "high"),
    Sphere: ("centre", "radius"),
}


def merged(known: Sequence[Shape], seen: Sequence[Shape]) -> tuple[list[Shape], list[Shape]]:
    """Return the known obstacles that stay as they are, and those that are new, or take the place of known ones."""
    kept, new = list(known), list[Shape]()
    for one in seen:
        same = ((old, around(old, one)) for old in (*kept, *new))
        old, both = next(((old, both) for old, both in same if both is not None), (None, one))
        if both == old:
            continue
        if old in kept:
            kept.remove(old)
        elif old is not None:
            new.remove(old)
        new.append(both)
    return kept, new


def around(known: Shape, seen: Shape) -> Shape | None:
    """Return what holds both of two obstacles if they are so alike that they count as one, else ``None``."""
    measures = _MEASURES.get(type(seen), ())
    if type(known) is not type(seen) or not measures:
        return None
    before, after = _numbers(known, measures), _numbers(seen, measures)
    if np.abs(after - before).max() > SAME:
        return None
    if derived(known, **{name: getattr(seen, name) for name in measures}) != seen:
        return None  # another name, kind or meaning
    low, high = np.minimum(before, after), np.maximum(before, after)
    if isinstance(known, Box):
        return derived(known, min=tuple(low[:3].tolist()), max=tuple(high[3:].tolist()))
    size = 2 if isinstance(known, Cylinder) else 3
    off = math.dist(after[:size], before[:size])
    more = {"radius": max(float(before[size]), float(after[size]) + off)}
    if isinstance(known, Cylinder):
        more |= {"low": float(low[3]), "high": float(high[4])}
    return derived(known, **more)


def _numbers(shape: Shape, measures: Sequence[str]) -> Floats:
    """Return all numbers of a shape, metres."""
    return np.concatenate([np.atleast_1d(np.array(getattr(shape, name), dtype=np.float64)) for name in measures])
