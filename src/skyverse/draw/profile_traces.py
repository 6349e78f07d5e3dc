"""The altitude profile of each flight as plotly traces."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.map_traces import MAX_NAMES, closed, numbered, rings, stretches
from skyverse.draw.margin_traces import MIN_DEVIATION
from skyverse.draw.plotly_values import Trace, area, columns, packed, plain, round_step, trace
from skyverse.draw.profile import Crossing, Profile
from skyverse.draw.scenes import NumberedPlace, Scene, SceneFinding
from skyverse.draw.track import DrawnTrack, few

SECONDS_TOLD = 6
"""About how many instants are told above a profile."""
LEAST_GAP = 0.06
"""The share of a profile's length that is kept between two instants."""
_PLACE_IN_PROFILE = "%{fullData.name}<br>%{x:,.0f} m from the start<br>z %{y:,.1f} m"


def from_the_side(scene: Scene) -> list[dict[str, Any]]:
    """Return, for each UAV that has a path, the traces of its profile and the range of its heights."""
    profiles = zip(scene.tracks, scene.profiles, range(len(scene.tracks)), strict=True)
    return [of(track, profile, uav, scene) for track, profile, uav in profiles if len(profile.distance)]


def of(track: DrawnTrack, profile: Profile, uav: int, scene: Scene) -> dict[str, Any]:
    """Return the traces of one UAV's profile, those in the background first."""
    heights = [profile.points[:, 2]]
    heights += [] if profile.ground is None else [profile.ground, profile.ground + profile.clearance]
    heights += [] if profile.band is None else [profile.band]
    heights += [] if profile.ceiling is None else [profile.ceiling]
    heights += [track.nominal[:, 2] - track.error.vertical, track.nominal[:, 2] + track.error.vertical]
    heights += [crossing.levels for crossing in profile.crossings if scene.world.kinds[crossing.kind].solid]
    heights += [crossing.levels for crossing in profile.movers]
    low, high = (float(edge([edge(values) for values in heights])) for edge in (np.min, np.max))
    margin = 0.06 * (high - low) or 1.0
    floor, top = low - margin, high + margin
    kinds = range(len(scene.world.kinds))
    traces = [one for kind in kinds if (one := _crossings(profile, scene, kind, floor, top)) is not None]
    if profile.ground is not None:
        traces += _ground(profile, floor)
    if profile.band is not None:
        traces += [_edge(profile, level) for level in profile.band.T]
    if profile.ceiling is not None:
        points = {"x": packed(profile.distance), "y": packed(profile.ceiling)}
        traces.append(trace("scatter", "lines", "Ceiling above ground", points, None, {"role": "ceiling"}))
    traces += _movers(profile, floor, top)
    traces += _names(profile, scene, floor, top)
    traces += _tube(track)
    marked = [*_marked(profile, uav, scene)] if profile.times is not None else []
    traces += _flight(track, profile, marked)
    return {"uav": uav, "traces": traces, "range": [floor, top], "seconds": _seconds(profile)}


def _marked(profile: Profile, uav: int, scene: Scene) -> Iterator[Trace]:
    """Yield what is wrong with a flight, and the numbers of its places, where it is then."""
    times = profile.times
    assert times is not None
    places = [place for place in scene.places if place.uav == uav]
    name = scene.scenario.uavs[uav].name
    found = [one for one in scene.findings if one.time is not None and (name in one.uavs or len(scene.tracks) == 1)]

    def at(marked: Sequence[NumberedPlace] | Sequence[SceneFinding]) -> Floats:
        along = np.interp([one.time or 0.0 for one in marked], times, profile.distance)
        return np.column_stack([along, [np.nan if one.position is None else one.position[2] for one in marked]])

    if found:
        along = partial(np.interp, xp=times, fp=profile.distance)
        yield from stretches("scatter", found, lambda line: np.column_stack([along(line[:, 3]), line[:, 2]]))
        yield from rings(found, at(found))
    if places:
        yield from numbered(places, at(places))


def _seconds(profile: Profile) -> list[list[float]]:
    """Return round instants of the mission, seconds, each with the distance along the path at which the UAV is then.

    Of instants that would be written over each other, as where the UAV hovers, only the first is told.
    """
    if profile.times is None or profile.distance[-1] == 0 or profile.times[-1] <= profile.times[0]:
        return []
    first, last = float(profile.times[0]), float(profile.times[-1])
    step = round_step((last - first) / SECONDS_TOLD)
    instants = step * np.arange(np.ceil(first / step - 1e-9), last / step + 1e-9)
    places = np.interp(instants, profile.times, profile.distance)
    told: list[list[float]] = []
    for instant, place in zip(instants.tolist(), places.tolist(), strict=True):
        if not told or place - told[-1][1] > LEAST_GAP * profile.distance[-1]:
            told.append([float(f"{instant:.6g}"), place])
    return told


def _tube(track: DrawnTrack) -> list[Trace]:
    """Return the heights between which the UAV stays by its tracking error."""
    up = track.error.vertical
    if up == 0:
        return []
    line = _nominal(track)
    s, z = line[few(line, MIN_DEVIATION / 5 * up)].T
    band = np.column_stack([np.r_[s, s[::-1]], np.r_[z + up, z[::-1] - up]])
    return [area(f"Tracking error, {up:g} m", closed([band]), {"role": "tube", "colour": track.colour})]


def _crossings(profile: Profile, scene: Scene, number: int, floor: float, top: float) -> Trace | None:
    found = [crossing for crossing in profile.crossings if crossing.kind == number]
    if not found:
        return None
    return area(plain(scene.world.kinds[number].name), _filled(found, floor, top), {"role": "kind", "kind": number})


def _movers(profile: Profile, floor: float, top: float) -> list[Trace]:
    """Return what a UAV passes of movers, each as it is when the UAV is there."""
    if not profile.movers:
        return []
    return [area("Movers as they are passed", _filled(profile.movers, floor, top), {"role": "mover"})]


def _names(profile: Profile, scene: Scene, floor: float, top: float) -> list[Trace]:
    """Return the names of airspace below, above and around a UAV, each in the middle of what is seen of it."""
    named = {}
    for crossing in profile.crossings:
        low, high = (float(np.clip(edge(crossing.levels), floor, top)) for edge in (np.min, np.max))
        kind = scene.world.kinds[crossing.kind]
        if crossing.name != kind.name and not kind.shapes[0].solid and low < high:
            named[float(crossing.distance.mean()), (low + high) / 2] = plain(crossing.name)
    if not 0 < len(named) <= MAX_NAMES:
        return []
    points = dict(zip("xy", map(list, zip(*named, strict=True)), strict=True))
    font = {"size": 11}
    return [trace("scatter", "text", "Names", points, None, {"role": "names"}, text=[*named.values()], textfont=font)]


def _filled(crossings: Sequence[Crossing], floor: float, top: float) -> Floats:
    """Return the outlines of crossings, cut off at the edges of the picture, as one line with gaps of nan."""
    rings = []
    for crossing in crossings:
        levels = np.clip(crossing.levels, floor, top)
        there, back = (np.column_stack([crossing.distance, levels[:, side]]) for side in (0, 1))
        rings.append(np.concatenate([there, back[::-1]]))
    return closed(rings)


def _ground(profile: Profile, floor: float) -> list[Trace]:
    assert profile.ground is not None
    s, z = profile.distance, profile.ground
    below = np.column_stack([np.r_[s, s[-1], s[0]], np.r_[z, floor, floor]])
    band = np.column_stack([np.r_[s, s[::-1]], np.r_[z, z[::-1] + profile.clearance]])
    return [
        area(f"Clearance, {profile.clearance:g} m above ground", closed([band]), {"role": "clearance"}),
        area("Ground", closed([below]), {"role": "ground"}),
    ]


def _edge(profile: Profile, level: Floats) -> Trace:
    points = {"x": packed(profile.distance), "y": packed(level)}
    return trace("scatter", "lines", "Altitude band", points, None, {"role": "band"})


def _flight(track: DrawnTrack, profile: Profile, marked: list[Trace]) -> list[Trace]:
    name, hover = plain(track.name), _PLACE_IN_PROFILE
    more: list[Floats] = []
    if profile.ground is not None:
        hover += f", %{{customdata[{len(more)}]:,.1f}} m above ground"
        more.append(profile.points[:, 2] - profile.ground)
    if profile.lowest is not None:
        hover += f" as raised, %{{customdata[{len(more)}]:,.1f}} m above the lowest that it may be"
        more.append(profile.points[:, 2] - profile.lowest)
    if profile.times is not None:
        hover += f"<br>t = %{{customdata[{len(more)}]:,.1f}} s"
        more.append(profile.times)
    above = {"customdata": packed(np.column_stack(more))} if more else {}
    hover += "<extra></extra>"
    points = {"x": packed(profile.distance), "y": packed(profile.points[:, 2])}
    style = {"color": track.colour, "width": 3}
    line = trace("scatter", "lines", name, points, hover, {"role": "flight"}, line=style, **above)
    points = {"x": profile.distance[[0, -1]].tolist(), "y": profile.points[[0, -1], 2].tolist()}
    marker = {"symbol": ["circle", "diamond"], "color": track.colour, "size": 11, "line": {"width": 1.5}}
    marks = {"marker": marker, "text": [f"{name}: start", f"{name}: end"]}
    planned = [] if track.nominal is track.positions or not len(track.times) else [_planned(track)]
    ends = trace("scatter", "markers", "Start and end", points, "%{text}<extra></extra>", {"role": "ends"}, **marks)
    return [*planned, line, *marked, ends]


def _nominal(track: DrawnTrack) -> Floats:
    """Return the flight as planned, (n, 2): metres from the start, measured on the map, and z."""
    steps = np.linalg.norm(np.diff(track.nominal[:, :2], axis=0), axis=1)
    return np.column_stack([np.append(0.0, np.cumsum(steps)), track.nominal[:, 2]])


def _planned(track: DrawnTrack) -> Trace:
    """Return the line of a flight as it was planned, beside which it is drawn as flown."""
    points = columns(_nominal(track), "xy", packed)
    style = {"color": track.colour, "width": 1, "dash": "dash"}
    return trace("scatter", "lines", f"{plain(track.name)}, as planned", points, None, {"role": "planned"}, line=style)
