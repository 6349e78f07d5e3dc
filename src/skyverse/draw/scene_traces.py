"""A scene as plotly traces, which are plain dicts, because plotly's own Python objects are slow to make."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from skyverse.draw.margin_traces import ceiling, landings_in_space, pads, separations, tube
from skyverse.draw.mover_traces import active_zones_in_space, movers_in_space
from skyverse.draw.palette import FINDINGS
from skyverse.draw.plotly_values import NOWHERE, PLOTLY_DASHES, Trace, columns, flat, plain, trace
from skyverse.draw.scenes import MissionScene, Scene
from skyverse.draw.track import DrawnTrack, few
from skyverse.draw.world_traces import bounds, edges, kind, terrain
from skyverse.model.result import Result
from skyverse.numerics.tolerances import DRAWN_DEVIATION

# plotly draws other symbols in 3-D as letters of a font, which may lack them
PLOTLY_SYMBOLS = ("circle", "square", "diamond", "circle-open", "square-open")
MAX_NAMED_UAVS = 12  # the names of more UAVs would hide the scene
MIN_NAME_GAP = 0.04
"""Names are hidden at first where two UAVs start closer together than this share of the picture's longest side."""
_PLACE_IN_SPACE = "x %{x:.2f}, y %{y:.2f}, z %{z:.2f} m<extra></extra>"


def shortened(name: str) -> str:
    """Return a name, cut to fit beside a marker."""
    return name if len(name) <= 20 else f"{name[:19]}…"


def of_track(track: DrawnTrack, number: int, tolerance: float) -> list[Trace]:
    """Return one UAV's path, its trajectory accurate to `tolerance` metres, and the marks of its start and target."""
    name, place = plain(track.name), "%{text}<br>" + _PLACE_IN_SPACE
    kept = few(track.positions, tolerance)
    thin = {"color": track.colour, "width": 1.5 if len(track.times) else 4}
    thick = {"color": track.colour, "width": 5, "dash": PLOTLY_DASHES[track.lap % len(PLOTLY_DASHES)]}
    role = {"role": "path", "uav": number}
    path = trace("scatter3d", "lines", f"{name}: path", columns(track.path), None, role, line=thin)
    timed = {"customdata": flat(track.times[kept]), "line": thick}
    hover = "%{fullData.name}<br>t = %{customdata:.2f} s<br>" + _PLACE_IN_SPACE
    role, points = {"role": "trajectory", "uav": number}, columns(track.positions[kept])
    trajectory = trace("scatter3d", "lines", f"{name}: trajectory", points, hover, role, **timed)
    ends, words, symbols = [track.start], [f"{name}: start"], ["circle"]
    if track.target is not None:
        ends, symbols = [track.start, track.target], ["circle", "diamond"]
        words.append(f"{name}: target {plain(track.target_name or '')}")
    marker = {"color": track.colour, "size": [5, 7][: len(ends)], "symbol": symbols, "opacity": 1}
    role, points = {"role": "ends", "uav": number}, columns(np.array(ends, dtype=np.float64))
    name = f"{name}: start and target"
    return [path, trajectory, trace("scatter3d", "markers", name, points, place, role, text=words, marker=marker)]


def _marks(name: str, points: Iterable[Any], words: list[str], marker: Trace, role: str) -> Trace:
    places = columns(np.array(list(points), dtype=np.float64).reshape(-1, 3))
    hover = "%{text}<extra></extra>"
    return trace("scatter3d", "markers", name, places, hover, {"role": role}, text=words, marker=marker)


def findings(scene: Scene) -> Trace:
    """Return the marks at the places of the referee's findings."""
    placed = [finding for finding in scene.findings if finding.position is not None]
    marker = {"symbol": "circle-open", "size": 16, "color": [FINDINGS[finding.severity] for finding in placed]}
    words = [plain(f"{finding.kind}: {finding.message}") for finding in placed]
    return _marks("Found wrong", (finding.position for finding in placed), words, marker, "finding")


def _apart(scene: Scene) -> bool:
    """Return whether names beside the starts would not overlap."""
    starts = np.array([track.start for track in scene.tracks], dtype=np.float64).reshape(-1, 3)
    gaps = np.linalg.norm(starts[:, None] - starts, axis=2) + np.diag(np.full(len(starts), np.inf))
    return bool(gaps.min(initial=np.inf) > MIN_NAME_GAP * (scene.world.high - scene.world.low).max())


def fleet(scene: Scene) -> list[Trace]:
    """Return the trail of the fleet, which is empty at first, and the UAVs at their first instant."""
    line: Trace = {"width": 9, "color": []}
    trail = trace("scatter3d", "lines", "Trail", NOWHERE, None, {"role": "trail"}, line=line)
    names = [plain(shortened(track.name)) for track in scene.tracks]
    marker = {
        "color": [track.colour for track in scene.tracks],
        "symbol": [PLOTLY_SYMBOLS[track.lap % len(PLOTLY_SYMBOLS)] for track in scene.tracks],
        "size": 8,
    }
    uavs = _marks("UAVs", [track.at(-math.inf) for track in scene.tracks], names, marker, "fleet")
    uavs["mode"] = "markers+text" if len(names) <= MAX_NAMED_UAVS and _apart(scene) else "markers"
    uavs["textposition"] = "top center"
    uavs["hovertemplate"] = "%{text}<br>" + _PLACE_IN_SPACE
    return [trail, uavs]


def in_space(scene: Scene) -> list[Trace]:
    """Return all traces of the 3-D scene; the ``meta`` of each says what it shows."""
    words = [f"{plain(name)}{scene.spare_note}" for name, _ in scene.spare_targets]
    marker = {"symbol": "diamond-open", "size": 8, "color": scene.spare_colour}
    spare = _marks("Spare targets", (position for _, position in scene.spare_targets), words, marker, "spare")
    if not scene.spare_note and len(words) <= MAX_NAMED_UAVS:  # nothing else leads to them
        spare |= {"mode": "markers+text", "textposition": "top center"}
    fine = DRAWN_DEVIATION * float((scene.world.high - scene.world.low).max())
    tracks = [each for number, track in enumerate(scene.tracks) for each in of_track(track, number, fine)]
    top = float(scene.world.high[2])
    kinds = [kind(shapes, number, top) for number, shapes in enumerate(scene.world.kinds)]
    world = [*terrain(scene), *kinds, *edges(scene), bounds(scene)]
    tubes = [each for number, track in enumerate(scene.tracks) for each in tube(track, number, fine)]
    margins = [*tubes, *pads(scene), *ceiling(scene), *separations(scene)]
    moving = [*movers_in_space(scene), *active_zones_in_space(scene)]
    return [*world, *moving, *tracks, spare, findings(scene), *margins, *landings_in_space(scene), *fleet(scene)]


def of_curve(track: DrawnTrack, result: Result, number: int, bound: str) -> list[Trace]:
    """Return the best cost so far of one search, and its bound as a dashed line that is named `bound`."""
    name, history = plain(track.name), result.history
    axes = {"iterations": history.iteration.tolist(), "paths": history.generated_paths.tolist()}
    points, role = {"x": axes["iterations"], "y": flat(history.cost)}, {"role": "cost", "curve": number, **axes}
    line: Trace = {"color": track.colour, "width": 2, "shape": "hv"}
    hover = "%{fullData.name}<br>cost %{y:.2f} at %{x:,}<extra></extra>"
    best = trace("scatter", "lines", name, points, hover, role, line=line)
    if result.bound is None:
        return [best]
    ends = {axis: [values[0], values[-1]] for axis, values in axes.items()}
    points, role = {"x": ends["iterations"], "y": flat([result.bound] * 2)}, {"role": "bound", "curve": number, **ends}
    line = {"color": track.colour, "width": 1.5, "dash": "dash"}
    hover = "%{fullData.name}<br>%{y:.2f}<extra></extra>"
    return [trace("scatter", "lines", f"{name}: {bound}", points, hover, role, line=line), best]


def of_search(scene: MissionScene) -> list[Trace]:
    """Return all traces of the convergence chart."""
    curves = enumerate(scene.curves)
    return [each for number, curve in curves for each in of_curve(*curve, number, scene.bound)]
