"""Orthographic views of a replanned flight: the world and what was planned stand still, all else moves."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.map_figure import INK, SOFT, colour
from skyverse.draw.mover_shapes import surface_of
from skyverse.draw.palette import LIGHT
from skyverse.draw.replanned_scene import ReplannedScene
from skyverse.draw.shape_geometry import DrawnShape, surface
from skyverse.model.shapes import Voxels

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


class OrthographicView:
    """A view along an axis.

    Parameters
    ----------
    axes
        Those of matplotlib that it is drawn in.
    right, up
        (3,) unit vectors: what points to the right, and up, in the picture.
    low, high
        (3,) metres: the corners of what is shown.
    """

    def __init__(self, axes: Any, right: Sequence[float], up: Sequence[float], low: Floats, high: Floats) -> None:
        self.axes = axes
        self._onto = np.array([right, up], dtype=np.float64)
        corners = self.seen(np.array([low, high], dtype=np.float64))
        (left, bottom), (far, top) = corners.min(axis=0), corners.max(axis=0)
        axes.set_xlim(left, far)
        axes.set_ylim(bottom, top)
        self._dress()

    def seen(self, points: Floats) -> Floats:
        """Return points (n, 3) as they are seen, (n, 2)."""
        return np.asarray(points) @ self._onto.T

    def outline(self, points: Floats) -> Floats:
        """Return the outline of a convex body that has its corners among points (n, 3), (m, 2)."""
        from scipy.spatial import ConvexHull

        seen = self.seen(points)
        return np.asarray(seen[ConvexHull(seen).vertices])

    def outlines(self, shape: DrawnShape) -> list[Floats]:
        """Return the outline of a shape, as if it were convex; voxels, which have no single one, are left out."""
        return [] if isinstance(shape, Voxels) else [self.outline(surface(shape)[0])]

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
        axes = self.axes
        axes.set_facecolor(LIGHT["card"])
        for side in axes.spines.values():
            side.set_color(LIGHT["line"])
        axes.grid(color=LIGHT["grid"], linewidth=0.6)
        axes.set_axisbelow(True)
        axes.tick_params(labelsize=8.5, labelcolor=LIGHT["soft"], color=LIGHT["line"])


class MovingView:
    """One view of a replanned flight.

    Parameters
    ----------
    view
        Where it is drawn.
    drawn
        What is drawn.
    strength
        How opaque movers are, from 0 to 1: from the side they may hide the flight.

    Attributes
    ----------
    artists
        Those of matplotlib that move, from the back to the front.
    """

    def __init__(self, view: OrthographicView, drawn: ReplannedScene, strength: float) -> None:
        self._view, self._drawn = view, drawn
        self.artists: list[Any] = []
        tracks, movers = drawn.scene.tracks, drawn.scene.scenario.movers
        self._stand_still()
        self._walls = [[self._polygon(zorder=2) for _ in view.outlines(wall)] for wall in drawn.unknown]
        ranged = tracks if drawn.flight.sensor.range else ()
        self._ranges = [self._polygon(**range_style(), zorder=2) for _ in ranged]
        self._doubt = [[self._polygon(**doubt_style(), zorder=3) for _ in movers] for _ in AHEAD]
        self._bodies = [self._polygon(**mover_style(strength), zorder=5) for _ in movers]
        self._trails = [self._line(color=track.colour, **FLOWN, zorder=6) for track in tracks]
        self._ways = [self._line(**COMMITTED, zorder=7) for _ in tracks]
        self._outs = [self._line(**WAY_OUT, zorder=7) for _ in tracks]
        mark: dict[str, Any] = {"marker": "o", "ms": 10, "mec": "white", "mew": 1.2, "zorder": 9}
        self._marks = [self._line(color=track.colour, **mark) for track in tracks]

    def _stand_still(self) -> None:
        """Draw the known world, and what was planned."""
        from matplotlib.collections import PolyCollection

        view, axes = self._view, self._view.axes
        for kind in self._drawn.scene.world.kinds:
            bodies = [body for shape in kind.shapes for body in view.outlines(shape)]
            tone, strength = colour(kind), 0.55 if kind.hard else 0.2
            style: dict[str, Any] = {"linewidths": 0.8, "linestyles": "-" if kind.hard else "--", "zorder": 1}
            axes.add_collection(PolyCollection(bodies, facecolors=clear(tone, strength), edgecolors=tone, **style))
        for track, (_, planned) in zip(self._drawn.scene.tracks, self._drawn.planned, strict=True):
            axes.plot(*view.seen(planned).T, **PLANNED, zorder=2)
            begin = view.seen(np.array([track.start]))[0]
            axes.plot(*begin, "o", color="white", mec=track.colour, ms=6, zorder=4)
            if track.target is not None:
                axes.plot(*view.seen(np.array([track.target]))[0], "D", color=track.colour, mec="white", ms=7, zorder=4)

    def _polygon(self, **style: Any) -> Any:
        from matplotlib.patches import Polygon

        artist = self._view.axes.add_patch(Polygon(np.zeros((3, 2)), closed=True, **style))
        self.artists.append(artist)
        return artist

    def _line(self, **style: Any) -> Any:
        (artist,) = self._view.axes.plot([], [], **style)
        self.artists.append(artist)
        return artist

    def show(self, t: float) -> None:
        """Move all that moves to where it is at `t` seconds."""
        self._show_movers(t)
        drawn, view = self._drawn, self._view
        for wall, artists, when in zip(drawn.unknown, self._walls, drawn.seen, strict=True):
            for body, artist in zip(view.outlines(wall), artists, strict=True):
                artist.set_xy(body)
                artist.set(**(SEEN if when is not None and when <= t else UNSEEN))
        for uav, track in enumerate(drawn.scene.tracks):
            place, way = view.seen(track.at(t)[None]), drawn.way(uav, t)
            if self._ranges:
                self._ranges[uav].set_xy(place + (drawn.flight.sensor.range or 0.0) * _CIRCLE)
            ahead, out = (np.empty((0, 3)), np.empty((0, 3))) if way is None else way.ahead(t)
            lines = (self._trails, track.flown(t)), (self._ways, ahead), (self._outs, out)
            for artists, points in lines:
                artists[uav].set_data(*view.seen(points).T)
            self._marks[uav].set_data(*place.T)

    def _show_movers(self, t: float) -> None:
        """Move the movers to where they truly are, and their doubt to where they are held to be."""
        drawn, view = self._drawn, self._view
        movers = drawn.scene.scenario.movers
        for mover, artist in zip(movers, self._bodies, strict=True):
            artist.set_xy(view.outline(surface_of(mover, 0.0) + mover.at([t])[0]))
        for share, artists in zip(AHEAD, self._doubt, strict=True):
            held = {
                mover.name: (place, doubt) for mover, place, doubt in drawn.predicted(t, share * drawn.flight.horizon)
            }
            for mover, artist in zip(movers, artists, strict=True):
                artist.set_visible(mover.name in held)
                if mover.name in held:
                    place, doubt = held[mover.name]
                    artist.set_xy(view.outline(surface_of(mover, doubt) + place))


def clear(tone: str, strength: float) -> tuple[float, float, float, float]:
    """Return a colour that lets through what is behind it."""
    from matplotlib.colors import to_rgba

    return to_rgba(tone, strength)
