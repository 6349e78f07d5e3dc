"""The altitude profile of each flight as plotly traces."""

from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.map_traces import closed
from skyverse.draw.plotly_values import Trace, packed, plain, trace
from skyverse.draw.profile import Profile
from skyverse.draw.scene import Scene
from skyverse.draw.track import Track

_PLACE_IN_PROFILE = "%{fullData.name}<br>%{x:,.0f} m from the start<br>z %{y:,.1f} m"


def from_the_side(scene: Scene) -> list[dict[str, Any]]:
    """Return, for each UAV that has a path, the traces of its profile and the range of its heights."""
    profiles = zip(scene.tracks, scene.profiles, range(len(scene.tracks)), strict=True)
    return [of(track, profile, uav, scene) for track, profile, uav in profiles if len(profile.distance)]


def of(track: Track, profile: Profile, uav: int, scene: Scene) -> dict[str, Any]:
    """Return the traces of one UAV's profile, those in the background first."""
    heights = [profile.points[:, 2]]
    heights += [] if profile.ground is None else [profile.ground, profile.ground + profile.clearance]
    heights += [] if profile.band is None else [profile.band]
    heights += [] if profile.ceiling is None else [profile.ceiling]
    heights += [crossing.levels for crossing in profile.crossings if scene.world.kinds[crossing.kind].solid]
    low, high = (float(edge([edge(values) for values in heights])) for edge in (np.min, np.max))
    margin = 0.06 * (high - low) or 1.0
    floor, top = low - margin, high + margin
    kinds = range(len(scene.world.kinds))
    traces = [area for kind in kinds if (area := _crossings(profile, scene, kind, floor, top)) is not None]
    if profile.ground is not None:
        traces += _ground(profile, floor)
    if profile.band is not None:
        traces += [_edge(profile, level) for level in profile.band.T]
    if profile.ceiling is not None:
        points = {"x": packed(profile.distance), "y": packed(profile.ceiling)}
        traces.append(trace("scatter", "lines", "Ceiling above ground", points, None, {"role": "ceiling"}))
    traces += _flight(track, profile)
    return {"uav": uav, "traces": traces, "range": [floor, top]}


def _crossings(profile: Profile, scene: Scene, number: int, floor: float, top: float) -> Trace | None:
    found = [crossing for crossing in profile.crossings if crossing.kind == number]
    if not found:
        return None
    rings = []
    for crossing in found:
        levels = np.clip(crossing.levels, floor, top)
        there, back = (np.column_stack([crossing.distance, levels[:, side]]) for side in (0, 1))
        rings.append(np.concatenate([there, back[::-1]]))
    return _area(plain(scene.world.kinds[number].name), closed(rings), {"role": "kind", "kind": number})


def _ground(profile: Profile, floor: float) -> list[Trace]:
    assert profile.ground is not None
    s, z = profile.distance, profile.ground
    below = np.column_stack([np.r_[s, s[-1], s[0]], np.r_[z, floor, floor]])
    band = np.column_stack([np.r_[s, s[::-1]], np.r_[z, z[::-1] + profile.clearance]])
    return [
        _area(f"Clearance, {profile.clearance:g} m above ground", closed([band]), {"role": "clearance"}),
        _area("Ground", closed([below]), {"role": "ground"}),
    ]


def _edge(profile: Profile, level: Floats) -> Trace:
    points = {"x": packed(profile.distance), "y": packed(level)}
    return trace("scatter", "lines", "Altitude band", points, None, {"role": "band"})


def _flight(track: Track, profile: Profile) -> list[Trace]:
    name, above = plain(track.name), {}
    hover = _PLACE_IN_PROFILE + "<extra></extra>"
    if profile.ground is not None:
        above = {"customdata": packed(profile.points[:, 2] - profile.ground)}
        hover = _PLACE_IN_PROFILE + ", %{customdata:,.1f} m above ground<extra></extra>"
    points = {"x": packed(profile.distance), "y": packed(profile.points[:, 2])}
    style = {"color": track.colour, "width": 3}
    line = trace("scatter", "lines", name, points, hover, {"role": "flight"}, line=style, **above)
    points = {"x": profile.distance[[0, -1]].tolist(), "y": profile.points[[0, -1], 2].tolist()}
    marker = {"symbol": ["circle", "diamond"], "color": track.colour, "size": 11, "line": {"width": 1.5}}
    marks = {"marker": marker, "text": [f"{name}: start", f"{name}: end"]}
    ends = trace("scatter", "markers", "Start and end", points, "%{text}<extra></extra>", {"role": "ends"}, **marks)
    return [line, ends]


def _area(name: str, line: Floats, meta: Trace) -> Trace:
    points = {"x": packed(line[:, 0]), "y": packed(line[:, 1])}
    return trace("scatter", "lines", name, points, None, meta, fill="toself")
