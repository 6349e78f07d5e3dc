"""The shapes of movers as they are drawn: grown by their doubt, as edges, seen from above, and from the side."""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.shape_geometry import footprint, outline, span, surface
from skyverse.model.mover import Ellipsoid, Mover
from skyverse.model.quantities import derived
from skyverse.model.shapes import Box, Cylinder, Sphere

MoverShape = Box | Cylinder | Sphere | Ellipsoid


def grown(mover: Mover, more: float) -> MoverShape:
    """Return a mover's shape, grown by some metres as by its doubt; an ellipsoid keeps its proportions."""
    shape = mover.shape
    match shape:
        case Box():
            low, high = np.array(shape.min) - more, np.array(shape.max) + more
            return Box(min=tuple(low.tolist()), max=tuple(high.tolist()))
        case Cylinder():
            update = {"radius": shape.radius + more, "low": shape.low - more, "high": shape.high + more}
            return derived(shape, **update)
        case Sphere():
            return derived(shape, radius=shape.radius + more)
        case Ellipsoid():
            larger = 1.0 + more / min(shape.semi_axis_xy, shape.semi_axis_z)
            axes = {name: larger * getattr(shape, name) for name in ("semi_axis_xy", "semi_axis_z")}
            return derived(shape, **axes)
    raise TypeError(f"a mover cannot be a {type(shape).__name__}")


def edges_of(mover: Mover, more: float) -> Floats:
    """Return the edges of a mover's shape that is grown by some metres, (n, 3), with gaps of nan."""
    shape = grown(mover, more)
    if isinstance(shape, Ellipsoid):
        unit = outline(Sphere(centre=(0, 0, 0), radius=1.0))
        return np.array(shape.centre) + unit * (shape.semi_axis_xy, shape.semi_axis_xy, shape.semi_axis_z)
    return outline(shape)


def surface_of(mover: Mover, more: float) -> Floats:
    """Return points of the surface of a mover's shape that is grown by some metres, (n, 3), with all its corners."""
    shape = grown(mover, more)
    if isinstance(shape, Ellipsoid):
        unit, _ = surface(Sphere(centre=(0, 0, 0), radius=1.0))
        return np.array(shape.centre) + unit * (shape.semi_axis_xy, shape.semi_axis_xy, shape.semi_axis_z)
    return surface(shape)[0]


def ring_of(mover: Mover, more: float) -> Floats:
    """Return a mover's shape that is grown by some metres, seen from above, (n, 2)."""
    shape = grown(mover, more)
    if isinstance(shape, Ellipsoid):
        shape = Sphere(centre=shape.centre, radius=shape.semi_axis_xy)
    return footprint(shape)[0]


def levels_over(shape: MoverShape, east: float, north: float) -> tuple[float, float]:
    """Return the least and greatest z of a mover's shape over a place, relative to the moving point; nan beside it."""
    if not isinstance(shape, Ellipsoid):
        least, greatest = span(shape, np.array([(east, north)]))[0].tolist()
        return least, greatest
    x, y, z = shape.centre
    aside = math.hypot(east - x, north - y) / shape.semi_axis_xy
    half = shape.semi_axis_z * math.sqrt(1.0 - aside**2) if aside <= 1.0 else math.nan
    return z - half, z + half
