"""Vertical prisms on simple polygons as one shape of space: how much of a segment is inside."""

from skyverse.kernel import kernel
from skyverse.result import Floats


@kernel
def between(low: float, high: float, a: Floats, b: Floats) -> tuple[float, float]:
    """Return the shares of a segment at which it enters and leaves a slab of altitudes; it misses it if they swap."""
    rise = b[2] - a[2]
    if rise == 0.0:
        return 0.0, 1.0 if low <= a[2] <= high else 0.0
    one, other = (low - a[2]) / rise, (high - a[2]) / rise
    return max(0.0, min(one, other)), min(1.0, max(one, other))


@kernel
def chord(corners: Floats, low: float, high: float, a: Floats, b: Floats) -> float:
    """Return the share, 0 to 1, of the segment a-b that lies inside a prism on the polygon (n, 2).

    A line enters and leaves a simple polygon in turn, and crosses its outline in opposite senses: the signed sum of
    where it does, each clipped to the segment, is what lies inside. Nothing need be sorted.
    """
    enter, leave = between(low, high, a, b)
    if enter >= leave:
        return 0.0
    dx, dy = b[0] - a[0], b[1] - a[1]
    squared = dx * dx + dy * dy
    ray = squared == 0.0  # straight up or down: look along x whether the place is inside
    if ray:
        dx = squared = 1.0
    inside = 0.0
    n = len(corners)
    px, py = corners[n - 1, 0] - a[0], corners[n - 1, 1] - a[1]
    side, along = dx * py - dy * px, (dx * px + dy * py) / squared
    for i in range(n):
        qx, qy = corners[i, 0] - a[0], corners[i, 1] - a[1]
        side_q, along_q = dx * qy - dy * qx, (dx * qx + dy * qy) / squared
        if (side > 0.0) != (side_q > 0.0):
            t = along + (along_q - along) * (side / (side - side_q))
            t = (1.0 if t > 0.0 else 0.0) if ray else min(max(t, enter), leave)
            inside += t if side_q > 0.0 else -t
        side, along = side_q, along_q
    return abs(inside) * (leave - enter) if ray else abs(inside)
