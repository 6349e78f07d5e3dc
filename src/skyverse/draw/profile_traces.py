"""The altitude profile of each flight as plotly traces."""

from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.map_traces import closed
from skyverse.draw.plotly_values import Trace, packed, plain
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
    heights += [crossing.levels for crossing in profile.crossings if scene.world.kinds[crossing.kind].solid]
    low, high = (float(edge([edge(values) for values in heights])) for edge in (np.min, np.max))
    margin = 0.06 * (high - low) or 1.0
    floor, top = low - margin, high + margin
    traces = [
        trace
        for number in range(len(scene.world.kinds))
        if (trace := _crossings(profile, scene, number, floor, top)) is not None
    ]
    if profile.ground is not None:
        traces += _ground(profile, floor)
    if profile.band is not None:
        traces += [_edge(profile, level) for level in profile.band.T]
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
    return {
        **_area(plain(scene.world.kinds[number].name), closed(rings)),
        "meta": {"role": "kind", "kind": number},
    }


def _ground(profile: Profile, floor: float) -> list[Trace]:
    assert profile.ground is not None
    s, z = profile.distance, profile.ground
    below = np.column_stack([np.r_[s, s[-1], s[0]], np.r_[z, floor, floor]])
    band = np.column_stack([np.r_[s, s[::-1]], np.r_[z, z[::-1] + profile.clearance]])
    return [
        {**_area(f"Clearance, {profile.clearance:g} m above ground", closed([band])), "meta": {"role": "clearance"}},
        {**_area("Ground", closed([below])), "meta": {"role": "ground"}},
    ]


def _edge(profile: Profile, level: Floats) -> Trace:
    return {
        "type": "scatter",
        "mode": "lines",
        "name": "Altitude band",
        "x": packed(profile.distance),
        "y": packed(level),
        "hoverinfo": "skip",
        "meta": {"role": "band"},
    }


def _flight(track: Track, profile: Profile) -> list[Trace]:
    name = plain(track.name)
    line: Trace = {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": packed(profile.distance),
        "y": packed(profile.points[:, 2]),
        "line": {"color": track.colour, "width": 3},
        "hovertemplate": _PLACE_IN_PROFILE + "<extra></extra>",
        "meta": {"role": "flight"},
    }
    if profile.ground is not None:
        line["customdata"] = packed(profile.points[:, 2] - profile.ground)
        line["hovertemplate"] = _PLACE_IN_PROFILE + ", %{customdata:,.1f} m above ground<extra></extra>"
    ends = {
        "type": "scatter",
        "mode": "markers",
        "name": "Start and end",
        "x": [float(profile.distance[0]), float(profile.distance[-1])],
        "y": [float(profile.points[0, 2]), float(profile.points[-1, 2])],
        "marker": {"symbol": ["circle", "diamond"], "color": track.colour, "size": 11, "line": {"width": 1.5}},
        "text": [f"{name}: start", f"{name}: end"],
        "hovertemplate": "%{text}<extra></extra>",
        "meta": {"role": "ends"},
    }
    return [line, ends]


def _area(name: str, line: Floats) -> Trace:
    return {
        "type": "scatter",
        "mode": "lines",
        "fill": "toself",
        "name": name,
        "x": packed(line[:, 0]),
        "y": packed(line[:, 1]),
        "hoverinfo": "skip",
    }
