"""Judges whether UAVs fly no faster through the air than they can, at every instant, in the stated wind and its gusts.

With the velocity v over ground, the wind w(z) at the altitude flown and the gust g, a multirotor's airspeed is at most
``|v - w(z)| + g``. An aeroplane, which holds its speed over ground, flies in a wind of at most ``|w(z)| + g``.
"""

import math
from typing import NamedTuple, Self

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.model.verdict import Fault, Violation
from skyverse.model.wind import Wind, told_wind
from skyverse.referee.curve import PolynomialCurve, derivative
from skyverse.referee.judgement import Judgement, position_text, position_tuple
from skyverse.referee.polynomial import Polynomials, bernstein
from skyverse.referee.subdivision import find_peaks
from skyverse.referee.tolerances import LIMIT_LET_PASS, SUMS_ROUNDING


class _Lines(NamedTuple):
    """The wind as lines over altitude: below the first layer, between each two, and above the last.

    Attributes
    ----------
    ends
        (n,) the altitudes of the layers, in the unit `unit`.
    anchors
        (n + 1,) an altitude on each line, in the same unit.
    winds
        (n + 1, 3) the wind there, m/s.
    slopes
        (n + 1, 3) how it changes, m/s for each unit.
    unit
        Units in a metre, so many that no wind changes by more than 1 m/s in one of them; 0 where none changes.
    """

    ends: Floats
    anchors: Floats
    winds: Floats
    slopes: Floats
    unit: float

    @classmethod
    def of(cls, wind: Wind) -> Self:
        """Return the lines of a wind."""
        z, winds = wind.table
        rise = np.diff(winds, axis=0) / np.diff(z)[:, None]
        unit = float(np.linalg.norm(rise, axis=1).max(initial=0.0))
        level = np.zeros((1, 3))
        slopes = np.concatenate([level, rise / (unit or 1.0), level])
        return cls(z * unit, np.r_[z[0], z] * unit, np.concatenate([winds[:1], winds]), slopes, unit)

    def line(self, height: Floats) -> Indices:
        """Return the line on which each height is, in the unit of altitudes."""
        return np.searchsorted(self.ends, height, side="right")

    def on(self, line: Indices, height: Floats) -> Floats:
        """Return the winds, (..., 3) m/s, that lines have at heights."""
        return self.winds[line] + self.slopes[line] * (height - self.anchors[line])[..., None]

    def off(self, line: Indices, low: Floats, high: Floats) -> Floats:
        """Return how far the wind is from lines, at most, at heights between others, (m,) m/s."""
        bends = [low, high, *(np.clip(end, low, high) for end in self.ends)]  # between these it changes linearly
        gaps = [np.linalg.norm(self.at(height) - self.on(line, height), axis=1) for height in bends]
        return np.max(gaps, axis=0)

    def at(self, height: Floats) -> Floats:
        """Return the winds, (m, 3) m/s, at heights."""
        return self.on(self.line(height), height)


def judge_wind(scenario: Scenario, uav: int, curve: PolynomialCurve) -> Judgement:
    """Judge whether UAV number `uav` flies no faster through the air than it can, or in no more wind."""
    vehicle, wing = scenario.uavs[uav], scenario.uavs[uav].fixed_wing
    if scenario.wind is None and (wing is not None or vehicle.max_airspeed is None):
        return Judgement([])
    wind = scenario.wind or Wind(velocity=(0.0, 0.0, 0.0))
    lines, moves, top = _Lines.of(wind), 1.0 if wing is None else 0.0, vehicle.max_wind
    most = top * (1 + LIMIT_LET_PASS) - wind.gust
    velocity = bernstein(derivative(curve.pieces), curve.durations)
    altitude = bernstein(curve.pieces, curve.durations)[2] * lines.unit
    columns = [part.raised(altitude.degree) for part in velocity] + [altitude]
    b = np.stack([part.b for part in columns], axis=2)

    def excess(part: Floats, _: Indices) -> Floats:
        height = part[:, :, 3]
        low, high = height.min(axis=1), height.max(axis=1)
        line = lines.line((low + high) / 2)
        through_air = moves * part[:, :, :3] - lines.on(line[:, None], height)
        return np.linalg.norm(through_air, axis=2).max(axis=1) + lines.off(line, low, high) - most

    peaks = find_peaks(b, _error(columns, lines, most), excess)
    halvings = int(peaks.halvings[0])
    if peaks.proven[0]:
        return Judgement([], halvings)
    piece, share = peaks.place()
    time = float(curve.knots[piece] + share * curve.durations[piece])
    motion = curve.motion(piece, share * float(curve.durations[piece]))
    height = motion[:1, 2] * lines.unit
    blows = lines.at(height)[0]
    reached = math.hypot(*(moves * motion[1] - blows)) + wind.gust
    at = f"at t = {time:.6g} s, position {position_text(motion[0])}"
    where = (time, position_tuple(motion[0]))
    if reached > top * (1 + LIMIT_LET_PASS):
        gusts = f" with gusts of {wind.gust:.6g} m/s" if wind.gust else ""
        deed = f"flies at up to {reached:.7g} m/s through the air" if wing is None else "holds its speed over ground"
        of = "of" if wing is None else f"{reached:.7g} m/s, of"
        message = f"{vehicle.name} {deed} in a wind of {told_wind(blows)}{gusts} ({of} {top:.7g}) {at}."
        return Judgement([Violation(Fault.WIND, (uav,), message, *where)], halvings)
    message = f"Whether {vehicle.name} flies too fast through the air could not be decided {at}."
    return Judgement([Violation(Fault.UNDECIDED, (uav,), message, *where)], halvings)


def _error(columns: list[Polynomials], lines: _Lines, most: float) -> Floats:
    """Return bounds, (n,) m/s, on what rounding makes of the excess over the most on pieces."""
    sizes = [column.size for column in columns]
    largest = np.max(sizes, axis=0) + np.abs(lines.winds).max() + np.abs(lines.ends).max() + abs(most)
    return np.sum([column.error for column in columns], axis=0) + SUMS_ROUNDING * largest
