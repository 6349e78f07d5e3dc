"""Judges whether UAVs stay clear of zones that must not be entered while they are active, at every instant.

Each zone is grown by the clearance, as an obstacle is. Only those parts of a UAV's motion are judged, waiting and
standing included, that are flown while the zone is active.
"""

from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.temporary_zones import is_closed_at_times, told_zone
from skyverse.model.uav import TrackingError
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.active_parts import active_parts, restricted, restriction_error
from skyverse.referee.boxes import grown_boxes
from skyverse.referee.closed_above import solid_shapes
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.fleet_motion import FleetMotion, fleet_motion
from skyverse.referee.movers import JudgedFlights
from skyverse.referee.positions import position_text, position_tuple
from skyverse.referee.prisms import grown_prisms
from skyverse.referee.round_solids import grown_cylinders, grown_spheres
from skyverse.referee.solids import GrownSolids
from skyverse.referee.subdivision import find_peaks
from skyverse.referee.tube import named


def judge_temporary_zones(
    scenario: Scenario, curves: Sequence[PolynomialCurve | None], unknown: set[int]
) -> JudgedFlights:
    """Judge every UAV whose motion is known among all zones, from 0 s until a second after the last arrival.

    The parameters are those of `judge_movers`. A UAV has one violation at most.
    """
    violations: list[list[Violation]] = [[] for _ in scenario.uavs]
    halvings = [0] * len(scenario.uavs)
    closed = [number for number, zone in enumerate(scenario.zones) if is_closed_at_times(zone)]
    if not closed or len(unknown) == len(scenario.uavs):
        return JudgedFlights(tuple(violations), tuple(halvings))
    motion = fleet_motion(scenario, curves, unknown)
    for k, uav in enumerate(motion.uavs):
        for kind in _solids(scenario, closed, scenario.uavs[uav].tracking_error):
            violation, cuts = _judge(scenario, uav, motion, k, kind, closed)
            halvings[uav] += cuts
            violations[uav] += [] if violation is None else [violation]
        violations[uav] = sorted(violations[uav], key=lambda one: one.fault is Fault.UNDECIDED)[:1]
    return JudgedFlights(tuple(violations), tuple(halvings))


def _solids(scenario: Scenario, closed: list[int], error: TrackingError) -> tuple[GrownSolids, ...]:
    """Return the zones numbered, grown by the clearance and the tracking error, one entry for each kind of shape."""
    given = derived(scenario, obstacles=tuple(scenario.zones[number] for number in closed))
    shapes = solid_shapes(given)
    kinds: list[GrownSolids] = [make(shapes, error) for make in (grown_cylinders, grown_spheres, grown_prisms)]
    return tuple(kind for kind in (grown_boxes(shapes, error), *kinds) if len(kind.obstacle))


def _judge(
    scenario: Scenario, uav: int, motion: FleetMotion, k: int, kind: GrownSolids, closed: list[int]
) -> tuple[Violation | None, int]:
    """Return what is wrong with a UAV, number `k` in the motion, among zones of one kind, and how often it was cut."""
    knots = motion.knots[k]
    position = motion.positions_between(k, knots)
    b = np.stack([axis.b for axis in position], axis=2)
    wrong = kind.error(b, np.max([axis.error for axis in position], axis=0))
    pairs = kind.tree.overlapping(b.min(axis=1) - wrong[:, None], b.max(axis=1) + wrong[:, None])
    piece, shape = np.concatenate([np.zeros((0, 2), dtype=np.intp), *pairs]).T
    zones = [scenario.zones[number] for number in closed]
    parts = active_parts(knots, piece, kind.obstacle[shape], zones)
    if not len(parts.pair):
        return None, 0
    piece, shape = piece[parts.pair], shape[parts.pair]

    def depth(part: Floats, row: Indices) -> Floats:
        return kind.depth(part, shape[row])

    whole = b[piece]
    peaks = find_peaks(restricted(whole, parts.begin, parts.end), wrong[piece] + restriction_error(whole), depth)
    if peaks.proven[0]:
        return None, int(peaks.halvings[0])
    row, share = peaks.place()
    share = float(parts.begin[row] + share * (parts.end[row] - parts.begin[row]))
    time = float(knots[piece[row]] + share * (knots[piece[row] + 1] - knots[piece[row]]))
    at = motion.shifted(motion.piece(k, np.array([time])), np.array([time]))[0, 0]
    vehicle, which = scenario.uavs[uav], int(shape[row])
    zone = told_zone(scenario, closed[int(kind.obstacle[which])])
    where = f"at t = {time:.6g} s, position {position_text(at)}"
    if peaks.refuted[0] and kind.depth(at[None, None], np.array([which]))[0] > 0:
        gap = kind.gap(at, which) - vehicle.tracking_error.horizontal
        deed = f"comes within {gap:.6g} m of {zone}" if gap >= 0 else f"is {-gap:.6g} m inside {zone}"
        who = named(vehicle.name, vehicle.tracking_error)
        message = f"{who} {deed} {where}; {scenario.clearance:.6g} m are required."
        return Violation(Fault.ACTIVE_ZONE, (uav,), message, time, position_tuple(at)), int(peaks.halvings[0])
    message = f"Whether {vehicle.name} keeps clear of {zone} could not be decided {where}."
    return Violation(Fault.UNDECIDED, (uav,), message, time, position_tuple(at)), int(peaks.halvings[0])
