"""Films and figures of replanned flights: from above, from the side, and every replan on a time line.

The world and what was planned stand still, and all else moves.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.draw.map_figure import INK, SOFT, blank, colour, plain
from skyverse.draw.palette import FINDINGS, LIGHT
from skyverse.draw.replanned_scene import ReplannedScene
from skyverse.draw.shape_geometry import DrawnShape, grown, is_fence, surface
from skyverse.model.shapes import Voxels

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


AHEAD = (1.0, 0.66, 0.33)
"""Shares of the horizon at which predicted movers are drawn, the farthest first."""
FLOWN: dict[str, Any] = {"linewidth": 2.6}
COMMITTED: dict[str, Any] = {"color": INK, "linewidth": 2.2}
WAY_OUT: dict[str, Any] = {**COMMITTED, "linestyle": (0, (1.6, 1.2))}
PLANNED: dict[str, Any] = {"color": SOFT, "linewidth": 0.9, "linestyle": (0, (1, 2))}
UNSEEN: dict[str, Any] = {"facecolor": "none", "edgecolor": LIGHT["edge"], "linestyle": ":"}
SEEN: dict[str, Any] = {"facecolor": LIGHT["zone"], "edgecolor": LIGHT["zone"], "linestyle": "-", "alpha": 0.75}
"""How things are drawn, in the views and in the legend."""
_CIRCLE = np.column_stack([np.cos(np.linspace(0, 2 * np.pi, 65)), np.sin(np.linspace(0, 2 * np.pi, 65))])


def mover_style(strength: float = 0.85) -> dict[str, Any]:
    """Return how movers are drawn."""
    return {"facecolor": clear(LIGHT["mover"], strength), "edgecolor": "white", "linewidth": 0.8}


def doubt_style() -> dict[str, Any]:
    """Return how it is drawn where movers may be."""
    return {"facecolor": clear(LIGHT["mover"], 0.07), "edgecolor": clear(LIGHT["mover"], 0.28), "linewidth": 0.6}


def range_style() -> dict[str, Any]:
    """Return how the range of sensors is drawn."""
    return {"facecolor": clear(LIGHT["accent"], 0.05), "edgecolor": clear(LIGHT["accent"], 0.6), "linewidth": 0.9}


def still(drawn: ReplannedScene, t: float) -> "Figure":
    """Return the figure of a replanned flight at `t` seconds."""
    picture = _Picture(drawn, "")
    picture.show(t)
    return picture.figure


def replanned_frames(
    drawn: ReplannedScene, times: Sequence[float], speed: int, dots: int
) -> Iterator[NDArray[np.uint8]]:
    """Return the frames of the film of a replanned flight, which is `speed` times as fast; see `film_frames`."""
    picture = _Picture(drawn, "" if speed == 1 else f", {speed} times as fast")
    return film_frames(picture.figure, picture.moving, picture.show, times, dots)


def film_frames(
    figure: "Figure", moving: Sequence[Any], show: Callable[[float], None], times: Sequence[float], dots: int
) -> Iterator[NDArray[np.uint8]]:
    """Yield frames, (height, width, 3) with even height and width, in which artists move over a still picture.

    Parameters
    ----------
    figure, moving
        The picture, and the artists in it that `show` moves to where they are at an instant.
    times
        Seconds into the mission.
    dots
        Pixels to an inch.
    """
    figure.set_dpi(dots)
    figure.set_size_inches(*(2 * np.ceil(size * dots / 2) / dots for size in figure.get_size_inches()))
    canvas: Any = figure.canvas
    for artist in moving:
        artist.set_animated(True)
    canvas.draw()
    background = canvas.copy_from_bbox(figure.bbox)
    for t in times:
        canvas.restore_region(background)
        show(t)
        for artist in moving:
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
        plan, from_side = MovingView(above, right, up, drawn, 0.85), MovingView(below, right, (0, 0, 1), drawn, 0.4)
        plan.label(1 - along, upright=True)
        from_side.label(2, upright=True)
        from_side.label(along, upright=False)
        above.tick_params(labelbottom=False)
        self._views = plan, from_side
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


class MovingView:
    """A view of a replanned flight along an axis.

    Parameters
    ----------
    axes
        Those of matplotlib that it is drawn in.
    right, up
        (3,) unit vectors: what points to the right, and up, in the picture.
    drawn
        What is drawn.
    strength
        How opaque movers are, from 0 to 1: from the side they may hide the flight.

    Attributes
    ----------
    artists
        Those of matplotlib that move, from the back to the front.
    """

    def __init__(
        self, axes: Any, right: Sequence[float], up: Sequence[float], drawn: ReplannedScene, strength: float
    ) -> None:
        self.axes, self._drawn = axes, drawn
        self._onto = np.array([right, up], dtype=np.float64)
        self.artists: list[Any] = []
        tracks, movers = drawn.scene.tracks, drawn.scene.scenario.movers
        self._dress()
        self._stand_still()
        self._walls = [[self._polygon(zorder=2) for _ in self._outlines(wall)] for wall in drawn.unknown]
        ranged = tracks if drawn.flight.sensor.range else ()
        self._ranges = [self._polygon(**range_style(), zorder=2) for _ in ranged]
        self._doubt = [[self._polygon(**doubt_style(), zorder=3) for _ in movers] for _ in AHEAD]
        self._bodies = [self._polygon(**mover_style(strength), zorder=5) for _ in movers]
        self._trails = [self._line(color=track.colour, **FLOWN, zorder=6) for track in tracks]
        self._ways = [self._line(**COMMITTED, zorder=7) for _ in tracks]
        self._outs = [self._line(**WAY_OUT, zorder=7) for _ in tracks]
        mark: dict[str, Any] = {"marker": "o", "ms": 10, "mec": "white", "mew": 1.2, "zorder": 9}
        self._marks = [self._line(color=track.colour, **mark) for track in tracks]

    def _seen(self, points: Floats) -> Floats:
        """Return points (n, 3) as they are seen, (n, 2)."""
        return np.asarray(points) @ self._onto.T

    def _outline(self, points: Floats) -> Floats:
        """Return the outline of a convex body that has its corners among points (n, 3), (m, 2)."""
        from scipy.spatial import ConvexHull

        seen = self._seen(points)
        return np.asarray(seen[ConvexHull(seen).vertices])

    def _outlines(self, shape: DrawnShape) -> list[Floats]:
        """Return the outline of a shape, as if it were convex; voxels, which have none, and fences are left out."""
        return [] if isinstance(shape, Voxels) or is_fence(shape) else [self._outline(surface(shape)[0])]

    def label(self, axis: int, upright: bool) -> None:
        """Label the upright or the level axis of the picture, along which x, y or z is shown, upwards or downwards."""
        letter, soft = f"{'xyz'[axis]} (m)", LIGHT["soft"]
        if upright:
            self.axes.set_ylabel(letter, color=soft, fontsize=9, labelpad=2)
        else:
            self.axes.set_xlabel(letter, color=soft, fontsize=9, labelpad=1)
        if upright and self._onto[1, axis] < 0:
            self.axes.yaxis.set_major_formatter(lambda value, _: f"{-value + 0.0:g}")

    def _dress(self) -> None:
        axes, world = self.axes, self._drawn.scene.world
        corners = self._seen(np.array([world.low, world.high], dtype=np.float64))
        (left, bottom), (far, top) = corners.min(axis=0), corners.max(axis=0)
        axes.set_xlim(left, far)
        axes.set_ylim(bottom, top)
        axes.set_facecolor(LIGHT["card"])
        for side in axes.spines.values():
            side.set_color(LIGHT["line"])
        axes.grid(color=LIGHT["grid"], linewidth=0.6)
        axes.set_axisbelow(True)
        axes.tick_params(labelsize=8.5, labelcolor=LIGHT["soft"], color=LIGHT["line"])

    def _stand_still(self) -> None:
        """Draw the known world, and what was planned."""
        from matplotlib.collections import PolyCollection

        axes = self.axes
        for kind in self._drawn.scene.world.kinds:
            bodies = [body for shape in kind.shapes for body in self._outlines(shape)]
            tone, strength = colour(kind), 0.55 if kind.hard else 0.2
            style: dict[str, Any] = {"linewidths": 0.8, "linestyles": "-" if kind.hard else "--", "zorder": 1}
            axes.add_collection(PolyCollection(bodies, facecolors=clear(tone, strength), edgecolors=tone, **style))
        for track, (_, planned) in zip(self._drawn.scene.tracks, self._drawn.planned, strict=True):
            axes.plot(*self._seen(planned).T, **PLANNED, zorder=2)
            begin = self._seen(np.array([track.start]))[0]
            axes.plot(*begin, "o", color="white", mec=track.colour, ms=6, zorder=4)
            if track.target is not None:
                axes.plot(
                    *self._seen(np.array([track.target]))[0], "D", color=track.colour, mec="white", ms=7, zorder=4
                )

    def _polygon(self, **style: Any) -> Any:
        from matplotlib.patches import Polygon

        artist = self.axes.add_patch(Polygon(np.zeros((3, 2)), closed=True, **style))
        self.artists.append(artist)
        return artist

    def _line(self, **style: Any) -> Any:
        (artist,) = self.axes.plot([], [], **style)
        self.artists.append(artist)
        return artist

    def show(self, t: float) -> None:
        """Move all that moves to where it is at `t` seconds."""
        self._show_movers(t)
        drawn = self._drawn
        for wall, artists, when in zip(drawn.unknown, self._walls, drawn.seen, strict=True):
            for body, artist in zip(self._outlines(wall), artists, strict=True):
                artist.set_xy(body)
                artist.set(**(SEEN if when is not None and when <= t else UNSEEN))
        for uav, track in enumerate(drawn.scene.tracks):
            place, way = self._seen(track.at(t)[None]), drawn.way(uav, t)
            if self._ranges:
                self._ranges[uav].set_xy(place + (drawn.flight.sensor.range or 0.0) * _CIRCLE)
            ahead, out = (np.empty((0, 3)), np.empty((0, 3))) if way is None else way.ahead(t)
            lines = (self._trails, track.flown(t)), (self._ways, ahead), (self._outs, out)
            for artists, points in lines:
                artists[uav].set_data(*self._seen(points).T)
            self._marks[uav].set_data(*place.T)

    def _show_movers(self, t: float) -> None:
        """Move the movers to where they truly are, and their doubt to where they are held to be."""
        drawn = self._drawn
        movers = drawn.scene.scenario.movers
        for mover, artist in zip(movers, self._bodies, strict=True):
            artist.set_xy(self._outline(surface(grown(mover, 0.0))[0] + mover.at([t])[0]))
        for share, artists in zip(AHEAD, self._doubt, strict=True):
            held = {
                mover.name: (place, doubt) for mover, place, doubt in drawn.predicted(t, share * drawn.flight.horizon)
            }
            for mover, artist in zip(movers, artists, strict=True):
                artist.set_visible(mover.name in held)
                if mover.name in held:
                    place, doubt = held[mover.name]
                    artist.set_xy(self._outline(surface(grown(mover, doubt))[0] + place))


def clear(tone: str, strength: float) -> tuple[float, float, float, float]:
    """Return a colour that lets through what is behind it."""
    from matplotlib.colors import to_rgba

    return to_rgba(tone, strength)
