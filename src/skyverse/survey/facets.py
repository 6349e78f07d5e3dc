"""Facets: what is to be seen of structures, cut to pieces that are much smaller than what a photo shows."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.polygon import orient

from skyverse._typing import Floats, Ints
from skyverse.model.arrays import arctan2
from skyverse.model.pad import ground_height
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import Cylinder, Prism, Shape, Sphere, Voxels
from skyverse.model.survey import Survey

ROUND_SIDES = 24
"""Sides at least of the polygon around a circle, whose corners are then at most 0.9 % farther out."""
ALONG, DEEPER = 129, 1.25
"""Places along a facet's foot at which the ground is looked at, and how much deeper it may dip between them."""
SMALLEST = 1e-4
"""Square metres: smaller facets are left out."""


class StructureOutline(NamedTuple):
    """A structure seen from above: rings (k, 2) with the structure on their left; and z of its foot and its top."""

    rings: tuple[Floats, ...]
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Facets:
    """Facets, four corners each, of which triangles have the last one twice, counterclockwise as seen from outside.

    Attributes
    ----------
    corners
        (n, 4, 3) metres.
    normal
        (n, 3) of length 1, outwards.
    wall
        (n,) the number of the flat part of a structure that it is cut from.
    """

    corners: Floats
    normal: Floats
    wall: Ints

    def __len__(self) -> int:
        return len(self.corners)

    @property
    def centre(self) -> Floats:
        """(n, 3) metres."""
        return self.corners.mean(axis=1)

    def chosen(self, which: NDArray[np.bool_]) -> "Facets":
        """Return those for which a truth value is given, (n,)."""
        return Facets(self.corners[which], self.normal[which], self.wall[which])


def outlines(scenario: Scenario, survey: Survey) -> list[StructureOutline]:
    """Return the outlines of a survey's structures; of voxels, spheres and facets those around all of them."""
    found = [outline(shape) for shape in scenario.obstacles if shape.name and shape.name in survey.structures]
    if survey.facets:
        corners = np.array(survey.facets).reshape(-1, 3)
        hull = orient(shapely.convex_hull(shapely.multipoints(corners[:, :2])).buffer(SMALLEST, cap_style="square"))
        ring = shapely.get_coordinates(hull.exterior.simplify(2.0 * SMALLEST))[:-1]
        found.append(StructureOutline((ring,), corners[:, 2].min(), corners[:, 2].max()))
    return found


def outline(shape: Shape) -> StructureOutline:
    """Return the outline of a shape."""
    low, high = extent(shape)
    if isinstance(shape, Cylinder | Sphere):
        return StructureOutline((_around(shape.centre[:2], shape.radius, ROUND_SIDES),), low[2], high[2])
    if isinstance(shape, Prism):
        flat = orient(shapely.Polygon(shape.vertices, shape.holes))
        rings = (flat.exterior, *flat.interiors)
        return StructureOutline(tuple(shapely.get_coordinates(ring)[:-1] for ring in rings), low[2], high[2])
    (x, y), (u, v) = low[:2], high[:2]
    return StructureOutline((np.array([(x, y), (u, y), (u, v), (x, v)]),), low[2], high[2])


def _around(centre: tuple[float, float], radius: float, sides: int) -> Floats:
    """Return the corners (sides, 2) of the polygon whose sides touch a circle."""
    turn = 2.0 * math.pi * (np.arange(sides) - 0.5) / sides
    return np.array(centre) + radius / math.cos(math.pi / sides) * np.column_stack([np.cos(turn), np.sin(turn)])


def facets_of(scenario: Scenario, survey: Survey, size: float) -> Facets:
    """Return what a survey is to see of its structures: walls above ground, and its facets; not roofs.

    Parameters
    ----------
    scenario, survey
        The space, and one of its surveys.
    size
        Metres, the longest side of a facet.

    Returns
    -------
    Facets
        Of round walls those of a polygon around them.
    """
    shapes = [shape for shape in scenario.obstacles if shape.name and shape.name in survey.structures]
    parts = [part for shape in shapes for part in _parts(shape, size)]
    parts += [_cut_triangle(np.array(facet), size) for facet in survey.facets]
    wall = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
    corners = np.concatenate([np.zeros((0, 4, 3)), *parts])
    floor = np.maximum(ground_height(scenario, corners[..., :2]), scenario.bounds.min[2])
    floor -= _dips(scenario, corners)[:, None]
    above = (corners[..., 2] > floor).any(axis=1)
    flat = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    z, foot = corners[..., 2], corners[..., 2].min(axis=1)
    a, b = (floor[:, ::2] - foot[:, None]).T  # by how much the ground is above the lower edge at its ends
    meets = np.where(a * b < 0.0, -a * b / np.where(a == b, 1.0, abs(b - a)), 0.0)
    corners[..., 2] = np.maximum(z, floor) - np.where(z == foot[:, None], meets[:, None], 0.0)
    length = np.sqrt((flat**2).sum(axis=1))
    above &= length > 2.0 * SMALLEST
    return Facets(corners[above], flat[above] / length[above, None], wall[above])


def _dips(scenario: Scenario, corners: Floats) -> Floats:
    """Return by how much the ground below facets is at most lower than straight between its ends there, (n,) metres."""
    share = np.linspace(0.0, 1.0, ALONG)[:, None]
    a, b = corners[:, None, 0, :2], corners[:, None, 2, :2]
    ground = ground_height(scenario, a + share * (b - a))
    straight = ground[:, :1] + share[:, 0] * (ground[:, -1:] - ground[:, :1])
    dips: Floats = DEEPER * (straight - ground).max(axis=1)
    return dips


def _parts(shape: Shape, size: float) -> Iterator[Floats]:
    """Yield the flat parts of a shape's walls, each cut to facets (n, 4, 3); of spheres those all around."""
    if isinstance(shape, Sphere):
        yield from _globe(shape, size)[:, None]
        return
    if isinstance(shape, Voxels):
        yield from _faces(shape, size)[:, None]
        return
    rings, low, high = outline(shape)
    if isinstance(shape, Cylinder):
        sides = max(ROUND_SIDES, math.ceil(2.0 * math.pi * shape.radius / size))
        rings = (_around(shape.centre, shape.radius, sides),)
    for ring in rings:
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            yield _cut_wall(np.array([*a, low]), np.array([*b, low]), np.array([0.0, 0.0, high - low]), size)


def _cut_wall(a: Floats, b: Floats, up: Floats, size: float) -> Floats:
    """Return a parallelogram, from `a` along to `b` and `up`, cut to equal parts, (n, 4, 3)."""
    across, along = (max(1, math.ceil(math.sqrt((side**2).sum()) / size)) for side in (b - a, up))
    s, t = (g.ravel()[:, None] for g in np.meshgrid(np.arange(across) / across, np.arange(along) / along))
    steps = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    corners = [a + (s + i / across) * (b - a) + (t + j / along) * up for i, j in steps]
    return np.stack(corners, axis=1)


def _cut_triangle(triangle: Floats, size: float) -> Floats:
    """Return a triangle cut to equal ones, (n, 4, 3)."""
    a, b, c = triangle
    sides = np.sqrt(((triangle - np.roll(triangle, 1, axis=0)) ** 2).sum(axis=1))
    n = max(1, math.ceil(sides.max() / size))
    u, v = (b - a) / n, (c - a) / n
    cells = [(i, j) for i in range(n) for j in range(n - i)]
    found = [(a + i * u + j * v, a + (i + 1) * u + j * v, a + i * u + (j + 1) * v) for i, j in cells]
    found += [
        (a + (i + 1) * u + j * v, a + (i + 1) * u + (j + 1) * v, a + i * u + (j + 1) * v)
        for i, j in cells
        if i + j < n - 1
    ]
    corners = np.array(found)
    return np.concatenate([corners, corners[:, 2:]], axis=1)


def _globe(sphere: Sphere, size: float) -> Floats:
    """Return flat facets around a sphere between circles of latitude and longitude, (n, 4, 3), that touch it."""
    rows = max(ROUND_SIDES // 2, math.ceil(math.pi * sphere.radius / size))
    i, j = (g.ravel() for g in np.meshgrid(np.arange(rows), np.arange(2 * rows)))
    corners = []
    for down, on in ((0, 0), (0, 1), (1, 1), (1, 0)):
        north, east = math.pi * (0.5 - (i + 1 - down) / rows), math.pi * (j + on) / rows
        corners.append(np.column_stack([np.cos(north) * np.cos(east), np.cos(north) * np.sin(east), np.sin(north)]))
    unit = np.stack(corners, axis=1)
    normal = np.cross(unit[:, 2] - unit[:, 0], unit[:, 3] - unit[:, 1])
    normal /= np.sqrt((normal**2).sum(axis=1))[:, None]
    near = (unit * normal[:, None]).sum(axis=2).min(axis=1)
    return np.array(sphere.centre) + sphere.radius * unit / near[:, None, None]


def _faces(voxels: Voxels, size: float) -> Floats:
    """Return the upright faces between occupied and free cells, (n, 4, 3)."""
    full, step, found = voxels.occupied, np.array(voxels.step), []
    for axis in range(3):
        parts = math.ceil(step[axis] / size)
        full, step[axis] = np.repeat(full, parts, axis=axis), step[axis] / parts
    full = np.pad(full, 1)
    for axis in range(2):
        u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
        for side in (0, 1):
            bare = full & ~np.roll(full, 1 - 2 * side, axis=axis)
            at = np.argwhere(bare)[:, None] - 1.0 + side * np.eye(3)[axis]
            ring = np.array([0 * u, u, u + v, v]) if side else np.array([0 * u, v, u + v, u])
            found.append(at + ring)
    return np.array(voxels.origin) + np.concatenate(found) * step


def heading_of(direction: Floats) -> float:
    """Return where a direction (2 or more,) points, degrees clockwise from north."""
    return float(np.degrees(arctan2(direction[0], direction[1])) % 360.0)
