"""Obstacles and zones grouped by kind, such as buildings: a colour for each kind, and a limit on the shapes drawn."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.draw.palette import KINDS, OTHER_KINDS
from skyverse.draw.shape_geometry import CIRCLE_SIDES, DrawnShape, coarser, skin
from skyverse.model.mover import Ellipsoid
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import Box, Cylinder, Prism, Sphere, Voxels, told_spans

MAX_TRIANGLES = 250_000
"""The largest number of triangles in a picture in space."""
MAX_EDGED_SHAPES = 300
"""The largest number of shapes whose edges are drawn in full; the edges of more would hide the faces."""
MAX_SMOOTH_SHAPES = 2_500
"""The largest number of shapes whose circles are drawn smooth."""


@dataclass(frozen=True, eq=False)
class ShapeKind:
    """The shapes of one kind.

    Attributes
    ----------
    name
        The kind, or ``"obstacle"`` or ``"zone"`` where the shapes have none; the speed limit of zones, in m/s; and when
        they are active.
    hard
        Whether the shapes are obstacles, which must not be entered, rather than zones, which may be at a risk.
    count
        The number of shapes of the kind.
    shapes
        The shapes that are drawn, largest first: all, or those that look largest from the paths.
    colour
        The colour; ``None`` for the page's colour of obstacles or of zones.
    solid
        Whether the shapes are opaque: solid obstacles of a kind, and those without a kind where there are too many for
        nearer ones to be told from farther ones.
    sides
        The number of sides of the polygon that stands for a circle.
    """

    name: str
    hard: bool
    count: int
    shapes: tuple[DrawnShape, ...]
    colour: str | None
    solid: bool
    sides: int = CIRCLE_SIDES

    @property
    def title(self) -> str:
        """The kind and the number of its shapes."""
        shown = len(self.shapes)
        return f"{self.name} ({self.count:,})" if shown == self.count else f"{self.name} ({shown:,} of {self.count:,})"

    @property
    def at_risk(self) -> bool:
        """Whether any of the shapes is a zone that adds to the risk of a path."""
        return any(shape.risk is not None for shape in self.shapes)

    @cached_property
    def extents(self) -> Floats:
        """The least and the greatest corner of the box around each shape, (n, 2, 3) metres."""
        return np.array([extent(shape) for shape in self.shapes]).reshape(-1, 2, 3)


def shapes_by_kind(
    obstacles: Sequence[DrawnShape], zones: Sequence[DrawnShape], lines: Sequence[Floats]
) -> tuple[ShapeKind, ...]:
    """Group shapes by kind, obstacles first; where there are too many to draw, keep those near `lines`, (k, 3) each.

    Obstacles and zones are each ordered by number of shapes, the most numerous kind first, so that rare kinds are drawn
    last and are at the end of the legend.
    """
    everything = [coarser(s, MAX_TRIANGLES // 2) if isinstance(s, Voxels) else s for s in (*obstacles, *zones)]
    sides = CIRCLE_SIDES if len(everything) <= MAX_SMOOTH_SHAPES else 12
    drawn = _chosen(everything, lines, sides)
    low, high = np.array([extent(shape) for shape in everything]).reshape(-1, 2, 3).swapaxes(0, 1)
    largest = np.argsort(-np.linalg.norm(high - low, axis=1), kind="stable").tolist()
    grouped: dict[tuple[bool, str, bool], list[int]] = {}
    for k in largest:
        shape, hard = everything[k], k < len(obstacles)
        grouped.setdefault((not hard, _kind_name(shape, hard), shape.solid), []).append(k)
    sorted_ = sorted(grouped.items(), key=lambda item: (item[0][0], -len(item[1]), item[0][1]))
    others = iter(OTHER_KINDS * (1 + len(sorted_) // len(OTHER_KINDS)))
    return tuple(
        ShapeKind(
            name=name,
            hard=not soft,
            count=len(numbers),
            shapes=tuple(everything[k] for k in numbers if drawn[k]),
            colour=_colour(name, others),
            solid=solid and not soft and (name != "obstacle" or len(numbers) > MAX_EDGED_SHAPES),
            sides=sides,
        )
        for (soft, name, solid), numbers in sorted_
    )


def _kind_name(shape: DrawnShape, hard: bool) -> str:
    """Return the kind of a shape; of zones also the speed limit, and when they are active, where they have these."""
    limit = [] if shape.max_speed is None else [f"speed limit {shape.max_speed:g} m/s"]
    kind = [shape.kind] if shape.kind else [] if limit else ["obstacle" if hard else "zone"]
    times = [] if shape.active is None else [f"active {told_spans(shape.active)}"]
    return ", ".join([*kind, *limit, *times])


def _colour(name: str, others: Iterator[str]) -> str | None:
    if name in ("obstacle", "zone"):
        return None
    return next((colour for word, colour in KINDS.items() if word in name.lower()), None) or next(others)


def _chosen(shapes: Sequence[DrawnShape], lines: Sequence[Floats], sides: int) -> NDArray[np.bool_]:
    """Return which shapes are drawn: those that look largest from the nearest path, up to `MAX_TRIANGLES`."""
    triangles = np.array([_triangles(shape, sides) for shape in shapes])
    if triangles.sum() <= MAX_TRIANGLES:
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
    drawn[order[np.cumsum(triangles[order]) - triangles[order] < MAX_TRIANGLES]] = True
    return drawn


def _triangles(shape: DrawnShape, sides: int) -> int:
    match shape:
        case Box():
            return 12
        case Cylinder():
            return 4 * sides - 4
        case Sphere() | Ellipsoid():
            return sides * (sides - 2)
        case Prism():
            corners = len(shape.vertices) + sum(map(len, shape.holes))
            return 4 * (corners + len(shape.holes)) - 4
        case Voxels():
            return 2 * len(skin(shape))
