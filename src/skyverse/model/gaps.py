"""How far a cost is above the best possible one, in per cent."""

import math

SMALLEST_GAP = 1e-9
"""A gap as small as this, as a share of the bound, is rounding and told as none."""


def told_gap(gap: float | None) -> str:
    """Return a gap, a share of the bound, in per cent rounded up: ``2 %``, ``0.1 %``, ``0 %``; ``-`` where unknown.

    A cost below its bound, which the referee refutes, is told with its sign.
    """
    if gap is None or not math.isfinite(gap):
        return "-"
    if abs(gap) <= SMALLEST_GAP:
        return "0 %"
    scale = 1 if gap >= 0.1 else 10
    percent = math.ceil(100 * scale * gap * (1 - SMALLEST_GAP)) / scale if gap > 0 else 100 * gap
    return f"{percent:,.4g} %" if percent < 1000 else f"{percent:,.0f} %"
