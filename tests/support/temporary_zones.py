"""Random zones with active times, and how deep places are inside of them, by formulas of the tests' own."""

import numpy as np
import shapely
from hypothesis import strategies as st

import skyverse as sky
from movers import depth_inside, points, sizes
from skyverse.model.shapes import active_spans


def depth_in_zone(zone, places, grown):
    """How deep (m, 3) places are inside a zone that is grown by some metres, whatever the time."""
    if not isinstance(zone, sky.Prism):
        return depth_inside(zone, places, grown)
    polygon, at = shapely.Polygon(zone.vertices, zone.holes), shapely.points(places[:, :2])
    from_outline = shapely.distance(polygon.boundary, at)
    level = np.where(shapely.contains(polygon, at), from_outline, -from_outline)
    return np.minimum(level, np.minimum(places[:, 2] - zone.low, zone.high - places[:, 2])) + grown


def depth_while_active(zone, instants, places, grown):
    """How deep (m, 3) places are inside a zone at (m,) instants; minus infinity while it is not active."""
    active = np.zeros(len(instants), dtype=bool)
    for begin, end in active_spans(zone.active):
        active |= (begin <= instants) & (instants <= end)
    return np.where(active, depth_in_zone(zone, places, grown), -np.inf)


@st.composite
def times(draw):
    """One to three spans, some of which are open at an end."""
    edges = np.round(np.cumsum(draw(st.lists(st.floats(0.5, 5), min_size=2, max_size=6))) - 1.0, 3).tolist()
    spans = [list(pair) for pair in zip(edges[0::2], edges[1::2], strict=False)]
    if draw(st.booleans()):
        spans[0][0] = None
    if draw(st.booleans()):
        spans[-1][1] = None
    return spans


@st.composite
def zones(draw, **more):
    """A box, a cylinder, a sphere, or a prism in the shape of an L or a ring."""
    (x, y, z), a, b, h = draw(points), draw(sizes), draw(sizes), draw(sizes)
    given = {"active": draw(times()), **more}
    kind = draw(st.sampled_from(["box", "cylinder", "sphere", "L", "ring"]))
    if kind == "box":
        return sky.Box(min=(x, y, z), max=(x + a, y + b, z + h), **given)
    if kind == "cylinder":
        return sky.Cylinder(centre=(x, y), radius=a, low=z, high=z + h, **given)
    if kind == "sphere":
        return sky.Sphere(centre=(x, y, z), radius=a, **given)
    if kind == "L":
        bend = [(0, 0), (2 * a, 0), (2 * a, b), (a, b), (a, 2 * b), (0, 2 * b)]
        return sky.Prism(vertices=[(x + u, y + v) for u, v in bend], low=z, high=z + h, **given)
    rim = [(0, 0), (3 * a, 0), (3 * a, 3 * b), (0, 3 * b)]
    hole = [(a, b), (2 * a, b), (2 * a, 2 * b), (a, 2 * b)]
    rings = [[(x + u, y + v) for u, v in ring] for ring in (rim, hole)]
    return sky.Prism(vertices=rings[0], holes=[rings[1]], low=z, high=z + h, **given)
