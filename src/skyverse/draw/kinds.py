"""Obstacles and zones by what they stand for: one colour a kind, and no more shapes than a picture can carry."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.draw.solids import SIDES, Shape, coarser, extent, skin
from skyverse.model.shapes import Box, Cylinder, Prism, Sphere, Voxels

TRIANGLES = 250_000
"""That a picture in space has at most."""
FEW = 300
"""Shapes of a kind that are drawn with their edges; of more, edges would hide the faces."""
ROUND = 2_500
"""Shapes that are drawn with smooth circles."""

_KNOWN = {
    "building": "#9aa3b4",
    "tree": "#6f8f57",
    "vegetation": "#6f8f57",
    "power line": "#6b5b95",
    "no-fly zone": "#c8323c",
    "restricted": "#c8323c",
    "prohibited": "#a3123a",
    "school": "#b8860b",
    "hospital": "#c2548b",
    "water": "#4f86c6",
    "bridge": "#a0785a",
    "construction": "#b5a27c",
    "furniture": "#5c6f82",
}
_OTHERS = ("#7b61a8", "#3b8ea5", "#a0522d", "#5f7f3f", "#96487a", "#5a6ea8", "#8a7a2a", "#4d7f74")
_AIR = ("zone", "space", "restricted", "prohibited", "danger", "fly", "corridor", "geofence")


@dataclass(frozen=True, eq=False)
class Kind:
    """The shapes of one kind.

    Attributes
    ----------
    name
        The kind, or ``"obstacle"`` or ``"zone"`` where the shapes have none.
    hard
        Whether they are obstacles, not to be entered; zones may be, at a risk.
    count
        How many there are.
    shapes
        Those that are drawn, from the largest: all, or those that look largest from the paths.
    colour
        ``None`` for that of the page for obstacles or zones.
    solid
        Whether it hides what is behind; what fills air is drawn so that one sees through.
    sides
        Of a circle.
    """

    name: str
    hard: bool
    count: int
    shapes: tuple[Shape, ...]
    colour: str | None
    solid: bool
    sides: int = SIDES

    @property
    def title(self) -> str:
        """The kind, and how many there are."""
        shown = len(self.shapes)
        return f"{self.name} ({self.count:,})" if shown == self.count else f"{self.name} ({shown:,} of {self.count:,})"

    @cached_property
    def extents(self) -> Floats:
        """The min and max corners around the shapes, (n, 2, 3) metres."""
        return np.array([extent(shape) for shape in self.shapes]).reshape(-1, 2, 3)


def kinds(obstacles: Sequence[Shape], zones: Sequence[Shape], lines: Sequence[Floats]) -> tuple[Kind, ...]:
    """Sort shapes by kind, obstacles first; where there are too many to draw, those near to `lines` (k, 3) come first.

    The most numerous are first, so that what is small and rare is drawn last and found below in the legend.
    """
    everything = [coarser(s, TRIANGLES // 2) if isinstance(s, Voxels) else s for s in (*obstacles, *zones)]
    sides = SIDES if len(everything) <= ROUND else 12
    drawn = _chosen(everything, lines, sides)
    low, high = np.array([extent(shape) for shape in everything]).reshape(-1, 2, 3).swapaxes(0, 1)
    largest = np.argsort(-np.linalg.norm(high - low, axis=1), kind="stable").tolist()
    grouped: dict[tuple[bool, str], list[int]] = {}
    for k in largest:
        shape, hard = everything[k], k < len(obstacles)
        grouped.setdefault((not hard, shape.kind or ("obstacle" if hard else "zone")), []).append(k)
    sorted_ = sorted(grouped.items(), key=lambda item: (item[0][0], -len(item[1]), item[0][1]))
    others = iter(_OTHERS * (1 + len(sorted_) // len(_OTHERS)))
    return tuple(
        Kind(
            name=name,
            hard=not soft,
            count=len(numbers),
            shapes=tuple(everything[k] for k in numbers if drawn[k]),
            colour=_colour(name, others),
            solid=not soft and name != "obstacle" and not any(word in name.lower() for word in _AIR),
            sides=sides,
        )
        for (soft, name), numbers in sorted_
    )


def _colour(name: str, others: Iterator[str]) -> str | None:
    if name in ("obstacle", "zone"):
        return None
    return next((colour for word, colour in _KNOWN.items() if word in name.lower()), None) or next(others)


def _chosen(shapes: Sequence[Shape], lines: Sequence[Floats], sides: int) -> NDArray[np.bool_]:
    """Tell which shapes are drawn: those that look largest from the nearest path, while triangles last."""
    triangles = np.array([_triangles(shape, sides) for shape in shapes])
    if triangles.sum() <= TRIANGLES:
        return np.ones(len(shapes), dtype=bool)
    from scipy.spatial import cKDTree

    boxes = np.array([extent(shape) for shape in shapes])
    sizes = np.linalg.norm(boxes[:, 1] - boxes[:, 0], axis=1)
    seen = sizes
    points = np.concatenate([np.empty((0, 3)), *lines])
    if len(points):
        away = cKDTree(points).query(boxes.mean(axis=1))[0]
        seen = sizes / np.maximum(away, sizes)
    order = np.lexsort((-sizes, -seen))
    drawn = np.zeros(len(shapes), dtype=bool)
    drawn[order[np.cumsum(triangles[order]) - triangles[order] < TRIANGLES]] = True
    return drawn


def _triangles(shape: Shape, sides: int) -> int:
    match shape:
        case Box():
            return 12
        case Cylinder():
            return 4 * sides - 4
        case Sphere():
            return sides * (sides - 2)
        case Prism():
            corners = len(shape.vertices) + sum(map(len, shape.holes))
            return 4 * (corners + len(shape.holes)) - 4
        case Voxels():
            return 2 * len(skin(shape))
