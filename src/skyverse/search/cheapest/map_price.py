"""The least price of a metre over each cell of a lattice on the map, at whatever altitude it is flown."""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Bools, Floats, Ints
from skyverse.cost import Rates
from skyverse.numerics.kernel import by_reference, inner
from skyverse.numerics.tolerances import COVER_MARGIN
from skyverse.search.cheapest.altitude_gain import is_counted
from skyverse.space import polygon
from skyverse.space.obstacles import Space
from skyverse.space.solids import BOX, CYLINDER, PRISM, Solids
from skyverse.space.tree import FIRST, SKIP, STOP

RIM = 2
"""Cells at each side of a lattice over which no path needs to lead."""


@by_reference
class MapLattice(NamedTuple):
    """Square cells around nodes; one node is the start, and a row of them leads to the goal.

    Attributes
    ----------
    start, ahead
        (2,) metres, and (2,) the direction of the goal, a unit vector.
    step
        Metres between nodes.
    first
        (2,) the numbers of the first node ahead of the start, and to its left; 0 is the start itself.
    price
        (n, m) the least price of a metre over each cell.
    free
        (n, m) whether a path that costs less than a known one may lead over the cell.
    """

    start: Floats
    ahead: Floats
    step: float
    first: Ints
    price: Floats
    free: Bools


@inner
def make_map_lattice(
    space: Space, rates: Rates, start: Floats, goal: Floats, longest: float, cells: int, least_steps: int
) -> MapLattice:
    """Return a lattice over all places from which the distances to start and goal add up to at most so many metres.

    Parameters
    ----------
    space, rates
        What must be kept clear of, and what is priced.
    start, goal
        (3,) metres; they must differ on the map.
    longest
        Metres on the map.
    cells
        About how many cells there are.
    least_steps
        At least so many steps lead from start to goal.
    """
    ahead = goal[:2] - start[:2]
    across = math.sqrt(ahead[0] ** 2 + ahead[1] ** 2)
    ahead = ahead / across
    beside, beyond = math.sqrt(max(0.0, longest**2 - across**2)) / 2, (longest - across) / 2
    low, high = np.full(2, math.inf), np.full(2, -math.inf)
    for corner in range(4):
        x = (space.high[0] if corner & 1 else space.low[0]) - start[0]
        y = (space.high[1] if corner & 2 else space.low[1]) - start[1]
        low[0], high[0] = min(low[0], x * ahead[0] + y * ahead[1]), max(high[0], x * ahead[0] + y * ahead[1])
        low[1], high[1] = min(low[1], y * ahead[0] - x * ahead[1]), max(high[1], y * ahead[0] - x * ahead[1])
    low[0], high[0] = max(low[0], -beyond), min(high[0], across + beyond)
    low[1], high[1] = max(low[1], -beside), min(high[1], beside)
    steps = max(least_steps, math.ceil(across / math.sqrt((high[0] - low[0]) * (high[1] - low[1]) / cells)))
    step = across / steps
    first, shape = np.empty(2, np.int64), np.empty(2, np.int64)
    for axis in range(2):
        first[axis] = min(math.floor(low[axis] / step), -least_steps) - RIM
        shape[axis] = (
            max(math.ceil(high[axis] / step), least_steps + (steps if axis == 0 else 0)) + RIM - first[axis] + 1
        )
    price, free = np.empty((shape[0], shape[1])), np.zeros((shape[0], shape[1]), np.bool_)
    lattice = MapLattice(start[:2].copy(), ahead, step, first, price, free)
    counted = is_counted(rates, start[2], goal[2])
    reach = step / math.sqrt(2.0) + COVER_MARGIN
    place = np.empty(2)
    covers = np.empty((len(space.boxes) + len(space.solids.kind) + len(rates.zones.kind), 3))
    for i in range(shape[0]):
        for j in range(shape[1]):
            _write_place(lattice, i, j, place)
            price[i, j] = _least_price(space, rates, counted, place, reach, covers)
            way = _distance(place, start) + _distance(place, goal)
            inside = way <= longest + 2.0 * reach and price[i, j] < math.inf
            for axis in range(2):
                inside &= space.low[axis] - reach <= place[axis] <= space.high[axis] + reach
            free[i, j] = inside and RIM <= i < shape[0] - RIM and RIM <= j < shape[1] - RIM
    return lattice


@inner
def _write_place(lattice: MapLattice, i: int, j: int, place: Floats) -> None:
    """Write where a node is, (2,) metres."""
    forward, left = (i + lattice.first[0]) * lattice.step, (j + lattice.first[1]) * lattice.step
    place[0] = lattice.start[0] + forward * lattice.ahead[0] - left * lattice.ahead[1]
    place[1] = lattice.start[1] + forward * lattice.ahead[1] + left * lattice.ahead[0]


@inner
def _distance(a: Floats, b: Floats) -> float:
    """Return the distance of two places on the map."""
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2)


@inner
def _least_price(
    space: Space, rates: Rates, counted: tuple[bool, bool], place: Floats, reach: float, covers: Floats
) -> float:
    """Return the least price of a metre at any altitude within `reach` of a place; infinite where nothing is free.

    `covers` is memory: the lowest and highest z of what covers all these places, and the price of a metre in it.
    """
    if space.low[2] == space.high[2]:
        return rates.metre
    size = _add_covers(space, rates, place, reach, covers)
    least = math.inf
    z = space.low[2]
    while z < space.high[2]:
        following = space.high[2]
        for edge in (rates.low, rates.high):
            if rates.altitude > 0.0 and not rates.above and edge > z:
                following = min(following, edge)
        dearer = 0.0
        for k in range(size):
            for edge in (covers[k, 0], covers[k, 1]):
                if edge > z:
                    following = min(following, edge)
            if covers[k, 0] <= z < covers[k, 1]:
                dearer += covers[k, 2]
        if rates.altitude > 0.0 and not rates.above:
            if following <= rates.low and not counted[0]:
                dearer += rates.altitude * (rates.low - following)
            if z >= rates.high and not counted[1]:
                dearer += rates.altitude * (z - rates.high)
        least = min(least, dearer)
        z = following
    return rates.metre + least


@inner
def _add_covers(space: Space, rates: Rates, place: Floats, reach: float, covers: Floats) -> int:
    """Write into `covers` what covers all places within `reach` of one; return how many there are."""
    size = 0
    node = 0
    while node < len(space.tree.links):
        if not _covers(space.tree.bounds[node], space.clearance, place, reach):
            node = space.tree.links[node, SKIP]
            continue
        for i in range(space.tree.links[node, FIRST], space.tree.links[node, STOP]):
            size = _add_box(space.boxes[i], space.clearance, math.inf, place, reach, covers, size)
        node += 1
    for i in range(len(space.solids.kind)):
        size = _add_solid(space.solids, i, space.clearance, math.inf, place, reach, covers, size)
    for i in range(len(rates.zones.kind)):
        size = _add_solid(rates.zones, i, 0.0, rates.risks[i], place, reach, covers, size)
    return size


@inner
def _covers(box: Floats, growth: float, place: Floats, reach: float) -> bool:
    """Tell whether a box (6,), grown by so many metres, covers all places within `reach` of one."""
    inside = True
    for axis in range(2):
        inside &= box[axis] - growth + reach <= place[axis] <= box[axis + 3] + growth - reach
    return inside


@inner
def _add_box(box: Floats, growth: float, price: float, place: Floats, reach: float, covers: Floats, size: int) -> int:
    """Add a box (6,), grown by so many metres, if it covers all places within `reach` of one."""
    if not _covers(box, growth, place, reach):
        return size
    covers[size, 0], covers[size, 1], covers[size, 2] = box[2] - growth, box[5] + growth, price
    return size + 1


@inner
def _add_solid(
    solids: Solids, i: int, growth: float, price: float, place: Floats, reach: float, covers: Floats, size: int
) -> int:
    """Add a solid, grown by so many metres, if it covers all places within `reach` of one; spheres never do."""
    kind = solids.kind[i, 0]
    grown = _add_box(solids.bounds[i], growth, price, place, reach, covers, size)
    if kind == BOX or grown == size:
        return grown
    if kind == CYLINDER:
        return grown if _distance(place, solids.round[i]) + reach <= solids.round[i, 3] + growth else size
    first, stop = solids.kind[i, 1], solids.kind[i, 2]
    if kind == PRISM and polygon.holds(solids.edges, first, stop, growth - reach, place[0], place[1]):
        return grown
    return size
