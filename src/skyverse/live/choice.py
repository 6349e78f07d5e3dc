"""What is chosen for a UAV to fly from now on, and the instants that matter for that."""

from typing import NamedTuple

LOOKED_AT = 0.5
"""The share of the horizon after which motions are compared by what they still have to fly."""
KEEP_ON = 0.05
"""Seconds by which another way must arrive earlier than the present one, so that a UAV does not waver."""
BLOCKED = 10.0
"""Seconds that it may take longer to arrive along a way in which something stands."""


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
    held_up
        Whether another UAV is in the way of the motion that would arrive first.
    """

    kept: bool
    proven: bool
    mover: int
    contact: float
    tried: int
    held_up: bool = False
