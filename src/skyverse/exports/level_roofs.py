"""Roofs that are level under all of a disc, and the lowest surface in one: where a UAV is not known to the metre.

One roof under all of a disc is looked for first. Where there is none, places of the disc are asked one by one.
"""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.landing import ground_below, solids_over, surfaces_among
from skyverse.model.polygon import is_inside
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import AnyShape, Box, Cylinder, Prism, Voxels
from skyverse.numerics.tolerances import LEG_ALLOWANCE
from skyverse.space.tube import steepest_within

LOWEST_ASKED, LEVEL_ASKED = 4.0, 10.0
"""Metres: places of discs with larger radii are not asked for the lowest surface, and whether a roof is level.

The first is asked often. Wider discs are taken not to be level unless one roof is under all of them.
"""
GAP = 0.1
"""Metres between the places of a disc that are then asked: narrower gaps between roofs are not seen."""


class SurfacesNear:
    """The surfaces about a place on which a UAV may come down.

    Parameters
    ----------
    scenario
        The scenario.
    place
        (2,) metres.
    reach
        Metres: what is farther from the place to the east or north is not asked for.
    floor
        z of the ground where there is no terrain, metres.
    """

    def __init__(self, scenario: Scenario, place: Floats, reach: float, floor: float | None) -> None:
        self.scenario, self.floor = scenario, floor
        self.solids = solids_over(scenario, place - reach, place + reach)

    def lowest(self, place: Floats, radius: float) -> float:
        """Return z of the lowest surface in a disc about the x, y of a place (3,): a level roof, or the ground; metres.

        A roof counts if it is not above the place and under all of the disc, also several side by side in a small disc.
        """
        roofs = self._roofs_under(place, radius)
        ground, varies = self._ground_under(place, radius)
        if not roofs and self.solids and radius <= LOWEST_ASKED:
            places = place + disc(radius)
            lowest = np.full(len(places), ground - varies)
            roofs = [float(surfaces_among(self.solids, places, lowest).min())]
        return min(max([ground - varies, *roofs]), float(place[2]))

    def is_level(self, place: Floats, radius: float, steepest: float) -> bool:
        """Tell whether what is under a disc about a place (3,) on a roof is no steeper as seen from there.

        Parameters
        ----------
        place
            (3,) metres.
        radius
            Of the disc, metres.
        steepest
            Metres up or down a metre.
        """
        ground, varies = self._ground_under(place, radius)
        one = any(top >= place[2] - LEG_ALLOWANCE for top in self._roofs_under(place, radius))
        highest = max([ground + varies, *(float(extent(shape)[1][2]) for shape in self.solids)])
        if one and highest <= place[2] + LEG_ALLOWANCE:
            return True
        if radius > LEVEL_ASKED:
            return False
        off = disc(radius)
        away = np.linalg.norm(off, axis=1)
        places = place + off + away[:, None] * [0.0, 0.0, 1.0]
        beside = surfaces_among(self.solids, places, ground_below(self.scenario, places, self.floor))
        return bool((np.abs(beside - place[2]) <= np.maximum(away * steepest, LEG_ALLOWANCE)).all())

    def _roofs_under(self, place: Floats, radius: float) -> list[float]:
        """Return z of the roofs that are not above a place (3,) and each under all of a disc about it, metres."""
        x, y, _ = place.tolist()
        tops = [roof_under_disc(shape, x, y, radius) for shape in self.solids]
        return [top for top in tops if top is not None and top <= place[2] + LEG_ALLOWANCE]

    def _ground_under(self, place: Floats, radius: float) -> tuple[float, float]:
        """Return z of the ground below a place (3,), and how much it varies at most within a disc about it; metres."""
        terrain = self.scenario.terrain
        varies = 0.0 if terrain is None else radius * steepest_within(terrain, place[:2], radius)
        return float(ground_below(self.scenario, place, self.floor)), varies


def disc(radius: float) -> Floats:
    """Return places of a disc about the origin, (n, 3) metres: its middle, its rim, and no more than `GAP` between."""
    rings = [np.zeros((1, 3))]
    for away in np.linspace(0.0, radius, math.ceil(radius / GAP) + 1)[1:]:
        angles = np.linspace(0.0, 2 * np.pi, max(math.ceil(2 * np.pi * away / GAP), 8), endpoint=False)
        rings.append(away * np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles]))
    return np.concatenate(rings)


def roof_under_disc(shape: AnyShape, x: float, y: float, radius: float) -> float | None:
    """Return z of the roof of a shape that is level under all of a disc about x, y, or ``None``; metres.

    A voxel grid may have several: its highest is meant. Spheres are not level.
    """
    if isinstance(shape, Box):
        (west, south, _), (east, north, top) = shape.min, shape.max
        room = min(x - west, east - x, y - south, north - y)
    elif isinstance(shape, Cylinder):
        room, top = shape.radius - math.hypot(x - shape.centre[0], y - shape.centre[1]), shape.high
    elif isinstance(shape, Prism):
        inside = is_inside((x, y), shape.vertices) and not any(is_inside((x, y), hole) for hole in shape.holes)
        room = min(_distance(x, y, ring) for ring in (shape.vertices, *shape.holes)) if inside else -1.0
        top = shape.high
    elif isinstance(shape, Voxels):
        return _voxel_roof(shape, x, y, radius)
    else:
        return None
    return float(top) if room >= radius else None


def _distance(x: float, y: float, ring: tuple[tuple[float, float], ...]) -> float:
    """Return how far a place is from an outline, metres."""
    start = np.array(ring)
    way, off = np.roll(start, -1, axis=0) - start, np.array([x, y]) - start
    share = np.clip((off * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), np.finfo(float).tiny), 0.0, 1.0)
    return float(np.linalg.norm(off - share[:, None] * way, axis=1).min())


def _voxel_roof(shape: Voxels, x: float, y: float, radius: float) -> float | None:
    """Return z of the top of the columns of voxels in the square around a disc, if they all end there."""
    cells = []
    for at, low, step, count in zip((x, y), shape.origin, shape.step, shape.occupied.shape, strict=False):
        first, last = math.floor((at - radius - low) / step), math.floor((at + radius - low) / step)
        if first < 0 or last >= count:
            return None
        cells.append(slice(first, last + 1))
    columns = shape.occupied[cells[0], cells[1]]
    if not columns.any(axis=2).all():
        return None
    tops = columns.shape[2] - np.argmax(columns[:, :, ::-1], axis=2)
    return float(shape.origin[2] + shape.step[2] * tops.flat[0]) if (tops == tops.flat[0]).all() else None
