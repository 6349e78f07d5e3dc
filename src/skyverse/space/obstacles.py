"""A scenario's space compiled to arrays, and the questions that all who plan ask of it: what is how near to obstacles.

Each takes a margin in metres, which is added to the clearance, or, below 0, taken off it.
"""

from typing import NamedTuple

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import by_reference, inner, inner_query, kernel, query
from skyverse.numerics.tolerances import SURFACE_DEPTH
from skyverse.space import ground, solids, tree
from skyverse.space.ground import Ground
from skyverse.space.solids import Solids
from skyverse.space.tree import Tree


@by_reference
class Space(NamedTuple):
    """What kernels know of a world; what a world does not have is an empty array, so that there is one type for all.

    Attributes
    ----------
    low, high
        (3,) metres: the bounds.
    boxes
        (n, 6) metres, in the order of `tree`: obstacles that are boxes, and voxels merged into boxes.
    clearance
        Metres to keep from every obstacle.
    tree
        The index over `boxes`.
    solids
        Cylinders, spheres and prisms.
    ground
        The terrain.
    ceiling
        What is too high above the terrain, upside down: a ground whose heights are the negative z of the ceiling. It
        is met by points and segments whose z is negated.
    """

    low: Floats
    high: Floats
    boxes: Floats
    clearance: float
    tree: Tree
    solids: Solids
    ground: Ground
    ceiling: Ground


@query
def in_bounds(space: Space, p: Floats) -> bool:
    """Tell whether a point lies in the closed bounds."""
    inside = True
    for axis in range(3):
        inside &= space.low[axis] - SURFACE_DEPTH <= p[axis] <= space.high[axis] + SURFACE_DEPTH  # False for NaN
    return inside


@inner
def boxes_near(space: Space, margin: float, low: Floats, high: Floats) -> Ints:
    """Return the boxes that come nearer to the closed box between two corners than the clearance and a margin."""
    return tree.touching(space.tree, space.boxes, space.clearance + margin, low, high)


@query
def box_crossed(space: Space, margin: float, a: Floats, b: Floats) -> int:
    """Return a box to which a segment comes nearer than the clearance and a margin, or -1."""
    return tree.crossed(space.tree, space.boxes, space.clearance + margin, a, b)


@query
def above_ceiling(space: Space, margin: float, p: Floats) -> bool:
    """Tell whether a point is above the ceiling, lowered by a margin."""
    return -p[2] < ground.height(space.ceiling, p[0], p[1]) + (space.clearance + margin) + space.ceiling.extra


@query
def shapes_hold(space: Space, margin: float, p: Floats) -> bool:
    """Tell whether a point is nearer to a shape that is no box, or to the terrain, than the clearance and a margin."""
    growth = space.clearance + margin
    return (
        solids.containing(space.solids, growth, p[0], p[1], p[2]) >= 0
        or p[2] < ground.height(space.ground, p[0], p[1]) + growth + space.ground.extra
        or above_ceiling(space, margin, p)
    )


@query
def shapes_crossed(space: Space, margin: float, dev: float, a: Floats, b: Floats) -> bool:
    """Tell whether what is within `dev` of a segment may be too near to a shape that is no box, or to the terrain.

    Too near is nearer than the clearance and a margin. The answer is exact for a `dev` of 0; see `ground.crossed`.
    """
    growth = space.clearance + margin
    return (
        solids.crossed(space.solids, growth + dev, a, b) >= 0
        or ground.crossed(space.ground, growth + space.ground.extra, dev, a, b, 1.0)
        or ground.crossed(space.ceiling, growth + space.ceiling.extra, dev, a, b, -1.0)
    )


@query
def crosses(space: Space, margin: float, a: Floats, b: Floats) -> bool:
    """Tell exactly whether a segment comes nearer to some obstacle than the clearance and a margin."""
    return box_crossed(space, margin, a, b) >= 0 or shapes_crossed(space, margin, 0.0, a, b)


@query
def shapes_reach(space: Space, margin: float, low: Floats, high: Floats) -> bool:
    """Tell whether a shape that is no box, or the terrain, reaches into the open box between two corners.

    Shapes are grown by the clearance and a margin.
    """
    growth = space.clearance + margin
    if solids.reaching(space.solids, growth, low, high) >= 0:
        return True
    floor = low[2] - growth - space.ground.extra + SURFACE_DEPTH
    if ground.highest(space.ground, floor, low[0], low[1], high[0], high[1]) > floor:
        return True
    floor = -high[2] - growth - space.ceiling.extra + SURFACE_DEPTH
    return ground.highest(space.ceiling, floor, low[0], low[1], high[0], high[1]) > floor


@inner_query
def obstacle_distance(space: Space, p: Floats) -> float:
    """Return the metres to the nearest obstacle as given, or down to the ground if that is less; negative inside."""
    nearest = min(
        tree.distance(space.tree, space.boxes, p[0], p[1], p[2]), p[2] - ground.height(space.ground, p[0], p[1])
    )
    return solids.distance(space.solids, nearest, p[0], p[1], p[2])


def only_boxes(space: Space) -> bool:
    """Tell whether all obstacles are boxes, with voxels among them: no other shape, and no ground."""
    return len(space.solids.kind) == 0 and space.ground.heights.size == 0


@kernel
def with_margin(space: Space, margin: float) -> Space:
    """Return the space with so many metres added to its clearance."""
    return Space(
        space.low,
        space.high,
        space.boxes,
        space.clearance + margin,
        space.tree,
        space.solids,
        space.ground,
        space.ceiling,
    )
