"""Orthographic views in a figure, from above and from the side, with outlines of what is in them."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.palette import LIGHT
from skyverse.draw.shape_geometry import DrawnShape, surface
from skyverse.model.shapes import Voxels


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


def clear(tone: str, strength: float) -> tuple[float, float, float, float]:
    """Return a colour that lets through what is behind it."""
    from matplotlib.colors import to_rgba

    return to_rgba(tone, strength)
