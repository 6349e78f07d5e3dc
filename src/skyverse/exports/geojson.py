"""GeoJSON (RFC 7946): longitude, latitude and height; times, altitudes and names are properties."""

import json
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.global_positions import geoid_of, global_positions, targets_on_globe
from skyverse.exports.sampling import SampledTrajectory
from skyverse.exports.shape_outlines import outlines
from skyverse.model.scenario import Scenario


def geojson_text(scenario: Scenario, flights: list[SampledTrajectory], what: str = "GeoJSON") -> str:
    """Return a ``.geojson`` text, whose heights are above the ellipsoid, as the standard requires."""
    geoid = geoid_of(scenario, what)
    features = []
    for flight in flights:
        at = global_positions(scenario, flight.uav, flight.position, "amsl")
        rows = np.column_stack([at.longitude, at.latitude, at.altitude + geoid])
        properties = {
            "kind": "path",
            "name": flight.name,
            "times": np.round(flight.seconds, 6).tolist(),
            "altitudes": np.round(at.altitude, 4).tolist(),
            "altitude_frame": "amsl",
        }
        features.append(_feature(_line(rows), properties))
    for name, (latitude, longitude, altitude) in targets_on_globe(scenario, "amsl"):
        point = {"type": "Point", "coordinates": _rounded([[longitude, latitude, altitude + geoid]])[0]}
        features.append(_feature(point, {"kind": "target", "name": name}))
    for noun, shapes in (("obstacle", scenario.obstacles), ("zone", scenario.zones)):
        for outline in outlines(scenario, shapes):
            rings = [_rounded(np.column_stack([r[:, 1], r[:, 0]])) for r in (outline.top, *outline.holes)]
            properties = {
                "kind": outline.kind or noun,
                "name": outline.name,
                "forbidden": noun == "obstacle",
                "low": round(float(outline.bottom[:, 2].mean()), 4),
                "high": round(float(outline.top[:, 2].mean()), 4),
                "altitude_frame": "amsl",
            }
            features.append(_feature({"type": "Polygon", "coordinates": [[*r, r[0]] for r in rings]}, properties))
    return json.dumps({"type": "FeatureCollection", "features": features}, allow_nan=False) + "\n"


def _feature(geometry: dict[str, Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "geometry": geometry, "properties": properties}


def _line(rows: Floats) -> dict[str, Any]:
    """Return a line through (n, 3) longitudes, latitudes and heights, cut where it crosses the antimeridian."""
    jumps = np.flatnonzero(np.abs(np.diff(rows[:, 0])) > 180)
    if not len(jumps):
        return {"type": "LineString", "coordinates": _rounded(rows)}
    parts, begin = [], rows[:0]
    first = 0
    for k in jumps.tolist():
        side = 180.0 if rows[k, 0] > 0 else -180.0
        ahead = rows[k + 1] + [2 * side, 0.0, 0.0]
        share = (side - rows[k, 0]) / (ahead[0] - rows[k, 0])
        edge = rows[k] + share * (ahead - rows[k])
        parts.append(np.concatenate([begin, rows[first : k + 1], edge[None]]))
        begin, first = (edge * [-1.0, 1.0, 1.0])[None], k + 1
    parts.append(np.concatenate([begin, rows[first:]]))
    return {"type": "MultiLineString", "coordinates": [_rounded(part) for part in parts]}


def _rounded(rows: Floats | list[list[float]]) -> list[list[float]]:
    return [[round(float(v), 9 if k < 2 else 4) for k, v in enumerate(row)] for row in rows]
