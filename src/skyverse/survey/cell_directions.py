"""Which cells of an area are swept in which direction: neighbours with the same direction are swept as one.

Cells of the boustrophedon decomposition along a base direction (Choset 2000, doi 10.1023/A:1008958800904) are given
other directions one by one, or two neighbours at once, as long as the lines of all groups cost less (compare the merged
cells of Agarwal and Akella 2022, doi 10.1109/LRA.2022.3141161).
"""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
import shapely
from scipy.sparse.csgraph import connected_components

from skyverse._typing import Bools, Floats
from skyverse.numerics.tolerances import SWEEP_CONTACT
from skyverse.survey.cells import CrossSections, cross_sections, number_cells, turned, turned_back
from skyverse.survey.visibility import outline

Price = Callable[[Floats, int], float]
"""What the lines of a group cost, from its outline (n, 4) and the number of its direction."""


class SweepCells(NamedTuple):
    """The cells of an area.

    Attributes
    ----------
    segments
        All pieces of borders (s, 4), metres.
    bounds
        Which pieces bound which cells (c, s).
    beside
        Which cells share a border (c, c).
    """

    segments: Floats
    bounds: Bools
    beside: Bools

    def outline(self, cells: frozenset[int]) -> Floats:
        """Return the outline (n, 4) of several cells together."""
        return self.segments[self.bounds[list(cells)].sum(axis=0) == 1]

    def groups(self, cells: frozenset[int]) -> Iterator[frozenset[int]]:
        """Yield the cells that hang together."""
        members = np.array(sorted(cells))
        count, label = connected_components(self.beside[np.ix_(members, members)]) if len(members) else (0, members)
        yield from (frozenset(members[label == k].tolist()) for k in range(count))


def cells_of(area: Any, way: Floats) -> SweepCells:
    """Cut an area along a direction wherever its cross-sections split or meet."""
    sections = cross_sections(turned(outline(area), *way))
    cuts = shapely.linestrings(turned_back(_cuts(sections), way))
    lines = shapely.union_all([*shapely.get_parts(area.boundary), *cuts])
    faces = shapely.get_parts(shapely.polygonize([lines]))
    shapely.prepare(area)
    faces = faces[shapely.contains(area, shapely.point_on_surface(faces))]
    number: dict[bytes, int] = {}
    bounds, segments = [], []
    for face in faces:
        edges = outline(face)
        turn = (edges[:, 0] > edges[:, 2]) | ((edges[:, 0] == edges[:, 2]) & (edges[:, 1] > edges[:, 3]))
        edges[turn] = edges[turn][:, [2, 3, 0, 1]]
        bounds.append([number.setdefault(edge.tobytes(), len(number)) for edge in edges])
        segments.append(edges)
    which = np.zeros((len(faces), len(number)), bool)
    places = np.empty((len(number), 4))
    for i, edges in enumerate(segments):
        which[i, bounds[i]] = True
        places[bounds[i]] = edges
    beside = np.einsum("is,js->ij", which.astype(int), which.astype(int)) > 0
    return SweepCells(places, which, beside)


def _cuts(sections: CrossSections) -> Floats:
    """Return the upright lines (k, 2, 2) at which cells begin and end, in the turned frame."""
    edges, x, first, low, high = sections
    cell = number_cells(sections)
    slab = np.repeat(np.arange(len(x) - 1), np.diff(first))
    _, begins = np.unique(cell, return_index=True)
    ends = len(cell) - 1 - np.unique(cell[::-1], return_index=True)[1]
    at = np.r_[begins, ends]
    where = np.r_[x[slab[begins]], x[slab[ends] + 1]]

    def height(edge: Floats) -> Floats:
        share = np.clip((where - edge[:, 0]) / (edge[:, 2] - edge[:, 0]), 0.0, 1.0)
        return edge[:, 1] + share * (edge[:, 3] - edge[:, 1])

    bottom, top = height(edges[low[at]]) - SWEEP_CONTACT, height(edges[high[at]]) + SWEEP_CONTACT
    return np.stack([np.stack([where, bottom], 1), np.stack([where, top], 1)], axis=1)


def choose_directions(cells: SweepCells, base: int, choices: list[list[int]], price: Price) -> list[int]:
    """Return the number of each cell's direction.

    Parameters
    ----------
    cells
        The cells.
    base
        The direction that all cells have at first.
    choices
        The directions that each cell may have besides.
    price
        What a group costs in a direction.
    """
    known: dict[tuple[int, frozenset[int]], float] = {}

    def total(direction: int, members: frozenset[int]) -> float:
        cost = 0.0
        for group in cells.groups(members):
            if (direction, group) not in known:
                known[direction, group] = price(cells.outline(group), direction)
            cost += known[direction, group]
        return cost

    count = len(choices)
    chosen = [base] * count
    pairs: list[tuple[int, ...]] = [(i,) for i in range(count)]
    pairs += [(int(i), int(j)) for i, j in np.argwhere(np.triu(cells.beside, 1))]
    changed = True
    while changed:
        changed = False
        for moved in pairs:
            beside = {chosen[j] for i in moved for j in np.flatnonzero(cells.beside[i])}
            for direction in sorted({base, *choices[moved[0]], *beside}):
                old = {chosen[i] for i in moved} | {direction}
                if len(old) == 1:
                    continue
                before = {d: frozenset(i for i in range(count) if chosen[i] == d) for d in old}
                after = {d: members - set(moved) for d, members in before.items()}
                after[direction] |= set(moved)
                gain = sum(total(d, before[d]) - total(d, after[d]) for d in old)
                if gain > SWEEP_CONTACT:
                    for i in moved:
                        chosen[i] = direction
                    changed = True
    return chosen
