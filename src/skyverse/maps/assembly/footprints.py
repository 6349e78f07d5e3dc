"""Footprints simplified so that they never cover less: fewer corners, no small courtyards, neighbours merged."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from skyverse._typing import Floats

_MIN_HOLE_DISTANCE = 1e-3
"""Metres; a hole that is nearer to the outline or to another hole is filled."""


def simplify(polygons: Sequence[Polygon] | NDArray[Any], tolerance: float) -> NDArray[Any]:
    """Return polygons with fewer corners that cover the given ones, and reach out of them by `tolerance` at most.

    The outline that Douglas and Peucker's algorithm simplifies is grown by as much as it may fall short, with mitred
    corners. A polygon stays as it is where the result would not cover it, or would not have fewer corners.

    Parameters
    ----------
    polygons
        Valid polygons, local metres.
    tolerance
        How far the result may reach out, metres.

    Returns
    -------
    ndarray of Polygon
        One for each polygon; its holes touch neither the outline nor each other.
    """
    given = _filled(np.array(polygons, dtype=object))
    if tolerance <= 0 or not len(given):
        return given
    lines = shapely.simplify(given, tolerance / 3, preserve_topology=True)
    whole = shapely.is_valid(lines) & (shapely.area(lines) > 0)
    lines[~whole] = given[~whole]
    grown = shapely.buffer(lines, tolerance / 3 * (1 + 1e-9), join_style="mitre", mitre_limit=2.0)
    covered = shapely.covers(lines, given)
    result = np.where(covered, lines, grown)
    single = shapely.get_type_id(result) == shapely.GeometryType.POLYGON
    fewer = shapely.get_num_coordinates(result) < shapely.get_num_coordinates(given)
    good = single & fewer
    good[good] = shapely.is_valid(result[good]) & shapely.covers(result[good], given[good])
    result = np.where(good, result, given)
    return _filled(result)


def _filled(polygons: NDArray[Any]) -> NDArray[Any]:
    """Return polygons of which holes are filled that are tiny, or that touch the outline or one another."""
    result = polygons.copy()
    for k in np.flatnonzero(shapely.get_num_interior_rings(polygons) > 0):
        rings = shapely.get_rings(polygons[k])
        outline, holes = rings[0], sorted(rings[1:], key=lambda ring: -Polygon(ring).area)
        kept: list[Any] = []
        for hole in holes:
            if Polygon(hole).area >= _MIN_HOLE_DISTANCE**2 and all(
                hole.distance(other) > _MIN_HOLE_DISTANCE for other in (outline, *kept)
            ):
                kept.append(hole)
        if len(kept) < len(holes):
            result[k] = Polygon(outline, kept)
    return result


@dataclass(frozen=True, eq=False)
class MergedFootprints:
    """Footprints of which neighbours have become one.

    Attributes
    ----------
    polygons
        (m,) polygons.
    low, high
        (m,) the lowest and the highest end of those that became one.
    members
        (m,) arrays of the numbers of those that became one.
    """

    polygons: NDArray[Any]
    low: Floats
    high: Floats
    members: list[NDArray[np.int64]]


def merge(polygons: Sequence[Polygon] | NDArray[Any], low: Floats, high: Floats, tolerance: float) -> MergedFootprints:
    """Merge footprints that touch or overlap, where both their ends are alike.

    Parameters
    ----------
    polygons
        (n,) valid polygons, local metres.
    low, high
        (n,) z where they begin and end, metres.
    tolerance
        How far the ends of all those that become one may lie apart, metres.
    """
    given = np.array(polygons, dtype=object)
    group = _groups(given, low, high, tolerance)
    order = np.argsort(group, kind="stable")
    members = np.split(order, np.flatnonzero(np.diff(group[order])) + 1) if len(given) else []
    shapes: list[Any] = []
    rows: list[NDArray[np.int64]] = []
    for one in members:
        parts = shapely.get_parts(shapely.union_all(given[one])) if len(one) > 1 else given[one]
        for part in parts:
            shapes.append(part)
            rows.append(one if len(parts) == 1 else one[shapely.covers(part, shapely.point_on_surface(given[one]))])
    least, most = np.array([low[one].min() for one in rows]), np.array([high[one].max() for one in rows])
    return MergedFootprints(_filled(np.array(shapes, dtype=object)), least, most, rows)


def _groups(polygons: NDArray[Any], low: Floats, high: Floats, tolerance: float) -> NDArray[np.int64]:
    """Return the number of the group that each belongs to; in a group, all ends lie within the tolerance."""
    group = np.arange(len(polygons))
    if len(polygons) < 2:
        return group
    a, b = shapely.STRtree(polygons).query(polygons, predicate="intersects")
    alike = (a < b) & (np.abs(low[a] - low[b]) <= tolerance) & (np.abs(high[a] - high[b]) <= tolerance)
    a, b = a[alike], b[alike]
    order = np.argsort(np.abs(high[a] - high[b]) + np.abs(low[a] - low[b]), kind="stable")
    ends = np.stack([low, low, high, high])  # of each group: least and greatest low, least and greatest high

    def root(k: int) -> int:
        while group[k] != k:
            group[k] = group[group[k]]
            k = int(group[k])
        return k

    for one, other in zip(a[order].tolist(), b[order].tolist(), strict=True):
        i, j = root(one), root(other)
        if i == j:
            continue
        least, most = np.minimum(ends[:, i], ends[:, j]), np.maximum(ends[:, i], ends[:, j])
        if most[1] - least[0] <= tolerance and most[3] - least[2] <= tolerance:
            group[j] = i
            ends[:, i] = least[0], most[1], least[2], most[3]
    return np.array([root(k) for k in range(len(polygons))])
