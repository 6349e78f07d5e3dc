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
from skyverse.referee.tolerances import LET_PASS, NO_LENGTH

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
    """Return the cells of a survey's walls, as far as they are above the ground at their feet, and of its facets."""
    named = {number for number, one in enumerate(scenario.obstacles) if one.name in survey.structures}
    quads: list[Floats] = []
    solid_of: list[int] = []
    for number, solid in enumerate(solids):
        if solid.obstacle in named:
            walls = [_whole(solid, a, b) for ring in rings_of(solid.polygon) for a, b in pairwise(ring)]
            quads, solid_of = quads + walls, solid_of + [number] * len(walls)
    quads += [np.array([*facet, facet[2]]) for facet in survey.facets]
    solid_of += [-1] * len(survey.facets)
    size = min(max(PIXELS_IN_CELL * survey.camera.gsd(survey.distance), SIZES[0]), SIZES[1])
    flat = np.array(quads).reshape(-1, 4, 3)
    total = float(np.linalg.norm(np.cross(flat[:, 2] - flat[:, 0], flat[:, 3] - flat[:, 1]), axis=1).sum() / 2)
    size = max(size, float(np.sqrt(total / MOST_FACET_CELLS)))
    cells = [
        _cut(part, source, number, size)
        for source, (quad, number) in enumerate(zip(quads, solid_of, strict=True))
        for part in ([quad] if number < 0 else _above_ground(scenario, quad, size))
    ]
    none = np.zeros(0, dtype=np.intp)
    cells.append(FacetCells(np.zeros((0, 4, 3)), np.zeros((0, 3)), none, none))
    whole = FacetCells(*(np.concatenate(column) for column in zip(*cells, strict=True)))
    return whole.of(whole.area > 0)


def _cut(quad: Floats, source: int, solid: int, size: float) -> FacetCells:
    """Return the cells of a part of a wall or facet, (4, 3); none where it has no area."""
    across = np.cross(quad[2] - quad[0], quad[3] - quad[1])
    length = float(math.hypot(*across))
    n, m = (
        max(int(np.ceil(max(math.dist(quad[a], quad[b]) for a, b in ends) / size)), 1)
        for ends in (((0, 1), (3, 2)), ((0, 3), (1, 2)))
    )
    u, v = (np.linspace(0, 1, k + 1)[:, None] for k in (n, m))
    low, high = quad[0] + u * (quad[1] - quad[0]), quad[3] + u * (quad[2] - quad[3])
    nodes = low[:, None] + v[None] * (high - low)[:, None]
    cells = np.stack([nodes[:-1, :-1], nodes[1:, :-1], nodes[1:, 1:], nodes[:-1, 1:]], axis=2).reshape(-1, 4, 3)
    cells = cells if length > 0 else cells[:0]
    count = len(cells)
    return FacetCells(
        cells, np.tile(across / max(length, NO_LENGTH), (count, 1)), np.full(count, source), np.full(count, solid)
    )


def _whole(solid: Solid, a: Floats, b: Floats) -> Floats:
    """Return the corners (4, 3) of a wall, counterclockwise as seen from outside."""
    return np.array([[*a, solid.low], [*b, solid.low], [*b, solid.high], [*a, solid.high]])


def _above_ground(scenario: Scenario, wall: Floats, size: float) -> Floats:
    """Return columns (n, 4, 3) of a wall that together hold all of it that is above the ground, and little else.

    Columns end where lines of the terrain's grid pass. Between two of these the ground at the foot is a parabola, of
    which the tangent in the middle is parallel to the line between its ends: columns begin at the lower of both.
    """
    a, b, low, high = wall[0, :2], wall[1, :2], wall[0, 2], wall[2, 2]
    shares = [np.linspace(0, 1, max(int(np.ceil(math.dist(a, b) / size)), 1) + 1)]
    if scenario.terrain is not None:
        for k, lines in enumerate(scenario.terrain.heights.shape):
            if abs(b[k] - a[k]) > NO_LENGTH:
                grid = scenario.terrain.origin[k] + scenario.terrain.step[k] * np.arange(lines)
                shares.append((grid - a[k]) / (b[k] - a[k]))
    share = np.concatenate(shares)
    share = np.unique(share[(share >= 0) & (share <= 1)])
    share = share[np.diff(share, append=2) * math.dist(a, b) > LET_PASS]
    share[0] = 0
    middle = (share[1:] + share[:-1]) / 2
    ground, inner = (ground_height(scenario, a + s[:, None] * (b - a)) for s in (share, middle))
    side = np.stack([ground[:-1], ground[1:]])
    side = side - np.maximum(side.mean(axis=0) - inner, 0) - low
    # where the ground meets the lower edge, both sides are lowered until the line between them is nowhere above both
    meets = np.where(side[0] * side[1] < 0, -side[0] * side[1] / np.maximum(abs(side[1] - side[0]), NO_LENGTH), 0)
    floor = np.minimum(low + np.maximum(side, 0) - meets, high)
    left, right = a + share[:-1, None] * (b - a), a + share[1:, None] * (b - a)
    top = np.full(len(middle), high)
    corners = [np.column_stack(one) for one in ((left, floor[0]), (right, floor[1]), (right, top), (left, top))]
    return np.stack(corners, axis=1)
