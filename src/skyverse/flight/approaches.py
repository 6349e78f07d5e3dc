"""How near UAVs come to movers, as both really moved."""

import numpy as np

from skyverse._typing import Floats
from skyverse.model.flight_record import Flown
from skyverse.model.mover import Ellipsoid, Mover
from skyverse.model.replanned_flight import Approach
from skyverse.model.scenario import Scenario
from skyverse.model.seconds import told_instant
from skyverse.model.shapes import Box, Cylinder, Sphere
from skyverse.model.verdict import Fault, Violation


def approaches(truth: Scenario, flown: tuple[Flown | None, ...]) -> tuple[Approach, ...]:
    """Return each UAV and mover when they were nearest to each other, by the samples of the flight."""
    found = []
    for one in flown:
        if one is None:
            continue
        for number, mover in enumerate(truth.movers):
            away = distances(mover, one.times, one.positions)
            k = int(np.argmin(away))
            found.append(Approach(one.uav, number, float(one.times[k]), float(away[k])))
    return tuple(found)


def too_near(
    truth: Scenario, flown: tuple[Flown | None, ...], near: tuple[Approach, ...], margin: float
) -> list[Violation]:
    """Return the violations of UAVs that came nearer to movers than the clearance less the margin, or touched them."""
    wrong, left = [], truth.clearance - margin
    for one in near:
        if one.distance > 0 and one.distance >= left:
            continue
        name, whom = truth.uavs[one.uav].name, f"mover {truth.movers[one.mover].name!r}"
        how = f"touches {whom}" if one.distance <= 0 else f"comes within {one.distance:.3f} m of {whom}"
        message = f"{name} {how} {told_instant(one.time)}; {left:.3g} m must be left"
        record = flown[one.uav]
        assert record is not None
        x, y, z = record.positions[int(np.searchsorted(record.times, one.time))].tolist()
        wrong.append(Violation(Fault.MOVER, (one.uav,), message, one.time, (x, y, z)))
    return wrong


def distances(mover: Mover, times: Floats, places: Floats) -> Floats:
    """Return how far places (m, 3) are from a mover at instants (m,), metres, 0 or less inside.

    The distance is Euclidean; from an ellipsoid it is a lower bound, which is 0 exactly on its surface.
    """
    off = places - mover.at(times)
    match mover.shape:
        case Box(min=low, max=high):
            return _from_box(np.maximum(low - off, off - high))
        case Cylinder(centre=centre, radius=radius, low=bottom, high=top):
            aside = np.hypot(off[:, 0] - centre[0], off[:, 1] - centre[1]) - radius
            return _from_box(np.column_stack([aside, np.maximum(bottom - off[:, 2], off[:, 2] - top)]))
        case Sphere(centre=middle, radius=radius):
            away: Floats = np.linalg.norm(off - middle, axis=1) - radius
            return away
        case Ellipsoid(centre=middle, semi_axis_xy=across, semi_axis_z=up):
            scaled: Floats = np.linalg.norm((off - middle) / (across, across, up), axis=1) - 1.0
            return scaled * min(across, up)


def _from_box(beyond: Floats) -> Floats:
    """Return distances from what is beyond each face (m, k), metres, below 0 where inside of all of them."""
    outside: Floats = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    inside: Floats = np.minimum(beyond.max(axis=1), 0.0)
    return outside + inside
