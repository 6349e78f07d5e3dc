"""The one search for routes along strips: who flies which strips, in which order and direction, in which rows.

An iterated local search in compiled code, whose kicks exchange neighbouring parts of a row (double bridges; Martin,
Otto and Felten 1991), or parts near one another in two rows.
"""

import math

import numpy as np
from numpy.random import Generator

from skyverse._typing import Bools, Floats, Ints
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import GAIN_ROUNDING
from skyverse.survey.strip_changes import best_change, exchange
from skyverse.survey.strip_fleet import StripFleet, StripRows, measure, strip_rows

_KICK = 30
"""The most strips of each of the two parts that a kick exchanges."""
_NEARBY = 8
"""Strips of other rows of which a kick takes the nearest."""
_TRIES = 100
"""Draws until there is a kick at the latest."""
_SPREAD = 4
"""The most strips of each of two parts of different rows that a kick exchanges."""


class StripSearch:
    """A search that begins with all strips on the ground, and goes on each time that it is asked to.

    Attributes
    ----------
    fleet
        The numbers of the search.
    """

    def __init__(self, fleet: StripFleet, rng: Generator) -> None:
        n = len(fleet.partner)
        line = np.r_[np.full(len(fleet.owner), n), np.flatnonzero(np.arange(n) <= fleet.partner)]
        self.fleet = fleet
        self._rows = strip_rows(fleet, line), strip_rows(fleet, line)
        self._value, self._rng = np.full(1, math.inf), rng

    def run(self, kicks: int) -> None:
        """Search on with so many kicks."""
        search_strips(self.fleet, *self._rows, self._value, self._rng, kicks)

    @property
    def value(self) -> float:
        """What the routes cost, with what is left on the ground."""
        return float(self._value[0])

    @property
    def tours(self) -> list[tuple[tuple[int, ...], ...]]:
        """The sorties of each vehicle that are not empty."""
        return self.fleet.tours(self._rows[0].line)


@kernel
def search_strips(
    fleet: StripFleet, rows: StripRows, trial: StripRows, values: Floats, rng: Generator, kicks: int
) -> None:
    """Change rows for the better, kick by kick, and keep what is no worse.

    Parameters
    ----------
    fleet
        The numbers of the search.
    rows, trial
        The present rows, and room for others.
    values
        (1,) of the rows, infinite at first; changed in place.
    kicks
        How many there are.
    """
    dirty = np.ones(len(fleet.partner), dtype=np.bool_)
    if values[0] == math.inf:
        values[0] = _improve(fleet, rows, trial, measure(fleet, rows), dirty)
    before, part = rows.line.copy(), np.zeros(6, dtype=np.int64)
    for _ in range(kicks):
        dirty[:] = False
        before[:] = rows.line
        if not _kick(fleet, rows, part, rng):
            return
        value = _make(fleet, rows, trial, part)
        _mark(fleet, trial.line, part, dirty)
        if value < fleet.broken:
            value = _improve(fleet, rows, trial, value, dirty)
        if value <= values[0]:
            values[0] = value
        else:
            rows.line[:] = before
            measure(fleet, rows)


@inner
def _make(fleet: StripFleet, rows: StripRows, trial: StripRows, part: Ints) -> float:
    """Make a change, keep the line before it in `trial`, and return the value."""
    exchange(fleet, rows.line, trial.line, part)
    for at in range(len(rows.line)):
        rows.line[at], trial.line[at] = trial.line[at], rows.line[at]
    return measure(fleet, rows)


@inner
def _mark(fleet: StripFleet, line: Ints, part: Ints, dirty: Bools) -> None:
    """Mark the strips of a line beside which it is changed."""
    for at in (part[0] - 1, part[0], part[1], part[1] + 1, part[3] - 1, part[3], part[4], part[4] + 1):
        if at < len(line) and line[at] < len(fleet.partner):
            dirty[line[at]] = dirty[fleet.partner[line[at]]] = True


@inner
def _kick(fleet: StripFleet, rows: StripRows, part: Ints, rng: Generator) -> bool:
    """Write down a random exchange of two neighbouring parts of a row, or of parts near one another in two rows."""
    n, count, ground = len(fleet.partner), len(rows.line), rows.first[len(fleet.owner) - 1]
    part[2] = part[5] = 0
    for _ in range(_TRIES):
        i = int(rng.random() * ground)
        row, k, nearest, longest = rows.row[i], -1, math.inf, _KICK
        if rows.line[i] == n:
            continue
        last = rows.first[row + 1] - 1
        j = i + int(rng.random() * min(_KICK, last - i))
        if len(fleet.owner) > 2 and rng.random() < 0.5:
            longest = _SPREAD
            j = min(i + int(rng.random() * _SPREAD), last)
            for _near in range(_NEARBY):
                at = int(rng.random() * count)
                if rows.line[at] < n and rows.row[at] != row and fleet.cost[0, rows.line[i], rows.line[at]] < nearest:
                    nearest, k = fleet.cost[0, rows.line[i], rows.line[at]], at
        elif j < last:
            k = j + 1
        if k >= 0:
            part[0], part[1], part[3] = i, j, k
            part[4] = min(k + int(rng.random() * longest), rows.first[rows.row[k] + 1] - 1)
            return True
    return False


@inner
def _improve(fleet: StripFleet, rows: StripRows, trial: StripRows, value: float, dirty: Bools) -> float:
    """Change rows while that saves anything beside strips that are dirty, and return their value."""
    n, looking, part = len(fleet.partner), True, np.zeros(6, dtype=np.int64)
    while looking:
        looking = False
        for p in range(len(rows.line)):
            node = rows.line[p]
            if node >= n or not dirty[node]:
                continue
            part[0] = 0
            best_change(fleet, rows, trial, p, value, part)
            after = value
            if part[0]:
                after = _make(fleet, rows, trial, part)
                if after >= value - GAIN_ROUNDING * abs(value):
                    rows.line[:] = trial.line
                    measure(fleet, rows)
            if after >= value - GAIN_ROUNDING * abs(value):
                dirty[node] = dirty[fleet.partner[node]] = False
                continue
            looking, value = True, after
            _mark(fleet, trial.line, part, dirty)
    return value
