"""Outlines of shapes in latitude and longitude, for formats that draw polygons."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.shape_geometry import footprint
from skyverse.exports.global_positions import origin_of
from skyverse.model.geodesy import to_wgs84
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import Box, Cylinder, Prism, Shape, Sphere

CIRCLE_CORNERS = 32
"""The number of corners of the polygon that stands for a circle."""


class Outline(NamedTuple):
    """The outline of a shape, seen from above.

    Attributes
    ----------
    name, kind
        As in the scenario; a shape without a name gets one from its kind and number.
    top, bottom
        (n, 3) latitude, longitude, metres above mean sea level; counter-clockwise, without repeating the first corner.
    holes
        (k, 3) each, as `top`, but clockwise.
    """

    name: str
    kind: str
    top: Floats
    bottom: Floats
    holes: tuple[Floats, ...]


def outlines(scenario: Scenario, shapes: Sequence[Shape]) -> Iterator[Outline]:
    """Yield the outlines of shapes; voxels have none."""
    origin = origin_of(scenario)
    for number, shape in enumerate(shapes, 1):
        if not isinstance(shape, Box | Cylinder | Prism | Sphere):
            continue
        (low, high), (ring, *holes) = extent(shape), footprint(shape, CIRCLE_CORNERS)
        top, bottom, *inner = (
            to_wgs84(origin, np.column_stack([edge, np.full(len(edge), z)]))
            for edge, z in [(ring, high[2]), (ring, low[2]), *((hole, high[2]) for hole in holes)]
        )
        yield Outline(shape.name or f"{shape.kind or 'shape'} {number}", shape.kind or "", top, bottom, tuple(inner))
