"""The shapes that fill space: boxes, cylinders, spheres, prisms, voxels, and the ground.

Each may be an obstacle, or, with a risk, a zone that may be flown through; the ground is the ground.
"""

from bisect import bisect_right
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    PlainSerializer,
    PlainValidator,
    PrivateAttr,
    SerializationInfo,
    Tag,
    ValidationInfo,
    WithJsonSchema,
    model_validator,
)

from skyverse.model.arrays import GridModel, frozen
from skyverse.model.quantities import Extent, Model, NonNegative, Number, Place, Point, Positive, Steps, listed


class Shape(Model):
    """What all shapes have.

    Attributes
    ----------
    name
        What it is called, if anything.
    kind
        What it stands for, such as ``"building"`` or ``"no-fly zone"``; pictures tell kinds apart.
    risk
        Of a zone: what a metre flown inside adds to the path's risk. Obstacles have none.
    """

    name: str | None = None
    kind: str | None = None
    risk: Positive | None = None


class Upright(Shape):
    """A shape with vertical walls, from ``low`` to ``high``, z in metres."""

    low: Number
    high: Number

    @model_validator(mode="after")
    def _upright(self) -> Self:
        if not self.low < self.high:
            raise ValueError(f"low must be below high, but they are {self.low:g} and {self.high:g}")
        return self


class Box(Extent, Shape):
    """An axis-aligned box: ``min`` and ``max`` corner, metres. Grown by the clearance it is a box."""

    shape: Literal["box"] = "box"


class Cylinder(Upright):
    """A vertical cylinder. Grown by the clearance it is a cylinder.

    Attributes
    ----------
    centre
        x, y, metres.
    radius
        Metres.
    low, high
        Where it begins and ends, z in metres.
    """

    shape: Literal["cylinder"] = "cylinder"
    centre: Place
    radius: Positive


class Sphere(Shape):
    """A sphere: ``centre`` and ``radius``, metres."""

    shape: Literal["sphere"] = "sphere"
    centre: Point
    radius: Positive


Ring = Annotated[tuple[Place, ...], BeforeValidator(listed), Field(min_length=3)]
"""x, y of three corners or more, metres, in either sense of rotation, the first not repeated."""


Outline = tuple[tuple[float, float], ...]
Edge = tuple[float, float, float, float]


class Prism(Upright):
    """A vertical prism on a polygon, convex or not, with or without holes.

    Grown by the clearance, it ends at that distance from the polygon, with rounded corners, and that much lower and
    higher.

    Attributes
    ----------
    vertices
        The outline: x, y of three corners or more, metres, in either sense of rotation, the first not repeated. It
        must not touch or cross itself.
    holes
        Outlines of what is left out, inside the first one; no outline may touch another.
    low, high
        Where it begins and ends, z in metres.
    """

    shape: Literal["prism"] = "prism"
    vertices: Ring
    holes: tuple[Ring, ...] = ()
    _sound: tuple[object, object] | None = PrivateAttr(None)  # the very rings that were looked at already

    @model_validator(mode="after")
    def _simple(self) -> Self:
        if self._sound is not None and self._sound[0] is self.vertices and self._sound[1] is self.holes:
            return self  # pydantic asks again whenever a prism becomes a part of something
        rings = [self.vertices, *self.holes]
        met = _edges_that_meet(rings)
        if met is not None:
            (ring, edge), (other, another) = met
            names = ["the outline", *(f"holes[{k}]" for k in range(len(self.holes)))]
            if ring == other:
                raise ValueError(
                    f"{names[ring]} must not touch or cross itself, but its edges {edge} and {another} meet"
                )
            raise ValueError(
                f"{names[ring]} and {names[other]} must not touch or cross, but edges {edge} and {another} meet"
            )
        for k, hole in enumerate(rings[1:]):
            others = [other for other in rings[1:] if other is not hole]
            if not _inside(hole[0], rings[0]) or any(_inside(hole[0], other) for other in others):
                raise ValueError(f"holes[{k}] must lie inside the outline and outside of other holes")
        self._sound = (self.vertices, self.holes)
        return self

    def __eq__(self, other: object) -> bool:  # whether it was looked at is no part of it
        return self.__dict__ == other.__dict__ if type(self) is type(other) else NotImplemented

    def __hash__(self) -> int:
        return hash((self.vertices, self.holes, self.low, self.high))


def _edges_that_meet(rings: list[Outline]) -> tuple[tuple[int, int], tuple[int, int]] | None:
    """Return two edges of outlines, each as ring and number, that meet, or ``None``; neighbours, where one folds back.

    A sweep along x or y: of edges that begin one after another, each is held against those that begin before it ends.
    """
    edges = [(*a, *b) for ring in rings for a, b in zip(ring, (*ring[1:], ring[0]), strict=True)]
    named = [(number, edge) for number, ring in enumerate(rings) for edge in range(len(ring))]
    sweeps = []
    for axis in range(2):
        low = [min(edge[axis], edge[axis + 2]) for edge in edges]
        high = [max(edge[axis], edge[axis + 2]) for edge in edges]
        begins = sorted(low)
        sweeps.append((sum(bisect_right(begins, end) for end in high), low, high))
    (_, low, high), (_, near, far) = sorted(sweeps, key=lambda sweep: sweep[0])
    order = sorted(range(len(edges)), key=low.__getitem__)
    for place, i in enumerate(order, 1):
        for k in range(place, len(order)):
            j = order[k]
            if low[j] > high[i]:
                break
            if near[j] <= far[i] and near[i] <= far[j] and _meet(edges[i], edges[j], named[i], named[j], rings):
                first, second = sorted((i, j))
                return named[first], named[second]
    return None


def _meet(one: Edge, other: Edge, name: tuple[int, int], another: tuple[int, int], rings: list[Outline]) -> bool:
    """Tell whether two edges whose bounds overlap meet; where one follows the other, whether it folds back."""
    ring, size = name[0], len(rings[name[0]])
    if ring == another[0]:
        if (name[1] + 1) % size == another[1]:
            return _folds(one, other)
        if (another[1] + 1) % size == name[1]:
            return _folds(other, one)
    return _side(one, *other[:2]) * _side(one, *other[2:]) <= 0 and _side(other, *one[:2]) * _side(other, *one[2:]) <= 0


def _folds(edge: Edge, following: Edge) -> bool:
    """Tell whether an edge lies on the one before it."""
    onward = (edge[2] - edge[0]) * (following[2] - following[0]) + (edge[3] - edge[1]) * (following[3] - following[1])
    return _side(edge, *following[2:]) == 0 and not onward > 0


def _side(edge: Edge, x: float, y: float) -> int:
    """Return on which side of an edge a place is: 1, -1, or 0 on its line, or where numbers cannot tell."""
    turn = (edge[2] - edge[0]) * (y - edge[1]) - (edge[3] - edge[1]) * (x - edge[0])
    return (turn > 0) - (turn < 0)


def _inside(place: tuple[float, float], ring: Outline) -> bool:
    """Tell whether a place is inside an outline: a ray along x crosses it an odd number of times."""
    odd = False
    for (ax, ay), (bx, by) in zip(ring, (*ring[1:], ring[0]), strict=True):
        if (ay > place[1]) != (by > place[1]):
            odd ^= (place[1] - ay) / (by - ay) * (bx - ax) + ax > place[0]
    return odd


def _stored(value: object, info: ValidationInfo) -> object:
    """Return an array; a reference stands for one in a side file, which the reader's `grids` gives or refuses."""
    if not isinstance(value, dict):
        return value
    grids = (info.context or {}).get("grids")
    if grids is None:
        raise ValueError(
            "expected rows of numbers; a reference to a file beside is followed by reading this from its file"
        )
    return grids(value)


def _heights(value: object, info: ValidationInfo) -> NDArray[np.float64]:
    rows = _stored(value, info)
    try:
        heights = np.asarray(rows, dtype=np.float64)
    except (TypeError, OverflowError, ValueError):
        raise ValueError("expected rows of numbers of equal length") from None
    if heights.ndim != 2 or min(heights.shape) < 2:
        raise ValueError(f"expected two rows of two numbers or more, found an array of shape {heights.shape}")
    holes = np.argwhere(~np.isfinite(heights))
    if len(holes):
        raise ValueError(f"expected a height everywhere, but there is none at [{holes[0, 0]}][{holes[0, 1]}]")
    return frozen(heights)


def _occupied(value: object, info: ValidationInfo) -> NDArray[np.bool_]:
    layers = _stored(value, info)
    try:
        occupied = np.asarray(layers)
    except ValueError:
        raise ValueError("expected layers of rows of equal length") from None
    if occupied.ndim != 3 or not occupied.size:
        raise ValueError(f"expected an array of three dimensions, found one of shape {occupied.shape}")
    if occupied.dtype != bool and not np.isin(occupied, (0, 1)).all():
        raise ValueError("expected 0 for what is free and 1 for what is occupied")
    return frozen(occupied.astype(bool))


INLINE = 4096
"""Numbers at most that a file holds itself; larger arrays go to a file beside it."""


def _filed(array: NDArray[Any], info: SerializationInfo) -> object:
    """Return an array as lists; a large one as the reference that the writer's `side` gives for it, if there is one."""
    side = (info.context or {}).get("side")
    if side is None or array.size <= INLINE:
        return array.astype(int).tolist() if array.dtype == bool else array.tolist()
    return side(array)


_REFERENCE = {
    "type": "object",
    "properties": {
        "file": {"type": "string"},
        "array": {"type": "string"},
        "shape": {"type": "array", "items": {"type": "integer"}},
        "sha256": {"type": "string"},
    },
    "required": ["file", "array", "shape", "sha256"],
    "additionalProperties": False,
}


def _schema(depth: int) -> WithJsonSchema:
    rows: dict[str, Any] = {"type": "number"}
    for _ in range(depth):
        rows = {"type": "array", "items": rows}
    return WithJsonSchema({"anyOf": [rows, _REFERENCE]})


Occupied = Annotated[
    NDArray[np.bool_], PlainValidator(_occupied), PlainSerializer(_filed, when_used="json"), _schema(3)
]
Heights = Annotated[
    NDArray[np.float64], PlainValidator(_heights), PlainSerializer(_filed, when_used="json"), _schema(2)
]


class Voxels(Shape, GridModel):
    """Equal cells of space, each free or occupied. Each occupied cell is a box, and grown by the clearance a box.

    Attributes
    ----------
    origin
        The min corner of the first cell, metres.
    step
        How long, wide and high a cell is, metres.
    occupied
        (nx, ny, nz) booleans.
    """

    shape: Literal["voxels"] = "voxels"
    origin: Point
    step: Steps
    occupied: Occupied


class Terrain(GridModel):
    """The ground: heights on a grid, bilinear between. Nothing flies below `clearance` above it.

    The clearance is vertical: over a place on the map, z must not be below the ground's z there and `clearance`.

    Attributes
    ----------
    origin
        x, y of the first height, metres.
    step
        Between heights along x and along y, metres.
    heights
        (nx, ny) z in metres; ``heights[i][j]`` stands at ``origin + (i * step[0], j * step[1])``.
    clearance
        Metres above ground; the scenario's clearance when left out.
    """

    origin: Place
    step: Annotated[tuple[Positive, Positive], BeforeValidator(listed)]
    heights: Heights
    clearance: NonNegative | None = None

    @property
    def extent(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The least and the greatest x, y that it covers, metres."""
        (x, y), (dx, dy), (nx, ny) = self.origin, self.step, self.heights.shape
        return (x, y), (x + dx * (nx - 1), y + dy * (ny - 1))

    def height(self, places: ArrayLike) -> NDArray[np.float64]:
        """Return the ground's z at places (..., 2), metres: bilinear, and level beyond the last heights."""
        h, last = self.heights, np.array(self.heights.shape) - 1
        at = np.clip((np.asarray(places, dtype=np.float64) - self.origin) / self.step, 0, last)
        cell = np.minimum(at.astype(np.intp), last - 1)
        (i, j), (u, v) = np.moveaxis(cell, -1, 0), np.moveaxis(at - cell, -1, 0)
        low, high = h[i, j] * (1 - u) + h[i + 1, j] * u, h[i, j + 1] * (1 - u) + h[i + 1, j + 1] * u
        z: NDArray[np.float64] = low * (1 - v) + high * v
        return z


def _kind_of(value: object) -> str:
    """Return which shape it is; a box where nothing is said."""
    said = value.get("shape", "box") if isinstance(value, dict) else getattr(value, "shape", "box")
    return said if isinstance(said, str) else "box"


AnyShape = Annotated[
    Annotated[Box, Tag("box")]
    | Annotated[Cylinder, Tag("cylinder")]
    | Annotated[Sphere, Tag("sphere")]
    | Annotated[Prism, Tag("prism")]
    | Annotated[Voxels, Tag("voxels")],
    Discriminator(_kind_of),
]
"""Told apart by `shape`; a box where that is left out."""


def _forbidden(shape: Shape) -> Shape:
    if shape.risk is not None:
        raise ValueError("an obstacle has no risk; what may be flown through belongs to zones")
    return shape


def _risky(shape: Shape) -> Shape:
    if shape.risk is None:
        raise ValueError("a zone needs a risk, per metre flown inside; what must not be entered belongs to obstacles")
    return shape


Obstacle = Annotated[AnyShape, AfterValidator(_forbidden)]
Zone = Annotated[AnyShape, AfterValidator(_risky)]
