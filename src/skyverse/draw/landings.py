"""The places where UAVs may land when they return by themselves, as plotly traces."""

from collections.abc import Iterator

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.plotly_values import Trace, flat, packed, plain, trace
from skyverse.draw.scene import LandingPlace, Scene
from skyverse.draw.track import DrawnTrack


def in_space(scene: Scene) -> list[Trace]:
    """Return, for each UAV, the descents to its landing places, marked where they begin."""
    made = []
    for number, track, own, feet in _landings(scene):
        tops = np.column_stack([feet[:, :2], [place.level for place in own]])
        line = np.stack([feet, tops, np.full_like(feet, np.nan)], axis=1).reshape(-1, 3)
        points = {axis: flat(line[:, column]) for column, axis in enumerate("xyz")}
        words = [plain(place.words) for place in own for _ in range(3)]
        sizes = [size for _ in own for size in (0, 6, 0)]
        marker = {"symbol": "square", "color": track.colour, "size": sizes, "opacity": 1}
        role, name = {"role": "landing", "uav": number}, f"{plain(track.name)}: where it may land"
        style = {"color": track.colour, "width": 2, "dash": "dot"}
        hover = "%{text}<extra></extra>"
        both = {"text": words, "marker": marker, "line": style}
        made.append(trace("scatter3d", "lines+markers", name, points, hover, role, **both))
    return made


def on_map(scene: Scene) -> list[Trace]:
    """Return, for each UAV, its landing places on the map."""
    made = []
    for number, track, own, feet in _landings(scene):
        points = {"x": packed(feet[:, 0]), "y": packed(feet[:, 1])}
        marker = {"symbol": "square-open", "color": track.colour, "size": 13, "line": {"width": 2.5}}
        words = [plain(place.words) for place in own]
        role, name = {"role": "landing", "uav": number}, f"{plain(track.name)}: where it may land"
        hover = "%{text}<extra></extra>"
        made.append(trace("scatter", "markers", name, points, hover, role, text=words, marker=marker))
    return made


def _landings(scene: Scene) -> Iterator[tuple[int, DrawnTrack, list[LandingPlace], Floats]]:
    """Yield the number and track of each UAV that has landing places, these places, and their positions (k, 3)."""
    for number, track in enumerate(scene.tracks):
        own = [place for place in scene.landings if place.uav == number]
        if own:
            yield number, track, own, np.array([place.position for place in own], dtype=np.float64)
