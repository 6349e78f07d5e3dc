"""The columns over a UAV's own start and target, in which its nominal position alone must keep the clearance.

A UAV that stands on the ground or on a roof is nearer to it than its clearance and its tracking error. So it is exempt
from the error, not from the clearance, where it flies straight up from its start or straight down to its target, as
high as the lowest place from which it may stray.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.referee.boxes import GrownBoxes
from skyverse.referee.ground import GrownGround
from skyverse.referee.prisms import GrownPrisms
from skyverse.referee.round_solids import GrownCylinders, GrownSpheres
from skyverse.referee.solids import GrownSolids
from skyverse.referee.tolerances import COLUMN_SLACK, LET_PASS
from skyverse.referee.tube import EXACT
from skyverse.referee.world import RefereeWorld

MAX_EXITS = 1000
"""Shapes one above another through which a column is followed at most."""


class Column(NamedTuple):
    """A vertical line from a start or target up: where it begins, (3,) metres, and the z where it ends."""

    foot: Floats
    top: float

    def holds(self, b: Floats, error: Floats) -> NDArray[np.bool_]:
        """Tell which pieces, (n, degree + 1, 3) coefficients and (n,) bounds on their errors, are in the column."""
        beside = np.abs(b[:, :, :2] - self.foot[:2]).max(axis=(1, 2))
        low, high = b[:, :, 2].min(axis=1), b[:, :, 2].max(axis=1)
        held: NDArray[np.bool_] = (beside + error <= LET_PASS) & (low + error >= self.foot[2] - LET_PASS)
        return held & (high - error <= self.top + COLUMN_SLACK)


def column_over(world: RefereeWorld, uav: int, place: Floats) -> Column | None:
    """Return the column over a UAV's start or target, (3,) metres; ``None`` if the UAV may stray from there.

    There is none for an aeroplane either, nor where the UAV can stray from no place above.
    """
    if world.error == EXACT or world.scenario.uavs[uav].fixed_wing is not None:
        return None
    top = place.copy()
    for _ in range(MAX_EXITS):
        above = _exit_above(world, top)
        if above is None:
            return Column(place, float(top[2])) if top[2] > place[2] else None
        if not above <= world.high[2]:
            return None
        top[2] = max(above, np.nextafter(top[2], np.inf) + LET_PASS / 2)
    return None


def _exit_above(world: RefereeWorld, place: Floats) -> float | None:
    """Return the z at which the highest of all that holds a place ends above it; ``None`` if nothing holds it."""
    found = [float(world.low[2])] if place[2] < world.low[2] else []
    for kind in (world.boxes, *world.others):
        for pairs in kind.tree.overlapping(place[None], place[None]):
            which = pairs[:, 1]
            inside = which[kind.depth(np.broadcast_to(place, (len(which), 1, 3)), which) > 0]
            found += [_top(kind, int(shape), place) for shape in inside]
    return max(found, default=None)


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
        case GrownGround():
            return float(place[2] + kind.depth(place[None, None], np.array([which]))[0])
    return float("inf")  # the ceiling does not end


def parts_of_flight(
    world: RefereeWorld, uav: int, target: int | None, b: Floats, error: Floats
) -> list[tuple[RefereeWorld, slice]]:
    """Cut the pieces of a flight where it leaves and enters its columns, and say in which world each part is judged.

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
    parts = [
        (world.nominal, slice(0, rise)),
        (world, slice(rise, count - descent)),
        (world.nominal, slice(count - descent, count)),
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
        return f", but without that in the column {' and in that '.join(named)}" if named else ""


def columns_of(world: RefereeWorld, uav: int, target: int | None) -> Columns:
    """Return the columns over a UAV's start and its target, if it has one."""
    scenario = world.scenario
    over = None if target is None else column_over(world, uav, np.array(scenario.targets[target].position))
    return Columns(column_over(world, uav, np.array(scenario.uavs[uav].start)), over)


def _leading(held: NDArray[np.bool_]) -> int:
    """Return how many of the first of some are true in a row."""
    return len(held) if held.all() else int(np.argmin(held))
