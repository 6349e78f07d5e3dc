"""A* over poses for an aeroplane: the shortest sequence of legs from the first waypoint to the last.

Legs are Dubins paths with a climb. A leg is tested for obstacles only when it is the next in the queue (a "lazy"
search), since most legs never are.
"""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.heap import Heap, make_heap, pop, push
from skyverse.numerics.kernel import by_reference, inner, kernel
from skyverse.numerics.tolerances import LEG_END, MIN_PLAIN_WAY
from skyverse.space.agility import Agility
from skyverse.space.obstacles import Space
from skyverse.space.world import segment_free
from skyverse.trajectory.dubins import all_words
from skyverse.trajectory.dubins_leg import ALL_ALONG, DubinsLeg, climb_along, climb_length, pose_on_leg
from skyverse.trajectory.dubins_leg_clearance import BLOCKED_AT_ANY_HEIGHT, CLEAR, leg_clear

MAX_WAYPOINTS_AHEAD = 5
"""How many waypoints farther on a leg may lead at most."""
UNSEEN_WAYPOINTS_AHEAD = 2
"""How many of these a leg may lead to even if they are out of sight."""
MAX_TESTS = 10_000
"""Legs that are tested for obstacles, and full turns in them, before a search gives up."""
HEAP_ROWS = 1 << 14
"""Entries that the queue has room for at first."""
OPTIONS_OF_RADIUS = 12
"""Options of a leg for each radius: six words, each with its full turns at the first or at the last letter."""
PROFILES = 3
"""Of a climb: along the whole leg, at its beginning, at its end."""


@by_reference
class Poses(NamedTuple):
    """The poses that legs lead from and to.

    Attributes
    ----------
    at
        (n, 4) x, y, z and heading, in the order of the waypoints.
    first
        (waypoints + 1,) the first pose of each waypoint.
    left
        (n,) estimated metres of way that are left: along the waypoints, or straight on where that is more.
    headings
        How many consecutive poses are at one place.
    """

    at: Floats
    first: Ints
    left: Floats
    headings: int


@kernel
def cheapest_legs(space: Space, poses: Poses, agility: Agility, blind: bool) -> Ints:
    """Return the shortest sequence of legs from the first waypoint to the last, (k, 4), k = 0 where none is found.

    A leg's row is: from pose, to pose, its option as in `_options`, the profile of its climb.
    """
    n, layers = len(poses.at), len(poses.first) - 1
    options = OPTIONS_OF_RADIUS * len(agility.radii)
    come = np.full((n, 4), -1)
    length = np.full(n, np.inf)
    heap = make_heap(HEAP_ROWS)
    tests = MAX_TESTS
    for u in range(poses.first[1]):
        length[u] = 0.0
        heap = _expand(heap, space, poses, agility, length, u, 0, blind)
    while heap.size[0]:
        _, entry = pop(heap)
        u, v, option = entry // options // n, entry // options % n, entry % options
        if length[v] < np.inf:
            continue
        if tests < 0:
            break
        leg = make_leg(poses.at[u], poses.at[v], agility, option, ALL_ALONG)
        tests -= 1 + int((leg.a + leg.c) / (2.0 * math.pi * leg.radius))
        profile = _clear_profile(space, poses.at[u], poses.at[v], agility, option)
        if profile < 0:
            heap = _push_next(heap, poses, agility, length, u, v, option)
            continue
        length[v] = length[u] + leg.a + leg.b + leg.c
        come[v, 0], come[v, 1], come[v, 2], come[v, 3] = u, v, option, profile
        if v >= poses.first[layers - 1]:
            return _legs_to(come, v)
        layer = int(np.searchsorted(poses.first, v, side="right")) - 1
        heap = _expand(heap, space, poses, agility, length, v, layer, blind)
    return np.empty((0, 4), np.int64)


@inner
def _legs_to(come: Ints, v: int) -> Ints:
    """Return the rows of the legs that lead to a pose."""
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
    heap: Heap, space: Space, poses: Poses, agility: Agility, length: Floats, u: int, layer: int, blind: bool
) -> Heap:
    """Queue the shortest leg to every pose of the waypoints ahead; unless `blind`, only of those near or in sight."""
    layers = len(poses.first) - 1
    far = poses.first[min(layers, layer + 1 + UNSEEN_WAYPOINTS_AHEAD)]
    seen = True
    for v in range(poses.first[layer + 1], poses.first[min(layers, layer + 1 + MAX_WAYPOINTS_AHEAD)]):
        if not blind and v >= far and (v - far) % poses.headings == 0:
            seen = segment_free(space, poses.at[u, :3], poses.at[v, :3])
        if seen and length[v] == np.inf:
            heap = _push_next(heap, poses, agility, length, u, v, -1)
    return heap


@inner
def _push_next(heap: Heap, poses: Poses, agility: Agility, length: Floats, u: int, v: int, option: int) -> Heap:
    """Queue the next longer leg between two poses after an option; after -1, the shortest."""
    lengths = _options(poses.at[u], poses.at[v], agility)
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
def _options(a: Floats, b: Floats, agility: Agility) -> Floats:
    """Return the metres of all legs between two poses, infinite where there is none.

    Option ``12 r + 2 word + end`` has radius r and a word, with full turns at its first (`end` 0) or last (1) letter.
    """
    lengths = np.full(OPTIONS_OF_RADIUS * len(agility.radii), np.inf)
    turning = np.full((len(agility.radii), 2, 2), np.inf)
    held = np.zeros((len(agility.radii), 2, 2), np.int64)
    needed = climb_length(b[2] - a[2], agility.slope, agility.rate)
    for r in range(len(agility.radii)):
        words = all_words(a[0], a[1], a[3], b[0], b[1], b[3], agility.radii[r])
        for word in range(6):
            plain = words[word, 0] + words[word, 1] + words[word, 2]
            if plain == np.inf:
                continue
            turns = _full_turns(plain, needed, agility.radii[r])
            whole = plain + turns * 2.0 * math.pi * agility.radii[r]
            if turns == 0:
                lengths[OPTIONS_OF_RADIUS * r + 2 * word] = whole
                continue
            for end in range(2):  # keep the shortest of the words that begin, or end, with the same turn
                side = word % 2 if end == 0 or word not in (2, 3) else 1 - word % 2
                if whole < turning[r, end, side]:
                    if turning[r, end, side] < np.inf:
                        lengths[held[r, end, side]] = np.inf
                    turning[r, end, side], held[r, end, side] = whole, OPTIONS_OF_RADIUS * r + 2 * word + end
                    lengths[OPTIONS_OF_RADIUS * r + 2 * word + end] = whole
    return lengths


@inner
def _full_turns(plain: float, needed: float, radius: float) -> int:
    """Return how many full turns a plain way needs to reach a length, one where it has no length itself."""
    least = 1 if plain < MIN_PLAIN_WAY * radius else 0
    return max(least, math.ceil((needed - plain) / (2.0 * math.pi * radius)))


@kernel
def make_leg(a: Floats, b: Floats, agility: Agility, option: int, profile: int) -> DubinsLeg:
    """Return the leg between two poses, (4,) each, by its option and the profile of its climb."""
    radius = agility.radii[option // OPTIONS_OF_RADIUS]
    word = option % OPTIONS_OF_RADIUS // 2
    lengths = all_words(a[0], a[1], a[3], b[0], b[1], b[3], radius)[word]
    rise = b[2] - a[2]
    turns = _full_turns(lengths.sum(), climb_length(rise, agility.slope, agility.rate), radius)
    lengths[2 * (option % 2)] += turns * 2.0 * math.pi * radius
    climb = climb_along(rise, lengths.sum(), agility.slope, agility.rate, profile)
    return DubinsLeg(a[0], a[1], a[2], a[3], word, lengths[0], lengths[1], lengths[2], radius, climb)


@inner
def _clear_profile(space: Space, a: Floats, b: Floats, agility: Agility, option: int) -> int:
    """Return the first profile of a climb with which a leg is clear and ends where it should, -1 if there is none."""
    for profile in range(PROFILES if a[2] != b[2] else 1):
        leg = make_leg(a, b, agility, option, profile)
        x, y, z, _ = pose_on_leg(leg, leg.a + leg.b + leg.c)
        if max(abs(x - b[0]), abs(y - b[1]), abs(z - b[2])) > LEG_END:
            return -1
        verdict = leg_clear(space, leg)
        if verdict == CLEAR:
            return profile
        if verdict == BLOCKED_AT_ANY_HEIGHT:
            return -1
    return -1
