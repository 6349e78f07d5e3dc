"""The columns over a UAV's own start and target, in which its error does not count for what lies below.

A UAV that stands on the ground or on a roof is nearer to it than its clearance and its tracking error. So where it
flies straight up from its start, or straight down to its target, the bounds' floor, ground that is nowhere steeper than
45 degrees within the horizontal error, and obstacles that end, grown by the clearance alone, no higher than the start
or target are exempt from the error, not from the clearance. Everything else, beside or above, keeps both, and so does
airspace below, which carries nobody. The column ends where the UAV may stray from what lies below.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.model.uav import TrackingError
from skyverse.referee.boxes import GrownBoxes
from skyverse.referee.ground import Ceiling, GrownGround
from skyverse.referee.prisms import GrownPrisms
from skyverse.referee.round_solids import GrownCylinders, GrownSpheres
from skyverse.referee.solids import GrownSolids
from skyverse.referee.tolerances import COLUMN_REACH, COLUMN_SLACK, EXEMPT_SLOPE, LET_PASS
from skyverse.referee.tube import EXACT, narrower, shorter
from skyverse.referee.world import RefereeWorld


class Column(NamedTuple):
    """A vertical line from a start or target up.

    Attributes
    ----------
    foot
        (3,) metres: where it begins.
    top
        z where it ends, metres.
    beside
        What must be kept in it with the tracking error: all but what lies below.
    """

    foot: Floats
    top: float
    beside: RefereeWorld

    def holds(self, b: Floats, error: Floats) -> NDArray[np.bool_]:
        """Tell which pieces, (n, degree + 1, 3) coefficients and (n,) bounds on their errors, are in the column."""
        beside = np.abs(b[:, :, :2] - self.foot[:2]).max(axis=(1, 2))
        low, high = b[:, :, 2].min(axis=1), b[:, :, 2].max(axis=1)
        held: NDArray[np.bool_] = (beside + error <= LET_PASS) & (low + error >= self.foot[2] - LET_PASS)
        return held & (high - error <= self.top + COLUMN_SLACK)


def column_over(world: RefereeWorld, uav: int, place: Floats) -> Column | None:
    """Return the column over a UAV's start or target, (3,) metres, or ``None`` if there is none.

    There is none for an aeroplane, nor where nothing below keeps the UAV from straying, nor where that keeps it from
    straying up to a greater height than clearance and errors together.
    """
    scenario, error = world.scenario, world.error
    if error == EXACT or scenario.uavs[uav].fixed_wing is not None:
        return None
    roof = float(place[2]) - scenario.clearance + LET_PASS
    top = max(_ends_of_what_is_below(world, place, roof), default=-np.inf)
    most = place[2] + scenario.clearance + error.horizontal + error.vertical + LET_PASS
    return Column(place, top, without_below(world, place, roof)) if place[2] < top <= most else None


def without_below(world: RefereeWorld, place: Floats, roof: float) -> RefereeWorld:
    """Return what there is about the vertical line through a place, (3,) metres, but for what lies below.

    Left out are what the error takes of the bounds' floor, the ground if it is not steep, and shapes, but not airspace,
    that end, as given, no higher than `roof`, metres; also all shapes that the line does not meet.
    """
    low = np.array([*world.low[:2], world.nominal.low[2]])
    kinds = [kind if _is_terrain(kind) else kind.of(_met(world, kind, place, roof)) for kind in world.others]
    floor_counts = world.ground is not None and (
        world.ground.steepest_about(place, world.error.horizontal) > EXEMPT_SLOPE
    )
    others = tuple(kind for kind in kinds if (floor_counts or not isinstance(kind, GrownGround)) and len(kind.obstacle))
    boxes = world.boxes.of(_met(world, world.boxes, place, roof))
    return replace(world, low=low, boxes=boxes, others=others)


def _is_terrain(kind: GrownSolids) -> bool:
    return isinstance(kind, GrownGround | Ceiling)


def _met(world: RefereeWorld, kind: GrownSolids, place: Floats, roof: float) -> Indices:
    """Return the numbers of the shapes of a kind that a vertical line may meet, above a roof or airspace."""
    line = np.array([*place[:2], 0.0])
    reach = np.array([COLUMN_REACH, COLUMN_REACH, np.inf])
    pairs = [found[:, 1] for found in kind.tree.overlapping((line - reach)[None], (line + reach)[None])]
    near = np.unique(np.concatenate([np.zeros(0, dtype=np.intp), *pairs]))
    return near[(_tops(kind, near, world.error) > roof) | _airspace(world, kind, near)]


def _airspace(world: RefereeWorld, kind: GrownSolids, which: Indices) -> NDArray[np.bool_]:
    """Tell which shapes, (n,), are airspace, which nothing stands on."""
    obstacles = world.scenario.obstacles
    return np.array([not obstacles[number].solid for number in kind.obstacle[which]], dtype=np.bool_)


def _tops(kind: GrownSolids, which: Indices, error: TrackingError) -> Floats:
    """Return z (n,) at which shapes end as they are given, without the error and the clearance, metres."""
    match kind:
        case GrownBoxes():
            return shorter(kind.high[which, 2], error)
        case GrownCylinders():
            return shorter(kind.high[which], error)
        case GrownPrisms():
            return shorter(kind.outlines.high[which], error)
        case GrownSpheres():
            return kind.centre[which, 2] + narrower(kind.radius[which], error)
    raise TypeError(f"{type(kind).__name__} has no tops")


def _ends_of_what_is_below(world: RefereeWorld, place: Floats, roof: float) -> Iterator[float]:
    """Yield the z at which each of all that holds a place, and ends below it but for the error, ends above it."""
    yield float(world.low[2])
    for kind in (world.boxes, *world.others):
        if isinstance(kind, GrownGround):
            yield float(place[2] + kind.depth(place[None, None], np.array([0]))[0])
        elif not _is_terrain(kind):
            for pairs in kind.tree.overlapping(place[None], place[None]):
                which = pairs[:, 1]
                held = kind.depth(np.repeat(place[None, None], len(which), axis=0), which) > 0
                held &= (_tops(kind, which, world.error) <= roof) & ~_airspace(world, kind, which)
                for shape in which[held]:
                    yield _top(kind, int(shape), place)


def _top(kind: GrownSolids, which: int, place: Floats) -> float:
    """Return the z at which one grown shape ends above a place that it holds, metres."""
    match kind:
        case GrownBoxes():
            return float(kind.grown_high[which, 2])
        case GrownCylinders() | GrownPrisms():
            return float(kind.grown_high[which])
        case GrownSpheres():
            centre, radius = kind.centre[which], kind.grown_radius[which]
            return float(centre[2] + np.sqrt(max(radius**2 - np.sum((place[:2] - centre[:2]) ** 2), 0.0)))
    raise TypeError(f"{type(kind).__name__} has no top")


def parts_of_flight(
    world: RefereeWorld, uav: int, target: int | None, b: Floats, error: Floats
) -> list[tuple[RefereeWorld, slice]]:
    """Cut the pieces of a flight where it leaves and enters its columns, and say in which worlds each part is judged.

    A part in a column is judged twice: without the error among everything, and with it among what is not exempt.

    Parameters
    ----------
    world
        For the nominal position of the UAV.
    uav, target
        The indices of the UAV, and of its target, ``None`` where it has none.
    b, error
        (n, degree + 1, 3) coefficients of the pieces, metres, and (n,) bounds on their errors.
    """
    columns = columns_of(world, uav, target)
    count = len(b)
    rise = descent = 0
    if columns.start is not None:
        rise = _leading(columns.start.holds(b, error))
    if columns.target is not None:
        descent = min(_leading(columns.target.holds(b, error)[::-1]), count - rise)
    cuts = slice(0, rise), slice(rise, count - descent), slice(count - descent, count)
    held = columns.start, None, columns.target
    parts = [
        (judged_in, part)
        for part, column in zip(cuts, held, strict=True)
        for judged_in in ([world] if column is None else [world.nominal, column.beside])
    ]
    return [(judged_in, part) for judged_in, part in parts if part.start < part.stop]


class Columns(NamedTuple):
    """The columns over a UAV's start and its target, ``None`` where there is none."""

    start: Column | None
    target: Column | None

    @property
    def sentence(self) -> str:
        """What a certificate says of them, to be added to a sentence; empty where there are none."""
        named = [
            f"over its {noun} up to z = {column.top:.6g} m"
            for noun, column in (("start", self.start), ("target", self.target))
            if column is not None
        ]
        told = " and in that ".join(named)
        return f"; only in the column {told} that error does not count for the ground and roofs below" if named else ""


def columns_of(world: RefereeWorld, uav: int, target: int | None) -> Columns:
    """Return the columns over a UAV's start and its target, if it has one."""
    scenario = world.scenario
    over = None if target is None else column_over(world, uav, np.array(scenario.targets[target].position))
    return Columns(column_over(world, uav, np.array(scenario.uavs[uav].start)), over)


def _leading(held: NDArray[np.bool_]) -> int:
    """Return how many of the first of some are true in a row."""
    return len(held) if held.all() else int(np.argmin(held))
