"""The empty map as a matplotlib figure in true proportions, and the marks that are drawn into it."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.scene import Finding, Scene
from skyverse.draw.scenery import build, handles
from skyverse.draw.solids import outline
from skyverse.draw.track import Point, Track
from skyverse.model.shapes import Box

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DASHES: tuple[Any, ...] = ("-", "--", ":", "-.", (0, (8, 2)))
SYMBOLS = ("o", "s", "D", "^", "P")
GRID, INK, SOFT = "#e3e8ee", "#17202b", "#5b6776"
FOUND = {"warning": "#d97706", "error": "#dc2626"}
WIDEST, TALLEST = 9.4, 7.5
"""Inches that the map may take in a figure."""


def blank(width: float, height: float) -> "Figure":
    """Return an empty figure that needs no display; sizes in inches."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    return figure


def stage(drawn: Scene, heading: str) -> tuple["Figure", Any]:
    """Return a figure of the map without its UAVs, seen obliquely from its longer side, and its 3-D axes."""
    low, high, stretch = drawn.world.low, drawn.world.high, drawn.world.stretch
    figure = blank(WIDEST, TALLEST)
    axes: Any = figure.add_axes((0.0, 0.0, 1.0, 1.0), projection="3d", computed_zorder=False)
    _dress(axes, low, high, stretch)
    rows = math.ceil((len(drawn.tracks) + 2 + len(handles(drawn)[0])) / _columns(drawn))
    frame = outline(Box(min=tuple(low), max=tuple(high)))[:-1]
    _fit(figure, axes, frame, legend=0.23 * rows)
    build(axes, drawn)
    for _, place in drawn.spare_targets:
        _dot(axes, place, "D", 7, "#9aa5b4", "white", zorder=6)
    heading += f" (heights drawn {stretch:g} times as large)" if stretch != 1 else ""
    title = f"{plain(drawn.scenario.name)}: {heading}{' (interrupted)' if drawn.interrupted else ''}"
    figure.suptitle(title, fontsize=13, color=INK, y=1 - 0.2 / figure.get_figheight())
    return figure, axes


def line(axes: Any, track: Track, points: Floats, *, width: float, alpha: float = 1.0) -> None:
    """Draw `points` (n, 3) in the colour and dash of `track`."""
    if len(points):
        style = {"color": track.colour, "linestyle": DASHES[track.lap % len(DASHES)]}
        axes.plot(*points.T, **style, linewidth=width, alpha=alpha, zorder=5, clip_on=False)


def ends(axes: Any, track: Track) -> None:
    """Mark start and target of `track`."""
    _dot(axes, track.start, "o", 6, "white", track.colour, zorder=7, rim=1.6)
    if track.target is not None:
        _dot(axes, track.target, "D", 7, track.colour, "white", zorder=7)


def uav(axes: Any, track: Track, place: Floats) -> None:
    """Draw the UAV of `track` at `place`."""
    _dot(axes, place, SYMBOLS[track.lap % len(SYMBOLS)], 9, track.colour, "white", zorder=9)


def ring(axes: Any, finding: Finding) -> None:
    """Ring the place of what the referee found wrong, where it has one."""
    if finding.position is not None:
        _dot(axes, finding.position, "o", 15, "none", FOUND[finding.severity], zorder=8, rim=1.8)


def legend(figure: "Figure", drawn: Scene) -> None:
    """Say below the map which colour is whose."""
    from matplotlib.lines import Line2D

    lines = [
        Line2D([], [], color=track.colour, linestyle=DASHES[track.lap % len(DASHES)], linewidth=2.2)
        for track in drawn.tracks
    ]
    for symbol, inside in (("o", "white"), ("D", INK)):
        mark: Any = {"markerfacecolor": inside, "markeredgecolor": INK, "markersize": 6}
        lines.append(Line2D([], [], linestyle="", marker=symbol, **mark))
    names = [*(plain(_told(track)) for track in drawn.tracks), "start", "target"]
    patches, words = handles(drawn)
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


def plain(text: str) -> str:
    """Return `text` so that matplotlib takes no dollar for mathematics and hides no leading underscore."""
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
        axis._axinfo["grid"].update(color=GRID, linewidth=0.6)
        axis.set_tick_params(labelsize=9, labelcolor=SOFT, pad=0)
        axis.set_label_text(f"{letter} (m)", color=INK)
        axis.labelpad = pads[k]


def _fit(figure: "Figure", axes: Any, corners: Floats, *, legend: float) -> None:
    """Size the figure to what the map takes in it; `legend` is the legend's height in inches."""
    from mpl_toolkits.mplot3d.proj3d import proj_transform  # type: ignore[import-untyped]

    x, y, _ = proj_transform(*corners.T, axes.get_proj())
    seen = axes.transAxes.inverted().transform(axes.transData.transform(np.column_stack([x, y])))
    low, (wide, tall) = seen.min(axis=0), np.ptp(seen, axis=0)
    side = min(WIDEST / wide, TALLEST / tall)
    left, right, above, below = 0.75, 0.85, 0.55, 0.6 + legend
    width, height = side * wide + left + right, side * tall + above + below
    figure.set_size_inches(width, height)
    corner = (left - side * low[0]) / width, (below - side * low[1]) / height
    axes.set_position((*corner, side / width, side / height))


def _dot(
    axes: Any,
    place: Point | Floats,
    symbol: str,
    size: int,
    inside: str,
    edge: str,
    *,
    zorder: int,
    rim: float = 1.0,
) -> None:
    style = {"markersize": size, "markerfacecolor": inside, "markeredgecolor": edge, "markeredgewidth": rim}
    axes.plot(*([k] for k in place), symbol, zorder=zorder, clip_on=False, **style)


def _columns(drawn: Scene) -> int:
    words = [*map(_told, drawn.tracks), *handles(drawn)[1]]
    widest = max(map(len, words), default=0)
    return max(1, min(len(words) + 2, int(150 / (widest + 9))))


def _told(track: Track) -> str:
    return track.name if track.target_name is None else f"{track.name} → {track.target_name}"
