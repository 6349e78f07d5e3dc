"""Random movers, and how deep places are inside their shapes, by formulas of the tests' own."""

import numpy as np
from hypothesis import strategies as st

from skyverse.model.mover import Doubt, Ellipsoid, Mover
from skyverse.model.mover_motions import CircularMotion, PeriodicMotion, PolynomialMotion, WaypointMotion, motion_bounds
from skyverse.model.shapes import Box, Cylinder, Sphere
from skyverse.model.timed_shapes import TimedShape


def depth_inside(shape, relative, grown):
    """How deep (m, 3) positions are inside a shape that is grown by (m,) metres; an oracle of its own."""
    if isinstance(shape, Box):
        return np.min(np.minimum(relative - shape.min, np.array(shape.max) - relative), axis=1) + grown
    if isinstance(shape, Cylinder):
        level = shape.radius - np.hypot(*(relative[:, :2] - shape.centre).T)
        return np.minimum(level, np.minimum(relative[:, 2] - shape.low, shape.high - relative[:, 2])) + grown
    if isinstance(shape, Sphere):
        return shape.radius - np.linalg.norm(relative - shape.centre, axis=1) + grown
    axes = np.array([shape.semi_axis_xy, shape.semi_axis_xy, shape.semi_axis_z])
    share = np.linalg.norm((relative - shape.centre) / axes, axis=1)
    return axes.min() * (1.0 - share) + grown


numbers = st.floats(-5, 5).map(lambda x: round(x, 3))
points = st.tuples(numbers, numbers, numbers)
sizes = st.floats(0.1, 2).map(lambda x: round(x, 3))
shapes = st.one_of(
    st.builds(lambda c, r: Sphere(centre=c, radius=r), points, sizes),
    st.builds(lambda c, r, z, h: Cylinder(centre=c[:2], radius=r, low=z, high=z + h), points, sizes, numbers, sizes),
    st.builds(
        lambda c, d: Box(min=c, max=tuple(a + b for a, b in zip(c, d, strict=False))),
        points,
        st.tuples(sizes, sizes, sizes),
    ),
    st.builds(lambda c, a, b: Ellipsoid(centre=c, semi_axis_xy=a, semi_axis_z=b), points, sizes, sizes),
)


@st.composite
def waypoints(draw):
    """Straight legs, then a stay, a return or a repetition."""
    places = draw(st.lists(points, min_size=1, max_size=5))
    then = draw(st.sampled_from(["stays", "repeats", "returns"])) if len(places) > 1 else "stays"
    if then == "repeats":
        places = [*places, places[0]]
    steps = draw(st.lists(st.floats(0.2, 6), min_size=len(places), max_size=len(places)))
    return WaypointMotion(points=places, times=tuple(np.cumsum(steps) - draw(st.floats(0, 8))), then=then)


@st.composite
def polynomials(draw):
    """Pieces of degree 3 that follow one another without a jump."""
    knots = np.cumsum(draw(st.lists(st.floats(0.3, 5), min_size=2, max_size=5)))
    rows = [[draw(points), *(tuple(x / 10 for x in draw(points)) for _ in range(3))] for _ in knots[1:]]
    for k in range(1, len(rows)):
        seconds = knots[k] - knots[k - 1]
        rows[k][0] = tuple(np.array(rows[k - 1]).T @ seconds ** np.arange(4))
    return PolynomialMotion(knots=tuple(knots), coefficients=rows)


circles = st.builds(
    lambda c, r, p, b, w: CircularMotion(centre=c, radius=r, period=p, bearing=b, clockwise=w),
    points, st.floats(0.2, 8), st.floats(0.5, 30), st.floats(0, 360), st.booleans(),
)  # fmt: skip
knots_of_three = st.builds(
    lambda c, p, rows: PeriodicMotion(centre=c, period=p, cosine=rows[:3], sine=rows[3:]),
    points, st.floats(2, 30), st.lists(points, min_size=6, max_size=6),
)  # fmt: skip
motions = st.one_of(waypoints(), circles, knots_of_three, polynomials())
doubts = st.builds(
    lambda r, g, s, a, more: Doubt(
        radius=r, growth=g, since=s,
        acceleration=0.0 if more is None else a, top_speed=None if more is None else g + more,
    ),
    st.floats(0, 0.5), st.floats(0, 0.3), st.floats(-2, 8), st.just(0.0) | st.floats(0.001, 2),
    st.none() | st.floats(0.01, 2),
)  # fmt: skip


def depth_at(mover, instants, places, kept):
    """How deep (m, 3) places are at (m,) instants in all that must be kept clear of a mover, metres."""
    depth = depth_inside(mover.shape, places - mover.at(instants), kept + mover.doubt.at(instants))
    if mover.doubt.top_speed is None:
        return depth
    since = instants - mover.doubt.since
    grown = kept + mover.doubt.radius + mover.doubt.top_speed * since
    by_speed = depth_inside(mover.shape, places - mover.at(mover.doubt.since), grown)
    return np.where(since > 0, np.minimum(depth, by_speed), depth)


def doubted(shape, motion, doubt):
    """A mover with a doubt whose top speed is at least its motion's own."""
    if doubt.top_speed is not None:
        doubt = doubt.model_copy(update={"top_speed": max(doubt.top_speed, motion_bounds(motion)[0])})
    return Mover(shape=shape, motion=motion, doubt=doubt)


movers = st.builds(doubted, shapes, motions, doubts)


def timed(given_movers, kept=0.5):
    """Movers as shapes in time, from which UAVs keep a distance, metres."""
    return [TimedShape(mover.shape, mover.motion, mover.doubt, kept) for mover in given_movers]
