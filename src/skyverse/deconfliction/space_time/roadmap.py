"""A roadmap for searches in space and time: a lattice fitted to the UAVs' separation, and their planned paths.

From each node of the lattice straight legs lead in 26 directions, over several lengths; where space is too narrow for
the lattice, there are the bends of planned paths and places between them, joined to what is visible around.
"""

from collections.abc import Sequence
from itertools import product

import numpy as np
from scipy.spatial import cKDTree

from skyverse._typing import Bools, Floats, Ints
from skyverse.deconfliction.space_time.search import RoadmapGraph
from skyverse.numerics.tolerances import MIN_SEGMENT
from skyverse.space.world import World

SPACING = 0.525
"""Semi-axes of the UAVs' ellipsoid from node to node: at every second node somebody can hover, or fly past."""
LENGTHS = (1, 2, 4, 8, 16, 32)
"""Spacings that a leg of the lattice is long, along each axis that it leads along."""
MOST_NODES = 30_000
"""Nodes of a lattice at most; that of a larger region has wider spacings."""
MARGIN = 4.0
"""Semi-axes by which the region is larger than what holds all planned paths."""
REACH = 2.0
"""Spacings to a lattice node that a place on a planned path is joined to, at most."""
HALF_OF_26 = np.array([way for way in product((-1, 0, 1), repeat=3) if way > (0, 0, 0)])


def make_roadmap(world: World, paths: Sequence[Floats], columns: Sequence[Floats], semi_axes: Floats) -> RoadmapGraph:
    """Return a roadmap of the free space around paths.

    Parameters
    ----------
    world
        The space.
    paths
        The planned paths, (k, 3) metres each, whose bends become vertices.
    columns
        Places where UAVs take off or land, and the bends straight above them, (2, 3) metres each.
    semi_axes
        (2,) the horizontal and the vertical semi-axis of the ellipsoid that UAVs keep free, metres.
    """
    bends = np.vstack(list(paths))
    reach = MARGIN * semi_axes[[0, 0, 1]]
    low, high = np.maximum(bends.min(axis=0) - reach, world.low), np.minimum(bends.max(axis=0) + reach, world.high)
    spacing = SPACING * semi_axes[[0, 0, 1]]
    spacing = spacing * max(1.0, (float(np.prod((high - low) / spacing + 1.0)) / MOST_NODES) ** (1.0 / 3.0))
    shape = np.floor((high - low) / spacing).astype(np.int64) + 1
    origin = 0.5 * (low + high - (shape - 1) * spacing)
    nodes = origin + np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 3) * spacing
    free = world.free(nodes)
    number = np.full(len(nodes), -1)
    number[free] = np.arange(free.sum())
    starts, ends, kinds, ways = _lattice_legs(world, nodes, free.reshape(shape), number.reshape(shape), spacing)
    nodes = nodes[free]
    places, pairs = _places(world, paths, nodes, spacing)
    points = np.vstack([nodes, places])
    pairs = np.vstack([pairs + len(nodes), _joined(world, nodes, places, spacing)])
    for ground, top in columns:
        near = np.flatnonzero(np.linalg.norm(points - top, axis=1) <= MIN_SEGMENT)[:1]
        pairs = np.vstack([pairs, np.column_stack([near, np.full(len(near), len(points))])])
        points = np.vstack([points, ground])
    pairs = pairs[np.linalg.norm(points[pairs[:, 1]] - points[pairs[:, 0]], axis=1) > MIN_SEGMENT]
    both = np.vstack([pairs, pairs[:, ::-1]])
    kinds = np.concatenate([kinds, len(ways) + np.arange(len(both))])
    ways = np.vstack([ways, points[both[:, 1]] - points[both[:, 0]]])
    starts, ends = np.concatenate([starts, both[:, 0]]), np.concatenate([ends, both[:, 1]])
    order = np.argsort(starts, kind="stable")
    first = np.searchsorted(starts[order], np.arange(len(points) + 1))
    return RoadmapGraph(points, first.astype(np.int64), ends[order], kinds[order], ways)


def _places(world: World, paths: Sequence[Floats], nodes: Floats, spacing: Floats) -> tuple[Floats, Ints]:
    """Return the bends of paths, with places between them that are near no node of the lattice, and pairs to be joined.

    Places that are neighbours on a path are joined, and so are neighbouring bends.
    """
    found: list[Floats] = []
    pairs: list[tuple[int, int]] = []
    for path in paths:
        before = -1
        for k, bend in enumerate(path):
            if k > 0:
                parts = max(int(np.ceil(np.abs((bend - path[k - 1]) / spacing).max())), 1)
                between = path[k - 1] + np.arange(1, parts)[:, None] / parts * (bend - path[k - 1])
                last = before
                for place in between[_lonely(world, between, nodes, spacing)]:
                    pairs.append((last, len(found)))
                    last = len(found)
                    found.append(place)
                pairs += [(one, len(found)) for one in {last, before}]
            before = len(found)
            found.append(bend)
    return np.array(found).reshape(-1, 3), np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _lonely(world: World, places: Floats, nodes: Floats, spacing: Floats) -> Bools:
    """Tell of which places (n, 3) no node of the lattice is near and visible, (n,)."""
    lonely = np.ones(len(places), np.bool_)
    place, node = _near(places, nodes, spacing)
    lonely[place[world.segments_free(places[place], nodes[node])]] = False
    return lonely


def _joined(world: World, nodes: Floats, places: Floats, spacing: Floats) -> Ints:
    """Return the pairs (n, 2) of a place and a node, or of two places, that are near and visible to each other."""
    points = np.vstack([nodes, places])
    place, other = _near(places, points, REACH * spacing)
    once = (other < len(nodes)) | (other > place + len(nodes))
    place, other = place[once] + len(nodes), other[once]
    free = world.segments_free(points[place], points[other])
    return np.column_stack([place, other])[free]


def _near(places: Floats, points: Floats, reach: Floats) -> tuple[Ints, Ints]:
    """Return the pairs of places and points that are no farther apart than `reach` along each axis."""
    tree = cKDTree(points / reach)
    found = [np.array(one, dtype=np.int64) for one in tree.query_ball_point(places / reach, 1.0, p=np.inf)]
    count = [len(one) for one in found]
    near = [np.sort(one) for one in found]
    return np.repeat(np.arange(len(places)), count), np.concatenate([np.zeros(0, np.int64), *near])


def _lattice_legs(
    world: World, nodes: Floats, free: Bools, number: Ints, spacing: Floats
) -> tuple[Ints, Ints, Ints, Floats]:
    """Return where legs between free nodes begin and end, (m,) numbers of nodes, their kinds, and the kinds' ways."""
    starts, ends, kinds = ([np.zeros(0, np.int64)] for _ in range(3))
    ways: list[Floats] = []
    shape = np.array(free.shape)
    index = np.arange(free.size).reshape(free.shape)
    for way in HALF_OF_26:
        opened = _both(free, way)
        if not opened.any():
            continue
        a, b = index[_shifted(shape, way, 0)][opened], index[_shifted(shape, way, 1)][opened]
        opened[opened] = world.segments_free(nodes[a], nodes[b])
        length = 1
        for longer in LENGTHS:
            while length < longer:  # two legs in a row that are free make one of twice the length
                opened = _both(opened, length * way)
                length *= 2
            if not opened.any():
                break
            a, b = (number[_shifted(shape, length * way, side)][opened] for side in (0, 1))
            for one, other, sign in ((a, b, 1), (b, a, -1)):
                starts.append(one)
                ends.append(other)
                kinds.append(np.full(len(one), len(ways)))
                ways.append(sign * length * way * spacing)
    return np.concatenate(starts), np.concatenate(ends), np.concatenate(kinds), np.array(ways).reshape(-1, 3)


def _shifted(shape: Ints, way: Ints, side: int) -> tuple[slice, ...]:
    """Return the nodes at which legs along a way begin (0) or end (1), as slices of an array of that shape."""
    return tuple(
        slice(max(-w, 0) + side * w, max(n - max(w, 0) + side * w, 0))
        for n, w in zip(shape.tolist(), way.tolist(), strict=True)
    )


def _both(opened: Bools, way: Ints) -> Bools:
    """Return for each beginning of a way whether it, and what is a way farther, are open."""
    shape = np.array(opened.shape)
    if (np.abs(way) >= shape).any():
        return np.zeros((0, 0, 0), np.bool_)
    return opened[_shifted(shape, way, 0)] & opened[_shifted(shape, way, 1)]
