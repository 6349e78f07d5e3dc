"""Outlines that cross the antimeridian in one piece, with longitudes that continue beyond 180 degrees."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.maps.georeference.feature import Feature

UNAMBIGUOUS_EDGE = 179.0
"""Degrees of longitude; an edge up to this long is read as it stands."""
CROSSING_EDGE = 90.0
"""Degrees; a longer edge crosses the antimeridian if the way across is at most this long, else it could be either."""
SCENARIO_REACH = 10.0
"""Degrees of latitude, and about as far east and west, that no scenario reaches away from its frame's origin."""


def unwrapped(places: Floats, where: str) -> Floats:
    """Return corners (n, 2), longitude and latitude, each of which lies the shorter way from the one before it.

    Raises
    ------
    InputError
        If an edge could run either way around the globe.
    """
    steps = np.diff(places, axis=0)
    turns = -np.round(steps[:, 0] / 360)
    short = steps[:, 0] + 360 * turns
    either = (np.abs(steps[:, 0]) > UNAMBIGUOUS_EDGE) & (np.abs(short) > CROSSING_EDGE)
    either |= (turns != 0) & (short == 0) & (steps[:, 1] == 0)
    if either.any():
        wide = abs(steps[np.flatnonzero(either)[0], 0])
        raise InputError(
            f"{where}: expected edges that run one way around the globe, found one of {wide:g} degrees of longitude; "
            "give it corners between, or cut it at the antimeridian or pole"
        )
    result = places.copy()
    result[1:, 0] += 360 * np.cumsum(turns)
    return result


def in_one_piece(polygon: Polygon, where: str, beside: float | None = None) -> Polygon:
    """Return a polygon with all its edges unwrapped.

    Parameters
    ----------
    polygon
        Longitude and latitude, degrees.
    where
        The beginning of messages.
    beside
        The longitude that its middle is to be nearest to; its own when left out, counted from its first corner on.

    Raises
    ------
    InputError
        If the polygon goes around a pole, or an edge could run either way.
    """
    rings = [unwrapped(shapely.get_coordinates(ring), where) for ring in (polygon.exterior, *polygon.interiors)]
    if any(ring[0, 0] != ring[-1, 0] for ring in rings):
        raise InputError(f"{where}: its outline goes around a pole, which has no inside on a flat map")
    middle = _middle(rings[0]) if beside is None else beside
    for ring in rings:
        ring[:, 0] += 360 * round((middle - _middle(ring)) / 360)
    return Polygon(rings[0], rings[1:])


def _middle(ring: Floats) -> float:
    return float(ring[:, 0].min() + ring[:, 0].max()) / 2


def joined(parts: list[Polygon]) -> list[Polygon]:
    """Return polygons that were cut at the antimeridian in one piece."""
    if len(parts) < 2:
        return parts
    bounds = shapely.bounds(np.array(parts, dtype=object))
    east, west = bounds[:, 2] >= 180 - 1e-9, bounds[:, 0] <= -180 + 1e-9
    if not (east & ~west).any() or not (west & ~east).any():
        return parts
    turned = [_turned(part, int(w and not e)) for part, e, w in zip(parts, east, west, strict=True)]
    return pieces(shapely.union_all(turned))


def _turned(polygon: Polygon, turns: int) -> Polygon:
    """Return a polygon with full turns of 360 degrees added to its longitudes."""
    moved: Polygon = shapely.transform(polygon, lambda places: places + np.array([360.0 * turns, 0.0]))
    return moved if turns else polygon


def pieces(geometry: BaseGeometry) -> list[Polygon]:
    """Return the polygons of a geometry that have an area."""
    if hasattr(geometry, "geoms"):
        return [piece for part in geometry.geoms for piece in pieces(part)]
    return [geometry] if isinstance(geometry, Polygon) and geometry.area > 0 else []


def features_around(features: Sequence[Feature], longitude: float, latitude: float) -> list[Feature]:
    """Return the parts of features within `SCENARIO_REACH` of a place; in a plane, others would fall on what is near.

    Parameters
    ----------
    features
        Features whose longitudes may continue beyond 180 degrees.
    longitude, latitude
        The place, degrees.
    """
    if not features:
        return []
    sizes = np.array([len(feature.outline) for feature in features])
    corners, starts = np.concatenate([feature.outline for feature in features]), np.cumsum(sizes) - sizes
    low, high = np.minimum.reduceat(corners, starts), np.maximum.reduceat(corners, starts)
    farthest = abs(latitude) + SCENARIO_REACH
    wide = 180.0 if farthest >= 85 else SCENARIO_REACH / math.cos(math.radians(farthest))
    frame = shapely.box(longitude - wide, latitude - SCENARIO_REACH, longitude + wide, latitude + SCENARIO_REACH)
    west, south, east, north = frame.bounds
    level = (low[:, 1] <= north) & (high[:, 1] >= south)
    inside = (low[:, 1] >= south) & (high[:, 1] <= north)
    turns = 360 * np.round((longitude - (low[:, 0] + high[:, 0]) / 2) / 360)
    inside &= (low[:, 0] + turns >= west) & (high[:, 0] + turns <= east)
    found = []
    for k in np.flatnonzero(level).tolist():
        found += [features[k]] if inside[k] else _cut(features[k], frame)
    return found


def _cut(feature: Feature, frame: Polygon) -> list[Feature]:
    """Return the parts of a feature in a frame of longitudes and latitudes, at every full turn that reaches it."""
    west, _, east, _ = frame.bounds
    low, high = feature.outline[:, 0].min(), feature.outline[:, 0].max()
    polygon = Polygon(feature.outline, feature.holes)
    turns = range(math.ceil((west - high) / 360), math.floor((east - low) / 360) + 1)
    parts = [part for turn in turns for part in pieces(_turned(polygon, turn).intersection(frame))]
    cut = []
    for part in shapely.segmentize(parts, 1.0):
        rings = [shapely.get_coordinates(ring)[:-1] for ring in (part.exterior, *part.interiors)]
        cut.append(replace(feature, outline=rings[0], holes=tuple(rings[1:])))
    return cut
