"""Grown upright cylinders, spheres and ellipsoids."""

import math
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.mover import Ellipsoid
from skyverse.model.shapes import Cylinder, Sphere
from skyverse.model.uav import TrackingError
from skyverse.referee.solid_shapes import SolidShapes
from skyverse.referee.solids import GrownSolids, chords, distance_to_segment, grown, vertical_depth
from skyverse.referee.tolerances import LET_PASS
from skyverse.referee.tracking_error import EXACT, reach, taller, wider


@dataclass(frozen=True, eq=False)
class GrownCylinders(GrownSolids):
    """Vertical cylinders.

    Attributes
    ----------
    centre, radius, low, high
        (m, 2) and (m,) metres, as given.
    grown_radius, grown_low, grown_high
        (m,) metres.
    """

    centre: Floats
    radius: Floats
    low: Floats
    high: Floats
    grown_radius: Floats
    grown_low: Floats
    grown_high: Floats

    def hulls(self) -> tuple[Floats, Floats]:
        """Return the corners of boxes about the grown cylinders."""
        radius = self.grown_radius[:, None]
        return (
            np.column_stack([self.centre - radius, self.grown_low]),
            np.column_stack([self.centre + radius, self.grown_high]),
        )

    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return how deep parts may be inside: a part outside is far from the axis, below or above."""
        chord = chords(part[:, :, :2])
        level = self.grown_radius[which] - distance_to_segment(self.centre[which], chord.a, chord.b) + chord.off
        return np.minimum(level, vertical_depth(part, self.grown_low[which], self.grown_high[which]))

    def gap(self, position: Floats, which: int) -> float:
        """Return the horizontal distance of a position to a cylinder, or that along z where it is larger, metres."""
        level = np.hypot(*(position[:2] - self.centre[which])) - self.radius[which]
        return float(max(level, self.low[which] - position[2], position[2] - self.high[which]))


def grown_cylinders(shapes: SolidShapes, error: TrackingError = EXACT) -> GrownCylinders:
    """Return all cylinders, for a UAV with a tracking error."""
    cylinders, number = shapes.of(Cylinder)
    rows = np.reshape([(*one.centre, one.radius, one.low, one.high) for one in cylinders], (len(cylinders), 5))
    centre, (radius, low, high) = rows[:, :2], rows[:, 2:].T
    clearance = reach(shapes.clearance, error)
    low, high = taller(low, high, error)
    grown_radius, ends = radius + (clearance - LET_PASS), grown(low, high, clearance)
    return GrownCylinders(clearance, number, centre, radius, low, high, grown_radius, *ends)


@dataclass(frozen=True, eq=False)
class GrownEllipsoids(GrownSolids):
    """Upright ellipsoids, spheres among them, grown in proportion: the shorter semi-axis grows by the clearance.

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

    @property
    def spread(self) -> float:
        """How much farther a hull reaches for each metre that an ellipsoid grows: it keeps its proportions."""
        return float((1.0 / self.scale).max(initial=1.0))

    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return how deep parts may be inside, where space is compressed; exactly, where they are straight."""
        scale = self.scale[which]
        chord = chords(part * scale[:, None])
        return self.grown_radius[which] - distance_to_segment(self.centre[which] * scale, chord.a, chord.b) + chord.off

    def gap(self, position: Floats, which: int) -> float:
        """Return the distance of a position to an ellipsoid where space is compressed, metres."""
        return float(math.hypot(*((position - self.centre[which]) * self.scale[which])) - self.radius[which])


def grown_ellipsoids(shapes: SolidShapes, error: TrackingError = EXACT) -> GrownEllipsoids:
    """Return all ellipsoids, for a UAV with a tracking error; they grow by all of it in every direction."""
    ellipsoids, number = shapes.of(Ellipsoid)
    rows = np.reshape([(*one.centre, one.semi_axis_xy, one.semi_axis_z) for one in ellipsoids], (len(ellipsoids), 5))
    shorter = rows[:, 3:].min(axis=1)
    scale = shorter[:, None] / rows[:, [3, 3, 4]]
    clearance = shapes.clearance + math.hypot(error.horizontal, error.vertical)
    return GrownEllipsoids(clearance, number, rows[:, :3], scale, shorter, shorter + (clearance - LET_PASS))


def grown_spheres(shapes: SolidShapes, error: TrackingError = EXACT) -> GrownEllipsoids:
    """Return all spheres, for a UAV with a tracking error."""
    spheres, number = shapes.of(Sphere)
    radius = wider(np.array([sphere.radius for sphere in spheres]), error)
    centre = np.reshape([sphere.centre for sphere in spheres], (len(spheres), 3))
    clearance = reach(shapes.clearance, error)
    return GrownEllipsoids(clearance, number, centre, np.ones_like(centre), radius, radius + (clearance - LET_PASS))
