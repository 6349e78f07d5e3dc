"""Judges whether UAVs stay clear of what changes with time: of movers, and of zones that are closed at times.

Such a zone is a mover that stands and is there for a while; see `model.timed_shapes`. The position of a UAV relative
to the point of a mover is a polynomial of time between all knots of both. The mover's shape, in its own frame, is grown
by the clearance, and by the doubt of the instant. Where a mover has a top speed, a UAV is clear if it is clear of
either all that the doubt or all that the top speed allows.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skyverse._typing import Floats, Indices
from skyverse.model.mover import Doubt
from skyverse.model.scenario import Scenario
from skyverse.model.timed_shapes import JUDGED_STAY, TimedShape, is_closed_at_times, timed_shapes, told_zone
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.fleet_motion import FleetMotion, fleet_motion, slice_boxes, time_slices
from skyverse.referee.judgement import Judgement, position_text, position_tuple
from skyverse.referee.mover_motion import EnclosedMotion, enclosed_motion
from skyverse.referee.polynomial import bernstein
from skyverse.referee.solid_shapes import by_kind
from skyverse.referee.solids import GrownSolids
from skyverse.referee.subdivision import Peaks, find_peaks
from skyverse.referee.tolerances import INSTANT_ROUNDING, LET_PASS, MOVER_SLACK
from skyverse.referee.tracking_error import named
from skyverse.referee.world import grown_kinds


class TimedThing(NamedTuple):
    """A mover, or a zone in one of its active times, as the referee judges it.

    Attributes
    ----------
    name
        How sentences call it.
    given
        What is given of it.
    enclosed
        Its motion; ``None`` where it has too many turns.
    """

    name: str
    given: TimedShape
    enclosed: EnclosedMotion | None


class MovingFleet(NamedTuple):
    """The motion of all UAVs and, after them, of all timed things.

    Attributes
    ----------
    scenario, motion
        What was given, and the motion of both.
    things
        The k-th is number ``uavs + k`` in the motion.
    uavs
        How many UAVs there are.
    error
        (p,) metres that each piece of a mover is at most away from its motion; 0 for UAVs.
    edges, boxes
        (n + 1,) seconds, the edges of slices of time, and corners (2, uavs + things, n, 3) of boxes about the motions.
    """

    scenario: Scenario
    motion: FleetMotion
    things: list[TimedThing]
    uavs: int
    error: Floats
    edges: Floats
    boxes: Floats


class Meetings(NamedTuple):
    """Intervals of time in each of which one UAV moves along one piece, and may be near one shape.

    Attributes
    ----------
    shape
        (m,) the shape's number among those of its kind.
    begins, ends
        (m,) seconds.
    b
        (m, degree + 1, 8) Bernstein coefficients: the UAV's position relative to the mover's point, and the doubt;
        then its position relative to where the mover was last seen, and how far the mover may have come from there.
        Without a top speed the last four are the first four. All in metres.
    error
        (m,) bounds on the errors of positions, metres.
    """

    shape: Indices
    begins: Floats
    ends: Floats
    b: Floats
    error: Floats


def judge_movers(
    scenario: Scenario, curves: Sequence[PolynomialCurve | None], unknown: set[int], stay: float = JUDGED_STAY
) -> list[Judgement]:
    """Judge every UAV whose motion is known among all that changes, from 0 s until a while after the last arrival.

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

    Returns
    -------
    list of Judgement
        Each has one violation of each fault at most, and one that is undecided where there is no other.
    """
    judged = [Judgement([]) for _ in scenario.uavs]
    if len(unknown) == len(scenario.uavs):
        return judged
    own = fleet_motion(scenario, curves, unknown, stay)
    things = list(_things(scenario, own.end))
    if not things:
        return judged
    wild = [one for one in things if one.enclosed is None]
    fleet = _with_movers(scenario, own, [one for one in things if one.enclosed is not None])
    shapes = by_kind(enumerate(one.given.shape for one in fleet.things), scenario.clearance)
    errors = {scenario.uavs[uav].tracking_error for uav in own.uavs}
    grown = {error: grown_kinds(shapes, error) for error in errors}
    for k, uav in enumerate(own.uavs):
        found, halvings = [_undecided(fleet, k, one, ": its motion has too many turns.") for one in wild], 0
        boxes, others = grown[scenario.uavs[uav].tracking_error]
        for kind in (boxes, *others):
            among = _judge(fleet, k, kind)
            found, halvings = found + among.violations, halvings + among.halvings
        refuted = {one.fault: one for one in found if one.fault is not Fault.UNDECIDED}
        judged[uav] = Judgement(list(refuted.values()) or found[:1], halvings)
    return judged


def _things(scenario: Scenario, end: float) -> Iterator[TimedThing]:
    """Yield all movers, and all zones that are closed at times, from 0 s until `end`."""
    names = iter([f"mover {mover.name!r}" for mover in scenario.movers])
    for one in timed_shapes(scenario):
        if one.zone < 0 or is_closed_at_times(scenario.zones[one.zone]):
            name = next(names) if one.zone < 0 else told_zone(scenario, one.zone)
            yield TimedThing(name, one, enclosed_motion(one.motion, end))


def _with_movers(scenario: Scenario, own: FleetMotion, things: list[TimedThing]) -> MovingFleet:
    """Return the motion of UAVs and of what else moves as one."""
    enclosed = [one.enclosed for one in things if one.enclosed is not None]
    degree = max([3, own.pieces.shape[1], *(known.pieces.shape[1] for known in enclosed)])  # that doubts need
    pieces = [own.pieces, *(known.pieces for known in enclosed)]
    motion = FleetMotion(
        uavs=own.uavs + [-1] * len(things),
        knots=[*own.knots, *(known.knots for known in enclosed)],
        first=[*own.first, *np.cumsum([len(rows) for rows in pieces[:-1]]).tolist()],
        begins=np.concatenate([own.begins, *(known.begins for known in enclosed)]),
        pieces=np.concatenate([np.pad(rows, ((0, 0), (0, degree - rows.shape[1]), (0, 0))) for rows in pieces]),
    )
    error = np.concatenate([np.zeros(len(own.pieces)), *(known.error for known in enclosed)])
    edges = time_slices(motion)
    return MovingFleet(scenario, motion, things, len(own.uavs), error, edges, slice_boxes(motion, edges))


def _near(fleet: MovingFleet, k: int, number: int, hull: Floats, spread: float) -> NDArray[np.bool_]:
    """Tell in which slices of time (n,) the k-th UAV may be near a thing whose grown shapes have a hull (2, 3)."""
    motion, j = fleet.motion, fleet.uavs + number
    error = fleet.error[motion.first[j] : motion.first[j] + len(motion.knots[j]) - 1].max()
    doubt = float(fleet.things[number].given.doubt.at(motion.end)[0])
    reach = MOVER_SLACK + spread * (doubt + float(error))
    (low, high), (low_j, high_j) = fleet.boxes[:, k], fleet.boxes[:, j]
    apart = (low >= high_j + hull[1] + reach) | (high <= low_j + hull[0] - reach)
    return ~apart.any(axis=1)


def _meetings(fleet: MovingFleet, k: int, kind: GrownSolids) -> Iterator[Meetings]:
    """Yield the intervals in which the k-th UAV may be near shapes of a kind, thing by thing."""
    motion, (low, high) = fleet.motion, kind.hulls()
    for number in np.unique(kind.obstacle).tolist():
        shapes = np.flatnonzero(kind.obstacle == number)
        hull = np.array([low[shapes].min(axis=0), high[shapes].max(axis=0)])
        near = _near(fleet, k, number, hull, kind.spread)
        if not near.any():
            continue
        given, slack = fleet.things[number].given, INSTANT_ROUNDING * motion.end
        since, until, doubt = given.active[0] - slack, given.active[1] + slack, given.doubt
        turns = np.clip([doubt.since, doubt.since + doubt.accelerating_for, since, until], 0.0, motion.end)
        cuts = np.unique(np.concatenate([motion.knots[k], motion.knots[fleet.uavs + number], fleet.edges, turns]))
        wanted = near[np.searchsorted(fleet.edges, cuts[:-1], side="right") - 1]
        wanted &= (since <= cuts[:-1]) & (cuts[1:] <= until)
        if wanted.any():
            yield _meetings_with(fleet, k, number, (cuts[:-1][wanted], cuts[1:][wanted]), kind, shapes)


def _meetings_with(
    fleet: MovingFleet, k: int, number: int, intervals: tuple[Floats, Floats], kind: GrownSolids, shapes: Indices
) -> Meetings:
    """Return the meetings of the k-th UAV with all shapes of one thing in intervals, by begins and ends, seconds."""
    motion, (begins, ends), given = fleet.motion, intervals, fleet.things[number].given
    own, theirs = motion.piece(k, begins), motion.piece(fleet.uavs + number, begins)
    relative = motion.difference(own, theirs, begins, ends)
    error = np.max([part.error for part in relative], axis=0) + fleet.error[theirs]
    b = np.empty((len(begins), motion.pieces.shape[1], 8))
    share = np.linspace(0.0, 1.0, b.shape[1])
    b[:, :, :3] = np.stack([part.b for part in relative], axis=2)
    instants = np.column_stack([begins, 0.5 * (begins + ends), ends])
    b[:, :, 3] = _quadratic(given.doubt.at(instants.ravel()).reshape(-1, 3), share)
    b[:, :, 4:] = b[:, :, :4]
    since, fastest = given.doubt.since, given.doubt.top_speed
    seen = np.flatnonzero(begins >= since)
    if fastest is not None and len(seen):
        position = bernstein(motion.shifted(own[seen], begins[seen]), (ends - begins)[seen])
        rounding = motion.shift_error(own[seen], ends[seen]).max(axis=1)
        error[seen] = np.maximum(error[seen], np.max([part.error for part in position], axis=0) + rounding)
        b[seen, :, 4:7] = np.stack([part.b for part in position], axis=2) - given.motion.at(since)[0]
        b[seen, :, 7] = _linear(given.doubt.radius + fastest * (instants[seen][:, [0, 2]] - since), share)
    row, shape = np.arange(len(b)), np.repeat(shapes, len(b))
    if len(shapes) > 1:  # of many parts, those that the UAV comes near; what has parts stands, and there is no doubt
        wrong = kind.error(b[:, :, :3], error)[:, None]
        pairs = kind.of(shapes).tree.overlapping(b[:, :, :3].min(axis=1) - wrong, b[:, :, :3].max(axis=1) + wrong)
        row, part = np.concatenate([np.zeros((0, 2), dtype=np.intp), *pairs]).T
        shape = shapes[part]
    return Meetings(shape, begins[row], ends[row], b[row], error[row])


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


def _judge(fleet: MovingFleet, k: int, kind: GrownSolids) -> Judgement:
    """Judge a UAV, number `k` in the motion, among shapes of one kind."""
    each = list(_meetings(fleet, k, kind))
    met = Meetings(*map(np.concatenate, zip(*each, strict=True))) if each else None
    if met is None or not len(met.shape):
        return Judgement([])

    def depth(part: Floats, row: Indices) -> Floats:
        shape = met.shape[row]
        by_doubt = kind.depth(part[:, :, :3], shape) + part[:, :, 3].max(axis=1)
        return np.minimum(by_doubt, kind.depth(part[:, :, 4:7], shape) + part[:, :, 7].max(axis=1))

    wrong = np.maximum(kind.error(met.b[:, :, :3], met.error), kind.error(met.b[:, :, 4:7], met.error))
    zone = np.array([thing.given.zone >= 0 for thing in fleet.things])[kind.obstacle[met.shape]]
    peaks = find_peaks(met.b, wrong, depth, question=zone.astype(np.intp), questions=2)
    wrong_in = [_violation(fleet, k, kind, met, peaks, int(which)) for which in np.flatnonzero(~peaks.proven)]
    return Judgement(wrong_in, int(peaks.halvings.sum()))


def _violation(fleet: MovingFleet, k: int, kind: GrownSolids, met: Meetings, peaks: Peaks, question: int) -> Violation:
    """Return what is wrong with the k-th UAV among movers, or among zones, of one kind of shape."""
    row, share = peaks.place(question)
    shape, time = int(met.shape[row]), float(met.begins[row] + share * (met.ends[row] - met.begins[row]))
    thing, vehicle = fleet.things[int(kind.obstacle[shape])], fleet.scenario.uavs[fleet.motion.uavs[k]]
    motion, doubt, error = thing.given.motion, thing.given.doubt, vehicle.tracking_error
    at = fleet.motion.shifted(fleet.motion.piece(k, np.array([time])), np.array([time]))[0, 0]
    gap = kind.gap(at - motion.at(time)[0], shape) - float(doubt.at(time)[0])
    if doubt.top_speed is not None and time > doubt.since:
        come = doubt.radius + doubt.top_speed * (time - doubt.since)
        gap = max(gap, kind.gap(at - motion.at(doubt.since)[0], shape) - come)
    if not (peaks.refuted[question] and gap < kind.clearance - LET_PASS):
        return _undecided(fleet, k, thing, f" at t = {time:.6g} s, position {position_text(at)}.", (time, at))
    gap -= error.horizontal
    whom = thing.name if doubt == Doubt() else f"where {thing.name} may be"
    deed = f"comes within {gap:.6g} m of {whom}" if gap >= 0 else f"is {-gap:.6g} m inside {whom}"
    where = f"at t = {time:.6g} s, position {position_text(at)}"
    message = f"{named(vehicle.name, error)} {deed} {where}; {fleet.scenario.clearance:.6g} m are required."
    fault = Fault.MOVER if thing.given.zone < 0 else Fault.ACTIVE_ZONE
    return Violation(fault, (fleet.motion.uavs[k],), message, time, position_tuple(at))


def _undecided(
    fleet: MovingFleet, k: int, thing: TimedThing, why: str, place: tuple[float, Floats] | None = None
) -> Violation:
    uav = fleet.motion.uavs[k]
    message = f"Whether {fleet.scenario.uavs[uav].name} keeps clear of {thing.name} could not be decided{why}"
    when, at = (None, None) if place is None else (place[0], position_tuple(place[1]))
    return Violation(Fault.UNDECIDED, (uav,), message, when, at)
