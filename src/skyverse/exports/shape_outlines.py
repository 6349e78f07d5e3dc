"""Shapes as outlines on the globe, for formats that draw polygons."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.global_positions import origin_of
from skyverse.model.geodesy import to_wgs84
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Box, Cylinder, Prism, Shape, Sphere

CIRCLE_CORNERS = 32
"""Of a circle."""


class Outline(NamedTuple):
    """A shape from above.

    Attributes
    ----------
    name, kind
        As in the scenario; the name is made up where there is none.
    top, bottom
        (n, 3) latitude, longitude, metres above mean sea level; counter-clockwise, the first corner not repeated.
    holes
        (k, 3) each, at the top; clockwise.
    """

    name: str
    kind: str
    top: Floats
    bottom: Floats
    holes: tuple[Floats, ...]


def outlines(scenario: Scenario, shapes: Sequence[Shape]) -> Iterator[Outline]:
    """Yield outlines; voxels have none."""
    origin = origin_of(scenario)
    for number, shape in enumerate(shapes, 1):
        found = _seen(shape)
        if found is None:
            continue
        ring, holes, low, high = found
        at = [
            to_wgs84(origin, np.column_stack([_turned(r, s), np.full(len(r), z)]))
            for r, s, z in [(ring, 1, high), (ring, 1, low), *((hole, -1, high) for hole in holes)]
        ]
        yield Outline(shape.name or f"{shape.kind or 'shape'} {number}", shape.kind or "", at[0], at[1], tuple(at[2:]))


def _seen(shape: Shape) -> tuple[Floats, tuple[Floats, ...], float, float] | None:
    if isinstance(shape, Box):
        (a, b, low), (c, d, high) = shape.min, shape.max
        return np.array([(a, b), (c, b), (c, d), (a, d)]), (), low, high
    if isinstance(shape, Prism):
        return np.array(shape.vertices), tuple(np.array(hole) for hole in shape.holes), shape.low, shape.high
    if isinstance(shape, Cylinder):
        return _circle(shape.centre, shape.radius), (), shape.low, shape.high
    if isinstance(shape, Sphere):
        x, y, z = shape.centre
        return _circle((x, y), shape.radius), (), z - shape.radius, z + shape.radius
    return None


def _circle(centre: tuple[float, float], radius: float) -> Floats:
    angles = 2 * np.pi * np.arange(CIRCLE_CORNERS) / CIRCLE_CORNERS
    ring: Floats = np.array(centre) + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return ring


def _turned(ring: Floats, sense: int) -> Floats:
    """Return a ring (n, 2) that runs counter-clockwise, or clockwise for a sense of -1."""
    x, y = ring.T
    area = np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
    return ring if area * sense > 0 else ring[::-1]
