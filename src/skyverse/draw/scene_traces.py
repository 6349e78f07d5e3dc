"""A scene as plotly traces, which are plain dicts, because plotly's own Python objects are slow to make."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.draw.ground_relief import relit
from skyverse.draw.map_traces import finding_marks, stretches
from skyverse.draw.margin_traces import ceiling, landings_in_space, pads, separations, tube
from skyverse.draw.mover_traces import active_zones_in_space, movers_in_space
from skyverse.draw.palette import GROUND
from skyverse.draw.plotly_values import NOWHERE, PLOTLY_DASHES, Trace, columns, flat, mesh, packed, plain, trace
from skyverse.draw.scenes import MissionScene, Scene
from skyverse.draw.shape_geometry import below, brightness, outline, skin, surface
from skyverse.draw.shape_kinds import MAX_EDGED_SHAPES, ShapeKind
from skyverse.draw.survey_traces import surveys_in_space
from skyverse.draw.track import DrawnTrack, few
from skyverse.model.result import Result
from skyverse.model.shapes import Box, Voxels
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
    name, place = plain(track.name), "%{hovertext}<br>" + _PLACE_IN_SPACE
    kept = few(track.positions, tolerance)
    thin = {"color": track.colour, "width": 1.5 if len(track.times) else 4}
    thick = {"color": track.colour, "width": 5, "dash": PLOTLY_DASHES[track.lap % len(PLOTLY_DASHES)]}
    role = {"role": "path", "uav": number}
    path = trace("scatter3d", "lines", f"{name}: path", columns(track.path), None, role, line=thin)
    timed = {"customdata": flat(track.times[kept]), "line": thick}
    hover = "%{fullData.name}<br>t = %{customdata:.2f} s<br>" + _PLACE_IN_SPACE
    role, points = {"role": "trajectory", "uav": number}, columns(track.positions[kept])
    trajectory = trace("scatter3d", "lines", f"{name}: trajectory", points, hover, role, **timed)
    ends, numbers, words = zip(*track.marks, strict=True)
    symbols, sizes = ["circle", *["diamond"] * (len(ends) - 1)], [5, *[7] * (len(ends) - 1)]
    marker = {"color": track.colour, "size": sizes, "symbol": symbols, "opacity": 1}
    more = {"text": numbers, "hovertext": list(map(plain, words)), "textposition": "top center", "marker": marker}
    role, points = {"role": "ends", "uav": number}, columns(np.array(ends, dtype=np.float64))
    mode = "markers+text" if track.visits else "markers"
    return [path, trajectory, trace("scatter3d", mode, f"{name}: start and target", points, place, role, **more)]


def _marks(name: str, points: Iterable[Any], words: list[str], marker: Trace, role: str) -> Trace:
    places = columns(np.array(list(points), dtype=np.float64).reshape(-1, 3))
    hover = "%{text}<extra></extra>"
    return trace("scatter3d", "markers", name, places, hover, {"role": role}, text=words, marker=marker)


def findings(scene: Scene) -> list[Trace]:
    """Return the stretches of flights, and the marks at the places, of what is found wrong."""
    placed = [finding for finding in scene.findings if finding.position is not None]
    words = [plain(f"{finding.kind}: {finding.message}") for finding in placed]
    marks = finding_marks(placed, 16)
    drawn = stretches("scatter3d", scene.findings, lambda line: line[:, :3])
    return [*drawn, _marks("Found wrong", (finding.position for finding in placed), words, marks, "finding")]


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
    marked = [*findings(scene), *margins, *landings_in_space(scene)]
    return [*world, *surveys_in_space(scene), *moving, *tracks, spare, *marked, *fleet(scene)]


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


# ---- the world: the ground, a mesh and edges for each kind of shape, and the bounds ----
def terrain(scene: Scene) -> list[Trace]:
    """Return the ground as a shaded surface; an empty list without a terrain."""
    if scene.world.relief is None:
        return []
    off = {"show": False, "highlight": False}
    ground = {
        "type": "surface",
        "name": "Terrain",
        "x": packed(scene.world.relief.x),
        "y": packed(scene.world.relief.y),
        "z": packed(scene.world.relief.z.T),
        "surfacecolor": packed(relit(scene.world.relief, scene.world.stretch).T),
        "cmin": 0,
        "cmax": 1,
        "colorscale": [[k / (len(GROUND) - 1), tone] for k, tone in enumerate(GROUND)],
        "showscale": False,
        "hoverinfo": "skip",
        "contours": dict.fromkeys("xyz", off),
        "meta": {"role": "terrain"},
    }
    return [ground]


def kind(kind: ShapeKind, number: int, top: float) -> Trace:
    """Return all shapes of a kind, as far as they are below z = `top`, as one mesh, which is fast for thousands."""
    points, faces = [np.empty((0, 3))], [np.empty((0, 3), np.int64)]
    first = 0
    for corners, triangles in _surfaces(kind, top):
        points.append(corners)
        faces.append(triangles + first)
        first += len(corners)
    triangles, corners = np.concatenate(faces), np.concatenate(points)
    shaded = {
        "intensity": packed(brightness(_normals(corners[triangles]))),
        "intensitymode": "cell",
        "cmin": 0,
        "cmax": 1,
    }
    shading = shaded | {"showscale": False} if kind.solid else {}
    return mesh(plain(kind.name), corners, triangles, {"role": "kind", "kind": number}, flatshading=True, **shading)


def _normals(triangles: Floats) -> Floats:
    """Return vectors, (m, 3), across triangles, (m, 3, 3)."""
    return np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])


def _surfaces(kind: ShapeKind, top: float) -> Iterator[tuple[Floats, Ints]]:
    """Yield surfaces, points (n, 3) and triangles (m, 3); boxes that touch and are seen through have one together."""
    shapes = [below(shape, top) for shape in kind.shapes]
    together = set() if kind.solid else touching(shapes)
    whole = united([shape for k, shape in enumerate(shapes) if k in together and isinstance(shape, Box)])
    if whole is not None:
        yield whole
    for k, shape in enumerate(shapes):
        if whole is None or k not in together:
            yield surface(shape, kind.sides)


def edges(scene: Scene) -> list[Trace]:
    """Return the edges of each kind as one line; those of too many shapes are omitted, as they would hide the faces."""
    mapped, top = scene.world.mapped, float(scene.world.high[2])
    return [
        _line(
            f"Edges: {plain(kind.name)}",
            np.concatenate([outline(below(shape, top), kind.sides) for shape in kind.shapes]),
            {"role": "edge", "kind": number},
        )
        for number, kind in enumerate(scene.world.kinds)
        if kind.shapes and (len(kind.shapes) <= MAX_EDGED_SHAPES if mapped else kind.hard)
    ]


def bounds(scene: Scene) -> Trace:
    """Return the edges of the bounds; an empty line where there is a terrain."""
    given = scene.scenario.bounds
    frame = np.empty((0, 3)) if scene.world.relief is not None else outline(Box(min=given.min, max=given.max))
    return _line("Bounds", frame, {"role": "bounds"})


def _line(name: str, points: Floats, meta: Trace) -> Trace:
    return trace("scatter3d", "lines", name, columns(points, form=packed), None, meta)


MAX_BOXES = 2_000
"""The largest number of boxes that are compared with each other."""
MAX_CELLS = 2_000_000
"""The largest number of cells into which the boxes' sides may cut space."""


def touching(shapes: Sequence[object]) -> set[int]:
    """Return the indices of the boxes among some shapes that touch or overlap another one of them."""
    rows = [k for k, shape in enumerate(shapes) if isinstance(shape, Box)]
    if not 1 < len(rows) <= MAX_BOXES:
        return set()
    boxes = [shape for shape in shapes if isinstance(shape, Box)]
    low, high = np.array([box.min for box in boxes]), np.array([box.max for box in boxes])
    meet = np.ones((len(boxes), len(boxes)), dtype=bool)
    for axis in range(3):
        meet &= low[:, None, axis] <= high[:, axis]
        meet &= low[:, axis] <= high[:, None, axis]
    np.fill_diagonal(meet, False)
    return {rows[k] for k in np.flatnonzero(meet.any(axis=1))}


def united(boxes: Sequence[Box]) -> tuple[Floats, Ints] | None:
    """Return the points (n, 3) and triangles (m, 3) of the surface of some boxes; ``None`` for none, or too many.

    Seen through, two boxes that share a wall would otherwise be darker there than anywhere else.
    """
    corners = np.array([(box.min, box.max) for box in boxes], dtype=np.float64).reshape(-1, 2, 3)
    sides = [np.unique(corners[:, :, axis]) for axis in range(3)]
    shape = [len(places) - 1 for places in sides]
    if min(shape, default=0) < 1 or np.prod(shape, dtype=float) > MAX_CELLS:
        return None
    cells = np.zeros(shape, dtype=bool)
    first, last = (
        np.column_stack([np.searchsorted(sides[axis], corners[:, end, axis]) for axis in range(3)]) for end in (0, 1)
    )
    for low, high in zip(first, last, strict=True):
        cells[tuple(slice(a, b) for a, b in zip(low, high, strict=True))] = True
    numbered = skin(Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=cells)).astype(np.int64)
    quads = np.stack([sides[axis][numbered[:, :, axis]] for axis in range(3)], axis=-1)
    start = 4 * np.arange(len(quads))[:, None]
    return quads.reshape(-1, 3), np.vstack([start + np.array(half) for half in ((0, 1, 2), (0, 2, 3))])
