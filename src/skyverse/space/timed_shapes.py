"""Movers, and zones with active times, as arrays: where each is at an instant, and how far a point is from it."""

import math
from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.model.mover import Doubt, Ellipsoid
from skyverse.model.mover_motions import (
    CircularMotion,
    MoverMotion,
    PeriodicMotion,
    PolynomialMotion,
    WaypointMotion,
    motion_bounds,
)
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Box, Cylinder, Prism, Shape, Sphere
from skyverse.model.timed_shapes import TimedShape, timed_shapes
from skyverse.model.uav import TrackingError
from skyverse.numerics.kernel import by_reference, inner_query, kernel
from skyverse.space import polygon
from skyverse.space.tracking_error import reach, taller, wider
from skyverse.space.voxels import parts_of

BOX, CYLINDER, SPHERE, ELLIPSOID, PRISM = range(5)
STAYS, REPEATS, RETURNS = range(3)
SHORTEST_STEP = 0.01
"""Seconds by which time goes on at least where a mover's first contact with a place is sought."""
LEAST_DOUBT = 0.05
"""Metres that are added to doubts where distances are measured in them."""


@by_reference
class MovingShapes(NamedTuple):
    """Movers, and zones with active times, as arrays, n of them, for UAVs with one tracking error.

    A zone is a shape that does not move and is there for a while: one for each of its active times.

    Attributes
    ----------
    active
        (n, 2) seconds from which and until which each is there; infinite where it always is.
    first
        (n + 1,) index of the first piece of each mover.
    begin, rows
        (p,) seconds and (p, degree + 1, 3) metres: on piece k a mover is at the sum over j of
        ``rows[k, j] * (t - begin[k])**j``.
    span
        (n, 2) seconds between which the pieces lie.
    then
        (n,) what follows them: ``STAYS``, ``REPEATS`` or ``RETURNS``.
    first_term
        (n + 1,) index of the first term of each mover's closed curve, which is added to the pieces.
    period, cosine, sine
        (n,) seconds, and (q, 3) metres: the closed curves, as in `Periodic`.
    kind, size
        (n,) and (n, 6) metres: a box's corners; a cylinder's x, y, radius, low and high; a sphere's centre and radius;
        an ellipsoid's centre and semi-axes; a prism's low and high. All relative to the moving point.
    rings, edges
        (n, 2) the first edge of each prism and the one after its last; (q, 4) the edges, x, y, x, y in metres.
    keep
        (n,) metres that UAVs must keep from each.
    doubt
        (n, 6): its radius, metres; how fast it grows, m/s; since when, seconds; the top speed, m/s, or infinity; and
        by how much that growth grows, m/s^2, and for how many seconds.
    seen
        (n, 3) metres: where each one was when it was last seen.
    rate
        (n,) m/s: a point that does not move comes nearer to a mover, or to where it may be, no faster than this.
    """

    active: Floats
    first: Ints
    begin: Floats
    rows: Floats
    span: Floats
    then: Ints
    first_term: Ints
    period: Floats
    cosine: Floats
    sine: Floats
    kind: Ints
    size: Floats
    rings: Ints
    edges: Floats
    keep: Floats
    doubt: Floats
    seen: Floats
    rate: Floats


def timed_parts(scenario: Scenario, kept: Collection[int] = ()) -> list[TimedShape]:
    """Return what changes with time in a scenario, as `timed_shapes` does, but each zone of voxels as boxes."""
    return [one._replace(shape=part) for one in timed_shapes(scenario, kept) for part in parts_of(one.shape)]


def moving_shapes(given: Sequence[TimedShape], error: TrackingError) -> MovingShapes:
    """Return shapes that move, or are there for a while, as arrays, for UAVs with a tracking error."""
    n = len(given)
    pieces = [_pieces(one.motion) for one in given]
    degree = max((rows.shape[1] for _, rows in pieces), default=1)
    rows = [np.pad(rows, ((0, 0), (0, degree - rows.shape[1]), (0, 0))) for _, rows in pieces]
    terms = [_terms(one.motion) for one in given]
    kept = [_kept(one.shape, one.keep, error) for one in given]
    edges = [_edges(one.shape) for one in given]
    last = np.cumsum([len(own) for own in edges], dtype=np.int64)
    return MovingShapes(
        active=np.array([one.active for one in given]).reshape(n, 2),
        first=np.cumsum([0, *(len(begin) for begin, _ in pieces)]).astype(np.int64),
        begin=np.concatenate([np.zeros(0), *(begin for begin, _ in pieces)]),
        rows=np.concatenate([np.zeros((0, degree, 3)), *rows]),
        span=np.array([_span(one.motion) for one in given]).reshape(n, 2),
        then=np.array([_then(one.motion) for one in given], dtype=np.int64),
        first_term=np.cumsum([0, *(0 if one is None else len(one.cosine) for one in terms)]).astype(np.int64),
        period=np.array([1.0 if one is None else one.period for one in terms]),
        cosine=np.array([row for one in terms if one is not None for row in one.cosine]).reshape(-1, 3),
        sine=np.array([row for one in terms if one is not None for row in one.sine]).reshape(-1, 3),
        kind=np.array([kind for kind, _, _ in kept], dtype=np.int64),
        size=np.array([size for _, size, _ in kept]).reshape(n, 6),
        rings=np.column_stack([last - [len(own) for own in edges], last]).astype(np.int64).reshape(n, 2),
        edges=np.concatenate([np.zeros((0, 4)), *edges]),
        keep=np.array([keep for _, _, keep in kept]),
        doubt=np.array([_doubt(one.doubt) for one in given]).reshape(n, 6),
        seen=np.array([one.motion.at(one.doubt.since)[0] for one in given]).reshape(n, 3),
        rate=np.array([_rate(one) for one in given]),
    )


def _kept(shape: Shape, clearance: float, error: TrackingError) -> tuple[int, tuple[float, ...], float]:
    """Return the kind and the sizes of a shape, and the metres to keep from it, so that the error is allowed for."""
    up, keep = taller(error), reach(clearance, error)
    match shape:
        case Box():
            low, high = (*shape.min[:2], shape.min[2] - up), (*shape.max[:2], shape.max[2] + up)
            return BOX, (*low, *high), keep
        case Cylinder():
            return CYLINDER, (*shape.centre, shape.radius, shape.low - up, shape.high + up, 0.0), keep
        case Sphere():
            return SPHERE, (*shape.centre, shape.radius, 0.0, 0.0), keep + wider(error)
        case Ellipsoid():
            size = (*shape.centre, shape.semi_axis_xy, shape.semi_axis_z, 0.0)
            return ELLIPSOID, size, keep + wider(error)
        case Prism():
            return PRISM, (shape.low - up, shape.high + up, 0.0, 0.0, 0.0, 0.0), keep
    raise TypeError(f"a {type(shape).__name__} can be neither a mover nor a part of a zone")


def _edges(shape: Shape) -> Floats:
    """Return the edges of a prism's rings, (m, 4) metres; other shapes have none."""
    if not isinstance(shape, Prism):
        return np.zeros((0, 4))
    rings = [np.array(ring) for ring in (shape.vertices, *shape.holes)]
    return np.concatenate([np.hstack([ring, np.roll(ring, -1, axis=0)]) for ring in rings])


def _pieces(motion: MoverMotion) -> tuple[Floats, Floats]:
    """Return when pieces begin, (p,) seconds, and their coefficients (p, degree + 1, 3), metres."""
    match motion:
        case WaypointMotion(points=points, times=times):
            places, instants = np.array(points), np.array(times)
            if len(places) == 1:
                return instants, places[:, None]
            slopes = np.diff(places, axis=0) / np.diff(instants)[:, None]
            return instants[:-1], np.stack([places[:-1], slopes], axis=1)
        case PolynomialMotion(knots=knots, coefficients=coefficients):
            rows = np.zeros((len(coefficients), max(map(len, coefficients)), 3))
            for k, given in enumerate(coefficients):
                rows[k, : len(given)] = given
            return np.array(knots[:-1]), rows
        case CircularMotion(centre=centre) | PeriodicMotion(centre=centre):
            return np.zeros(1), np.array(centre)[None, None]


def _terms(motion: MoverMotion) -> PeriodicMotion | None:
    match motion:
        case CircularMotion():
            return motion.as_periodic
        case PeriodicMotion():
            return motion
        case _:
            return None


def _span(motion: MoverMotion) -> tuple[float, float]:
    match motion:
        case WaypointMotion(times=instants) | PolynomialMotion(knots=instants):
            return instants[0], instants[-1]
        case _:
            return 0.0, 0.0


def _then(motion: MoverMotion) -> int:
    followed = motion.then if isinstance(motion, WaypointMotion) else "stays"
    return {"stays": STAYS, "repeats": REPEATS, "returns": RETURNS}[followed]


def _doubt(given: Doubt) -> tuple[float, ...]:
    top = math.inf if given.top_speed is None else given.top_speed
    return given.radius, given.growth, given.since, top, given.acceleration, given.accelerating_for


def _rate(given: TimedShape) -> float:
    """Return how fast at most a point comes nearer to where a mover may be, m/s."""
    fastest, _ = motion_bounds(given.motion)
    doubt, growth = given.doubt, given.doubt.growth
    if doubt.acceleration > 0.0:
        growth += doubt.acceleration * min(max(given.active[1] - doubt.since, 0.0), doubt.accelerating_for)
    return max(fastest + growth, doubt.top_speed or 0.0)


@inner_query
def mover_position(shapes: MovingShapes, m: int, t: float, out: Floats) -> None:
    """Write where the point of mover m is at an instant by its stated motion, (3,) metres."""
    begins, ends = shapes.span[m, 0], shapes.span[m, 1]
    since, length = t - begins, ends - begins
    if since > length:
        if shapes.then[m] == REPEATS:
            since = since % length
        elif shapes.then[m] == RETURNS:
            since = length - abs(since % (2.0 * length) - length)
        else:
            since = length
    since = max(since, 0.0)
    low, high = shapes.first[m], shapes.first[m + 1] - 1
    while low < high:
        middle = (low + high + 1) // 2
        if shapes.begin[middle] - begins <= since:
            low = middle
        else:
            high = middle - 1
    local = since - (shapes.begin[low] - begins)
    for axis in range(3):
        value = 0.0
        for j in range(shapes.rows.shape[1] - 1, -1, -1):
            value = value * local + shapes.rows[low, j, axis]
        out[axis] = value
    first = shapes.first_term[m]
    turn = t / shapes.period[m] % 1.0
    for k in range(first, shapes.first_term[m + 1]):
        angle = 2.0 * math.pi * turn * (k - first + 1)
        c, s = math.cos(angle), math.sin(angle)
        for axis in range(3):
            out[axis] += c * shapes.cosine[k, axis] + s * shapes.sine[k, axis]


@inner_query
def _gap(kind: int, size: Floats, x: float, y: float, z: float) -> float:
    """Return how far a point is from a shape, metres, below 0 inside; to boxes along the axis where it is farthest."""
    if kind == BOX:
        level = max(max(size[0] - x, x - size[3]), max(size[1] - y, y - size[4]))
        return max(level, max(size[2] - z, z - size[5]))
    if kind == CYLINDER:
        level = math.hypot(x - size[0], y - size[1]) - size[2]
        return max(level, max(size[3] - z, z - size[4]))
    x, y, z = x - size[0], y - size[1], z - size[2]
    if kind == SPHERE:
        return math.sqrt(x * x + y * y + z * z) - size[3]
    shorter = min(size[3], size[4])
    across, up = shorter / size[3], shorter / size[4]
    return math.sqrt((x * x + y * y) * across * across + z * z * up * up) - shorter


@inner_query
def _prism_gap(shapes: MovingShapes, m: int, x: float, y: float, z: float) -> float:
    """Return how far a point is from a prism, metres, below 0 inside; to the side, or up or down where that is more."""
    first, stop = shapes.rings[m, 0], shapes.rings[m, 1]
    level = polygon.to_outline(shapes.edges, first, stop, x, y)
    if polygon.inside(shapes.edges, first, stop, x, y):
        level = -level
    return max(level, max(shapes.size[m, 0] - z, z - shapes.size[m, 1]))


@inner_query
def _spread(doubt: Floats, after: float) -> float:
    """Return how far a mover may be from its motion some seconds after it was last seen, metres."""
    quick = min(after, doubt[5])
    return doubt[0] + doubt[1] * after + doubt[4] * quick * (after - 0.5 * quick)


@inner_query
def gap_at(shapes: MovingShapes, m: int, t: float, place: Floats, moved: Floats) -> float:
    """Return how much farther than it must a place is from where mover m may be at an instant, metres.

    Below 0 it is too near; it is infinitely far from what is not there then. `moved` is (3,) metres of room to work in.
    """
    if t < shapes.active[m, 0] or t > shapes.active[m, 1]:
        return math.inf
    kind, size, doubt = shapes.kind[m], shapes.size[m], shapes.doubt[m]
    if kind == PRISM:  # only zones are, which do not move
        return _prism_gap(shapes, m, place[0], place[1], place[2]) - shapes.keep[m]
    mover_position(shapes, m, t, moved)
    after = max(t - doubt[2], 0.0)
    gap = _gap(kind, size, place[0] - moved[0], place[1] - moved[1], place[2] - moved[2])
    gap -= _spread(doubt, after)
    if after > 0.0 and doubt[3] < math.inf:
        seen = shapes.seen[m]
        reached = _gap(kind, size, place[0] - seen[0], place[1] - seen[1], place[2] - seen[2])
        gap = max(gap, reached - doubt[0] - doubt[3] * after)
    return gap - shapes.keep[m]


@inner_query
def gap_in_doubts(shapes: MovingShapes, m: int, t: float, place: Floats, moved: Floats) -> float:
    """Return of which share of what mover m may do until an instant a place is clear, above 1 if of more than all.

    A mover that did a share of it would be within that share of its doubt, and of what its top speed allows from
    where it was seen. Where a place is clear of one of these, it is clear of the mover. `moved` is (3,) metres of room
    to work in.
    """
    if t < shapes.active[m, 0] or t > shapes.active[m, 1]:
        return math.inf
    if shapes.kind[m] == PRISM:
        return gap_at(shapes, m, t, place, moved) / LEAST_DOUBT
    mover_position(shapes, m, t, moved)
    gap = _gap(shapes.kind[m], shapes.size[m], place[0] - moved[0], place[1] - moved[1], place[2] - moved[2])
    doubt, seen = shapes.doubt[m], shapes.seen[m]
    after = max(t - doubt[2], 0.0)
    share = (gap - shapes.keep[m]) / (LEAST_DOUBT + _spread(doubt, after))
    if after > 0.0 and doubt[3] < math.inf:
        gap = _gap(shapes.kind[m], shapes.size[m], place[0] - seen[0], place[1] - seen[1], place[2] - seen[2])
        share = max(share, (gap - shapes.keep[m]) / (LEAST_DOUBT + doubt[0] + doubt[3] * after))
    return share


@kernel
def first_too_near(shapes: MovingShapes, m: int, place: Floats, since: float, until: float) -> float:
    """Return the first instant within a span at which mover m is too near to a place (3,); infinite if there is none.

    Time goes on in steps in which the distance that is left cannot be used up, or by `SHORTEST_STEP`.
    """
    moved, now, rate = np.empty(3), since, shapes.rate[m]
    while now <= until:
        gap = gap_at(shapes, m, now, place, moved)
        if gap < 0.0:
            return now
        if rate <= 0.0:
            return math.inf
        now += max(gap / rate, SHORTEST_STEP)
    return math.inf


@kernel
def mover_gaps(shapes: MovingShapes, instants: Floats, places: Floats) -> Floats:
    """Return for n movers and m instants how much farther than it must the place (m, 3) is from each, (n, m) metres."""
    gaps = np.empty((len(shapes.kind), len(instants)))
    moved = np.empty(3)
    for m in range(len(shapes.kind)):
        for i in range(len(instants)):
            gaps[m, i] = gap_at(shapes, m, instants[i], places[i], moved)
    return gaps
