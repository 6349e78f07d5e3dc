"""Films and figures of replanned flights: from above, from the side, and every replan on a time line."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skyverse.draw.map_figure import INK, SOFT, blank, plain
from skyverse.draw.moving_view import (
    COMMITTED,
    FLOWN,
    PLANNED,
    UNSEEN,
    WAY_OUT,
    MovingView,
    OrthographicView,
    doubt_style,
    mover_style,
    range_style,
)
from skyverse.draw.palette import FINDINGS, LIGHT
from skyverse.draw.replanned_scene import ReplannedScene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH = 9.6
"""Inches."""
EDGE, TITLE, GAP, AXIS, LEGEND = 0.55, 0.75, 0.12, 0.55, 1.3
"""Inches at the sides, above the views, between them, below them, and below the time line."""
MAX_PLAN_HEIGHT, MIN_SIDE_HEIGHT = 6.2, 0.7
"""Inches of the views from above at most, and from the side at least, even if heights are then drawn larger."""
LONGER = 1.2
"""A world that is so much longer along y than along x lies on its side, with x pointing down."""
TICKS = {"kept": LIGHT["box"], "replaced": LIGHT["accent"], "no way out": FINDINGS["error"]}
"""The colours of answers on the time line."""


def still(drawn: ReplannedScene, t: float) -> "Figure":
    """Return the figure of a replanned flight at `t` seconds."""
    picture = _Picture(drawn, "")
    picture.show(t)
    return picture.figure


def replanned_frames(
    drawn: ReplannedScene, times: Sequence[float], speed: int, dots: int
) -> Iterator[NDArray[np.uint8]]:
    """Yield the frames of a film, (height, width, 3) with even height and width.

    Parameters
    ----------
    drawn
        What is shown.
    times
        Seconds into the mission.
    speed
        How many times as fast as the flight the film is.
    dots
        Pixels to an inch.
    """
    picture = _Picture(drawn, "" if speed == 1 else f", {speed} times as fast")
    figure = picture.figure
    figure.set_dpi(dots)
    figure.set_size_inches(*(2 * np.ceil(size * dots / 2) / dots for size in figure.get_size_inches()))
    canvas: Any = figure.canvas
    for artist in picture.moving:
        artist.set_animated(True)
    canvas.draw()
    background = canvas.copy_from_bbox(figure.bbox)
    for t in times:
        canvas.restore_region(background)
        picture.show(t)
        for artist in picture.moving:
            (artist.axes or figure).draw_artist(artist)
        yield np.ascontiguousarray(np.asarray(canvas.buffer_rgba())[..., :3])


class _Picture:
    """A figure of a replanned flight, and the artists in it that move."""

    def __init__(self, drawn: ReplannedScene, fast: str) -> None:
        self._drawn, self._end = drawn, drawn.scene.makespan or 1.0
        low, high = drawn.scene.world.low, drawn.scene.world.high
        size = high - low
        along = 1 if size[1] > LONGER * size[0] else 0
        right, up = ((1, 0, 0), (0, 1, 0)) if along == 0 else ((0, 1, 0), (-1, 0, 0))
        scale = min((WIDTH - 2 * EDGE) / size[along], MAX_PLAN_HEIGHT / size[1 - along])
        wide, tall, side = scale * size[along], scale * size[1 - along], max(scale * size[2], MIN_SIDE_HEIGHT)
        line = 0.32 + 0.2 * len(drawn.scene.tracks)
        total, left = TITLE + tall + GAP + side + AXIS + line + LEGEND, (WIDTH - wide) / 2
        self.figure = blank(WIDTH, total)

        def axes(bottom: float, height: float) -> Any:
            return self.figure.add_axes((left / WIDTH, bottom / total, wide / WIDTH, height / total))

        self._line = axes(LEGEND, line)
        below, above = axes(LEGEND + line + AXIS, side), axes(LEGEND + line + AXIS + side + GAP, tall)
        plan = OrthographicView(above, right, up, low, high)
        from_side = OrthographicView(below, right, (0, 0, 1), low, high)
        plan.label(1 - along, upright=True)
        from_side.label(2, upright=True)
        from_side.label(along, upright=False)
        above.tick_params(labelbottom=False)
        self._views = MovingView(plan, drawn, 0.85), MovingView(from_side, drawn, 0.4)
        place: dict[str, Any] = {"x": left / WIDTH, "color": INK, "va": "top"}
        title = f"{plain(drawn.scene.scenario.name)}, replanned in flight{fast}"
        self.figure.text(**place, y=1 - 0.24 / total, s=title, fontsize=14)
        clock = place | {"x": 1 - left / WIDTH, "ha": "right", "family": "monospace"}
        self._clock = self.figure.text(**clock, y=1 - 0.24 / total, s="", fontsize=13)
        self._told = self.figure.text(**place | {"color": SOFT}, y=1 - 0.52 / total, s="", fontsize=9.5)
        self._draw_time_line()
        self._draw_legend()
        self.moving = [*(one for view in self._views for one in view.artists), self._ticks, self._cursor]
        self.moving += [self._clock, self._told]

    def _draw_time_line(self) -> None:
        from matplotlib.collections import LineCollection

        axes, tracks = self._line, self._drawn.scene.tracks
        axes.set_xlim(0, self._end)
        axes.set_ylim(len(tracks), 0)
        for side in ("top", "right", "left"):
            axes.spines[side].set_visible(False)
        axes.spines["bottom"].set_color(SOFT)
        axes.set_yticks(np.arange(len(tracks)) + 0.5, [plain(track.name) for track in tracks])
        axes.tick_params(labelsize=8.5, labelcolor=SOFT, color=SOFT, left=False)
        axes.set_xlabel("seconds into the mission; each mark is an answer to an observation", color=SOFT, fontsize=9)
        self._ticks = LineCollection([], linewidths=2.0, zorder=3)
        axes.add_collection(self._ticks)
        (self._cursor,) = axes.plot([0, 0], [0, len(tracks)], color=INK, linewidth=1.2, zorder=5, clip_on=False)

    def _draw_legend(self) -> None:
        from matplotlib.lines import Line2D
        from matplotlib.patches import Patch

        drawn, sensor = self._drawn, self._drawn.flight.sensor
        entries: list[tuple[Any, str]] = [
            (Line2D([], [], color=drawn.scene.tracks[0].colour, **FLOWN), "flown"),
            (Line2D([], [], **COMMITTED), "committed way"),
            (Line2D([], [], **WAY_OUT), "its way out: braking to rest"),
            (Line2D([], [], **PLANNED), "as planned"),
        ]
        if drawn.scene.scenario.movers:
            entries.append((Patch(**mover_style()), "mover"))
            entries.append((Patch(**doubt_style()), "where it may be, up to the horizon"))
        if sensor.range:
            entries.append((Patch(**range_style()), f"sensor range, {sensor.range:g} m"))
        if drawn.unknown:
            entries.append((Patch(**UNSEEN), "obstacle not seen yet"))
        mark: dict[str, Any] = {"linestyle": "", "marker": "|", "ms": 9, "mew": 2.5}
        entries += [(Line2D([], [], color=tone, **mark), tick) for tick, tone in TICKS.items()]
        style: dict[str, Any] = {"frameon": False, "fontsize": 8.5, "labelcolor": INK, "columnspacing": 1.6}
        self.figure.legend(*zip(*entries, strict=True), loc="lower center", ncols=4, handlelength=2.2, **style)

    def show(self, t: float) -> None:
        """Move all that moves to where it is at an instant."""
        for view in self._views:
            view.show(t)
        rows = enumerate(self._drawn.ticks)
        given = [(when, row, tick) for row, ticks in rows for when, tick in ticks if when <= t + 1e-9]
        self._ticks.set_segments([[(when, row + 0.15), (when, row + 0.85)] for when, row, _ in given])
        self._ticks.set_color([TICKS[tick] for *_, tick in given])
        self._cursor.set_xdata([t, t])
        self._clock.set_text(f"{t:5.2f} s / {self._end:.2f} s")
        self._told.set_text(plain(self._sentence(t)))

    def _sentence(self, t: float) -> str:
        """Return what was last answered: to the first UAV that has no way out, else to the first one."""
        k = int(np.searchsorted(self._drawn.arrivals, t + 1e-9)) - 1
        if k < 0:
            return ""
        answers = self._drawn.flight.steps[k].answers
        return next((answer for answer in answers if not answer.proven), answers[0]).sentence
