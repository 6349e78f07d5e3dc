"""The walls of structures, and facets, that are to be seen, cut into cells with three or four corners."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely

from skyverse._typing import Bools, Floats, Indices
from skyverse.model.pad import ground_height
from skyverse.model.scenario import Scenario
from skyverse.model.survey import Survey
from skyverse.referee.blockers import Solid, rings_of
from skyverse.referee.ground_cells import PIXELS_IN_CELL, SIZES
from skyverse.referee.tolerances import LET_PASS

MOST_FACET_CELLS = 400_000
"""Cells at most: larger structures have larger ones."""


class FacetCells(NamedTuple):
    """Flat convex cells of what is to be seen of structures.

    Attributes
    ----------
    corners
        (n, 4, 3) metres, the last one repeated in triangles.
    normal
        (n, 3) to the outside.
    source
        (n,) the number of the wall or facet that each is of.
    solid
        (n,) the index of the solid whose wall it is of; -1 of facets.
    """

    corners: Floats
    normal: Floats
    source: Indices
    solid: Indices

    @property
    def area(self) -> Floats:
        """Square metres, (n,)."""
        a, b, c, d = np.moveaxis(self.corners, 1, 0)
        whole: Floats = np.linalg.norm(np.cross(c - a, d - b), axis=1) / 2
        return whole

    @property
    def outline(self) -> tuple[tuple[float, float, float], ...]:
        """The corners of a rectangle, in the plane of the first cell, that holds all of them, metres."""
        first, sides = self.corners[0, 0], np.roll(self.corners[0], -1, axis=0) - self.corners[0]
        long = np.linalg.norm(sides, axis=1)
        along = sides[long.argmax()] / long.max()
        axes = np.stack([along, np.cross(self.normal[0], along)])
        places = np.einsum("ij,kj->ik", (self.corners.reshape(-1, 3) - first), axes)
        (a, b), (c, d) = places.min(axis=0), places.max(axis=0)
        found = (first + u * axes[0] + v * axes[1] for u, v in ((a, b), (c, b), (c, d), (a, d)))
        return tuple((float(x), float(y), float(z)) for x, y, z in found)

    def of(self, some: Indices | Bools) -> "FacetCells":
        """Return some of them."""
        return FacetCells(self.corners[some], self.normal[some], self.source[some], self.solid[some])

    def halved(self) -> "FacetCells":
        """Return them cut in four, along the lines between the middles of their sides."""
        sides = (self.corners + np.roll(self.corners, -1, axis=1)) / 2
        middle = self.corners.mean(axis=1)
        parts = [np.stack([self.corners[:, k], sides[:, k], middle, sides[:, k - 1]], axis=1) for k in range(4)]
        numbers = np.tile(self.source, 4), np.tile(self.solid, 4)
        cells = FacetCells(np.concatenate(parts), np.tile(self.normal, (4, 1)), *numbers)
        return cells.of(cells.area > 0)

    def inside(self, solids: list[Solid]) -> Bools:
        """Tell of which a part is in, or against, another solid than their own, (n,): no photo shows that."""
        found = np.zeros(len(self.source), dtype=np.bool_)
        low, high = self.corners.min(axis=1), self.corners.max(axis=1)
        for number, solid in enumerate(solids):
            west, south, east, north = shapely.bounds(solid.polygon)
            near = (low < (east, north, solid.high - LET_PASS)) & (high > (west, south, solid.low + LET_PASS))
            some = np.flatnonzero(near.all(axis=1) & (self.solid != number) & ~found)
            outlines = shapely.convex_hull(shapely.multipoints(self.corners[some, :, :2]))
            within = shapely.buffer(solid.polygon, -LET_PASS)
            against = shapely.length(shapely.intersection(outlines, solid.polygon)) > LET_PASS
            found[some] = shapely.intersects(outlines, within) | (against & (self.solid[some] >= 0))
        return found


def facet_cells(scenario: Scenario, survey: Survey, solids: list[Solid]) -> FacetCells:
    """Return the cells of a survey's walls, from the highest ground at their feet upwards, and of its facets."""
    corners, owners, normals = [], list[int](), []
    named = {number for number, one in enumerate(scenario.obstacles) if one.name in survey.structures}
    quads: list[Floats] = []
    solid_of: list[int] = []
    for number, solid in enumerate(solids):
        if solid.obstacle in named:
            walls = [_wall(scenario, solid, a, b) for ring in rings_of(solid.polygon) for a, b in pairwise(ring)]
            quads, solid_of = quads + walls, solid_of + [number] * len(walls)
    quads += [np.array([*facet, facet[2]]) for facet in survey.facets]
    solid_of += [-1] * len(survey.facets)
    size = min(max(PIXELS_IN_CELL * survey.camera.gsd(survey.distance), SIZES[0]), SIZES[1])
    flat = np.array(quads).reshape(-1, 4, 3)
    total = float(np.linalg.norm(np.cross(flat[:, 2] - flat[:, 0], flat[:, 3] - flat[:, 1]), axis=1).sum() / 2)
    size = max(size, float(np.sqrt(total / MOST_FACET_CELLS)))
    for quad, number in zip(quads, solid_of, strict=True):
        across = np.cross(quad[2] - quad[0], quad[3] - quad[1])
        n, m = (
            max(int(np.ceil(max(math.dist(quad[a], quad[b]) for a, b in ends) / size)), 1)
            for ends in (((0, 1), (3, 2)), ((0, 3), (1, 2)))
        )
        u, v = (np.linspace(0, 1, k + 1)[:, None] for k in (n, m))
        low, high = quad[0] + u * (quad[1] - quad[0]), quad[3] + u * (quad[2] - quad[3])
        nodes = low[:, None] + v[None] * (high - low)[:, None]
        cells = np.stack([nodes[:-1, :-1], nodes[1:, :-1], nodes[1:, 1:], nodes[:-1, 1:]], axis=2).reshape(-1, 4, 3)
        length = float(math.hypot(*across))
        if length > 0:
            corners.append(cells)
            normals.append(np.tile(across / length, (len(cells), 1)))
            owners.append(number)
    if not corners:
        none = np.zeros(0, dtype=np.intp)
        return FacetCells(np.zeros((0, 4, 3)), np.zeros((0, 3)), none, none)
    of = np.repeat(np.arange(len(owners)), [len(cells) for cells in corners])
    whole = FacetCells(np.concatenate(corners), np.concatenate(normals), of, np.array(owners)[of])
    return whole.of(whole.area > 0)


def _wall(scenario: Scenario, solid: Solid, a: Floats, b: Floats) -> Floats:
    """Return the corners (4, 3) of a wall, counterclockwise as seen from outside."""
    foot = float(ground_height(scenario, a + np.linspace(0, 1, 33)[:, None] * (b - a)).max())
    low = min(max(solid.low, foot), solid.high)
    return np.array([[*a, low], [*b, low], [*b, solid.high], [*a, solid.high]])
