"""Vertical cylinders as one shape of space: how much of a segment is inside."""

import math

from skyverse.kernel import kernel
from skyverse.result import Floats
from skyverse.space.prism import between


@kernel
def chord(x: float, y: float, radius: float, low: float, high: float, a: Floats, b: Floats) -> float:
    """Return the share, 0 to 1, of the segment a-b that lies inside a cylinder about (x, y)."""
    enter, leave = between(low, high, a, b)
    if enter >= leave:
        return 0.0
    dx, dy = b[0] - a[0], b[1] - a[1]
    ax, ay = a[0] - x, a[1] - y
    squared = dx * dx + dy * dy
    if squared == 0.0:
        return leave - enter if ax * ax + ay * ay < radius * radius else 0.0
    middle = -(ax * dx + ay * dy) / squared
    nx, ny = ax + middle * dx, ay + middle * dy
    half = radius * radius - nx * nx - ny * ny
    if half <= 0.0:
        return 0.0
    half = math.sqrt(half / squared)
    return max(0.0, min(leave, middle + half) - max(enter, middle - half))
