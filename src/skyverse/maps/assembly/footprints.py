"""Footprints made simpler without ever making them smaller: fewer corners, no small courtyards, neighbours as one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from skyverse._typing import Floats

_APART = 1e-3
"""Metres that a hole must keep from the outline and from other holes; otherwise it is filled."""


def simplify(polygons: Sequence[Polygon] | NDArray[Any], tolerance: float, least_hole: float = 0.0) -> NDArray[Any]:
    """Return polygons with fewer corners that cover the given ones, and reach out of them by `tolerance` at most.

    Douglas and Peucker's line is grown, with mitred corners, by as much as it falls short. A polygon of which that
    would not cover everything, or that would not lose a corner, stays as it is.

    Parameters
    ----------
    polygons
        Valid ones, local metres.
    tolerance
        Metres.
    least_hole
        Holes with less area than this, square metres, are filled.

    Returns
    -------
    ndarray of Polygon
        One for each; their holes touch neither the outline nor each other.
    """
    given = np.empty(len(polygons), dtype=object)
    given[:] = list(polygons)
    if len(given) == 0:
        return given
    given = _filled(given, least_hole)
    if tolerance <= 0:
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
    return _filled(result, least_hole)


def _filled(polygons: NDArray[Any], least_hole: float) -> NDArray[Any]:
    """Return polygons without holes that are small, or that touch the outline or one another."""
    result = polygons.copy()
    for k in np.flatnonzero(shapely.get_num_interior_rings(polygons) > 0):
        rings = shapely.get_rings(polygons[k])
        outline, holes = rings[0], sorted(rings[1:], key=lambda ring: -Polygon(ring).area)
        kept: list[Any] = []
        for hole in holes:
            if Polygon(hole).area >= max(least_hole, _APART**2) and all(
                hole.distance(other) > _APART for other in (outline, *kept)
            ):
                kept.append(hole)
        if len(kept) < len(holes):
            result[k] = Polygon(outline, kept)
    return result


@dataclass(frozen=True, eq=False)
class Merged:
    """Footprints of which neighbours have become one.

    Attributes
    ----------
    polygons
        (m,) polygons.
    low, high
        (m,) the lowest and the highest of those that became one.
    members
        (m,) arrays: the numbers of these.
    """

    polygons: NDArray[Any]
    low: Floats
    high: Floats
    members: list[NDArray[np.int64]]


def merge(polygons: Sequence[Polygon] | NDArray[Any], low: Floats, high: Floats, tolerance: float) -> Merged:
    """Return footprints of which those that touch or overlap are one, where both their ends are alike.

    Parameters
    ----------
    polygons
        (n,) valid ones, local metres.
    low, high
        (n,) where they begin and end.
    tolerance
        How far the ends of those that become one may lie apart, metres; all of them, not only neighbours.
    """
    given = np.empty(len(polygons), dtype=object)
    given[:] = list(polygons)
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
    result = np.empty(len(shapes), dtype=object)
    result[:] = shapes
    return Merged(
        _filled(result, 0.0),
        np.array([low[one].min() for one in rows]),
        np.array([high[one].max() for one in rows]),
        rows,
    )


def _groups(polygons: NDArray[Any], low: Floats, high: Floats, tolerance: float) -> NDArray[np.int64]:
    """Return the number of the group that each belongs to; in a group all ends lie within the tolerance."""
    group = np.arange(len(polygons))
    if len(polygons) < 2:
        return group
    a, b = shapely.STRtree(polygons).query(polygons, predicate="intersects")
    alike = (a < b) & (np.abs(low[a] - low[b]) <= tolerance) & (np.abs(high[a] - high[b]) <= tolerance)
    a, b = a[alike], b[alike]
    order = np.argsort(np.abs(high[a] - high[b]) + np.abs(low[a] - low[b]), kind="stable")
    ends = np.stack([low, low, high, high])  # least and greatest low, least and greatest high, of each group

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
