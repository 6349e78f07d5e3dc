"""What a camera is certain to show of facets, wherever within its errors it is and looks, and what hides them."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Ints
from skyverse.interrupt import raise_if_interrupted
from skyverse.model.pad import ground_height
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.survey import Survey
from skyverse.model.uav import TrackingError
from skyverse.numerics.kernel import inner, inner_query, kernel
from skyverse.space.obstacles import Space, crosses
from skyverse.space.world import World
from skyverse.survey.facets import Facets

MOST_SLANT = 70.0
"""Degrees between a facet's normal and the sight on it, at most."""
OFF_WALL = 0.01
"""Metres in front of a facet, and the share of the way from its corners to its centre, where sights on it end."""
AT_ONCE = 1_000
"""Views for which the answers are held in memory at once."""


class Look(NamedTuple):
    """How a camera sees from a view, which is x, y, z in metres, heading and pitch in degrees.

    Attributes
    ----------
    wide, high
        Half of what it shows across and along its upright side, for each metre of distance.
    depth
        Metres along the optical axis at most.
    aside, up
        By how much its position may be off, metres.
    turn
        The sine of the angle by which its direction may be off.
    slant
        The cosine of the greatest angle between a normal and a sight.
    """

    wide: float
    high: float
    depth: float
    aside: float
    up: float
    turn: float
    slant: float

    @property
    def off(self) -> float:
        """By how much the position may be off, metres."""
        return math.hypot(self.aside, self.up)

    @property
    def corner(self) -> float:
        """The length of the sight on a picture's corner, for each metre of distance."""
        return math.sqrt(1.0 + self.wide**2 + self.high**2)

    @property
    def distance(self) -> float:
        """Metres along the optical axis at which all of a picture is certain to be no farther than `depth`."""
        return self.depth * (1.0 - self.turn * self.corner) - self.off


def look_of(survey: Survey, error: TrackingError) -> Look:
    """Return how a survey's camera sees that is carried by a UAV with a tracking error."""
    wide, high = survey.camera.half_widths
    turn = math.sin(math.radians(survey.camera.attitude_error))
    look = Look(wide, high, survey.distance, error.horizontal, error.vertical, turn, math.cos(math.radians(MOST_SLANT)))
    if survey.gsd is not None:
        return look
    return look._replace(depth=(survey.distance + look.off) / (1.0 - turn * look.corner))


def axes_of(heading: float, pitch: float) -> Floats:
    """Return the directions ahead, to the right and up of a camera, (3, 3), from degrees."""
    h, p = math.radians(heading), math.radians(pitch)
    (s, c), (u, v) = (math.sin(h), math.cos(h)), (math.sin(p), math.cos(p))
    return np.array([(v * s, v * c, u), (c, -s, 0.0), (-u * s, -u * c, v)])


Vector = tuple[float, float, float]


@inner_query
def _along(direction: Floats, v: Vector) -> float:
    return direction[0] * v[0] + direction[1] * v[1] + direction[2] * v[2]


@inner_query
def _off(look: Look, direction: Floats) -> float:
    """Return how far a position may be off in a direction, metres."""
    return look.aside * math.hypot(direction[0], direction[1]) + look.up * abs(direction[2])


@inner_query
def _from(a: Floats, b: Floats) -> Vector:
    return b[0] - a[0], b[1] - a[1], b[2] - a[2]


@inner_query
def _volume(a: Vector, b: Vector, c: Vector) -> float:
    """Return the scalar triple product of three vectors."""
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])


@kernel
def _seen(look: Look, places: Floats, axes: Floats, corners: Floats, normals: Floats) -> NDArray[np.bool_]:
    """Tell for each view (m,) and facet (n,) whether all of the facet is in the picture, near and upright enough.

    A rotation by an angle turns no sight by more, so that a sight stays within a side of the picture if its angle to
    that side's plane is at least that angle; how much nearer to the plane the position may be is taken off.
    """
    seen = np.ones((len(places), len(corners)), np.bool_)
    off = math.hypot(look.aside, look.up)
    sides, offs = np.empty((4, 3)), np.empty(4)
    for i in range(len(places)):
        for side in range(4):
            half, across = (look.wide, axes[i, 1]) if side < 2 else (look.high, axes[i, 2])
            sign = 1.0 if side % 2 else -1.0
            for axis in range(3):
                sides[side, axis] = (half * axes[i, 0, axis] + sign * across[axis]) / math.hypot(1.0, half)
            offs[side] = _off(look, sides[side])
        far = _off(look, axes[i, 0])
        for j in range(len(corners)):
            aside = _off(look, normals[j])
            for k in range(4):
                v = _from(places[i], corners[j, k])
                length = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + off
                if (
                    -_along(normals[j], v) - aside < look.slant * length
                    or _along(axes[i, 0], v) + far + look.turn * length > look.depth
                    or _along(sides[0], v) - offs[0] < look.turn * length
                    or _along(sides[1], v) - offs[1] < look.turn * length
                    or _along(sides[2], v) - offs[2] < look.turn * length
                    or _along(sides[3], v) - offs[3] < look.turn * length
                ):
                    seen[i, j] = False
                    break
    return seen


@inner_query
def _meets(triangle: Floats, a: Floats, b: Floats) -> bool:
    """Tell whether a segment meets a triangle (Moeller and Trumbore 1997)."""
    d, w = _from(a, b), _from(triangle[0], a)
    u, v = _from(triangle[0], triangle[1]), _from(triangle[0], triangle[2])
    det = _volume(u, d, v)
    if det == 0.0:
        return False
    s, t, share = _volume(w, d, v) / det, _volume(d, w, u) / det, _volume(v, w, u) / det
    return s >= 0.0 and t >= 0.0 and s + t <= 1.0 and 0.0 <= share <= 1.0


@inner
def _near(triangles: Floats, starts: Floats, ends: Floats, found: Ints) -> int:
    """Write which triangles meet the box around places (k, 3) and (l, 3), and return how many there are."""
    count, low, high = 0, np.empty(3), np.empty(3)
    for axis in range(3):
        low[axis] = min(starts[:, axis].min(), ends[:, axis].min())
        high[axis] = max(starts[:, axis].max(), ends[:, axis].max())
    for j in range(len(triangles)):
        meets = True
        for axis in range(3):
            a, b, c = triangles[j, 0, axis], triangles[j, 1, axis], triangles[j, 2, axis]
            meets = meets and max(a, b, c) >= low[axis] and min(a, b, c) <= high[axis]
        if meets:
            found[count] = j
            count += 1
    return count


@kernel
def _clear(space: Space, triangles: Floats, starts: Floats, ends: Floats, which: Ints) -> NDArray[np.bool_]:
    """Tell of places (n, k, 3) and some of (m, l, 3), `which` (n,), whether all lines between them are free, (n,)."""
    clear = np.ones(len(starts), np.bool_)
    near = np.empty(len(triangles), np.int64)
    for i in range(len(starts)):
        sights = ends[which[i]]
        count = _near(triangles, starts[i], sights, near)
        for k in range(starts.shape[1] * len(sights)):
            a, b = starts[i, k % starts.shape[1]], sights[k // starts.shape[1]]
            clear[i] = not crosses(space, -space.clearance, a, b)
            for j in range(count):
                clear[i] = clear[i] and not _meets(triangles[near[j]], a, b)
            if not clear[i]:
                break
    return clear


class Sights:
    """What views see of facets, over a scenario's ground and with its solid obstacles and a survey's facets in between.

    Parameters
    ----------
    scenario, survey
        The space, and one of its surveys.
    look
        How its camera sees.
    """

    def __init__(self, scenario: Scenario, survey: Survey, look: Look) -> None:
        solid = tuple(derived(one, closed_above=False) for one in scenario.obstacles if one.solid)
        ground = None if scenario.terrain is None else derived(scenario.terrain, clearance=None)
        changes = {"obstacles": solid, "terrain": ground, "surveys": (), "max_height": None}
        self.world, self.look = World(derived(scenario, **changes)), look
        own = tuple(one for one in scenario.obstacles if one.name and one.name in survey.structures)
        self.structures = World(derived(scenario, **{**changes, "obstacles": own, "terrain": None}))
        self.triangles = np.array(survey.facets, dtype=np.float64).reshape(-1, 3, 3)
        aside, up = look.aside, look.up
        rim = [(aside, 0.0, up), (-aside, 0.0, up), (0.0, aside, up), (0.0, -aside, up)]
        rim = [(0.0, 0.0, 0.0), *rim, *((x, y, -z) for x, y, z in rim)]
        self.strays = np.unique(np.array(rim), axis=0)

    def seen(self, views: Floats, facets: Facets) -> tuple[Ints, Ints]:
        """Return the pairs of a view (m, 5) and a facet that it is certain to show, their numbers in rising order."""
        rows: list[Ints] = [np.zeros((2, 0), dtype=np.int64)]
        for first in range(0, len(views), AT_ONCE):
            raise_if_interrupted()
            part = np.ascontiguousarray(views[first : first + AT_ONCE])
            axes = np.array([axes_of(heading, pitch) for heading, pitch in part[:, 3:]])
            seen = _seen(self.look, part[:, :3].copy(), axes, facets.corners, facets.normal)
            view, facet = np.nonzero(seen)
            clear = self.clear(part[view, :3], facets, facet)
            rows.append(np.array([view[clear] + first, facet[clear]]))
        view, facet = np.concatenate(rows, axis=1)
        return view, facet

    def inside_structures(self, facets: Facets) -> NDArray[np.bool_]:
        """Tell which facets lie inside the survey's structures, (n,): those that its obstacles cover together."""
        if not self.structures.scenario.obstacles:
            return np.zeros(len(facets), dtype=np.bool_)
        depth = self.structures.distance(self._before(facets).reshape(-1, 3)).reshape(-1, 4)
        return np.asarray((depth < 0.0).all(axis=1), dtype=np.bool_)

    def _before(self, facets: Facets) -> Floats:
        """Return places (n, 4, 3) close before the facets' corners, and above the ground."""
        inward = facets.corners + OFF_WALL * (facets.centre[:, None] - facets.corners)
        places = inward + OFF_WALL * facets.normal[:, None]
        places[..., 2] = np.maximum(places[..., 2], ground_height(self.world.scenario, places[..., :2]) + OFF_WALL)
        return places

    def clear(self, places: Floats, facets: Facets, which: Ints) -> NDArray[np.bool_]:
        """Tell for each place (n, 3) and facet (n,) whether nothing hides a corner of it, (n,)."""
        starts = places[:, None] + self.strays
        return _clear(self.world.space, self.triangles, starts, self._before(facets), which)
