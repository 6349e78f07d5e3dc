"""Where a UAV may be at which time, if its autopilot flies faster or slower than planned."""

from dataclasses import dataclass

from skyverse._typing import Floats


@dataclass(frozen=True, eq=False)
class TimedPath:
    """Straight pieces of a path, with the earliest and the latest time at which a UAV may be on each.

    Along a piece, both times and the deviation change linearly with the share of its length. A piece whose ends are at
    one place is a stay there.

    Attributes
    ----------
    starts, ends
        (n, 3) metres: the ends of each piece.
    earliest, latest
        (n, 2) seconds at the start and at the end of each piece; the latest may be infinite.
    deviation
        (n, 2) metres: how far the UAV may be from the piece at its start and at its end, because it cuts a corner.
    """

    starts: Floats
    ends: Floats
    earliest: Floats
    latest: Floats
    deviation: Floats
