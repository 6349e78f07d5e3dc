"""Gaps: what no photo is certain to show, as outlines with why, and whether some of it is certainly not shown."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from skyverse._typing import Bools, Floats
from skyverse.model.scenario import Scenario
from skyverse.referee.blockers import Solid
from skyverse.referee.ground_cells import quarters
from skyverse.referee.photo_views import PhotoView
from skyverse.referee.tolerances import LET_PASS, NO_LENGTH

MOST_GAPS = 200
"""Outlines at most: where there are more, those that are near each other are joined."""
ON_RAY = 64
"""Places on the way from a gap to a camera at which the ground is looked at."""
NOT_SHOWN, TOO_COARSE, NOT_CERTAIN = (
    "no photo shows it",
    "no photo shows it finely enough",
    "no photo is certain to show it",
)


class Reason(NamedTuple):
    """Why a place is not certain to be seen, and whether in some flight within the errors it is certainly not."""

    why: str
    certain: bool


@dataclass(frozen=True, eq=False)
class Sight:
    """What the cameras of photos may see, place by place.

    Attributes
    ----------
    scenario
        What was given.
    views, nominal
        Of the photos, with their errors and without.
    most
        Metres along the optical axis: what is deeper is shown too coarsely.
    solids
        What may hide places, besides the ground.
    """

    scenario: Scenario
    views: Sequence[PhotoView]
    nominal: Sequence[PhotoView]
    most: float
    solids: Sequence[Solid]

    def reasons(self, places: Floats, normal: Floats | None = None) -> list[Reason]:
        """Return why each of places (n, 3), on facets with normals (n, 3), is not certain to be seen."""
        n = len(places)
        shown, fine, sure, by = np.zeros(n, bool), np.zeros(n, bool), np.ones(n, bool), [""] * n
        for view, exact in zip(self.views, self.nominal, strict=True):
            margin, depth = view.look(*places.T)
            stray = 2 * view.sine * float(np.hypot(view.error.horizontal, view.error.vertical)) + LET_PASS
            missed = (margin + stray < 0) | (depth - stray > self.most)
            in_view = exact.look(*places.T)[0] >= 0
            if normal is not None:
                shifted = 2 * float(np.hypot(view.error.horizontal, view.error.vertical)) + LET_PASS
                missed |= view.facing(places[:, None], normal)[:, 0] + shifted < 0
                in_view &= exact.facing(places[:, None], normal)[:, 0] >= 0
            good = in_view & (depth <= self.most)
            fine |= good
            for k in np.flatnonzero(in_view | ~missed).tolist():
                hidden = self._hidden(places[k], view)
                by[k] = by[k] or hidden
                shown[k] |= in_view[k] and not hidden
                if not hidden and not missed[k]:
                    sure[k] = False
        found = []
        for k in range(n):
            bare = NOT_CERTAIN if fine[k] else TOO_COARSE if shown[k] else ""
            why = by[k] if fine[k] and by[k] else bare or by[k] or NOT_SHOWN
            found.append(Reason(why, bool(sure[k])))
        return found

    def _hidden(self, place: Floats, view: PhotoView) -> str:
        """Say what certainly hides a place from some place where the camera may be; nothing where that is not known."""
        away = view.position[:2] - place[:2]
        stray = away / max(float(np.hypot(*away)), NO_LENGTH) * view.error.horizontal
        lowered = view.position + np.array([*stray, -view.error.vertical])
        for camera in (view.position, lowered):
            if self.scenario.terrain is not None:
                share = (np.arange(1, ON_RAY) / ON_RAY)[:, None]
                way = place + share * (camera - place)
                if (self.scenario.terrain.height(way[:, :2]) > way[:, 2] + LET_PASS).any():
                    return "hidden by the ground"
            line = shapely.linestrings([place[:2], camera[:2]])
            for solid in self.solids:
                if not shapely.intersects(solid.core, line):
                    continue
                inner = shapely.get_coordinates(shapely.intersection(solid.core, line))
                length = max(float(np.hypot(*(camera - place)[:2])), NO_LENGTH)
                z = place[2] + np.hypot(*(inner - place[:2]).T) / length * (camera[2] - place[2])
                if max(z.min(), solid.low) + LET_PASS < min(z.max(), solid.high):
                    return f"hidden by {name_of(self.scenario, solid)}"
        return ""


def name_of(scenario: Scenario, solid: Solid) -> str:
    """Return how sentences call the obstacle that a solid is of."""
    shape = scenario.obstacles[solid.obstacle]
    return f"{shape.kind or 'obstacle'} {shape.name or solid.obstacle!r}"


def outlines_of(polygons: NDArray[np.object_], size: float) -> list[tuple[shapely.Geometry, float]]:
    """Return polygons that together hold polygons, joined where they meet, each with the area of what it holds."""
    together = shapely.union_all(polygons)
    parts, reach = shapely.get_parts(together), size
    while len(parts) > MOST_GAPS:
        parts = shapely.get_parts(
            shapely.union_all(shapely.buffer(parts, reach, quad_segs=1, cap_style="square", join_style="mitre"))
        )
        reach *= 2
    held = shapely.area(parts) if reach == size else shapely.area(shapely.intersection(parts, together))
    order = np.argsort(-held, kind="stable")
    return list(zip(parts[order], held[order].tolist(), strict=True))


def runs(which: Bools, x: Floats, y: Floats) -> NDArray[np.object_]:
    """Return boxes that fill some cells (n, m) of a grid between lines."""
    steps = np.diff(np.pad(which, [(0, 0), (1, 1)]).astype(np.int8), axis=1)
    (i, begin), (_, end) = np.nonzero(steps > 0), np.nonzero(steps < 0)
    return shapely.box(x[i], y[begin], x[i + 1], y[end])


def spots(polygon: shapely.Geometry) -> Floats:
    """Return places (n, 2) in a polygon: one of all of it, and one of each part of its quarters."""
    low, high = np.split(np.array([shapely.bounds(polygon)]), 2, axis=1)
    parts = np.append(polygon, quarters(np.array([polygon]), (low + high) / 2))
    return shapely.get_coordinates(shapely.point_on_surface(parts))
