"""Flight for what cannot hover: level speed held, turns no tighter than a radius, climbs no steeper than an angle.

Headings at the waypoints, and which waypoints to keep, are searched for at once: A* over poses, with legs that are
Dubins paths and are tested for obstacles only when they come up (a "lazy" search). Every pose is level.
"""

import itertools
import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.numerics.heap import Heap, make_heap, pop, push
from skyverse.numerics.kernel import inner, kernel
from skyverse.search.path_shortening.shortcut import drop_collinear
from skyverse.space.world import Space, World, segment_free
from skyverse.trajectory.dubins import all_words
from skyverse.trajectory.leg import CLEAR, SHUT, Leg, climb_along, climb_length, leg_clear, leg_pieces, place

_MARGIN = 1e-4
"""The share of a limit that is left: polynomials are not quite arcs."""
_TURNING = 0.98
"""The share of `max_acceleration` that turns may take; the rest is for climbs."""
_AHEAD = 5
"""How many waypoints further a leg may lead at most."""
_NEAR = 2
"""How many of them even if they are not in sight."""
_TRIES = 10_000
"""Legs that are tested for obstacles, and full turns in them, before a search gives up."""


class _Search(NamedTuple):
    """How far a search reaches.

    Attributes
    ----------
    offsets
        Of poses from their waypoint: outwards and along the way, in least radii.
    radii
        Of turns, in least radii.
    headings
        At each place.
    greed
        What the way that is left counts; above 1, what leads on is preferred to what is short.
    wide
        Whether there are poses between waypoints that are far apart, and waypoints out of sight are flown to directly.
    """

    offsets: tuple[tuple[float, float], ...]
    radii: tuple[float, ...]
    headings: int
    greed: float
    wide: bool


def _cross(reach: float) -> tuple[tuple[float, float], ...]:
    return ((0.0, 0.0), (0.4, 0.0), (reach, 0.0), (-reach, 0.0), (0.0, reach), (0.0, -reach))


_SEARCHES = (
    _Search(((0.0, 0.0), (0.3, 0.0), (0.8, 0.0)), (1.0, 1.5), headings=16, greed=1.0, wide=False),
    _Search(_cross(1.3), (1.0,), headings=16, greed=3.0, wide=False),
    _Search(_cross(1.5), (1.0, 1.5), headings=8, greed=3.0, wide=True),
)
"""One after the other until one finds a way: what is short, then what is found soon, then what is out of the way."""


class _Able(NamedTuple):
    """What the aeroplane can do, by metres of way: radii of turns, steepest slope, and the slope's greatest rate."""

    radii: Floats
    slope: float
    bend: float


class _Poses(NamedTuple):
    """Where to fly through.

    Attributes
    ----------
    at
        (n, 4) x, y, z and heading, in the waypoints' order.
    first
        (waypoints + 1,) where each waypoint's begin.
    left
        (n,) metres of way that are left, about: along the waypoints, or straight on where that is more.
    headings
        As many poses follow each other at one place.
    """

    at: Floats
    first: Ints
    left: Floats
    headings: int


def fly_aeroplane(world: World, waypoints: Floats, uav: UAV) -> Trajectory | None:
    """Fly an aeroplane along waypoints, or return ``None`` where no way is found.

    It keeps its horizontal speed, turns on arcs of its least radius or somewhat wider ones, and is level at its start,
    its target, and where it changes over from one leg to the next. Waypoints may be left out, or passed on the outside.
    Headings at both ends are free. Where start and target are one place it flies a full turn.

    Parameters
    ----------
    world
        To stay clear of.
    waypoints
        (n, 3) metres, from start to target along straight legs that are clear.
    uav
        With its `fixed_wing`.

    Returns
    -------
    Trajectory
        Of form ``"dubins"``, from 0 s on; position and velocity are continuous.
    """
    wing = uav.fixed_wing
    if wing is None:
        raise ValueError(f"{uav.name or 'the UAV'} has no fixed_wing")
    points = drop_collinear(waypoints)
    if len(points) == 1:
        points = np.vstack([points, points])
    least = max(wing.turn_radius * (1.0 + _MARGIN), wing.speed**2 / (_TURNING * uav.max_acceleration))
    vertical = math.sqrt(uav.max_acceleration**2 - (wing.speed**2 / least) ** 2)
    slope = math.tan(math.radians(wing.climb))
    for search in _SEARCHES:
        able = _Able(
            least * np.array(search.radii), slope * (1.0 - _MARGIN), vertical / wing.speed**2 * (1.0 - _MARGIN)
        )
        poses = _poses(world, points, search, least, slope)
        way = _cheapest(world.space, poses, able, search.wide)
        if len(way):
            return _flown(poses.at, way, able, wing.speed)
    return None


def _between(points: Floats, least: float) -> Floats:
    """Return the waypoints with three more along each leg that is long."""
    rows = [points[:1]]
    for a, b in itertools.pairwise(points):
        shares = np.array([0.25, 0.5, 0.75, 1.0]) if np.linalg.norm(b - a) > least else np.array([1.0])
        rows.append(a + shares[:, None] * (b - a))
    return np.vstack(rows)


def _poses(world: World, points: Floats, search: _Search, radius: float, slope: float) -> _Poses:
    """Set poses at the waypoints, and beside those in between: outwards and along the way, by so many radii."""
    if search.wide:
        points = _between(points, 4.0 * radius)
    courses = np.arctan2(*np.diff(points, axis=0).T[1::-1])
    moving = np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1) > 1e-9
    rows, counts = [], []
    for i, point in enumerate(points):
        before, after = courses[:i][moving[:i]][-1:], courses[i:][moving[i:]][:1]
        known = np.r_[before, after] if len(before) + len(after) else np.zeros(1)
        ways = np.column_stack([np.cos(known), np.sin(known)])
        along = ways.sum(axis=0)
        if np.linalg.norm(along) < 1e-6:  # it turns back
            along = np.array([-ways[0, 1], ways[0, 0]])
        heading = math.atan2(along[1], along[0])
        along = np.array([math.cos(heading), math.sin(heading)])
        outward = np.array([-along[1], along[0]])
        if len(ways) == 2 and outward @ (ways[0] - ways[1]) < 0.0:
            outward = -outward
        places = np.array([point])
        if 0 < i < len(points) - 1:
            shifts = radius * np.array([out * outward + on * along for out, on in search.offsets])
            places = point + np.column_stack([shifts, np.zeros(len(shifts))])
        places = places[world.free(places)]
        headings = heading + np.arange(search.headings) * (2.0 * math.pi / search.headings)
        rows.append(np.column_stack([np.repeat(places, search.headings, axis=0), np.tile(headings, len(places))]))
        counts.append(len(rows[-1]))
    at = np.vstack(rows)
    ahead = np.repeat(_left(points, slope), counts)
    aside = np.hypot(*(at[:, :2] - np.repeat(points[:, :2], counts, axis=0)).T)
    straight = np.hypot(*(points[-1] - at[:, :3])[:, :2].T)
    left = search.greed * np.maximum(ahead - aside, straight)
    return _Poses(at, np.r_[0, np.cumsum(counts)], left, search.headings)


def _left(points: Floats, slope: float) -> Floats:
    """Return the metres of way (n,) that are left from each waypoint on, nowhere climbing steeper than a slope."""
    steps = np.diff(points, axis=0)
    left = np.zeros(len(points))
    end, way, rise = 0.0, 0.0, 0.0  # what is left after the rise or descent that a step belongs to, and the part of it
    for i in range(len(steps) - 1, -1, -1):
        if rise * steps[i, 2] < 0.0:
            end, way, rise = left[i + 1], 0.0, 0.0
        way, rise = way + math.hypot(steps[i, 0], steps[i, 1]), rise + steps[i, 2]
        left[i] = end + max(way, abs(rise) / slope)
    return left


def _flown(poses: Floats, way: Ints, able: _Able, speed: float) -> Trajectory:
    durations, pieces = [], []
    for u, v, option, profile in way.tolist():
        duration, coefficients = leg_pieces(_leg(poses[u], poses[v], able, option, profile), speed)
        durations.append(duration)
        pieces.append(coefficients)
    knots = np.r_[0.0, np.cumsum(np.concatenate(durations))]
    return Trajectory(knots, np.concatenate(pieces), form="dubins")


@kernel
def _cheapest(space: Space, poses: _Poses, able: _Able, blind: bool) -> Ints:
    """Return the shortest way from a pose of the first waypoint to one of the last, none if there is none.

    Rows are: from pose, to pose, which option of `_options`, which profile of the climb.
    """
    n, layers = len(poses.at), len(poses.first) - 1
    options = 12 * len(able.radii)
    come = np.full((n, 4), -1)
    length = np.full(n, np.inf)
    heap = make_heap(1 << 14)
    tries = _TRIES
    for u in range(poses.first[1]):
        length[u] = 0.0
        heap = _expand(heap, space, poses, able, length, u, 0, blind)
    while heap.size[0]:
        _, entry = pop(heap)
        u, v, option = entry // options // n, entry // options % n, entry % options
        if length[v] < np.inf:
            continue
        if tries < 0:
            break
        leg = _leg(poses.at[u], poses.at[v], able, option, 0)
        tries -= 1 + int((leg.a + leg.c) / (2.0 * math.pi * leg.radius))
        profile = _clear_profile(space, poses.at[u], poses.at[v], able, option)
        if profile < 0:
            heap = _push_next(heap, poses, able, length, u, v, option)
            continue
        length[v] = length[u] + leg.a + leg.b + leg.c
        come[v, 0], come[v, 1], come[v, 2], come[v, 3] = u, v, option, profile
        if v >= poses.first[layers - 1]:
            return _back(come, v)
        layer = int(np.searchsorted(poses.first, v, side="right")) - 1
        heap = _expand(heap, space, poses, able, length, v, layer, blind)
    return np.empty((0, 4), np.int64)


@inner
def _back(come: Ints, v: int) -> Ints:
    count, u = 0, v
    while come[u, 0] >= 0:
        u = come[u, 0]
        count += 1
    way = np.empty((count, 4), np.int64)
    while count:
        count -= 1
        way[count] = come[v]
        v = come[v, 0]
    return way


@inner
def _expand(
    heap: Heap, space: Space, poses: _Poses, able: _Able, length: Floats, u: int, layer: int, blind: bool
) -> Heap:
    """Offer the shortest leg to every pose of the waypoints ahead; unless `blind` to those in sight or next to it."""
    layers = len(poses.first) - 1
    far = poses.first[min(layers, layer + 1 + _NEAR)]
    seen = True
    for v in range(poses.first[layer + 1], poses.first[min(layers, layer + 1 + _AHEAD)]):
        if not blind and v >= far and (v - far) % poses.headings == 0:
            seen = segment_free(space, poses.at[u, :3], poses.at[v, :3])
        if seen and length[v] == np.inf:
            heap = _push_next(heap, poses, able, length, u, v, -1)
    return heap


@inner
def _push_next(heap: Heap, poses: _Poses, able: _Able, length: Floats, u: int, v: int, option: int) -> Heap:
    """Offer the next longer leg between two poses after an option, the shortest after -1."""
    lengths = _options(poses.at[u], poses.at[v], able)
    found = -1
    for i in range(len(lengths)):
        later = option < 0 or lengths[i] > lengths[option] or (lengths[i] == lengths[option] and i > option)
        if later and lengths[i] < np.inf and (found < 0 or lengths[i] < lengths[found]):
            found = i
    if found < 0:
        return heap
    key = length[u] + lengths[found] + poses.left[v]
    return push(heap, key, (u * len(poses.at) + v) * len(lengths) + found)


@inner
def _options(a: Floats, b: Floats, able: _Able) -> Floats:
    """Return the metres of all legs between two poses: by radius, word, and full turns at the first or last letter."""
    lengths = np.full(12 * len(able.radii), np.inf)
    turning = np.full((len(able.radii), 2, 2), np.inf)
    held = np.zeros((len(able.radii), 2, 2), np.int64)
    needed = climb_length(b[2] - a[2], able.slope, able.bend)
    for r in range(len(able.radii)):
        words = all_words(a[0], a[1], a[3], b[0], b[1], b[3], able.radii[r])
        for word in range(6):
            plain = words[word, 0] + words[word, 1] + words[word, 2]
            if plain == np.inf:
                continue
            turns = _full_turns(plain, needed, able.radii[r])
            whole = plain + turns * 2.0 * math.pi * able.radii[r]
            if turns == 0:
                lengths[12 * r + 2 * word] = whole
                continue
            for end in range(2):  # of the words that begin, or end, with the same turn, the shortest
                side = word % 2 if end == 0 or word not in (2, 3) else 1 - word % 2
                if whole < turning[r, end, side]:
                    if turning[r, end, side] < np.inf:
                        lengths[held[r, end, side]] = np.inf
                    turning[r, end, side], held[r, end, side] = whole, 12 * r + 2 * word + end
                    lengths[12 * r + 2 * word + end] = whole
    return lengths


@inner
def _full_turns(plain: float, needed: float, radius: float) -> int:
    """Return how many full turns a way needs, one where it has no length."""
    least = 1 if plain < 1e-6 * radius else 0
    return max(least, math.ceil((needed - plain) / (2.0 * math.pi * radius)))


@kernel
def _leg(a: Floats, b: Floats, able: _Able, option: int, profile: int) -> Leg:
    radius = able.radii[option // 12]
    word = option % 12 // 2
    lengths = all_words(a[0], a[1], a[3], b[0], b[1], b[3], radius)[word]
    rise = b[2] - a[2]
    turns = _full_turns(lengths.sum(), climb_length(rise, able.slope, able.bend), radius)
    lengths[2 * (option % 2)] += turns * 2.0 * math.pi * radius
    climb = climb_along(rise, lengths.sum(), able.slope, able.bend, profile)
    return Leg(a[0], a[1], a[2], a[3], word, lengths[0], lengths[1], lengths[2], radius, climb)


@inner
def _clear_profile(space: Space, a: Floats, b: Floats, able: _Able, option: int) -> int:
    """Return the first profile of climb with which a leg is clear and ends where it should, -1 without any."""
    for profile in range(3 if a[2] != b[2] else 1):
        leg = _leg(a, b, able, option, profile)
        x, y, z, _ = place(leg, leg.a + leg.b + leg.c)
        if max(abs(x - b[0]), abs(y - b[1]), abs(z - b[2])) > 1e-7:
            return -1
        verdict = leg_clear(space, leg)
        if verdict == CLEAR:
            return profile
        if verdict == SHUT:
            return -1
    return -1
