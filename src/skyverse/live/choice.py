"""What is chosen for a UAV to fly from now on, and the instants that matter for that."""

from typing import NamedTuple


class Span(NamedTuple):
    """The instants that matter, seconds into the mission.

    Attributes
    ----------
    now, join
        Now, and when a new motion can begin.
    until
        Until when it is proven.
    apart
        Until when it is proven to keep its distance from other UAVs, no earlier than `until`.
    """

    now: float
    join: float
    until: float
    apart: float


class Choice(NamedTuple):
    """What is known of the motion that was chosen.

    Attributes
    ----------
    kept, proven
        Whether it is what was flown before, and whether it is proven up to the horizon.
    mover, contact
        The mover that it comes too near to first, -1 if none, and when, infinite if never, up to the horizon.
    tried
        How many motions were made.
    """

    kept: bool
    proven: bool
    mover: int
    contact: float
    tried: int
