"""Judges at every instant whether a UAV keeps the speed limits of zones.

Where the UAV is inside a zone while that is active, its speed must be within the limit: at no instant then may both the
depth inside the zone and the excess of the speed be above zero. The lesser of the two is bounded on parts of the
trajectory.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Zone
from skyverse.model.temporary_zones import told_zone
from skyverse.model.uav import TrackingError
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.active_parts import active_parts, restricted, restriction_error
from skyverse.referee.boxes import grown_boxes
from skyverse.referee.closed_above import solid_shapes
from skyverse.referee.curve import PolynomialCurve, derivative
from skyverse.referee.polynomial import bernstein, squared
from skyverse.referee.positions import position_text, position_tuple
from skyverse.referee.prisms import grown_prisms
from skyverse.referee.round_solids import grown_cylinders, grown_spheres
from skyverse.referee.solids import GrownSolids
from skyverse.referee.subdivision import find_peaks
from skyverse.referee.tolerances import LIMIT_LET_PASS
from skyverse.referee.tube import EXACT, named


class SpeedZones(NamedTuple):
    """The zones of a scenario that have a speed limit.

    Attributes
    ----------
    names
        What messages call them.
    limits
        (n,) m/s.
    solids
        Their shapes, grown by the tracking error, one entry for each kind.
    zones
        As they are given; the limit of one with active times holds only then.
    """

    names: list[str]
    limits: Floats
    solids: tuple[GrownSolids, ...]
    zones: tuple[Zone, ...]


class JudgedZoneSpeed(NamedTuple):
    """What is wrong or undecided, and how often pieces were cut in two."""

    violation: Violation | None
    halvings: int


def speed_zones(scenario: Scenario, error: TrackingError = EXACT) -> SpeedZones:
    """Return the zones of a scenario that have a speed limit, for a UAV with a tracking error."""
    slow = [(number, zone) for number, zone in enumerate(scenario.zones) if zone.max_speed is not None]
    names = [told_zone(scenario, number) for number, _ in slow]
    given = derived(scenario, obstacles=tuple(zone for _, zone in slow), clearance=0.0)
    shapes = solid_shapes(given)
    kinds: list[GrownSolids] = [make(shapes, error) for make in (grown_cylinders, grown_spheres, grown_prisms)]
    solids = [kind for kind in (grown_boxes(shapes, error), *kinds) if len(kind.obstacle)]
    zoned = tuple(zone for _, zone in slow)
    return SpeedZones(names, np.array([zone.max_speed for zone in zoned]), tuple(solids), zoned)


def judge_zone_speed(scenario: Scenario, uav: int, curve: PolynomialCurve) -> JudgedZoneSpeed:
    """Judge whether a UAV's trajectory keeps the speed limits of zones, wherever it may be in one."""
    if all(zone.max_speed is None for zone in scenario.zones):
        return JudgedZoneSpeed(None, 0)
    vehicle = scenario.uavs[uav]
    name, halvings = named(vehicle.name, vehicle.tracking_error), 0
    zones = speed_zones(scenario, vehicle.tracking_error)
    undecided: Violation | None = None
    for kind in zones.solids:
        position = bernstein(curve.pieces, curve.durations)
        speed = squared(bernstein(derivative(curve.pieces), curve.durations))
        degree = max(speed.degree, position[0].degree)
        columns = [*(axis.raised(degree) for axis in position), speed.raised(degree)]
        b = np.stack([column.b for column in columns], axis=2)
        wrong = kind.error(b[:, :, :3], np.max([column.error for column in columns[:3]], axis=0))
        pairs = kind.tree.overlapping(
            b[:, :, :3].min(axis=1) - wrong[:, None], b[:, :, :3].max(axis=1) + wrong[:, None]
        )
        piece, shape = np.concatenate([np.zeros((0, 2), dtype=np.intp), *pairs]).T
        parts = active_parts(curve.knots, piece, kind.obstacle[shape], zones.zones)
        if not len(parts.pair):
            continue
        piece, shape = piece[parts.pair], shape[parts.pair]
        squares = (zones.limits[kind.obstacle[shape]] * (1 + LIMIT_LET_PASS)) ** 2

        def both(
            part: Floats, pair: Indices, kind: GrownSolids = kind, shape: Indices = shape, squares: Floats = squares
        ) -> Floats:
            excess: Floats = part[:, :, 3].max(axis=1) / squares[pair] - 1
            return np.minimum(kind.depth(part[:, :, :3], shape[pair]), excess)

        rows = b[piece]
        error = np.maximum(
            wrong[piece] + restriction_error(rows[:, :, :3]),
            (columns[3].error[piece] + restriction_error(rows[:, :, 3:])) / squares,
        )
        peaks = find_peaks(restricted(rows, parts.begin, parts.end), error, both)
        halvings += int(peaks.halvings[0])
        if peaks.proven[0]:
            continue
        pair, share = peaks.place()
        k, zone = int(piece[pair]), int(kind.obstacle[shape[pair]])
        share = float(parts.begin[pair] + share * (parts.end[pair] - parts.begin[pair]))
        local = share * float(curve.durations[k])
        motion, time = curve.motion(k, local), float(curve.knots[k] + local)
        flown, at = math.hypot(*motion[1]), f"at t = {time:.6g} s, position {position_text(motion[0])}"
        inside = kind.depth(motion[None, :1], shape[pair : pair + 1])[0] > 0
        if inside and flown > zones.limits[zone] * (1 + LIMIT_LET_PASS):
            deed = f"flies {flown:.7g} m/s in {zones.names[zone]} (of {zones.limits[zone]:.7g})"
            fast = Violation(Fault.ZONE_SPEED, (uav,), f"{name} {deed} {at}.", time, position_tuple(motion[0]))
            return JudgedZoneSpeed(fast, halvings)
        message = f"Whether {name} keeps the speed limit of {zones.names[zone]} could not be decided {at}."
        undecided = Violation(Fault.UNDECIDED, (uav,), message, time, position_tuple(motion[0]))
    return JudgedZoneSpeed(undecided, halvings)
