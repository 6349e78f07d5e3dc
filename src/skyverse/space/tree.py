"""The spatial index: a hierarchy of bounding boxes over the shapes, built once a world and walked without a stack.

Nodes are stored in preorder. A query that misses a node's bounds goes on at the node's `SKIP` link, past all nodes
below it; otherwise it goes on at the next node. So a walk is a loop over one rising number, and nothing is allocated.
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.arrays import doubled, order_of, put_box
from skyverse.numerics.kernel import by_reference, inner, kernel, query
from skyverse.space import box

LEAF = 4
"""Shapes in a leaf at most."""

SKIP, FIRST, STOP = 0, 1, 2
"""Columns of `Tree.links`."""


@by_reference
class Tree(NamedTuple):
    """An index over boxes that are stored in the tree's order.

    Attributes
    ----------
    bounds
        (nodes, 6) metres: min and max corner of all boxes below each node.
    links
        (nodes, 3): the node at which a walk goes on that misses this one (`SKIP`), and a leaf's boxes, from `FIRST` up
        to before `STOP`; both are 0 in other nodes.
    """

    bounds: Floats
    links: Ints


@kernel
def build(boxes: Floats) -> tuple[Tree, Ints]:
    """Index (n, 6) boxes; return the tree, and (n,) the order in which the boxes have to be stored for it."""
    n = len(boxes)
    order = np.arange(n)
    sizes = np.ones(n + 1, np.int64)  # nodes of a tree over so many boxes
    for count in range(LEAF + 1, n + 1):
        sizes[count] = 1 + sizes[count // 2] + sizes[count - count // 2]
    nodes = sizes[n] if n else 0
    bounds = np.empty((nodes, 6))
    links = np.zeros((nodes, 3), np.int64)
    waiting = np.empty((64, 2), np.int64)  # ranges of `order`, halved at every level
    waiting[0, 0], waiting[0, 1] = 0, n
    depth = 1 if n else 0
    node = 0
    while depth:
        depth -= 1
        a, z = waiting[depth, 0], waiting[depth, 1]
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        least, most = np.full(3, np.inf), np.full(3, -np.inf)
        for i in range(a, z):
            for axis in range(3):
                b, c = boxes[order[i], axis], boxes[order[i], axis + 3]
                low[axis], high[axis] = min(low[axis], b), max(high[axis], c)
                least[axis], most[axis] = min(least[axis], b + c), max(most[axis], b + c)
        put_box(bounds, node, low, high)
        links[node, SKIP] = node + sizes[z - a]
        if z - a <= LEAF:
            links[node, FIRST], links[node, STOP] = a, z
        else:
            axis = 0
            for other in range(1, 3):
                if most[other] - least[other] > most[axis] - least[axis]:
                    axis = other
            some, centres = order[a:z].copy(), np.empty(z - a)
            for k in range(z - a):
                centres[k] = boxes[some[k], axis] + boxes[some[k], axis + 3]
            wanted = order_of(centres)
            for k in range(z - a):
                order[a + k] = some[wanted[k]]
            middle = a + (z - a) // 2
            waiting[depth, 0], waiting[depth, 1] = middle, z
            waiting[depth + 1, 0], waiting[depth + 1, 1] = a, middle
            depth += 2
        node += 1
    return Tree(bounds, links), order


@query
def containing(tree: Tree, boxes: Floats, growth: float, x: float, y: float, z: float) -> int:
    """Return a box whose interior, grown by `growth`, holds the point, or -1."""
    node = 0
    while node < len(tree.links):
        if not box.holds(tree.bounds, node, growth, x, y, z):
            node = tree.links[node, SKIP]
            continue
        for i in range(tree.links[node, FIRST], tree.links[node, STOP]):
            if box.holds(boxes, i, growth, x, y, z):
                return i
        node += 1
    return -1


@query
def crossed(tree: Tree, boxes: Floats, growth: float, a: Floats, b: Floats) -> int:
    """Return a box whose interior, grown by `growth`, the segment a-b meets, or -1."""
    r = box.ray(a, b)
    node = 0
    while node < len(tree.links):
        if not box.meets(tree.bounds, node, growth, r):
            node = tree.links[node, SKIP]
            continue
        for i in range(tree.links[node, FIRST], tree.links[node, STOP]):
            if box.meets(boxes, i, growth, r):
                return i
        node += 1
    return -1


@inner
def touching(tree: Tree, boxes: Floats, growth: float, low: Floats, high: Floats) -> Ints:
    """Return the boxes that, grown by `growth`, touch the closed box between two corners."""
    found = np.empty(64, np.int64)
    count = 0
    node = 0
    while node < len(tree.links):
        if not box.touches(tree.bounds, node, growth, low, high):
            node = tree.links[node, SKIP]
            continue
        for i in range(tree.links[node, FIRST], tree.links[node, STOP]):
            if box.touches(boxes, i, growth, low, high):
                if count == len(found):
                    found = doubled(found)
                found[count] = i
                count += 1
        node += 1
    return found[:count]


@query
def distance(tree: Tree, boxes: Floats, x: float, y: float, z: float) -> float:
    """Return the Euclidean distance to the nearest box as given, negative inside; infinite without boxes."""
    nearest = np.inf
    node = 0
    while node < len(tree.links):
        if box.gap(tree.bounds, node, x, y, z) >= nearest:
            node = tree.links[node, SKIP]
            continue
        for i in range(tree.links[node, FIRST], tree.links[node, STOP]):
            nearest = min(nearest, box.gap(boxes, i, x, y, z))
        node += 1
    return nearest
