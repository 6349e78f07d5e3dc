"""Shapes as outlines on the globe, for formats that draw polygons."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.shape_geometry import extent, footprint
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
        if not isinstance(shape, Box | Cylinder | Prism | Sphere):
            continue
        (low, high), (ring, *holes) = extent(shape), footprint(shape, CIRCLE_CORNERS)
        top, bottom, *inner = (
            to_wgs84(origin, np.column_stack([edge, np.full(len(edge), z)]))
            for edge, z in [(ring, high[2]), (ring, low[2]), *((hole, high[2]) for hole in holes)]
        )
        yield Outline(shape.name or f"{shape.kind or 'shape'} {number}", shape.kind or "", top, bottom, tuple(inner))
