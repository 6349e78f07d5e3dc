"""Trajectories of aeroplanes along waypoints: constant horizontal speed, Dubins paths, bounded climbs.

Headings at the waypoints, and which waypoints to keep, are searched for at once: A* over poses, which are set at and
beside the waypoints, with legs that are Dubins paths. An aeroplane is level at every pose.
"""

import itertools
import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.model.arrays import arctan2
from skyverse.model.trajectory import Trajectory, joined
from skyverse.model.uav import UAV
from skyverse.numerics.kernel import kernel
from skyverse.numerics.tolerances import MIN_FLOWN, TURN_BACK
from skyverse.search.path_shortening.shortcut import drop_collinear
from skyverse.space.agility import Agility, agility_of, fixed_wing
from skyverse.space.world import World
from skyverse.trajectory.dubins import all_words
from skyverse.trajectory.dubins_leg import MAX_ARC, leg_pieces
from skyverse.trajectory.pose_search import Poses, cheapest_legs, make_leg

FINE_ARC = MAX_ARC / 2.0
"""Radians that a polynomial turns at most where more legs follow, whose errors add up."""
LONG_LEG = 4.0
"""Least turn radii: a longer leg gets poses in between in the widest search."""


class SearchSettings(NamedTuple):
    """How far a search for an aeroplane's way reaches.

    Attributes
    ----------
    offsets
        Of poses from their waypoint: outwards and along the way, in least turn radii.
    radii
        Of turns, in least turn radii.
    headings
        How many are tried at each place.
    greed
        The weight of the way that is left. Above 1, progress is preferred to a short way.
    wide
        Whether poses are set on long legs too, and waypoints that are out of sight are flown to directly.
    """

    offsets: tuple[tuple[float, float], ...]
    radii: tuple[float, ...]
    headings: int
    greed: float
    wide: bool


def _cross(reach: float) -> tuple[tuple[float, float], ...]:
    """Return offsets along both axes, as far as a reach."""
    return ((0.0, 0.0), (0.4, 0.0), (reach, 0.0), (-reach, 0.0), (0.0, reach), (0.0, -reach))


SEARCHES = (
    SearchSettings(((0.0, 0.0), (0.3, 0.0), (0.8, 0.0)), (1.0, 1.5), headings=16, greed=1.0, wide=False),
    SearchSettings(_cross(1.3), (1.0,), headings=16, greed=3.0, wide=False),
    SearchSettings(_cross(1.5), (1.0, 1.5), headings=8, greed=3.0, wide=True),
)
"""Tried in turn until one finds a way: first for a short way, then for any way soon, then for one farther aside."""


Headings = tuple[float | None, float | None]
"""At the start and at the target, radians from the x-axis towards the y-axis; ``None`` where it is free."""


def fly_aeroplane(world: World, waypoints: Floats, uav: UAV, headings: Headings = (None, None)) -> Trajectory | None:
    """Fly an aeroplane along waypoints, or return ``None`` where no way is found.

    It keeps its horizontal speed, turns on arcs of its least radius or somewhat wider ones, and is level at its start,
    at its target, and where one leg ends and the next begins. Waypoints may be left out, or passed on the outside.
    Where start and target are the same point it flies a full turn.

    Parameters
    ----------
    world
        With the obstacles.
    waypoints
        (n, 3) metres, from start to target; the straight legs between them are clear.
    uav
        A UAV with `fixed_wing`.
    headings
        At the start and at the target.

    Returns
    -------
    Trajectory
        Of form ``"dubins"``, from 0 s on; position and velocity are continuous.
    """
    points = drop_collinear(waypoints)
    if len(points) == 1:
        points = np.vstack([points, points])
    level = agility_of(uav)
    least, slope = float(level.radii[0]), math.tan(math.radians(fixed_wing(uav).climb))
    for settings in SEARCHES:
        agility = level._replace(radii=least * np.array(settings.radii))
        poses = _poses(world, points, settings, least, slope, headings)
        legs = cheapest_legs(world.space, poses, agility, settings.wide)
        if len(legs):
            arc = MAX_ARC if headings[1] is None else FINE_ARC
            return _trajectory(poses.at, legs, agility, fixed_wing(uav).speed, arc)
    return None


def fly_straight(world: World, path: Floats, uav: UAV) -> Trajectory | None:
    """Fly an aeroplane straight along a path (n, 3), level at its points; ``None`` where that is not clear."""
    parts = []
    for a, b in itertools.pairwise(path):
        heading = math.atan2(b[1] - a[1], b[0] - a[0])
        part = fly_aeroplane(world, np.stack([a, b]), uav, (heading, heading))
        if part is None:
            return None
        parts.append(part)
    return joined(parts)


def least_ways(leaving: Floats, entering: Floats, uav: UAV) -> Floats:
    """Return metres (n, n) below which no way is between places (n, 3): x, y and heading where it leaves and enters.

    A heading that is not a number is free.
    """
    return _least_ways(leaving, entering, float(agility_of(uav).radii[0]))


@kernel
def _least_ways(leaving: Floats, entering: Floats, radius: float) -> Floats:
    n = len(leaving)
    least = np.empty((n, n))
    for i in range(n):
        x, y, heading = leaving[i]
        for k in range(n):
            x1, y1, heading1 = entering[k]
            straight = math.hypot(x1 - x, y1 - y)
            if math.isnan(heading) or math.isnan(heading1):
                least[i, k] = straight
            else:
                words = all_words(x, y, heading, x1, y1, heading1, radius)
                least[i, k] = max(straight, (words[:, 0] + words[:, 1] + words[:, 2]).min())
    return least


def _between(points: Floats, least: float) -> Floats:
    """Return the waypoints and three more on each leg that is longer than `least` metres."""
    rows = [points[:1]]
    for a, b in itertools.pairwise(points):
        shares = np.array([0.25, 0.5, 0.75, 1.0]) if math.dist(b, a) > least else np.array([1.0])
        rows.append(a + shares[:, None] * (b - a))
    return np.vstack(rows)


def _poses(
    world: World, points: Floats, settings: SearchSettings, radius: float, slope: float, ends: Headings
) -> Poses:
    """Return poses at the waypoints and beside those in between, in as many headings as the settings say.

    Start and target have only the headings that are given for them.
    """
    if settings.wide:
        points = _between(points, LONG_LEG * radius)
    courses = arctan2(*np.diff(points, axis=0).T[1::-1])
    moving = np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1) > MIN_FLOWN
    rows, counts = [], []
    for i, point in enumerate(points):
        before, after = courses[:i][moving[:i]][-1:], courses[i:][moving[i:]][:1]
        known = np.r_[before, after] if len(before) + len(after) else np.zeros(1)
        ways = np.column_stack([np.cos(known), np.sin(known)])
        along = ways.sum(axis=0)
        if math.hypot(*along) < TURN_BACK:  # the path turns straight back
            along = np.array([-ways[0, 1], ways[0, 0]])
        heading = math.atan2(along[1], along[0])
        along = np.array([math.cos(heading), math.sin(heading)])
        outward = np.array([-along[1], along[0]])
        if len(ways) == 2 and np.sum(outward * (ways[0] - ways[1])) < 0.0:
            outward = -outward
        places = np.array([point])
        if 0 < i < len(points) - 1:
            shifts = radius * np.array([out * outward + on * along for out, on in settings.offsets])
            places = point + np.column_stack([shifts, np.zeros(len(shifts))])
        places = places[world.free(places)]
        headings = heading + np.arange(settings.headings) * (2.0 * math.pi / settings.headings)
        given = ends[0] if i == 0 else ends[1] if i == len(points) - 1 else None
        if given is not None:
            headings = np.full(1 if i == 0 else settings.headings, given)
        rows.append(np.column_stack([np.repeat(places, len(headings), axis=0), np.tile(headings, len(places))]))
        counts.append(len(rows[-1]))
    at = np.vstack(rows)
    ahead = np.repeat(_left(points, slope), counts)
    aside = np.hypot(*(at[:, :2] - np.repeat(points[:, :2], counts, axis=0)).T)
    straight = np.hypot(*(points[-1] - at[:, :3])[:, :2].T)
    left = settings.greed * np.maximum(ahead - aside, straight)
    return Poses(at, np.r_[0, np.cumsum(counts)], left, settings.headings)


def _left(points: Floats, slope: float) -> Floats:
    """Return the metres of way (n,) that are left from each waypoint on, as no climb may be steeper than a slope."""
    steps = np.diff(points, axis=0)
    left = np.zeros(len(points))
    # consecutive steps that all rise, or all descend: the way left after them, their own way, and their rise
    end, way, rise = 0.0, 0.0, 0.0
    for i in range(len(steps) - 1, -1, -1):
        if rise * steps[i, 2] < 0.0:
            end, way, rise = left[i + 1], 0.0, 0.0
        way, rise = way + math.hypot(steps[i, 0], steps[i, 1]), rise + steps[i, 2]
        left[i] = end + max(way, abs(rise) / slope)
    return left


def _trajectory(poses: Floats, legs: Ints, agility: Agility, speed: float, arc: float) -> Trajectory:
    """Return the trajectory along legs as from `cheapest_legs`, in pieces that turn by an `arc` at most, rad."""
    durations, pieces = [], []
    for u, v, option, profile in legs.tolist():
        duration, coefficients = leg_pieces(make_leg(poses[u], poses[v], agility, option, profile), speed, arc)
        durations.append(duration)
        pieces.append(coefficients)
    knots = np.r_[0.0, np.cumsum(np.concatenate(durations))]
    return Trajectory(knots, np.concatenate(pieces), form="dubins")
