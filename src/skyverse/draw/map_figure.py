"""The map as a matplotlib figure in true proportions: ground, obstacles and zones, and the marks in it."""

import math
from collections.abc import Sequence
from functools import partial
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.ground_relief import along, cleared, relief, tinted
from skyverse.draw.palette import FINDINGS, LIGHT, SURVEY
from skyverse.draw.scenes import Scene, SceneFinding
from skyverse.draw.shape_geometry import DrawnShape, brightness, faces, outline, surface
from skyverse.draw.shape_kinds import MAX_EDGED_SHAPES, ShapeKind
from skyverse.draw.track import DrawnTrack, Point
from skyverse.model.shapes import Box
from skyverse.model.short_lines import counted

if TYPE_CHECKING:
    from matplotlib.figure import Figure


LINE_STYLES: tuple[Any, ...] = ("-", "--", ":", "-.", (0, (8, 2)))
MARKERS = ("o", "s", "D", "^", "P")
GRID, INK, SOFT = LIGHT["grid"], LIGHT["ink"], LIGHT["soft"]
MAX_MAP_WIDTH, MAX_MAP_HEIGHT = 9.4, 7.5
"""The largest width and height of the map in a figure, inches."""


def blank(width: float, height: float) -> "Figure":
    """Return an empty figure that needs no display; `width` and `height` are in inches."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    vars(figure)["_repr_png_"] = partial(png, figure)  # what notebooks show also without pyplot, which would keep it
    return figure


def png(figure: "Figure") -> bytes:
    """Return a figure as the bytes of a PNG file, as large as notebooks show it."""
    file = BytesIO()
    figure.savefig(file, format="png", facecolor="white")
    return file.getvalue()


def map_figure(drawn: Scene, heading: str) -> tuple["Figure", Any]:
    """Return a figure of the map without UAVs, seen obliquely from a longer side, and its 3-D axes."""
    from matplotlib import rc_context

    low, high, stretch = drawn.world.low, drawn.world.high, drawn.world.stretch
    figure = blank(MAX_MAP_WIDTH, MAX_MAP_HEIGHT)
    with rc_context({"grid.color": GRID, "grid.linewidth": 0.6}):  # 3-D axes take their grid from here alone
        axes: Any = figure.add_axes((0.0, 0.0, 1.0, 1.0), projection="3d", computed_zorder=False)
    _dress(axes, low, high, stretch)
    rows = math.ceil((len(drawn.tracks) + 2 + len(legend_entries(drawn)[0])) / _columns(drawn))
    frame = outline(Box(min=tuple(low), max=tuple(high)))[:-1]
    _fit(figure, axes, frame, legend=0.23 * rows)
    draw_world(axes, drawn)
    for _, place in drawn.spare_targets:
        _dot(axes, place, "D", 7, drawn.spare_colour, "white", zorder=6)
    heading += f" (heights drawn {stretch:g} times as large)" if stretch != 1 else ""
    title = f"{plain(drawn.scenario.name)}: {heading}{' (interrupted)' if drawn.interrupted else ''}"
    figure.suptitle(title, fontsize=13, color=INK, y=1 - 0.2 / figure.get_figheight())
    return figure, axes


def line(axes: Any, track: DrawnTrack, points: Floats, *, width: float, alpha: float = 1.0) -> None:
    """Draw a line through `points`, (n, 3), in the colour and dash of `track`."""
    if len(points):
        style = {"color": track.colour, "linestyle": LINE_STYLES[track.lap % len(LINE_STYLES)]}
        axes.plot(*points.T, **style, linewidth=width, alpha=alpha, zorder=5, clip_on=False)


def ends(axes: Any, track: DrawnTrack) -> None:
    """Mark the start and the targets of `track`, which are numbered in a tour."""
    (start, *_), *targets = track.marks
    _dot(axes, start, "o", 6, "white", track.colour, zorder=7, rim=1.6)
    for place, number, _ in targets:
        _dot(axes, place, "o" if number else "D", 13 if number else 7, track.colour, "white", zorder=7)
        if number:
            style = {"color": "white", "fontsize": 7.5, "fontweight": "bold", "ha": "center", "va": "center_baseline"}
            axes.text(*place, number, zorder=8, **style)


def uav(axes: Any, track: DrawnTrack, place: Floats) -> None:
    """Draw the UAV of `track` at `place`."""
    _dot(axes, place, MARKERS[track.lap % len(MARKERS)], 9, track.colour, "white", zorder=9)


def surveys(axes: Any, drawn: Scene) -> None:
    """Draw the outlines of what is to be seen, on the ground, and a dot for each photo."""
    for survey in drawn.surveys:
        for edge in survey.outlines:
            axes.plot(*edge.T, color=SURVEY, linewidth=1.2, zorder=4)
        axes.plot(*survey.photos.position.T, ".", color=SURVEY, markersize=1.8, zorder=6)


def ring(axes: Any, finding: SceneFinding) -> None:
    """Draw a ring around the place of a finding, if it has one."""
    if finding.position is not None:
        _dot(axes, finding.position, "o", 15, "none", FINDINGS[finding.severity], zorder=8, rim=1.8)


def legend(figure: "Figure", drawn: Scene) -> None:
    """Draw the legend of tracks and kinds of shapes below the map."""
    from matplotlib.lines import Line2D

    lines = [
        Line2D([], [], color=track.colour, linestyle=LINE_STYLES[track.lap % len(LINE_STYLES)], linewidth=2.2)
        for track in drawn.tracks
    ]
    for symbol, inside in (("o", "white"), ("D", INK)):
        mark: Any = {"markerfacecolor": inside, "markeredgecolor": INK, "markersize": 6}
        lines.append(Line2D([], [], linestyle="", marker=symbol, **mark))
    names = [*(plain(_told(track)) for track in drawn.tracks), "start", "target"]
    if drawn.surveys:
        lines.append(Line2D([], [], color=SURVEY, linewidth=1.2, marker=".", markersize=4))
        names.append("survey and its photos")
    patches, words = legend_entries(drawn)
    shape: Any = {"ncols": _columns(drawn), "handlelength": 2.6}
    figure.legend(
        [*lines, *patches],
        [*names, *map(plain, words)],
        loc="lower center",
        frameon=False,
        fontsize=9,
        labelcolor=INK,
        **shape,
    )


def logarithmic(axes: Any, name: str, steps: Sequence[float]) -> None:
    """Make the axis ``"x"`` or ``"y"`` logarithmic, with plain numbers at these multiples of powers of ten."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis = getattr(axes, f"{name}axis")
    getattr(axes, f"set_{name}scale")("log")
    axis.set_major_locator(LogLocator(subs=steps))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,g}"))
    axis.set_minor_formatter(NullFormatter())


def plain(text: str) -> str:
    """Return `text` escaped: matplotlib reads dollars as mathematics and hides labels with a leading underscore."""
    return text.replace("$", r"\$") if not text.startswith("_") else "\u200b" + text.replace("$", r"\$")


def _dress(axes: Any, low: Floats, high: Floats, stretch: float) -> None:
    from matplotlib.ticker import MaxNLocator

    size = (high - low) * (1, 1, stretch)
    lengthwise = size[1] >= size[0]
    axes.set_proj_type("persp", focal_length=1.6)
    axes.view_init(elev=27, azim=-24 if lengthwise else -66)
    axes.set_box_aspect(size / size.max())
    pads = (2, 8, 0) if lengthwise else (8, 2, 0)
    for k, (axis, letter) in enumerate(zip((axes.xaxis, axes.yaxis, axes.zaxis), "xyz", strict=True)):
        getattr(axes, f"set_{letter}lim")(low[k], high[k], view_margin=0)
        axis.set_major_locator(MaxNLocator(max(2, round(9 * size[k] / size.max())), steps=[1, 2, 5, 10]))
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.line.set_color(SOFT)
        axis.set_tick_params(labelsize=9, labelcolor=SOFT, pad=0)
        axis.set_label_text(f"{letter} (m)", color=INK)
        axis.labelpad = pads[k]


def _fit(figure: "Figure", axes: Any, corners: Floats, *, legend: float) -> None:
    """Fit the figure's size to the map in it; `legend` is the height of the legend in inches."""
    from mpl_toolkits.mplot3d.proj3d import proj_transform  # type: ignore[import-untyped]

    x, y, _ = proj_transform(*corners.T, axes.get_proj())
    seen = axes.transAxes.inverted().transform(axes.transData.transform(np.column_stack([x, y])))
    low, (wide, tall) = seen.min(axis=0), np.ptp(seen, axis=0)
    side = min(MAX_MAP_WIDTH / wide, MAX_MAP_HEIGHT / tall)
    left, right, above, below = 0.75, 0.85, 0.55, 0.6 + legend
    width, height = side * wide + left + right, side * tall + above + below
    figure.set_size_inches(width, height)
    corner = (left - side * low[0]) / width, (below - side * low[1]) / height
    axes.set_position((*corner, side / width, side / height))


def _dot(
    axes: Any, place: Point | Floats, symbol: str, size: int, inside: str, edge: str, *, zorder: int, rim: float = 1.0
) -> None:
    style = {"markersize": size, "markerfacecolor": inside, "markeredgecolor": edge, "markeredgewidth": rim}
    axes.plot(*([k] for k in place), symbol, zorder=zorder, clip_on=False, **style)


def _columns(drawn: Scene) -> int:
    words = [*map(_told, drawn.tracks), *legend_entries(drawn)[1]]
    widest = max(map(len, words), default=0)
    return max(1, min(len(words) + 2, int(150 / (widest + 9))))


def _told(track: DrawnTrack) -> str:
    if len(track.visits) > 1:
        return f"{track.name} → {counted(len(track.visits), 'target')}"
    return track.name if track.target_name is None else f"{track.name} → {track.target_name}"


MAX_FIGURE_HEIGHTS = 120
"""The largest number of heights along each side of the ground."""
MAX_FIGURE_SHAPES = 3_000
"""The largest number of shapes in a figure; of more, the largest ones are drawn."""


def draw_world(axes: Any, drawn: Scene) -> None:
    """Draw the world of `drawn` into 3-D axes; solid shapes are one collection, so that nearer ones hide others."""
    polygons: list[Floats] = []
    colours: list[Floats] = []
    _ground(drawn, polygons, colours)
    left = MAX_FIGURE_SHAPES
    for kind in drawn.world.kinds:
        shapes = _largest(kind, left)
        left -= len(shapes)
        if kind.solid:
            for shape in shapes:
                walls = faces(shape, kind.sides)
                polygons += walls
                colours += _lit(walls, colour(kind))
        else:
            _clear(axes, kind, shapes)
    if polygons:
        # edges of the same colour cover the seams that antialiasing would leave
        paint = np.array(colours)
        _add(axes, polygons, facecolors=paint, edgecolors=paint, linewidths=0.3, zorder=0.2, rasterized=True)


def legend_entries(drawn: Scene) -> tuple[list[Any], list[str]]:
    """Return the patches and labels of a legend, one for each kind, where the world is more than plain boxes."""
    from matplotlib.patches import Patch

    kinds = drawn.world.kinds if drawn.world.mapped else ()
    patches = [Patch(facecolor=colour(kind), alpha=1.0 if kind.solid else 0.35) for kind in kinds]
    return patches, [f"{kind.title}, at a risk" if kind.at_risk else kind.title for kind in kinds]


def colour(kind: ShapeKind) -> str:
    """Return the colour in which a kind is drawn."""
    return kind.colour or LIGHT["box" if kind.hard else "zone"]


def _ground(drawn: Scene, polygons: list[Floats], colours: list[Floats]) -> None:
    terrain = drawn.scenario.terrain
    if terrain is None:
        return
    ground = relief(terrain, drawn.world.low, drawn.world.high, MAX_FIGURE_HEIGHTS)
    lines = [line for track in drawn.tracks for line in (track.path, track.positions)]
    ground = cleared(ground, terrain, along(lines, float(ground.x[1] - ground.x[0]) / 2))
    points = np.stack([*np.meshgrid(ground.x, ground.y, indexing="ij"), ground.z], axis=-1)
    quads = np.stack([points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]], axis=2)
    polygons += list(quads.reshape(-1, 4, 3))
    tints = tinted(ground, drawn.world.stretch)
    colours += list(((tints[:-1, :-1] + tints[1:, 1:]) / 2).reshape(-1, 3))


def _largest(kind: ShapeKind, most: int) -> list[DrawnShape]:
    if len(kind.shapes) <= most:
        return list(kind.shapes)
    sizes = np.linalg.norm(kind.extents[:, 1] - kind.extents[:, 0], axis=1)
    return [kind.shapes[k] for k in np.sort(np.argsort(-sizes)[:most])]


def _clear(axes: Any, kind: ShapeKind, shapes: list[DrawnShape]) -> None:
    """Draw transparent shapes: obstacles with their edges, zones without."""
    if kind.hard:
        walls = [face for shape in shapes for face in faces(shape, kind.sides)]
        edge = LIGHT["edge"] if kind.colour is None else kind.colour
        crowded = len(shapes) > MAX_EDGED_SHAPES
        lines = {"edgecolors": edge, "linewidths": 0.15 if crowded else 0.5}
        _add(axes, walls, facecolors=colour(kind), alpha=0.16, zorder=1, rasterized=crowded, **lines)
    else:
        cut = (surface(shape, kind.sides) for shape in shapes)
        walls = [points[triangle] for points, triangles in cut for triangle in triangles]
        _add(axes, walls, facecolors=colour(kind), edgecolors="none", alpha=0.14, zorder=0.5)


def _lit(walls: list[Floats], paint: str) -> list[Floats]:
    from matplotlib.colors import to_rgb

    normals = [np.cross(wall, np.append(wall[1:], wall[:1], axis=0)).sum(axis=0) for wall in walls]
    return [np.array(to_rgb(paint)) * light for light in brightness(np.array(normals).reshape(-1, 3))]


def _add(axes: Any, polygons: list[Floats], *, rasterized: bool = False, **style: Any) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

    if polygons:
        collection = Poly3DCollection(polygons, **style)
        collection.set_rasterized(rasterized)
        collection.set_clip_on(False)
        axes.add_collection3d(collection)
