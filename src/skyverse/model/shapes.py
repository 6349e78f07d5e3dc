"""The shapes that fill space: boxes, cylinders, spheres, prisms, voxels, and the ground.

A shape is an obstacle, or a zone: one with a risk or a speed limit may be flown through, one that has only active times
may be at other times. The ground is neither.
"""

import math
from functools import lru_cache
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    SerializationInfo,
    SerializerFunctionWrapHandler,
    Tag,
    model_serializer,
    model_validator,
)

from skyverse._typing import Floats
from skyverse.model.grids import GridModel, Heights, Occupied, written
from skyverse.model.polygon import edges_that_meet, is_inside
from skyverse.model.quantities import (
    Extent,
    Flag,
    Instant,
    Limit,
    Model,
    Number,
    Place,
    Point,
    Positive,
    Steps,
    derived,
    listed,
    named_type,
)

Spans = tuple[tuple[float | None, float | None], ...]


def _in_order(given: Spans) -> Spans:
    spans = active_spans(given)
    for k, (begin, end) in enumerate(spans):
        if not begin < end:
            raise ValueError(f"active[{k}] must end after it begins, but is from {begin:g} s to {end:g} s")
    for k, ((_, end), (begin, _)) in enumerate(pairwise(spans), 1):
        if not end < begin:
            raise ValueError(f"active[{k}] must begin after active[{k - 1}] has ended")
    return given


Span = Annotated[tuple[Instant | None, Instant | None], BeforeValidator(listed)]
ActiveTimes = Annotated[tuple[Span, ...], BeforeValidator(listed), Field(min_length=1), AfterValidator(_in_order)]
"""When a zone is active: pairs of instants, ``None`` where a pair has no beginning or no end; in order of time."""


def active_spans(active: Spans | None) -> tuple[tuple[float, float], ...]:
    """Return from when until when a zone is active, seconds, infinite where it is open; always without such times."""
    if active is None:
        return ((-math.inf, math.inf),)
    return tuple((-math.inf if a is None else a, math.inf if b is None else b) for a, b in active)


MAX_TOLD = 3
"""Active times that are told in one sentence; of more it is told how many there are."""


def told_spans(active: Spans) -> str:
    """Return when a zone is active, as sentences tell it: ``from 60 s to 120 s and from 300 s on``."""
    told = active if len(active) <= MAX_TOLD else active[: MAX_TOLD - 1]
    more = [f"{len(active) - len(told):,} times more"] if len(active) > len(told) else []
    return " and ".join([*map(_told, active_spans(told)), *more])


def _told(span: tuple[float, float]) -> str:
    begin, end = span
    if begin == -math.inf:
        return "at all times" if end == math.inf else f"until {end:g} s"
    return f"from {begin:g} s on" if end == math.inf else f"from {begin:g} s to {end:g} s"


LEAST_CLEARANCE = 0.001
"""Metres: the least clearance where there is anything to keep clear of, so that nothing leads between what touches."""

NO_FLY_ZONE = "no-fly zone"
"""What zones that must not be flown through are called where a map says nothing more of them."""
FENCE = "fence"
"""What obstacles are called that fill all around the areas that UAVs must stay in; pictures show their edges alone."""


class Shape(Model):
    """The fields that all shapes have.

    Attributes
    ----------
    name
        What it is called, if it has a name.
    kind
        What it stands for, such as ``"building"`` or ``"no-fly zone"``: a name and, in pictures, its looks, no more.
    solid
        Whether an obstacle is a thing, on which UAVs may stand and which they can hit, rather than airspace that they
        must not enter, such as a no-fly zone. Zones of a scenario are airspace, whatever they say.
    risk
        What a metre flown inside a zone adds to the path's risk. Obstacles have none.
    max_speed
        How fast UAVs may fly inside a zone at most, m/s; ``None`` where it has no such limit. Obstacles have none.
    closed_above
        Whether all that is above the shape belongs to it too, so that nothing may fly over it. Zones have no such.
    active
        When a zone is active: pairs of the instants, seconds into the mission, from which and until which it is;
        ``None`` instead of an instant where it has been active before, or stays so. Its speed limit holds only then; a
        zone without one must not be entered while it is active. Obstacles have none.
    """

    name: str | None = None
    kind: str | None = None
    solid: Flag = True
    risk: Positive | None = None
    max_speed: Limit | None = None
    closed_above: Flag = False
    active: ActiveTimes | None = None


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
    """An axis-aligned box: ``min`` and ``max`` corner, metres. A box grown by the clearance is a box."""

    shape: Literal["box"] = "box"


class Cylinder(Upright):
    """A vertical cylinder. A cylinder grown by the clearance is a cylinder.

    Attributes
    ----------
    centre
        x, y, metres.
    radius
        Metres.
    low, high
        The z where it begins and ends, metres.
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
"""x, y of at least three corners, metres, clockwise or not, the first not repeated."""


class Region(Model):
    """A part of the plane: an outline and holes in it, seen from above.

    Attributes
    ----------
    vertices
        The outline: x, y of at least three corners, metres, clockwise or not, the first not repeated. It must not
        touch or cross itself.
    holes
        Outlines of holes, inside the first outline; no outline may touch another.
    """

    vertices: Ring
    holes: tuple[Ring, ...] = ()

    @model_validator(mode="after")
    def _simple(self) -> Self:
        wrong = _wrong_rings(tuple(map(tuple, self.vertices)), tuple(tuple(map(tuple, hole)) for hole in self.holes))
        if wrong:
            raise ValueError(wrong)
        return self


class Prism(Region, Upright):
    """A vertical prism on a polygon, convex or not, with or without holes.

    A prism grown by the clearance reaches that distance from the polygon, with rounded corners, and begins that much
    lower and ends that much higher.

    Attributes
    ----------
    vertices, holes
        Its outline and the outlines of holes in it, as those of a `Region`.
    low, high
        The z where it begins and ends, metres.
    """

    shape: Literal["prism"] = "prism"


@lru_cache(2**16)
def _wrong_rings(outline: tuple[Place, ...], holes: tuple[tuple[Place, ...], ...]) -> str:
    """Return what is wrong with a region's rings, or nothing; pydantic asks whenever one is part of something."""
    rings = [outline, *holes]
    met = edges_that_meet(rings)
    if met is not None:
        (ring, edge), (other, another) = met
        names = ["the outline", *(f"holes[{k}]" for k in range(len(holes)))]
        if ring == other:
            return f"{names[ring]} must not touch or cross itself, but its edges {edge} and {another} meet"
        return f"{names[ring]} and {names[other]} must not touch or cross, but edges {edge} and {another} meet"
    for k, hole in enumerate(holes):
        others = [other for other in holes if other is not hole]
        if not is_inside(hole[0], outline) or any(is_inside(hole[0], other) for other in others):
            return f"holes[{k}] must lie inside the outline and outside of other holes"
    return ""


class Voxels(Shape, GridModel):
    """Equal cells of space, each free or occupied. Each occupied cell is a box, which the clearance grows.

    Attributes
    ----------
    origin
        The min corner of the first cell, metres.
    step
        The lengths of a cell along x, y and z, metres.
    occupied
        (nx, ny, nz) booleans.
    """

    shape: Literal["voxels"] = "voxels"
    origin: Point
    step: Steps
    occupied: Occupied


class Terrain(GridModel):
    """The ground: heights on a grid, bilinear in between.

    No UAV may fly lower above it than the clearance, which is counted vertically: z must not be below the sum of the
    ground's z at the same x, y and `clearance`.

    Attributes
    ----------
    origin
        x, y of the first height, metres.
    step
        The distances between heights along x and along y, metres.
    heights
        (nx, ny) z in metres; ``heights[i][j]`` stands at ``origin + (i * step[0], j * step[1])``.
    clearance
        Metres above ground, at least `LEAST_CLEARANCE`; the scenario's clearance if it is left out.
    lowest
        (nx, ny) z in metres, nowhere above `heights`: the surface that a ceiling above ground is counted from. It
        belongs to ground whose `heights` were raised, so that a height above them is less than the height above the
        real ground. If it is left out, a ceiling is counted from `heights`.
    """

    origin: Place
    step: Annotated[tuple[Positive, Positive], BeforeValidator(listed)]
    heights: Heights
    clearance: Annotated[Number, Field(ge=LEAST_CLEARANCE)] | None = None
    lowest: Annotated[Heights | None, Field(exclude=True)] = None

    @model_serializer(mode="wrap")
    def _with_lowest(self, dump: SerializerFunctionWrapHandler, info: SerializationInfo) -> dict[str, Any]:
        """Return the terrain's data, with `lowest` where it is given: arrays cannot be compared with a default."""
        data: dict[str, Any] = dump(self)
        if self.lowest is not None:
            data["lowest"] = written(self.lowest, info) if info.mode == "json" else self.lowest
        return data

    @model_validator(mode="after")
    def _lowest_below(self) -> Self:
        if self.lowest is None:
            return self
        if self.lowest.shape != self.heights.shape:
            raise ValueError(
                f"lowest must have as many rows and numbers as heights, {self.heights.shape}, found {self.lowest.shape}"
            )
        above = np.argwhere(self.lowest > self.heights)
        if len(above):
            i, j = above[0]
            raise ValueError(
                f"lowest must not be above heights, but at [{i}][{j}] they are {self.lowest[i, j]:g} and "
                f"{self.heights[i, j]:g}"
            )
        return self

    @property
    def lowest_ground(self) -> "Terrain":
        """The surface that a ceiling above ground is counted from: a terrain whose heights are `lowest`, if given."""
        return self if self.lowest is None else derived(self, heights=self.lowest, lowest=None)

    @property
    def extent(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The least x, y and the greatest x, y that the terrain covers, metres."""
        (x, y), (dx, dy), (nx, ny) = self.origin, self.step, self.heights.shape
        return (x, y), (x + dx * (nx - 1), y + dy * (ny - 1))

    def height(self, places: ArrayLike) -> Floats:
        """Return the ground's z (...) at places (..., 2), metres; beyond the grid it is that of the nearest edge."""
        h, last = self.heights, np.array(self.heights.shape) - 1
        at = np.clip((np.asarray(places, dtype=np.float64) - self.origin) / self.step, 0, last)
        cell = np.minimum(at.astype(np.intp), last - 1)
        (i, j), (u, v) = np.moveaxis(cell, -1, 0), np.moveaxis(at - cell, -1, 0)
        low, high = h[i, j] * (1 - u) + h[i + 1, j] * u, h[i, j + 1] * (1 - u) + h[i + 1, j + 1] * u
        return low * (1 - v) + high * v


AnyShape = Annotated[
    Annotated[Box, Tag("box")]
    | Annotated[Cylinder, Tag("cylinder")]
    | Annotated[Sphere, Tag("sphere")]
    | Annotated[Prism, Tag("prism")]
    | Annotated[Voxels, Tag("voxels")],
    Discriminator(named_type("shape", "box")),
]
"""Any shape; its field `shape` names the type, and a shape without it is a box."""


def _forbidden(shape: Shape) -> Shape:
    if shape.risk is not None:
        raise ValueError("an obstacle has no risk; what may be flown through belongs to zones")
    if shape.max_speed is not None:
        raise ValueError("an obstacle has no max_speed; what may be flown through belongs to zones")
    if shape.active is not None:
        raise ValueError("an obstacle is always there; what is there only at active times belongs to zones")
    return shape


def _open_to_flight(shape: Shape) -> Shape:
    if shape.risk is None and shape.max_speed is None and shape.active is None:
        raise ValueError(
            "a zone needs a risk, per metre flown inside, a max_speed, m/s, or times at which it is active; "
            "what must never be entered belongs to obstacles"
        )
    if shape.risk is not None and shape.active is not None:
        raise ValueError("a zone with a risk has no active times, since paths, which pay for risks, have no times")
    if shape.closed_above:
        raise ValueError("a zone cannot be closed above; what must not be flown over belongs to obstacles")
    return shape


Obstacle = Annotated[AnyShape, AfterValidator(_forbidden)]
Zone = Annotated[AnyShape, AfterValidator(_open_to_flight)]
