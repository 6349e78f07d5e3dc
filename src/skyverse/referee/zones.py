"""Judges UAVs among zones at every instant: stays out of those that are closed at times, and keeps their speed limits.

Only those parts of a UAV's motion are judged that are flown while a zone is active. A closed zone is grown by the
clearance, as an obstacle is. In a zone with a speed limit, the depth inside and the excess of the speed may at no
instant both be above zero: the lesser of the two is bounded.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Shape, active_spans
from skyverse.model.temporary_zones import is_closed_at_times, told_zone
from skyverse.model.uav import TrackingError
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.boxes import grown_boxes
from skyverse.referee.curve import PolynomialCurve, derivative
from skyverse.referee.fleet_motion import FleetMotion, fleet_motion
from skyverse.referee.judgement import Judgement, position_text, position_tuple
from skyverse.referee.polynomial import bernstein, squared
from skyverse.referee.prisms import grown_prisms
from skyverse.referee.round_solids import grown_cylinders, grown_spheres
from skyverse.referee.solid_shapes import solid_shapes
from skyverse.referee.solids import GrownSolids
from skyverse.referee.subdivision import Peaks, find_peaks
from skyverse.referee.tolerances import LIMIT_LET_PASS, MACHINE_EPSILON
from skyverse.referee.tube import named


def judge_closed_zones(
    scenario: Scenario, curves: Sequence[PolynomialCurve | None], unknown: set[int]
) -> list[Judgement]:
    """Judge every UAV whose motion is known among all zones, from 0 s until a second after the last arrival.

    The parameters are those of `judge_movers`. A UAV has one violation at most.
    """
    judged = [Judgement([]) for _ in scenario.uavs]
    closed = [number for number, zone in enumerate(scenario.zones) if is_closed_at_times(zone)]
    if not closed or len(unknown) == len(scenario.uavs):
        return judged
    motion = fleet_motion(scenario, curves, unknown)
    for k, uav in enumerate(motion.uavs):
        kinds = _grown(scenario, closed, scenario.uavs[uav].tracking_error, scenario.clearance)
        each = [_judge_closed(scenario, uav, motion, k, kind, closed) for kind in kinds]
        found = sorted((one for some, _ in each for one in some), key=lambda one: one.fault is Fault.UNDECIDED)
        judged[uav] = Judgement(found[:1], sum(halvings for _, halvings in each))
    return judged


def _judge_closed(
    scenario: Scenario, uav: int, motion: FleetMotion, k: int, kind: GrownSolids, closed: list[int]
) -> Judgement:
    """Judge a UAV, number `k` in the motion, among closed zones of one kind of shape."""
    knots = motion.knots[k]
    position = motion.positions_between(k, knots)
    b = np.stack([axis.b for axis in position], axis=2)
    wrong = kind.error(b, np.max([axis.error for axis in position], axis=0))
    worst = _worst_while_active(kind, [scenario.zones[number] for number in closed], knots, b, wrong)
    if worst is None or worst.peaks.proven[0]:
        return Judgement([], 0 if worst is None else int(worst.peaks.halvings[0]))
    time, which = float(knots[worst.piece] + worst.share * (knots[worst.piece + 1] - knots[worst.piece])), worst.shape
    at = motion.shifted(motion.piece(k, np.array([time])), np.array([time]))[0, 0]
    vehicle, zone = scenario.uavs[uav], told_zone(scenario, closed[int(kind.obstacle[which])])
    where = f"at t = {time:.6g} s, position {position_text(at)}"
    fault, message = Fault.UNDECIDED, f"Whether {vehicle.name} keeps clear of {zone} could not be decided {where}."
    if worst.peaks.refuted[0] and kind.depth(at[None, None], np.array([which]))[0] > 0:
        gap = kind.gap(at, which) - vehicle.tracking_error.horizontal
        deed = f"comes within {gap:.6g} m of {zone}" if gap >= 0 else f"is {-gap:.6g} m inside {zone}"
        who = named(vehicle.name, vehicle.tracking_error)
        fault, message = Fault.ACTIVE_ZONE, f"{who} {deed} {where}; {scenario.clearance:.6g} m are required."
    violation = Violation(fault, (uav,), message, time, position_tuple(at))
    return Judgement([violation], int(worst.peaks.halvings[0]))


def judge_zone_speed(scenario: Scenario, uav: int, curve: PolynomialCurve) -> Judgement:
    """Judge whether a UAV's trajectory keeps the speed limits of zones, wherever it may be in one."""
    slow = [number for number, zone in enumerate(scenario.zones) if zone.max_speed is not None]
    if not slow:
        return Judgement([])
    zones = [scenario.zones[number] for number in slow]
    limits = np.array([zone.max_speed for zone in zones], dtype=np.float64)
    vehicle = scenario.uavs[uav]
    name, halvings = named(vehicle.name, vehicle.tracking_error), 0
    undecided: list[Violation] = []
    position = bernstein(curve.pieces, curve.durations)
    speed = squared(bernstein(derivative(curve.pieces), curve.durations))
    degree = max(speed.degree, position[0].degree)
    columns = [*(axis.raised(degree) for axis in position), speed.raised(degree)]
    b = np.stack([column.b for column in columns], axis=2)
    for kind in _grown(scenario, slow, vehicle.tracking_error, 0.0):
        wrong = kind.error(b[:, :, :3], np.max([column.error for column in columns[:3]], axis=0))
        fast = _Fast((limits * (1 + LIMIT_LET_PASS)) ** 2, columns[3].error)
        worst = _worst_while_active(kind, zones, curve.knots, b, wrong, fast)
        halvings += 0 if worst is None else int(worst.peaks.halvings[0])
        if worst is None or worst.peaks.proven[0]:
            continue
        zone = int(kind.obstacle[worst.shape])
        local, told = worst.share * float(curve.durations[worst.piece]), told_zone(scenario, slow[zone])
        motion, time = curve.motion(worst.piece, local), float(curve.knots[worst.piece] + local)
        flown, at = math.hypot(*motion[1]), f"at t = {time:.6g} s, position {position_text(motion[0])}"
        where = time, position_tuple(motion[0])
        inside = kind.depth(motion[None, :1], np.array([worst.shape]))[0] > 0
        if inside and flown > limits[zone] * (1 + LIMIT_LET_PASS):
            message = f"{name} flies {flown:.7g} m/s in {told} (of {limits[zone]:.7g}) {at}."
            return Judgement([Violation(Fault.ZONE_SPEED, (uav,), message, *where)], halvings)
        message = f"Whether {name} keeps the speed limit of {told} could not be decided {at}."
        undecided = [Violation(Fault.UNDECIDED, (uav,), message, *where)]
    return Judgement(undecided, halvings)


def _grown(scenario: Scenario, numbers: list[int], error: TrackingError, clearance: float) -> list[GrownSolids]:
    """Return the zones numbered, grown by a clearance and a tracking error, one entry for each kind of shape."""
    zones = tuple(scenario.zones[number] for number in numbers)
    shapes = solid_shapes(derived(scenario, obstacles=zones, clearance=clearance))
    kinds: list[GrownSolids] = [make(shapes, error) for make in (grown_cylinders, grown_spheres, grown_prisms)]
    return [kind for kind in (grown_boxes(shapes, error), *kinds) if len(kind.obstacle)]


class _Fast(NamedTuple):
    """The squares of the speeds (zones,) that zones allow, and (n,) errors of the squared speeds on pieces."""

    squares: Floats
    error: Floats


class _Worst(NamedTuple):
    """The peaks over all parts of pieces in active zones; the shape, the piece and its share where it is worst."""

    peaks: Peaks
    shape: int
    piece: int
    share: float


def _worst_while_active(
    kind: GrownSolids, zones: Sequence[Shape], knots: Floats, b: Floats, wrong: Floats, fast: _Fast | None = None
) -> _Worst | None:
    """Return where pieces are deepest inside zones of one kind while these are active; ``None`` if none is near any.

    Parameters
    ----------
    kind, zones
        The grown zones, and all zones that their numbers mean.
    knots
        (n + 1,) seconds.
    b, wrong
        (n, degree + 1, 3) Bernstein coefficients of positions, and (n,) bounds on their errors, metres. Where speeds
        are limited, (n, degree + 1, 4), with the squared speed; then the lesser of depth and excess counts.
    fast
        What the speeds are compared with.
    """
    place = b[:, :, :3]
    pairs = kind.tree.overlapping(place.min(axis=1) - wrong[:, None], place.max(axis=1) + wrong[:, None])
    piece, shape = np.concatenate([np.zeros((0, 2), dtype=np.intp), *pairs]).T
    parts = active_parts(knots, piece, kind.obstacle[shape], zones)
    if not len(parts.pair):
        return None
    piece, shape = piece[parts.pair], shape[parts.pair]
    rows = b[piece]
    error = wrong[piece] + restriction_error(rows[:, :, :3])
    top = np.full(len(rows), np.inf)
    if fast is not None:
        top = fast.squares[kind.obstacle[shape]]
        error = np.maximum(error, (fast.error[piece] + restriction_error(rows[:, :, 3:])) / top)

    def depth(part: Floats, row: Indices) -> Floats:
        inside = kind.depth(part[:, :, :3], shape[row])
        return inside if fast is None else np.minimum(inside, part[:, :, 3].max(axis=1) / top[row] - 1)

    peaks = find_peaks(restricted(rows, parts.begin, parts.end), error, depth)
    row, share = peaks.place()
    share = float(parts.begin[row] + share * (parts.end[row] - parts.begin[row]))
    return _Worst(peaks, int(shape[row]), int(piece[row]), share)


class ActiveParts(NamedTuple):
    """Parts of pieces, of pairs of a piece and a zone: those in which the zone is active.

    Attributes
    ----------
    pair
        (m,) the number of the pair.
    begin, end
        (m,) the shares of the piece between which the part lies.
    """

    pair: Indices
    begin: Floats
    end: Floats


def active_parts(knots: Floats, piece: Indices, zone: Indices, zones: Sequence[Shape]) -> ActiveParts:
    """Return in which parts of pieces zones are active, made longer by what rounding may take off them.

    Parameters
    ----------
    knots
        (n + 1,) seconds between which the n pieces lie.
    piece, zone
        (k,) pairs of a piece and a zone, by their numbers.
    zones
        The zones; one without active times is always active.
    """
    begins, seconds = knots[:-1][piece], np.diff(knots)[piece]
    slack = 8 * MACHINE_EPSILON * float(np.abs(knots).max(initial=0.0)) / seconds
    found: list[tuple[Indices, Floats, Floats]] = []
    for number in np.unique(zone).tolist():
        own = np.flatnonzero(zone == number)
        for since, until in active_spans(zones[number].active):
            begin = np.clip((since - begins[own]) / seconds[own] - slack[own], 0.0, 1.0)
            end = np.clip((until - begins[own]) / seconds[own] + slack[own], 0.0, 1.0)
            some = begin < end
            found.append((own[some], begin[some], end[some]))
    if not found:
        return ActiveParts(np.zeros(0, dtype=np.intp), np.zeros(0), np.zeros(0))
    return ActiveParts(*(np.concatenate(column) for column in zip(*found, strict=True)))


def restricted(b: Floats, begin: Floats, end: Floats) -> Floats:
    """Return Bernstein coefficients (m, degree + 1, d) on parts of their intervals, by de Casteljau's algorithm.

    Those of the whole interval, from 0 to 1, stay exactly as they are; see `restriction_error`.
    """
    degree = b.shape[1] - 1
    first, last = b.copy(), end[:, None, None]
    rows = b
    for k in range(1, degree + 1):
        rows = rows[:, :-1] * (1.0 - last) + rows[:, 1:] * last
        first[:, k] = rows[:, 0]
    part, share = first.copy(), (begin / end)[:, None, None]
    rows = first
    for k in range(1, degree + 1):
        rows = rows[:, :-1] * (1.0 - share) + rows[:, 1:] * share
        part[:, degree - k] = rows[:, -1]
    return part


def restriction_error(b: Floats) -> Floats:
    """Return bounds (m,) on what rounding adds to coefficients (m, degree + 1, d) when they are restricted."""
    return 8 * b.shape[1] * MACHINE_EPSILON * np.abs(b).max(axis=(1, 2), initial=0.0)
