"""Questions about one box: ``boxes`` is (n, 6) metres, min corner then max corner, not yet grown.

`solids` answers the same questions about other shapes, `tree` about all boxes.
"""

import math
from typing import NamedTuple

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner_query, query
from skyverse.numerics.tolerances import NO_EXTENT, SURFACE_DEPTH


@query
def holds(boxes: Floats, i: int, growth: float, x: float, y: float, z: float) -> bool:
    """Tell whether the interior of box i, grown by `growth`, holds the point."""
    margin = growth - SURFACE_DEPTH
    return (
        boxes[i, 0] - margin < x < boxes[i, 3] + margin
        and boxes[i, 1] - margin < y < boxes[i, 4] + margin
        and boxes[i, 2] - margin < z < boxes[i, 5] + margin
    )


@inner_query
def touches(boxes: Floats, i: int, growth: float, low: Floats, high: Floats) -> bool:
    """Tell whether box i, grown by `growth`, touches the closed box between two corners."""
    meet = True
    for axis in range(3):
        meet &= boxes[i, axis] - growth <= high[axis] and boxes[i, axis + 3] + growth >= low[axis]
    return meet


@inner_query
def reaches(boxes: Floats, i: int, growth: float, low: Floats, high: Floats) -> bool:
    """Tell whether the interior of box i, grown by `growth`, reaches into the open box between two corners."""
    margin = growth - SURFACE_DEPTH
    meet = True
    for axis in range(3):
        meet &= boxes[i, axis] - margin < high[axis] and boxes[i, axis + 3] + margin > low[axis]
    return meet


class Ray(NamedTuple):
    """A segment prepared for slab tests: where it begins, and 1 over its extent on each axis, or 0 for no extent."""

    x: float
    y: float
    z: float
    per_x: float
    per_y: float
    per_z: float


@query
def ray(a: Floats, b: Floats) -> Ray:
    """Prepare the segment from a to b."""
    dx, dy, dz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    return Ray(
        a[0],
        a[1],
        a[2],
        1.0 / dx if abs(dx) > NO_EXTENT else 0.0,
        1.0 / dy if abs(dy) > NO_EXTENT else 0.0,
        1.0 / dz if abs(dz) > NO_EXTENT else 0.0,
    )


@query
def meets(boxes: Floats, i: int, growth: float, r: Ray) -> bool:
    """Tell whether a segment meets the interior of box i, grown by `growth` (slab method, exact)."""
    margin = growth - SURFACE_DEPTH
    enter, leave = _between(boxes[i, 0] - margin, boxes[i, 3] + margin, r.x, r.per_x, 0.0, 1.0)
    enter, leave = _between(boxes[i, 1] - margin, boxes[i, 4] + margin, r.y, r.per_y, enter, leave)
    enter, leave = _between(boxes[i, 2] - margin, boxes[i, 5] + margin, r.z, r.per_z, enter, leave)
    return enter < leave or (enter == leave and holds(boxes, i, growth, r.x, r.y, r.z))


@inner_query
def _between(low: float, high: float, a: float, per: float, enter: float, leave: float) -> tuple[float, float]:
    """Narrow a segment's shares to those in this open slab; where none are left, the first is the greater one."""
    if per == 0.0:
        return (enter, leave) if low < a < high else (1.0, -1.0)
    t1, t2 = (low - a) * per, (high - a) * per
    return max(enter, min(t1, t2)), min(leave, max(t1, t2))


@query
def gap(boxes: Floats, i: int, x: float, y: float, z: float) -> float:
    """Return the Euclidean distance to box i as given, negative inside."""
    dx = max(boxes[i, 0] - x, x - boxes[i, 3])
    dy = max(boxes[i, 1] - y, y - boxes[i, 4])
    dz = max(boxes[i, 2] - z, z - boxes[i, 5])
    outside = math.sqrt(max(dx, 0.0) ** 2 + max(dy, 0.0) ** 2 + max(dz, 0.0) ** 2)
    return outside if outside > 0.0 else max(dx, dy, dz)
