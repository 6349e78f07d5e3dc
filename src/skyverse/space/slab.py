"""Clip a segment to a slab, the space between two parallel planes across an axis."""

from skyverse.numerics.kernel import inner_query


@inner_query
def clip(low: float, high: float, a: float, d: float, enter: float, leave: float) -> tuple[float, float]:
    """Narrow the shares `enter` to `leave` of a segment to those within the closed slab from `low` to `high`.

    The segment begins at `a` and extends by `d` along the slab's axis. Where nothing is left, the first of the returned
    shares is greater than the second.
    """
    if d == 0.0:
        return (enter, leave) if low <= a <= high else (2.0, -1.0)
    one, other = (low - a) / d, (high - a) / d
    return max(enter, min(one, other)), min(leave, max(one, other))
