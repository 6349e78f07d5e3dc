"""Where a UAV may take photos, seen from above: inside the bounds and beside what reaches up to where it flies.

What moves does not count, since departures can wait for it; zones that are closed at times do, since lines have none.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from shapely import Polygon

from skyverse._typing import Floats
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extent, extruded
from skyverse.model.shapes import FENCE, AnyShape, Box, Cylinder, Prism, Sphere, Voxels
from skyverse.model.timed_shapes import is_closed_at_times
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import LEG_ALLOWANCE
from skyverse.survey.footprints import GroundView
from skyverse.survey.ground import GroundCells

ALLOWANCE = 0.01 + LEG_ALLOWANCE
"""Metres by which what is not free is larger, so that lines along its edge are clear in spite of all rounding.

They are so as well where an autopilot flies them by rounded degrees, and a little beside straight lines.
"""
ROUNDNESS = 16
"""Straight pieces of a quarter of a circle."""


@dataclass(frozen=True, eq=False)
class FreeArea:
    """Where a UAV may take photos.

    Attributes
    ----------
    polygon
        shapely geometry, metres.
    roofs, tops
        What may be flown over: shapely polygons, and the z above which, (n,) metres.
    closed, names
        What may not: shapely polygons, and how sentences call each.
    """

    polygon: Any
    roofs: Any
    tops: Floats
    closed: Any
    names: tuple[str, ...]

    def why(self, place: Any) -> str:
        """Return why a place cannot be flown over, to be put after its name."""
        if self.polygon.contains(place.representative_point()):
            return "no line shows all of it, wherever UAVs and cameras may be off"
        near = [self.names[k] for k in np.argsort(shapely.distance(self.closed, place), kind="stable")[:1]]
        return f"no UAV may fly near enough because of {near[0] if near else 'the bounds'}"


def free_area(scenario: Scenario, error: TrackingError, cells: GroundCells, view: GroundView) -> FreeArea:
    """Return where UAVs may take photos of the ground, at the heights that it asks for.

    Parameters
    ----------
    scenario
        The scenario.
    error
        How far they may stray.
    cells, view
        The ground, and what limits the heights above it.
    """
    keep = (scenario.clearance + error.horizontal) / math.cos(math.pi / (4 * ROUNDNESS)) + ALLOWANCE
    upright = scenario.clearance + error.vertical + ALLOWANCE
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    inside = error.horizontal + ALLOWANCE if error.horizontal else 0.0
    bounds = shapely.box(*(low[:2] + inside), *(high[:2] - inside))
    roofs, tops, closed, names = [], [], [], []
    for shape, name in _solids(scenario):
        for part, bottom, top in _seen_from_above(shape, keep):
            least, most = _flown(cells, view, part)
            if bottom - upright >= most:
                continue
            if top + upright <= least:
                roofs.append(part)
                tops.append(top + upright)
            else:
                closed.append(part)
                names.append(name)
    polygon = bounds.difference(shapely.union_all(closed)) if closed else bounds
    # the bounds are the last of what closes, so that they are named where nothing else is nearer
    closed.append(bounds.boundary)
    names.append("the bounds")
    return FreeArea(polygon, np.array(roofs), np.array(tops), np.array(closed), tuple(names))


def _solids(scenario: Scenario) -> Iterator[tuple[AnyShape, str]]:
    """Yield what must not be flown through, each with how sentences call it."""
    closed_at_times = [zone for zone in scenario.zones if is_closed_at_times(zone)]
    for shapes, noun in ((scenario.obstacles, "obstacle"), (closed_at_times, "zone")):
        for number, shape in enumerate(shapes):
            kind = shape.kind or noun
            name = f"the {kind}" if kind == FENCE else f"{kind} {shape.name!r}" if shape.name else f"{kind} {number}"
            for part in extruded(shape, scenario.bounds.max[2]):
                yield part, name


def _flown(cells: GroundCells, view: GroundView, part: Any) -> tuple[float, float]:
    """Return the least z at which lines over a place can be asked to be, and the greatest, metres."""
    reach = max(view.before, view.behind, view.beside)
    x0, y0, x1, y1 = part.bounds
    near = [
        np.floor((np.array(corner) - cells.origin) / cells.step).astype(int)
        for corner in ((x0 - reach, y0 - reach), (x1 + reach, y1 + reach))
    ]
    (i0, j0), (i1, j1) = np.clip(near, 0, np.array(cells.low.shape) - 1)
    ground = cells.low[i0 : i1 + 1, j0 : j1 + 1], cells.high[i0 : i1 + 1, j0 : j1 + 1]
    return float(ground[0].min()) + view.drop, float(ground[1].max()) + view.drop


def _seen_from_above(shape: AnyShape, keep: float) -> Iterator[tuple[Any, float, float]]:
    """Yield the parts of a shape, grown: a polygon, and the z where it begins and ends."""
    low, high = extent(shape)
    match shape:
        case Box():
            yield shapely.box(*(low[:2] - keep), *(high[:2] + keep)), low[2], high[2]
        case Voxels():
            columns = shape.occupied.any(axis=2)
            for i, j in zip(*np.nonzero(columns), strict=True):
                corner = low[:2] + np.array(shape.step[:2]) * (i, j)
                layers = np.flatnonzero(shape.occupied[i, j])
                z = low[2] + shape.step[2] * np.array([layers[0], layers[-1] + 1])
                yield shapely.box(*(corner - keep), *(corner + shape.step[:2] + keep)), float(z[0]), float(z[1])
        case Cylinder() | Sphere():
            radius = shape.radius / math.cos(math.pi / (4 * ROUNDNESS)) + keep
            yield shapely.Point(shape.centre[:2]).buffer(radius, quad_segs=ROUNDNESS), low[2], high[2]
        case Prism():
            polygon = Polygon(shape.vertices, shape.holes).buffer(keep, quad_segs=ROUNDNESS)
            yield polygon, shape.low, shape.high
