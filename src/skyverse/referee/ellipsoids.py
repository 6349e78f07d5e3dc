"""Grown upright ellipsoids: spheres, once space is compressed along the longer axes."""

import math
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.mover import Ellipsoid
from skyverse.model.uav import TrackingError
from skyverse.referee.segments import distance_to_segment
from skyverse.referee.solids import GrownSolids, chords
from skyverse.referee.tolerances import LET_PASS


@dataclass(frozen=True, eq=False)
class GrownEllipsoids(GrownSolids):
    """Upright ellipsoids, grown in proportion, so that the shorter semi-axis grows by the clearance.

    Attributes
    ----------
    centre, scale
        (m, 3) metres, and (m, 3) by which coordinates are multiplied to make the ellipsoid a sphere: 1 along its
        shorter semi-axis, and less along the longer one.
    radius, grown_radius
        (m,) metres, of that sphere.
    """

    centre: Floats
    scale: Floats
    radius: Floats
    grown_radius: Floats

    def hulls(self) -> tuple[Floats, Floats]:
        """Return the corners of boxes about the grown ellipsoids."""
        semi_axes = self.grown_radius[:, None] / self.scale
        return self.centre - semi_axes, self.centre + semi_axes

    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return how deep parts may be inside, where space is compressed; exactly, where they are straight."""
        scale = self.scale[which]
        chord = chords(part * scale[:, None])
        return self.grown_radius[which] - distance_to_segment(self.centre[which] * scale, chord.a, chord.b) + chord.off

    def gap(self, position: Floats, which: int) -> float:
        """Return the distance of a position to an ellipsoid where space is compressed, metres."""
        return float(math.hypot(*((position - self.centre[which]) * self.scale[which])) - self.radius[which])


def grown_ellipsoids(ellipsoids: list[Ellipsoid], clearance: float, error: TrackingError) -> GrownEllipsoids:
    """Return ellipsoids for a UAV with a tracking error; they grow by all of it in every direction."""
    rows = np.reshape([(*one.centre, one.semi_axis_xy, one.semi_axis_z) for one in ellipsoids], (len(ellipsoids), 5))
    shorter = rows[:, 3:].min(axis=1)
    scale = shorter[:, None] / rows[:, [3, 3, 4]]
    clearance += float(np.hypot(error.horizontal, error.vertical))
    whole = shorter + clearance
    grown_radius = whole - np.minimum(LET_PASS, whole / 4)
    return GrownEllipsoids(clearance, np.arange(len(rows)), rows[:, :3], scale, shorter, grown_radius)
