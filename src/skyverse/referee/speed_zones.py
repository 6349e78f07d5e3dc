"""Judges whether UAVs keep the speed limits of zones at every instant, wherever each may be within its tracking error.

In a zone with a speed limit, the depth inside and the excess of the speed may at no instant both be above zero: the
lesser of the two is bounded. A zone with active times counts while it is active.
"""

import math

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import active_spans
from skyverse.model.timed_shapes import told_zone
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.curve import PolynomialCurve, derivative
from skyverse.referee.fleet_motion import FleetMotion
from skyverse.referee.judgement import Judgement, position_text, position_tuple
from skyverse.referee.polynomial import Polynomials, squared
from skyverse.referee.solid_shapes import by_kind
from skyverse.referee.solids import GrownSolids
from skyverse.referee.subdivision import Peaks, find_peaks
from skyverse.referee.tolerances import INSTANT_ROUNDING, LIMIT_LET_PASS
from skyverse.referee.tracking_error import named
from skyverse.referee.world import grown_kinds


def judge_zone_speed(scenario: Scenario, uav: int, curve: PolynomialCurve) -> Judgement:
    """Judge whether a UAV's trajectory keeps the speed limits of zones, wherever it may be in one."""
    slow = [number for number, zone in enumerate(scenario.zones) if zone.max_speed is not None]
    if not slow:
        return Judgement([])
    zones, knots = [scenario.zones[number] for number in slow], curve.knots
    most = np.array([zone.max_speed for zone in zones], dtype=np.float64) * (1 + LIMIT_LET_PASS)
    wider = INSTANT_ROUNDING * float(np.abs(knots).max()) * np.array([-1.0, 1.0])
    spans = [np.array(active_spans(zone.active)) + wider for zone in zones]
    edges = np.unique(np.concatenate([knots, np.clip(np.concatenate(spans).ravel(), knots[0], knots[-1])]))
    active = np.array([((each[:, :1] <= edges[:-1]) & (edges[1:] <= each[:, 1:])).any(axis=0) for each in spans])
    position, velocity = (
        FleetMotion([uav], [knots], [0], knots[:-1], rows).positions_between(0, edges)
        for rows in (curve.pieces, derivative(curve.pieces))
    )
    vehicle, speed = scenario.uavs[uav], squared(velocity)
    name, halvings, undecided = named(vehicle.name, vehicle.tracking_error), 0, list[Violation]()
    boxes, others = grown_kinds(by_kind(enumerate(zones), 0.0), vehicle.tracking_error)
    for kind in (boxes, *others):
        piece, shape = _meetings(kind, position, active)
        if not len(piece):
            continue
        peaks = _peaks(kind, [*position, speed], most[kind.obstacle[shape]] ** 2, piece, shape)
        halvings += int(peaks.halvings[0])
        if peaks.proven[0]:
            continue
        row, share = peaks.place()
        k, which = int(piece[row]), int(shape[row])
        zone, time = int(kind.obstacle[which]), float(edges[k] + share * (edges[k + 1] - edges[k]))
        motion = curve.at(time)
        flown, at = math.hypot(*motion[1]), f"at t = {time:.6g} s, position {position_text(motion[0])}"
        where, told = (time, position_tuple(motion[0])), told_zone(scenario, slow[zone])
        if kind.depth(motion[None, :1], np.array([which]))[0] > 0 and flown > most[zone]:
            message = f"{name} flies {flown:.7g} m/s in {told} (of {zones[zone].max_speed:.7g}) {at}."
            return Judgement([Violation(Fault.ZONE_SPEED, (uav,), message, *where)], halvings)
        message = f"Whether {name} keeps the speed limit of {told} could not be decided {at}."
        undecided = [Violation(Fault.UNDECIDED, (uav,), message, *where)]
    return Judgement(undecided, halvings)


def _meetings(kind: GrownSolids, position: list[Polynomials], active: NDArray[np.bool_]) -> tuple[Indices, Indices]:
    """Return the pairs (m,) of pieces and shapes whose boxes overlap; zones are `active` on pieces, (zones, pieces)."""
    b = np.stack([axis.b for axis in position], axis=2)
    wrong = kind.error(b, np.max([axis.error for axis in position], axis=0))[:, None]
    pairs = kind.tree.overlapping(b.min(axis=1) - wrong, b.max(axis=1) + wrong)
    piece, shape = np.concatenate([np.zeros((0, 2), dtype=np.intp), *pairs]).T
    some = active[kind.obstacle[shape], piece]
    return piece[some], shape[some]


def _peaks(kind: GrownSolids, columns: list[Polynomials], top: Floats, piece: Indices, shape: Indices) -> Peaks:
    """Return where pieces (m,) of x, y, z and the squared speed are deepest inside shapes (m,), above tops (m,)."""
    degree = max(column.degree for column in columns)
    raised = [column.raised(degree) for column in columns]
    b = np.stack([column.b for column in raised], axis=2)[piece]
    error = kind.error(b[:, :, :3], np.max([column.error for column in raised[:3]], axis=0)[piece])

    def depth(part: Floats, row: Indices) -> Floats:
        return np.minimum(kind.depth(part[:, :, :3], shape[row]), part[:, :, 3].max(axis=1) / top[row] - 1)

    return find_peaks(b, np.maximum(error, raised[3].error[piece] / top), depth)
