"""The mission seen from above as plotly traces, and the ground as an image below them."""

import base64
import io
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.ground_relief import Relief, tinted
from skyverse.draw.margin_traces import MIN_DEVIATION, landings_on_map
from skyverse.draw.mover_traces import ways_on_map
from skyverse.draw.palette import FINDINGS
from skyverse.draw.plotly_values import PLOTLY_DASHES, Trace, area, columns, packed, plain, round_step, trace
from skyverse.draw.scenes import NumberedPlace, Scene, SceneFinding
from skyverse.draw.shape_geometry import footprint, is_fence
from skyverse.draw.shape_kinds import ShapeKind
from skyverse.draw.survey_traces import surveys_on_map
from skyverse.draw.track import DrawnTrack, few
from skyverse.model.frame import Origin
from skyverse.model.shape_extent import extent

MAX_CONTOUR_HEIGHTS = 160
"""The largest number of heights along each side from which contour lines are drawn."""
MIN_CONTOUR_RANGE = 1.0
"""Metres: there are contour lines only where the ground's heights differ by more."""

WIDTHS = {"warning": 14, "error": 6}
"""Pixels of the stretches of flights on which something is wrong, by its severity."""
MAX_NAMES = 30
"""Names at most that are written in one picture."""
APART = 0.03
"""The share of a picture by which numbers of places are apart at least."""
_PLACE_ON_MAP = "x %{x:.1f}, y %{y:.1f} m<extra></extra>"


def from_above(scene: Scene) -> dict[str, Any]:
    """Return the data of the page's map: traces, an image of the ground, and latitudes and longitudes."""
    relief, degrees = scene.overhead.relief, scene.overhead.degrees
    kinds = [kind(shapes, number) for number, shapes in enumerate(scene.world.kinds)]
    tubes = [each for number, track in enumerate(scene.tracks) for each in _tube(track, number)]
    tracks = [each for number in range(len(scene.tracks)) for each in _track(scene, number)]
    return {
        "traces": [
            *([] if relief is None else [contours(relief, scene.scenario.frame.origin)]),
            *kinds,
            *surveys_on_map(scene),
            *_zone_names(scene),
            *ways_on_map(scene),
            *tubes,
            *tracks,
            *landings_on_map(scene),
            _ends(scene),
            *_findings(scene),
            *numbered(scene.places, np.array([one.position[:2] for one in scene.places]).reshape(-1, 2)),
        ],
        "ground": None if relief is None else picture(relief, scene.world.stretch),
        "degrees": None if degrees is None else degrees.tolist(),
    }


def picture(relief: Relief, stretch: float) -> dict[str, Any]:
    """Return the shaded ground as an image, with its place and size on the map."""
    from PIL import Image

    colours = np.round(255 * tinted(relief, stretch)).astype(np.uint8).swapaxes(0, 1)[::-1]
    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(colours)).save(file, "JPEG", quality=88)
    # the centre of each pixel lies at the place of its height
    dx, dy = relief.x[1] - relief.x[0], relief.y[1] - relief.y[0]
    return {
        "source": f"data:image/jpeg;base64,{base64.b64encode(file.getvalue()).decode()}",
        "x": float(relief.x[0] - dx / 2),
        "y": float(relief.y[-1] + dy / 2),
        "sizex": float(dx * len(relief.x)),
        "sizey": float(dy * len(relief.y)),
    }


def contours(relief: Relief, origin: Origin | None) -> Trace:
    """Return contour lines whose heights differ by a round number of metres: above sea level, if there is an origin."""
    rows, columns = (
        np.unique(np.linspace(0, n - 1, min(n, MAX_CONTOUR_HEIGHTS)).round().astype(int)) for n in relief.z.shape
    )
    heights = relief.z[np.ix_(rows, columns)] + (0.0 if origin is None else origin.altitude)
    range_ = float(np.ptp(heights))
    step = spacing(range_)
    return {
        "type": "contour",
        "name": f"Contour lines every {step:g} m",
        "x": packed(relief.x[rows]),
        "y": packed(relief.y[columns]),
        "z": packed(heights.T),
        "contours": {
            "coloring": "none",
            "showlabels": True,
            "start": math.ceil(heights.min() / step) * step,
            "end": float(heights.max()),
            "size": step,
        },
        "showscale": False,
        "hoverinfo": "skip",
        "visible": range_ >= MIN_CONTOUR_RANGE,
        "meta": {
            "role": "contours",
            "step": step if range_ >= MIN_CONTOUR_RANGE else None,
            "above": "" if origin is None else " above sea level",
        },
    }


def spacing(range_: float) -> float:
    """Return a round number of metres that divides a range of heights into at most ten steps."""
    return round_step(max(range_, 0.1) / 10)


def kind(kind: ShapeKind, number: int) -> Trace:
    """Return the footprints of a kind as one line, in which holes run clockwise; all but fences are filled."""
    rings = [ring for shape in kind.shapes for ring in footprint(shape, kind.sides)]
    found = area(plain(kind.name), closed(rings), {"role": "kind", "kind": number})
    return found | {"fill": "none"} if any(map(is_fence, kind.shapes)) else found


def _zone_names(scene: Scene) -> list[Trace]:
    """Return the names of airspace, each in the middle of its footprint, where there are few enough to be read."""
    scenario = scene.scenario
    zones = [zone for zone in (*scenario.obstacles, *scenario.zones) if zone.name and not zone.solid]
    if not 0 < len(zones) <= MAX_NAMES:
        return []
    low, high = (np.array(side[:2]) for side in (scenario.bounds.min, scenario.bounds.max))
    boxes = [np.clip(np.array(extent(zone))[:, :2], low, high) for zone in zones]
    words, font = [plain(zone.name or "") for zone in zones], {"size": 11}
    points, role = columns(np.array([box.mean(axis=0) for box in boxes]), "xy", packed), {"role": "names"}
    return [trace("scatter", "text", "Names of zones", points, None, role, text=words, textfont=font)]


def closed(rings: list[Floats]) -> Floats:
    """Return rings, (n, 2) each, as closed curves in one line with gaps of nan."""
    gap = np.full((1, 2), np.nan)
    parts = [part for ring in rings for part in (ring, ring[:1], gap)]
    return np.concatenate(parts) if parts else np.empty((0, 2))


def _tube(track: DrawnTrack, number: int) -> list[Trace]:
    """Return the strip of the map within which a UAV stays by its tracking error."""
    aside, line = track.error.horizontal, track.nominal[:, :2]
    if aside == 0 or len(line) < 2:
        return []
    line = line[few(track.nominal, MIN_DEVIATION * aside)]
    steps = np.diff(line, axis=0)
    line = line[np.append(True, np.linalg.norm(steps, axis=1) > 0)]
    if len(line) < 2:
        return []
    ahead = np.gradient(line, axis=0)
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1), 1e-12)[:, None]
    left = aside * np.column_stack([-ahead[:, 1], ahead[:, 0]])
    turn = np.pi * np.arange(1, 12) / 12
    cap = np.column_stack([np.sin(turn), np.cos(turn)])  # ahead, to the left
    caps = [line[k] + way * cap[:, :1] * aside * ahead[k] + way * cap[:, 1:] * left[k] for k, way in ((-1, 1), (0, -1))]
    ring = np.concatenate([line + left, caps[0], (line - left)[::-1], caps[1]])
    style = {"fillcolor": f"{track.colour}38", "line": {"width": 0}}
    named = f"{plain(track.name)}: tracking error"
    return [area(named, closed([ring]), {"role": "tube", "uav": number}, **style)]


def _track(scene: Scene, number: int) -> list[Trace]:
    track, name = scene.tracks[number], plain(scene.tracks[number].name)
    flies = len(track.times) > 0
    line = {"color": track.colour, "width": 1.2 if flies else 3}
    role = {"role": "path", "uav": number}
    planned = trace("scatter", "lines", f"{name}: path", columns(track.path, "xy", packed), None, role, line=line)
    line = {"color": track.colour, "width": 3, "dash": PLOTLY_DASHES[track.lap % len(PLOTLY_DASHES)]}
    timed = {"customdata": packed(np.column_stack([track.times, track.positions[:, 2]])), "line": line}
    hover = "%{fullData.name}<br>t = %{customdata[0]:.1f} s, z %{customdata[1]:.1f} m<br>" + _PLACE_ON_MAP
    role = {"role": "trajectory", "uav": number}
    return [planned, trace("scatter", "lines", name, columns(track.positions, "xy", packed), hover, role, **timed)]


def _ends(scene: Scene) -> Trace:
    """Return the marks of starts, targets and targets without a UAV."""
    marks = [
        (place, "diamond" if k else "circle", track.colour, said)
        for track in scene.tracks
        for k, (place, _, said) in enumerate(track.marks)
    ]
    marks += [
        (place, "diamond-open", scene.spare_colour, f"{name}{scene.spare_note}") for name, place in scene.spare_targets
    ]
    points = columns(np.array([mark[0][:2] for mark in marks], dtype=np.float64).reshape(-1, 2), "xy", packed)
    symbols, colours = [mark[1] for mark in marks], [mark[2] for mark in marks]
    marker = {"symbol": symbols, "color": colours, "size": 11, "line": {"width": 1.5}}
    words, hover = [plain(mark[3]) for mark in marks], "%{text}<br>" + _PLACE_ON_MAP
    return trace("scatter", "markers", "Starts and targets", points, hover, {"role": "ends"}, text=words, marker=marker)


def _findings(scene: Scene) -> list[Trace]:
    placed = [finding for finding in scene.findings if finding.position is not None]
    places = [finding.position[:2] for finding in placed if finding.position is not None]
    drawn = stretches("scatter", scene.findings, lambda line: line[:, :2])
    return [*drawn, *rings(placed, np.array(places, dtype=np.float64).reshape(-1, 2))]


def rings(found: Sequence[SceneFinding], points: Floats) -> list[Trace]:
    """Return rings around what is wrong, at points (n, 2) of the map or of a profile; on stretches they are dots."""
    words = [plain(f"{finding.kind}: {finding.message}") for finding in found]
    marker = finding_marks(found, 18) | {"line": {"width": 2}}
    role, told, where = {"role": "finding"}, "%{text}<extra></extra>", columns(points, "xy", packed)
    return [trace("scatter", "markers", "Found wrong", where, told, role, text=words, marker=marker)]


def finding_marks(found: Sequence[SceneFinding], size: int) -> Trace:
    """Return the markers of what is wrong: rings of a size, and small dots on stretches that are drawn themselves."""
    drawn = [finding.stretch is not None for finding in found]
    return {
        "symbol": ["circle" if one else "circle-open" for one in drawn],
        "size": [size // 2 if one else size for one in drawn],
        "color": [FINDINGS[finding.severity] for finding in found],
    }


def stretches(form: str, found: Sequence[SceneFinding], seen: Callable[[Floats], Floats]) -> list[Trace]:
    """Return the stretches of flights that are wrong, as `seen` makes points of theirs, one trace for each colour.

    Warnings come first and are wider, so that they show beside errors on the same stretch.
    """
    made = []
    for severity, colour in FINDINGS.items():
        some = [seen(one.stretch) for one in found if one.severity == severity and one.stretch is not None]
        if some:
            points = np.concatenate([np.vstack([line, np.full_like(line[:1], np.nan)]) for line in some])
            where, style = columns(points, "xyz"[: points.shape[1]]), {"color": colour, "width": WIDTHS[severity]}
            made.append(trace(form, "lines", "Found wrong", where, None, {"role": "finding"}, line=style))
    return made


def numbered(places: Sequence[NumberedPlace], points: Floats) -> list[Trace]:
    """Return the numbers of places at points (n, 2) of the map or of a profile, those that are wrong first.

    A number that would be written over another is left out.
    """
    cells = (
        np.floor((points - points.min(axis=0)) / np.maximum(APART * np.ptp(points, axis=0), 1e-9)) if places else points
    )
    taken, shown = set[tuple[int, int]](), {False: list[int](), True: list[int]()}
    for k in sorted(range(len(places)), key=lambda k: not places[k].wrong):
        column, row = cells[k].astype(int).tolist()
        if not taken & {(column + i, row + j) for i in (-1, 0, 1) for j in (-1, 0, 1)}:
            taken.add((column, row))
            shown[places[k].wrong].append(k)
    made = []
    for wrong, some in shown.items():
        numbers = [f"<b>{places[k].number}</b>" if wrong else str(places[k].number) for k in some]
        font = {"size": 12, "shadow": "auto"} | ({"color": FINDINGS["error"]} if wrong else {})
        marker = {"size": 11, "opacity": 0}  # keeps the number off a mark at its place
        beside = {"textposition": "top right", "textfont": font, "cliponaxis": False, "marker": marker}
        role, where = {"role": "finding" if wrong else "names"}, columns(points[some], "xy", packed)
        made.append(trace("scatter", "markers+text", "Items", where, None, role, text=numbers, **beside))
    return [one for one in made if one["text"]]
