"""Fences: areas that UAVs must stay in become obstacles that fill all around them, and never allow more than that."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import shapely

from skyverse._typing import Floats
from skyverse.errors import InputError, require_number
from skyverse.maps.assembly.bad_points import BadPoint, Point
from skyverse.maps.assembly.obstacles import ROUNDING, LocalFeatures, local_outlines, prisms, simplified, within_bounds
from skyverse.maps.assembly.places import refuse_swapped
from skyverse.maps.georeference.feature import Feature, require_on_globe
from skyverse.maps.georeference.reading import LEAST_BUFFER, MAX_BUFFER
from skyverse.model.frame import Origin
from skyverse.model.scenario import Bounds
from skyverse.model.shapes import FENCE, Prism
from skyverse.model.short_lines import told_metres

JOINED = 0.005
"""Metres around areas within which they count as one: gaps twice as wide are closed, as straight edges that two areas
share are rounded otherwise in each, and necks as narrow are shut."""
Rule = Literal["union", "intersection"]
"""Whether UAVs must stay in any of several areas, or in all of them."""


def fence_area(outline: Floats, holes: Sequence[Floats], where: str, *, outside: bool = False) -> list[Feature]:
    """Return an area that UAVs must stay in, or out of.

    Parameters
    ----------
    outline
        (n, 2) longitude and latitude, degrees; edges are straight in degrees.
    holes
        Outlines of what does not belong to it, each (k, 2).
    where
        File and area, for messages.
    outside
        Whether they must stay out of it: an outline that meets itself is then repaired so that it covers all.

    Raises
    ------
    InputError
        If it is not on the globe, encloses nothing, or the outline of an area to stay in meets itself or a hole.
    """
    from skyverse.maps.readers.polygons import area_features

    rings = [np.asarray(ring, dtype=np.float64) for ring in (outline, *holes)]
    for ring in rings:
        if len(ring) < 3:
            raise InputError(f"{where}: expected an outline of three corners or more, found {len(ring)}")
        for longitude, latitude in ring.tolist():
            require_on_globe(where, latitude, longitude)
    return area_features(shapely.Polygon(rings[0], rings[1:]), where, outside=outside)


def fence_circle(
    longitude: float, latitude: float, radius: float, where: str, *, outside: bool = False
) -> list[Feature]:
    """Return an area of all within a radius, metres, of a place, degrees.

    One to stay in reaches nowhere farther, and one to stay out of, `outside`, nowhere less far.
    """
    from skyverse.maps.readers.polygons import area_features

    require_on_globe(where, latitude, longitude)
    require_number(radius, f"{where}: radius", "metres", LEAST_BUFFER, MAX_BUFFER)
    return area_features(shapely.Point(longitude, latitude), where, radius=radius, outside=outside)


@dataclass(frozen=True)
class Fence:
    """What is around the areas that UAVs must stay in.

    Attributes
    ----------
    prisms
        Airspace that must not be entered, as high as the bounds and higher.
    inside
        A geometry of shapely, local metres: where UAVs may be.
    """

    prisms: tuple[Prism, ...]
    inside: Any

    def points_outside(self, points: Sequence[tuple[str, Point]], clearance: float, file: str) -> list[BadPoint]:
        """Return those points, given with their names, that are outside of it or nearer to its edge than that."""
        found = []
        for name, point in points:
            place = shapely.Point(point[:2])
            out, edge = place.distance(self.inside), place.distance(self.inside.boundary)
            if out or edge < clearance:
                where = f"{told_metres(edge)} {'outside' if out else 'from its edge'}"
                text = f"expected a point {clearance:g} m or more inside the fence of {file}, found it {where}"
                found.append(BadPoint(name, point, text))
        return found


def fence_around(
    areas: Sequence[Feature],
    origin: Origin,
    bounds: Bounds,
    *,
    rule: Rule = "union",
    outside: Sequence[Feature] = (),
    reach: float = 20.0,
    tolerance: float = 0.5,
) -> Fence:
    """Return the fence around areas.

    Parameters
    ----------
    areas
        Areas that UAVs must stay in, such as `fence_area` and `fence_circle` make, and readers of files; without any
        they may be everywhere.
    origin, bounds
        The local frame's origin, and the bounds of the scenario.
    rule
        Whether UAVs must stay in any of them, or in all of them.
    outside
        Areas that they must stay out of, made by the same functions with `outside`.
    reach
        Metres that the fence is wide around the bounds; at least the clearance.
    tolerance
        By how much areas may shrink for their outlines to lose corners, metres.

    Raises
    ------
    InputError
        If nothing of it lies within the bounds.
    """
    from skyverse.maps.readers.polygons import features_around, pieces

    (x0, y0, z0), (x1, y1, z1) = bounds.min, bounds.max
    frame = shapely.box(x0, y0, x1, y1)

    def local(areas: Sequence[Feature]) -> list[Any]:
        each = (features_around([area], origin.longitude, origin.latitude) for area in areas)
        return [shapely.union_all(_moved(local_outlines(near, origin), JOINED)) for near in each]

    parts = local(areas) or [frame.buffer(2 * reach)]
    joined = shapely.union_all(parts) if rule == "union" else shapely.intersection_all(parts)
    joined = joined.difference(shapely.union_all(local(outside)))
    inside = _moved(_moved(joined, -2 * JOINED - 2 * ROUNDING), JOINED)
    if areas and not frame.intersects(inside):
        where = areas[0].where.partition(": ")[0]
        refuse_swapped(where, areas, origin, (x0, y0, x1, y1))
        raise InputError(f"{where}: expected a fence around a part of the area, found none of it inside")
    around = pieces(shapely.box(x0 - reach, y0 - reach, x1 + reach, y1 + reach).difference(inside))
    fence = Feature(np.empty((0, 2)), (), None, None, FENCE, False, None, [*areas, *outside][0].where)
    ends = np.full(len(around), np.inf)
    beyond = within_bounds(LocalFeatures(around, [fence] * len(around), -ends, ends), z0, z1, reach)
    made, _ = prisms(simplified(beyond, tolerance))
    solid = shapely.union_all([shapely.Polygon(prism.vertices, prism.holes) for prism in made])
    return Fence(tuple(made), inside.difference(solid))


def _moved(geometry: Any, metres: float) -> Any:
    """Return a geometry whose edges have moved outwards."""
    return shapely.buffer(geometry, metres, join_style="mitre", mitre_limit=5.0)
