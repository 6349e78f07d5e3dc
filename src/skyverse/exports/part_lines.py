"""Collects the lines that stand for returns from parts of a flight, with how far the UAV may be off each."""

from typing import NamedTuple, TypedDict

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.exports.return_lines import Ground, ReturnLines, joined
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import LEG_ALLOWANCE
from skyverse.space.tube import NO_ERROR


class Deviation(NamedTuple):
    """How far a UAV may be off lines, (m,) metres each.

    Attributes
    ----------
    growth, aside, above
        From a line that stands for a part of the flight: in any direction, to the side, and up and down.
    bent_aside, bent_above
        The same from the line of the place in the part from which it returns.
    """

    growth: Floats
    aside: Floats
    above: Floats
    bent_aside: Floats
    bent_above: Floats


class _Begins(TypedDict):
    whole: bool
    on_path: bool
    lax: tuple[float, float]


class PartLines:
    """Lines for parts of a flight, (m,) numbers of parts, which lie in boxes (m, 3), of a UAV with a tracking error.

    Lines that begin `on_path` begin where the UAV is when it is called back, which may be off its path by the error:
    then it may be beside them by as much again. It does not climb from lower than it was, however it strays.
    """

    def __init__(self, part: NDArray[np.intp], low: Floats, high: Floats, error: TrackingError) -> None:
        self.part, self.low, self.high, self.error = part, low, high, error
        self.found: list[tuple[ReturnLines, NDArray[np.intp]]] = []

    def add(
        self,
        starts: Floats,
        ends: Floats,
        off: Deviation,
        some: NDArray[np.bool_],
        *,
        ground: Ground = Ground.RULES,
        strays: bool = True,
        whole: bool = True,
        on_path: bool = False,
        roof: float | Floats = -np.inf,
        lax: tuple[float, float] | Floats = (0.0, 0.0),
    ) -> None:
        """Add lines between starts and ends, (m, 3) metres, but only `some` of them; `lax` is as in `ReturnLines`.

        Where they lead from the `whole` part of the flight, they lie within the bounds as far as the part does.
        """
        low, high = np.minimum(starts, ends), np.maximum(starts, ends)
        if whole:  # below, the flight itself is proven to be within bounds
            low[:, :2], high = np.minimum(low, self.low)[:, :2], np.maximum(high, self.high)
        beside, upright = (np.maximum(one - LEG_ALLOWANCE, 0.0) for one in off[3:])
        off_path = self.error.horizontal * on_path
        beside = beside + off_path
        reach = np.column_stack([beside, beside, upright])
        counts, errs = np.full(len(some), int(ground)), np.full(len(some), strays)
        roofs = np.broadcast_to(roof, some.shape)
        accepts = np.broadcast_to(lax, (len(some), 2)) + np.array([off_path, 0.0])
        lines = ReturnLines(starts, ends, *off[:3], low - reach, high + reach, counts, errs, roofs, accepts)
        self.found.append((lines.of(some), self.part[some]))

    def add_in_column(
        self,
        starts: Floats,
        ends: Floats,
        off: Deviation,
        some: NDArray[np.bool_],
        roof: Floats,
        *,
        ground: Ground = Ground.RULES,
        whole: bool = True,
        on_path: bool = False,
        lax: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Add lines that are in a column over roofs, (m,) metres: without the error, and with it but for the roofs.

        Neither the error nor `lax` counts for the ground.
        """
        self.add(starts, ends, off, some, ground=ground, strays=False, whole=whole)
        if lax != (0.0, 0.0):
            self.add(starts, ends, off, some, ground=Ground.NONE, strays=False, whole=whole, lax=lax)
        if self.error != NO_ERROR:
            self.add(starts, ends, off, some, ground=Ground.NONE, whole=whole, on_path=on_path, roof=roof, lax=lax)

    def descend(
        self,
        above: Floats,
        top: Floats,
        below: Floats,
        off: Deviation,
        some: NDArray[np.bool_],
        *,
        on_path: bool = False,
        lax: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Add vertical lines under places (m, 3) that are at z = `top`.

        `below`, (4, m) metres, are z of the tops of columns, z down to which lines keep above ground, and among
        obstacles, and z of the roofs of the columns.
        """
        *ends, roof = below
        levels = [top, *(np.minimum(level, top) for level in ends)]
        first, second, third, last = (np.column_stack([above[:, :2], level]) for level in levels)
        how: _Begins = {"whole": on_path, "on_path": on_path, "lax": lax}
        ground = Ground.NEAR if on_path else Ground.RULES
        self.add(first, second, off, some & (levels[0] > levels[1]), ground=ground, **how)
        self.add_in_column(second, third, off, some & (levels[1] > levels[2]), roof, ground=ground, **how)
        under = some & (levels[2] > levels[3])
        self.add_in_column(third, last, off, under, roof, ground=Ground.NONE, **how)

    def made(self) -> tuple[ReturnLines, NDArray[np.intp]]:
        """Return the lines that were added, and the part of each."""
        lines, parts = zip(*self.found, strict=True)
        return joined(lines), np.concatenate(parts)
