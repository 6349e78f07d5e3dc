"""What changes with time in a scenario, movers and zones with active times, as shapes that are there for a while."""

import math
from collections.abc import Collection
from typing import NamedTuple

from skyverse.model.mover import Doubt
from skyverse.model.mover_motions import MoverMotion, WaypointMotion
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Shape, Voxels, active_spans
from skyverse.model.temporary_zones import is_closed_at_times, temporary_zones
from skyverse.space.voxels import boxes_of


class TimedShape(NamedTuple):
    """A shape that moves, or is there for a while.

    Attributes
    ----------
    shape
        About the moving point.
    motion
        Of that point.
    doubt
        How far it may be from there.
    keep
        Metres that UAVs must keep from it.
    active
        Seconds from which and until which it is there.
    zone
        The number of the zone that it is a part of; -1 for a mover.
    """

    shape: Shape
    motion: MoverMotion
    doubt: Doubt
    keep: float
    active: tuple[float, float] = (-math.inf, math.inf)
    zone: int = -1


STANDING = WaypointMotion(points=((0.0, 0.0, 0.0),), times=(0.0,))
"""The motion of zones: none, about the zero of the frame."""
CERTAIN = Doubt()
"""The doubt of zones: none."""


def timed_shapes(scenario: Scenario, kept: Collection[int] = ()) -> list[TimedShape]:
    """Return a scenario's movers, and its zones with active times, each as if it could not be entered while active.

    Zones whose numbers are in `kept`, which are known to be kept at all times, are left out.
    """
    found = [TimedShape(mover.shape, mover.motion, mover.doubt, scenario.clearance) for mover in scenario.movers]
    for number in temporary_zones(scenario):
        zone = scenario.zones[number]
        keep = scenario.clearance if is_closed_at_times(zone) else 0.0
        parts = boxes_of(zone) if isinstance(zone, Voxels) else (zone,)
        spans = () if number in kept else active_spans(zone.active)
        found += [TimedShape(part, STANDING, CERTAIN, keep, span, number) for span in spans for part in parts]
    return found
