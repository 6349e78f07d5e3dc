"""Lines in one direction across an area, and about what they take."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import shapely

from skyverse._typing import Floats
from skyverse.numerics.tolerances import SWEEP_CONTACT
from skyverse.survey.cells import cover_lines, cross_sections, lines_at, price_lines, turned
from skyverse.survey.leg_time import LegTime
from skyverse.survey.visibility import outline

Ends = Literal["line", "swath", "corners"]
Offsets = Callable[[Floats, Any, float, float], Floats]
_MOST_BORDERS = 120
_SAME_DIRECTION = 1e-3  # radians
LEFT_OPEN = 0.4
"""Of half a width squared: no part left open is larger than that, where borders are met at a slant."""


@dataclass(frozen=True)
class SweepTask:
    """What all parts of a search share."""

    wanted: Any
    free: Any
    width: float | Offsets
    cost: LegTime
    ends: Ends
    start: Floats | None
    reach: float
    flown: Any = field(init=False)
    terms: dict[tuple[float, float], tuple[float, float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "flown", polygons(self.wanted.intersection(self.free)))

    @property
    def step(self) -> float:
        """A usual distance from line to line, metres."""
        return float(np.sqrt(self.flown.area)) / 30 if callable(self.width) else self.width


def candidate_directions(area: Any) -> Floats:
    """Return unit vectors (d, 2) along the borders of an area and of its convex hull, and across them."""
    edges = np.concatenate([outline(area), outline(area.convex_hull)])
    along = edges[:, 2:] - edges[:, :2]
    long = np.hypot(along[:, 0], along[:, 1])
    along = along[np.argsort(-long, kind="stable")][:_MOST_BORDERS]
    return units(np.concatenate([along, np.stack([-along[:, 1], along[:, 0]], 1)]))


def units(vectors: Floats) -> Floats:
    """Return unit vectors in the upper half plane, each direction once."""
    units = vectors / np.hypot(vectors[:, 0], vectors[:, 1])[:, None]
    units = units * np.where((units[:, 1] < 0.0) | ((units[:, 1] == 0.0) & (units[:, 0] < 0.0)), -1.0, 1.0)[:, None]
    units = units[np.argsort(-units[:, 0], kind="stable")]
    turn = units[:-1, 0] * units[1:, 1] - units[:-1, 1] * units[1:, 0]
    return units[np.r_[True, turn > _SAME_DIRECTION]]


def polygons(area: Any) -> Any:
    """Return the polygons of an area as one valid geometry, without lines and points."""
    area = shapely.make_valid(area) if not area.is_valid else area
    parts = shapely.get_parts(area, return_index=False)
    parts = shapely.get_parts(parts) if len(parts) else parts
    return shapely.union_all([part for part in parts if part.geom_type == "Polygon" and part.area > SWEEP_CONTACT])


def _terms(task: SweepTask, way: Floats) -> tuple[float, float, float]:
    """Return seconds per metre of a line along a direction, of its ramps, and of a hop to the next line."""
    key = (float(way[0]), float(way[1]))
    if key in task.terms:
        return task.terms[key]
    ramp = task.cost.speed**2 / task.cost.acceleration
    one, two, hop = task.cost(np.array([way * ramp, 2 * way * ramp, [way[1] * task.step, -way[0] * task.step]]))
    slope = float(two - one) / ramp
    task.terms[key] = slope, float(one) - slope * ramp, float(hop)
    return task.terms[key]


def lines_across(task: SweepTask, edges: Floats, way: Floats) -> Floats:
    """Return lines (k, 3) in the frame turned along a direction: x, y0, y1."""
    sections = cross_sections(turned(edges, *way))
    if callable(task.width):
        offsets = task.width(way, task.flown, float(sections.x[0]), float(sections.x[-1]))
        lines = lines_at(sections.edges, offsets)
        return np.concatenate([lines, _beside_corners(task, offsets, lines, way)]) if task.ends == "corners" else lines
    return cover_lines(sections, 0.5 * task.width, _terms(task, way))


def price(task: SweepTask, edges: Floats, way: Floats) -> float:
    """Return about how many seconds the lines of an outline take."""
    if callable(task.width):
        lines = lines_across(task, edges, way)
        hops = len(lines) * task.cost(np.array([way[1], -way[0]]) * task.step)
        return float(task.cost((lines[:, 2] - lines[:, 1])[:, None] * way).sum() + hops)
    half, direction = 0.5 * task.width, (float(way[0]), float(way[1]))
    return float(price_lines(edges, direction, half, _terms(task, way), LEFT_OPEN * half**2))


def _beside_corners(task: SweepTask, offsets: Floats, lines: Floats, way: Floats) -> Floats:
    """Return lines (k, 3) beside what of the area is nearest to an offset at which no line cuts it."""
    area = across(task.flown, way)
    middles = np.r_[-1e9, 0.5 * (offsets[1:] + offsets[:-1]), 1e9]
    bands = shapely.intersection(shapely.box(middles[:-1], -1e9, middles[1:], 1e9), area)
    parts, which = shapely.get_parts(bands, return_index=True)
    cut, _ = shapely.STRtree(shapely.linestrings(upright(lines))).query(
        parts, predicate="dwithin", distance=SWEEP_CONTACT
    )
    alone = np.setdiff1d(np.flatnonzero(shapely.area(parts) > SWEEP_CONTACT), cut)
    return np.column_stack([offsets[which[alone]], shapely.bounds(parts[alone])[:, 1::2]])


def widest_gaps(offsets: Floats, alone: float) -> Floats:
    """Return how far lines (k,) at offsets are from those beside them, at most, metres; or `alone` without any."""
    x, at = np.unique(offsets, return_inverse=True)
    gaps = np.diff(x) if len(x) > 1 else np.full(1, alone)
    return np.maximum(np.r_[gaps[:1], gaps], np.r_[gaps, gaps[-1:]])[at]


def upright(lines: Floats) -> Floats:
    """Return the ends (k, 2, 2) of lines (k, 3) in their frame."""
    return np.stack([lines[:, [0, 1]], lines[:, [0, 2]]], axis=1)


def across(area: Any, way: Floats) -> Any:
    """Return a shapely geometry in the frame whose y runs along a unit vector, and x to the right of it."""
    ux, uy = way
    return shapely.transform(area, lambda p: np.stack([p[:, 0] * uy - p[:, 1] * ux, p[:, 0] * ux + p[:, 1] * uy], 1))
