"""Judges whether UAVs stay clear of movers, wherever within its doubt each mover may be, at every instant.

The position of a UAV relative to the point of a mover is a polynomial of time between all knots of both. The mover's
shape, in its own frame, is grown by the clearance, and by the doubt of the instant. Where a mover has a top speed, a
UAV is clear if it is clear of either all that the doubt or all that the top speed allows.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats, Indices
from skyverse.model.mover import Doubt, Ellipsoid, Mover
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Box, Cylinder, Shape, Sphere
from skyverse.model.temporary_zones import JUDGED_STAY
from skyverse.model.uav import TrackingError
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.boxes import grown_boxes
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.fleet_motion import FleetMotion, fleet_motion, near_pairs, time_slices
from skyverse.referee.judgement import Judgement, position_text, position_tuple
from skyverse.referee.mover_motion import EnclosedMotion, enclosed_motion
from skyverse.referee.outlines import outlines_of
from skyverse.referee.polynomial import bernstein
from skyverse.referee.round_solids import grown_cylinders, grown_ellipsoids, grown_spheres
from skyverse.referee.solid_shapes import SolidShapes
from skyverse.referee.solids import GrownSolids
from skyverse.referee.subdivision import find_peaks
from skyverse.referee.tolerances import LET_PASS, MOVER_SLACK
from skyverse.referee.tube import named


class MovingFleet(NamedTuple):
    """The motion of all UAVs and, after them, of all movers.

    Attributes
    ----------
    motion
        Of both.
    movers
        Those whose motion is enclosed; the k-th is number ``uavs + k`` in the motion.
    uavs
        How many UAVs there are.
    error
        (p,) metres that each piece of a mover is at most away from its motion; 0 for UAVs.
    """

    motion: FleetMotion
    movers: list[Mover]
    uavs: int
    error: Floats


class SharedIntervals(NamedTuple):
    """Intervals of time in which one UAV and one mover each move along one piece.

    Attributes
    ----------
    mover
        (m,) the mover's number.
    begins, ends
        (m,) seconds.
    b
        (m, degree + 1, 8) Bernstein coefficients: the UAV's position relative to the mover's point, and the doubt;
        then its position relative to where the mover was last seen, and how far the mover may have come from there.
        Without a top speed the last four are the first four. All in metres.
    error
        (m,) bounds on the errors of positions, metres.
    """

    mover: Indices
    begins: Floats
    ends: Floats
    b: Floats
    error: Floats


def judge_movers(
    scenario: Scenario, curves: Sequence[PolynomialCurve | None], unknown: set[int], stay: float = JUDGED_STAY
) -> list[Judgement]:
    """Judge every UAV whose motion is known among all movers, from 0 s until a while after the last arrival.

    Parameters
    ----------
    scenario
        What was given.
    curves
        The motion of each UAV; one without a motion stands at its start.
    unknown
        The UAVs whose motion is not known; they are left out.
    stay
        Seconds for which they must stay clear where they have arrived.
    """
    judged = [Judgement([]) for _ in scenario.uavs]
    if not scenario.movers or len(unknown) == len(scenario.uavs):
        return judged
    own = fleet_motion(scenario, curves, unknown, stay)
    enclosed = [(mover, enclosed_motion(mover.motion, own.end)) for mover in scenario.movers]
    wild = [mover for mover, pieces in enclosed if pieces is None]
    fleet = _with_movers(own, [(mover, pieces) for mover, pieces in enclosed if pieces is not None])
    edges = time_slices(fleet.motion)
    near = _near(scenario, fleet, edges)
    for k, uav in enumerate(own.uavs):
        found, halvings = [_undecided(scenario, uav, mover) for mover in wild], 0
        for which, solids in _kinds(fleet.movers, scenario.clearance, scenario.uavs[uav].tracking_error):
            rows = _rows(fleet, k, near, edges, which)
            among = _judge(scenario, uav, fleet, k, which, rows, solids)
            found, halvings = found + among.violations, halvings + among.halvings
        judged[uav] = Judgement(sorted(found, key=lambda one: one.fault is Fault.UNDECIDED)[:1], halvings)
    return judged


def _with_movers(own: FleetMotion, movers: list[tuple[Mover, EnclosedMotion]]) -> MovingFleet:
    """Return the motion of UAVs and movers as one."""
    degree = max([3, own.pieces.shape[1], *(known.pieces.shape[1] for _, known in movers)])  # that doubts need
    first, count = list(own.first), len(own.pieces)
    for _, known in movers:
        first.append(count)
        count += len(known.pieces)
    pieces = [own.pieces, *(known.pieces for _, known in movers)]
    motion = FleetMotion(
        uavs=list(range(len(own.uavs) + len(movers))),
        knots=[*own.knots, *(known.knots for _, known in movers)],
        first=first,
        begins=np.concatenate([own.begins, *(known.begins for _, known in movers)]),
        pieces=np.concatenate([np.pad(rows, ((0, 0), (0, degree - rows.shape[1]), (0, 0))) for rows in pieces]),
    )
    error = np.concatenate([np.zeros(len(own.pieces)), *(known.error for _, known in movers)])
    return MovingFleet(motion, [mover for mover, _ in movers], len(own.uavs), error)


def _near(scenario: Scenario, fleet: MovingFleet, edges: Floats) -> Indices:
    """Return (m, 3) numbers of UAVs, of movers in the motion, and of slices of time in which they may be near."""
    count = len(fleet.motion.uavs)
    across, above = np.zeros((count, count)), np.zeros((count, count))
    stray = [scenario.uavs[uav].tracking_error for uav in range(len(scenario.uavs))]
    error = max(max(one.horizontal, one.vertical) for one in stray) * 2.0
    for k, mover in enumerate(fleet.movers, fleet.uavs):
        reach = _reach(mover.shape) + float(mover.doubt.at(fleet.motion.end)[0])
        own = slice(fleet.motion.first[k], fleet.motion.first[k] + len(fleet.motion.knots[k]) - 1)
        reach = reach + scenario.clearance + error + MOVER_SLACK + float(fleet.error[own].max())
        scale = 1.0
        if isinstance(mover.shape, Ellipsoid):  # grows in proportion
            axes = mover.shape.semi_axis_xy, mover.shape.semi_axis_z
            scale = max(axes) / min(axes)
        across[: fleet.uavs, k], above[: fleet.uavs, k] = max(reach[:2]) * scale, reach[2] * scale
    return np.concatenate([np.zeros((0, 3), dtype=np.intp), *near_pairs(fleet.motion, edges, across, above)])


def _reach(shape: Shape) -> Floats:
    """Return how far a shape reaches from the zero of its frame along each axis, (3,) metres."""
    match shape:
        case Box():
            return np.abs([shape.min, shape.max]).max(axis=0)
        case Cylinder():
            return np.array([*(np.abs(shape.centre) + shape.radius), max(abs(shape.low), abs(shape.high))])
        case Sphere():
            return np.abs(shape.centre) + shape.radius
        case Ellipsoid():
            return np.abs(shape.centre) + np.array([shape.semi_axis_xy, shape.semi_axis_xy, shape.semi_axis_z])
    raise TypeError(f"a mover cannot be a {type(shape).__name__}")


def _kinds(movers: list[Mover], clearance: float, error: TrackingError) -> Iterator[tuple[Indices, GrownSolids]]:
    """Yield the numbers of the movers of each kind of shape, and their grown shapes in the same order."""
    by_kind: dict[type[Shape], list[int]] = {}
    for k, mover in enumerate(movers):
        by_kind.setdefault(type(mover.shape), []).append(k)
    for kind, numbers in by_kind.items():
        shapes = [movers[k].shape for k in numbers]
        solid = SolidShapes(clearance, {kind: (list(shapes), list(range(len(shapes))))}, outlines_of([]))
        if kind is Box:
            yield np.array(numbers), grown_boxes(solid, error)
        elif kind is Cylinder:
            yield np.array(numbers), grown_cylinders(solid, error)
        elif kind is Sphere:
            yield np.array(numbers), grown_spheres(solid, error)
        else:
            yield np.array(numbers), grown_ellipsoids([s for s in shapes if isinstance(s, Ellipsoid)], clearance, error)


def _rows(fleet: MovingFleet, k: int, near: Indices, edges: Floats, which: Indices) -> SharedIntervals:
    """Return the intervals in which the k-th UAV may be near movers number `which`."""
    motion = fleet.motion
    columns: list[tuple[Indices, Floats, Floats]] = []
    for place, number in enumerate(which):
        j = fleet.uavs + int(number)
        wanted = np.zeros(len(edges), dtype=bool)
        wanted[near[(near[:, 0] == k) & (near[:, 1] == j), 2]] = True
        if not wanted.any():
            continue
        doubt = fleet.movers[number].doubt
        turns = np.clip([doubt.since, doubt.since + doubt.accelerating_for], 0.0, motion.end)
        cuts = np.unique(np.concatenate([motion.knots[k], motion.knots[j], edges, turns]))
        inside = wanted[np.searchsorted(edges, cuts[:-1], side="right") - 1]
        columns.append((np.full(int(inside.sum()), place), cuts[:-1][inside], cuts[1:][inside]))
    if not columns:
        return SharedIntervals(np.zeros(0, dtype=np.intp), np.zeros(0), np.zeros(0), np.zeros((0, 1, 8)), np.zeros(0))
    mover, begins, ends = (np.concatenate(column) for column in zip(*columns, strict=True))
    own = motion.piece(k, begins)
    theirs = np.concatenate(
        [motion.piece(fleet.uavs + int(which[place]), begins[mover == place]) for place in np.unique(mover)]
    )
    relative = motion.difference(own, theirs, begins, ends)
    error = np.max([part.error for part in relative], axis=0) + fleet.error[theirs]
    b = np.empty((len(mover), motion.pieces.shape[1], 8))
    b[:, :, :3] = np.stack([part.b for part in relative], axis=2)
    share = np.linspace(0.0, 1.0, b.shape[1])
    doubts = [fleet.movers[int(which[place])].doubt for place in mover]
    b[:, :, 3] = _quadratic(
        [doubt.at([u, 0.5 * (u + v), v]) for doubt, u, v in zip(doubts, begins, ends, strict=True)], share
    )
    b[:, :, 4:] = b[:, :, :4]
    seen = np.flatnonzero([d.top_speed is not None and u >= d.since for d, u in zip(doubts, begins, strict=True)])
    if len(seen):
        since = np.array([doubts[row].since for row in seen])
        fastest = np.array([doubts[row].top_speed for row in seen], dtype=np.float64)
        radius = np.array([doubts[row].radius for row in seen])
        last = np.array([fleet.movers[int(which[mover[row]])].at(t)[0] for row, t in zip(seen, since, strict=True)])
        position = bernstein(motion.shifted(own[seen], begins[seen]), (ends - begins)[seen])
        rounding = motion.shift_error(own[seen], ends[seen]).max(axis=1)
        error[seen] = np.maximum(error[seen], np.max([part.error for part in position], axis=0) + rounding)
        b[seen, :, 4:7] = np.stack([part.b for part in position], axis=2) - last[:, None]
        instants = np.column_stack([begins, ends])[seen]
        b[seen, :, 7] = _linear(radius[:, None] + fastest[:, None] * (instants - since[:, None]), share)
    return SharedIntervals(mover, begins, ends, b, error)


def _quadratic(values: ArrayLike, share: Floats) -> Floats:
    """Return the Bernstein coefficients (m, n) of quadratic functions by their values (m, 3) at ends and middle."""
    first, middle, last = np.asarray(values, dtype=np.float64).T[:, :, None]
    degree = len(share) - 1
    at_both = share * (1.0 - share) * degree / (degree - 1.0)
    between = 2.0 * middle - 0.5 * (first + last)
    return first * (1.0 - share - at_both) + 2.0 * between * at_both + last * (share - at_both)


def _linear(ends: ArrayLike, share: Floats) -> Floats:
    """Return the Bernstein coefficients (m, n) of linear functions with values (m, 2) at both ends."""
    values = np.asarray(ends, dtype=np.float64)
    return values[:, :1] * (1.0 - share) + values[:, 1:] * share


def _judge(
    scenario: Scenario, uav: int, fleet: MovingFleet, k: int, which: Indices, rows: SharedIntervals, solids: GrownSolids
) -> Judgement:
    """Judge a UAV, number `k` in the motion, among movers of one kind."""
    if not len(rows.mover):
        return Judgement([])

    def depth(part: Floats, row: Indices) -> Floats:
        shape = rows.mover[row]
        by_doubt = solids.depth(part[:, :, :3], shape) + part[:, :, 3].max(axis=1)
        return np.minimum(by_doubt, solids.depth(part[:, :, 4:7], shape) + part[:, :, 7].max(axis=1))

    wrong = np.maximum(solids.error(rows.b[:, :, :3], rows.error), solids.error(rows.b[:, :, 4:7], rows.error))
    peaks = find_peaks(rows.b, wrong, depth)
    if peaks.proven[0]:
        return Judgement([], int(peaks.halvings[0]))
    row, share = peaks.place()
    time = float(rows.begins[row] + share * (rows.ends[row] - rows.begins[row]))
    mover = fleet.movers[int(which[rows.mover[row]])]
    at = fleet.motion.shifted(fleet.motion.piece(k, np.array([time])), np.array([time]))[0, 0]
    shape, doubt = int(rows.mover[row]), mover.doubt
    gap = solids.gap(at - mover.at(time)[0], shape) - float(doubt.at(time)[0])
    if doubt.top_speed is not None and time > doubt.since:
        come = doubt.radius + doubt.top_speed * (time - doubt.since)
        gap = max(gap, solids.gap(at - mover.at(doubt.since)[0], shape) - come)
    if peaks.refuted[0] and gap < solids.clearance - LET_PASS:
        return Judgement([_too_close(scenario, uav, mover, time, at, gap)], int(peaks.halvings[0]))
    return Judgement([_undecided(scenario, uav, mover, time, at)], int(peaks.halvings[0]))


def _too_close(scenario: Scenario, uav: int, mover: Mover, time: float, at: Floats, gap: float) -> Violation:
    """Return the violation of a UAV that comes too close; `gap` is to the mover and its doubt, in metres."""
    vehicle, aside = scenario.uavs[uav], scenario.uavs[uav].tracking_error.horizontal
    who, gap = named(vehicle.name, vehicle.tracking_error), gap - aside
    whom = f"mover {mover.name!r}" if mover.doubt == Doubt() else f"where mover {mover.name!r} may be"
    deed = f"comes within {gap:.6g} m of {whom}" if gap >= 0 else f"is {-gap:.6g} m inside {whom}"
    message = (
        f"{who} {deed} at t = {time:.6g} s, position {position_text(at)}; {scenario.clearance:.6g} m are required."
    )
    return Violation(Fault.MOVER, (uav,), message, time, position_tuple(at))


def _undecided(
    scenario: Scenario, uav: int, mover: Mover, time: float | None = None, at: Floats | None = None
) -> Violation:
    name = scenario.uavs[uav].name
    if time is None or at is None:
        message = (
            f"Whether {name} keeps clear of mover {mover.name!r} could not be decided: its motion has too many turns."
        )
        return Violation(Fault.UNDECIDED, (uav,), message)
    message = (
        f"Whether {name} keeps clear of mover {mover.name!r} could not be decided at t = {time:.6g} s, "
        f"position {position_text(at)}."
    )
    return Violation(Fault.UNDECIDED, (uav,), message, time, position_tuple(at))
