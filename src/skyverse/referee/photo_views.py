"""Views of photos: what a camera is certain to show, wherever within its tracking error and attitude error it is.

A place is shown if it lies on the inner side of the four planes through the camera and the sides of its sensor. Turned
by at most the attitude error e, the inward normal m of such a plane keeps the place at q inside if q m >= abs(q) sin e,
which is a convex cone; moved by the tracking error, the camera takes off what the cylinder reaches along m. The depth
along the optical axis, at its most over all attitudes, is convex. So whoever sees all corners of a convex part is
certain to see all of it, and nowhere more coarsely than at its coarsest corner.
"""

import math
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.model.camera import Camera
from skyverse.model.photos import Photos
from skyverse.model.uav import TrackingError

FLATTEST = math.cos(math.radians(75.0))
"""The cosine of the angle, from straight on, at which facets are seen at most."""


@dataclass(frozen=True, eq=False)
class PhotoView:
    """What one photo is certain to show.

    Attributes
    ----------
    position, axis
        (3,) metres: where the camera is nominally; and the direction in which it looks.
    corners
        (4, 3) the directions of the picture's corners, one metre along the axis.
    sides
        (4, 3) the inward normals of the planes through its sides.
    shrink
        (4,) metres by which these planes move inwards at most.
    sine, cosine
        Of the attitude error.
    deeper
        Metres that the tracking error adds to the depth at most.
    error
        The tracking error.
    """

    position: Floats
    axis: Floats
    corners: Floats
    sides: Floats
    shrink: Floats
    sine: float
    cosine: float
    deeper: float
    error: TrackingError

    def look(self, x: Floats, y: Floats, z: Floats) -> tuple[Floats, Floats]:
        """Return of places by how much they are certain to be in view, metres, and how deep they are at most, metres.

        The coordinates may be arrays of any shapes that fit each other.
        """
        x, y, z = x - self.position[0], y - self.position[1], z - self.position[2]
        squared = x * x + y * y + z * z
        far = np.sqrt(squared)
        margin = np.full(far.shape, np.inf)
        for (a, b, c), shrink in zip(self.sides.tolist(), self.shrink.tolist(), strict=True):
            np.minimum(margin, (a * x + (b * y - shrink)) + c * z, out=margin)
        along = (self.axis[0] * x + self.axis[1] * y) + self.axis[2] * z
        if not self.sine:
            return margin, along + self.deeper
        margin -= self.sine * far
        aside = np.sqrt(np.maximum(squared - along * along, 0.0))
        depth = np.where(along >= self.cosine * far, far, self.cosine * along + self.sine * aside)
        return margin, depth + self.deeper

    def facing(self, corners: Floats, normal: Floats) -> Floats:
        """Return by how much places (n, k, 3) on facets with normals (n, 3) are certain not to be seen too flatly."""
        way = self.position - corners
        front = np.einsum("ikj,ij->ik", way, normal) - FLATTEST * np.linalg.norm(way, axis=2)
        level, upright = self.error.horizontal, self.error.vertical
        stray = level * np.hypot(normal[:, 0], normal[:, 1]) + upright * np.abs(normal[:, 2])
        found: Floats = front - (stray + FLATTEST * math.hypot(level, upright))[:, None]
        return found

    def window(self, low: Floats, high: Floats) -> Floats:
        """Return the least and the greatest x and y, (2, 2) metres, of what it may show between corners (3,)."""
        fall = -self.corners[:, 2]
        down = max(float(self.position[2] + self.error.vertical - low[2]), 0.0)
        depth = np.divide(down, fall, out=np.full(4, np.inf), where=fall > 0)
        farthest = float(math.dist(high, low) + math.dist(self.position, low))
        if depth.max() > farthest:
            depth = np.full(4, farthest)
        reach = self.position[:2] + np.vstack([np.zeros(2), depth[:, None] * self.corners[:, :2]])
        return np.array([reach.min(axis=0), reach.max(axis=0)])


def views_of(photos: Photos, camera: Camera, errors: list[TrackingError], attitude: float) -> list[PhotoView]:
    """Return the views of photos, each with its tracking error, and all with an attitude error, degrees."""
    sine, cosine = math.sin(math.radians(attitude)), math.cos(math.radians(attitude))
    wide, high = camera.half_widths
    signs = ((-1, -1), (-1, 1), (1, 1), (1, -1))
    views = []
    for position, (axis, right, top), error in zip(photos.position, photos.frames, errors, strict=True):
        sides = np.stack(
            [(t * axis + s * d) / math.hypot(t, 1) for t, d in ((wide, right), (high, top)) for s in (1, -1)]
        )
        corners = np.stack([axis + s * wide * right + t * high * top for s, t in signs])
        stray = sine * math.hypot(error.horizontal, error.vertical)
        shrink = error.horizontal * np.hypot(sides[:, 0], sides[:, 1]) + error.vertical * np.abs(sides[:, 2]) + stray
        deeper = error.horizontal * math.hypot(axis[0], axis[1]) + error.vertical * abs(float(axis[2])) + stray
        views.append(PhotoView(position, axis, corners, sides, shrink, sine, cosine, deeper, error))
    return views
