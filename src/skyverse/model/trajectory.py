"""A motion along a path: position, velocity, acceleration, and where nose and camera point, as functions of time."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.model.arrays import ArrayRecord, FloatArray, arctan2, instants_of
from skyverse.model.quantities import Point
from skyverse.model.short_lines import as_lines, counted, told_point, told_seconds


class Heading(NamedTuple):
    """Yaw (rad, counterclockwise from east), its rate (rad/s) and the camera's pitch (rad), at m instants, (m,) each.

    The pitch is that of the line of sight above the horizon: 0 level, and -pi/2 straight down.
    """

    yaw: Floats
    yaw_rate: Floats
    pitch: Floats


@dataclass(frozen=True, eq=False)
class Pointing(ArrayRecord):
    """The yaw of a UAV: turns, each spread over some seconds about its instant, so that the yaw rate is continuous.

    The yaw is the sum of the turns before an instant, averaged over a window of `spread` seconds, and that average
    over a window of `rise` seconds. So the yaw rate is at most the sum of the turns within one spread, divided by it.

    Attributes
    ----------
    yaw
        At the beginning, rad, counterclockwise from east.
    instants, turns
        (n,) seconds, rising, and the turns about them, (n,) rad, positive to the left.
    spread, rise
        The windows, seconds.
    look_at
        x, y, z in metres, where nose and camera point; ``None`` where the nose follows the course and the camera looks
        ahead.
    """

    yaw: float
    instants: FloatArray
    turns: FloatArray
    spread: float
    rise: float
    look_at: Point | None = None

    def retimed(self, begin: float, start: float, factor: float) -> "Pointing":
        """Return the same turns in a flight that begins at `start`, not `begin`, and is `factor` times as long."""
        instants = start + (self.instants - begin) * factor
        return replace(self, instants=instants, spread=self.spread * factor, rise=self.rise * factor)

    def parted(self, t: float) -> tuple["Pointing", "Pointing"]:
        """Return the turns that have ended by an instant, and the same yaw from then on, without these turns."""
        ended = self.instants + 0.5 * (self.spread + self.rise) <= t
        yaw = self.yaw + float(np.sum(self.turns[ended]))
        past = replace(self, instants=self.instants[ended], turns=self.turns[ended])
        return past, replace(self, yaw=yaw, instants=self.instants[~ended], turns=self.turns[~ended])

    @cached_property
    def corners(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Instants between which the yaw rate is linear, (4 n,) seconds, rising; yaw, its rate, and the slope of that.

        Each turn adds a trapezoid to the yaw rate: up in `rise` seconds, level, and down in `rise` seconds.
        """
        half, flat = 0.5 * (self.spread + self.rise), 0.5 * (self.spread - self.rise)
        corners = (self.instants[:, None] + np.array([-half, -flat, flat, half])).ravel()
        bends = ((self.turns / (self.spread * self.rise))[:, None] * np.array([1.0, -1.0, -1.0, 1.0])).ravel()
        order = np.argsort(corners, kind="stable")
        t, slopes = corners[order], np.cumsum(bends[order])
        gaps = np.diff(t, prepend=t[:1])
        before = np.r_[0.0, slopes[:-1]][: len(t)]
        rates = np.cumsum(before * gaps)
        yaws = self.yaw + np.cumsum((rates - 0.5 * before * gaps) * gaps)
        return t, yaws, rates, slopes

    def at(self, t: Floats, position: Floats) -> Heading:
        """Return where nose and camera point at instants (m,), seconds, from positions (m, 3), metres."""
        yaw, rate, pitch = np.full(len(t), self.yaw), np.zeros(len(t)), np.zeros(len(t))
        corners, yaws, rates, slopes = self.corners
        last = np.searchsorted(corners, t, side="right") - 1
        begun = last >= 0
        last = last[begun]
        later = np.where(last < len(corners) - 1, t[begun] - corners[last], 0.0)  # after the last turn it stays
        yaw[begun] = yaws[last] + (rates[last] + 0.5 * slopes[last] * later) * later
        rate[begun] = np.where(last < len(corners) - 1, rates[last] + slopes[last] * later, 0.0)
        if self.look_at is not None:
            way = np.array(self.look_at) - position
            pitch = arctan2(way[:, 2], np.hypot(way[:, 0], way[:, 1]))
        return Heading(yaw, rate, pitch)


def spread_turns(
    instants: Floats, turns: Floats, max_rate: float, max_acceleration: float, shortest: float
) -> tuple[float, float]:
    """Return the windows over which turns are to be spread, seconds, so that rate and acceleration keep their limits.

    Parameters
    ----------
    instants, turns
        As of `Pointing`.
    max_rate, max_acceleration
        The largest yaw rate, rad/s, and its largest rate of change, rad/s^2.
    shortest
        The least spread, seconds.
    """
    spread, sums = shortest, np.r_[0.0, np.cumsum(turns)]
    while True:
        edges = np.sort(np.r_[instants, instants - spread])  # where a turn leaves a window as it slides, or enters it
        begins = np.r_[edges, 0.5 * (edges[1:] + edges[:-1])]
        first = np.searchsorted(instants, begins, side="left")
        last = np.searchsorted(instants, begins + spread, side="right")
        rate = float(np.abs(sums[last] - sums[first]).max(initial=0.0)) / spread
        rise = max(2.0 * rate / max_acceleration, 0.1 * shortest)
        if rate <= max_rate and rise <= spread:
            return spread, rise
        spread *= 1.1


def wrapped(angle: Floats) -> Floats:
    """Return angles between -pi and pi, rad."""
    turned: Floats = (angle + math.pi) % (2.0 * math.pi) - math.pi
    return turned


Form = Literal["blended", "smooth", "slowed", "straightened", "stop-and-go", "dubins"]


SAME_INSTANT = 1e-9
"""Seconds beyond its ends at which a trajectory still moves, since instants are rounded."""


class Motion(NamedTuple):
    """Position (m), velocity (m/s) and acceleration (m/s^2) at m instants, (m, 3) each."""

    position: Floats
    velocity: Floats
    acceleration: Floats


@dataclass(frozen=True, eq=False)
class Trajectory(ArrayRecord):
    """Position, velocity and acceleration as functions of time: polynomial pieces between knots.

    Attributes
    ----------
    knots
        (n + 1,) seconds, strictly increasing.
    coefficients
        (n, degree + 1, 3) metres; piece k is the sum over j of ``coefficients[k, j] * (t - knots[k])**j``.
    form
        How it is flown: ``"blended"``, along straight legs with blends at the bends; ``"smooth"``, along a spline;
        ``"slowed"`` or ``"straightened"``, which are smooth too, but slower or along other curves than first planned;
        ``"stop-and-go"``, at rest at every waypoint; ``"dubins"``, for an aeroplane.
    note
        Says why the form is not the one that was asked for, and how far the nose is off a place to look at; else empty.
    pointing
        Where the UAV's nose and camera point; ``None`` in files of older versions, whose UAVs keep their noses east.
    """

    knots: FloatArray
    coefficients: FloatArray
    form: Form = "stop-and-go"
    note: str = ""
    pointing: Pointing | None = None

    def __repr__(self) -> str:
        ends = self.at([self.start, self.end]).position
        pieces, degree = len(self.coefficients), self.coefficients.shape[1] - 1
        return as_lines(
            f"Trajectory: {self.form}, {told_seconds(self.duration)} long, "
            f"from t = {told_seconds(self.start)} to t = {told_seconds(self.end)}",
            f"from {told_point(ends[0])} to {told_point(ends[1])}, "
            f"in {counted(pieces, 'polynomial piece')} of degree {degree}",
            self.note,
        )

    @property
    def start(self) -> float:
        """The first instant, seconds."""
        return float(self.knots[0])

    @property
    def end(self) -> float:
        """The last instant, seconds."""
        return float(self.knots[-1])

    @property
    def duration(self) -> float:
        """The seconds from the first instant to the last one."""
        return self.end - self.start

    def instants(self, count: int, begin: float = -math.inf, end: float = math.inf) -> Floats:
        """Return instants (n,), seconds, that share each piece between two into `count` equal parts, both included."""
        begin, end = max(begin, self.start), min(end, self.end)
        ends = np.r_[begin, self.knots[(self.knots > begin) & (self.knots < end)], end]
        return np.r_[(ends[:-1, None] + np.diff(ends)[:, None] * (np.arange(count) / count)).ravel(), end]

    def retimed(self, start: float, factor: float = 1.0) -> "Trajectory":
        """Return the same motion, beginning at the instant `start` and taking `factor` times as long.

        A blended or smooth trajectory that becomes slower gets the form ``"slowed"``.
        """
        if start == self.start and factor == 1.0:
            return self
        powers = np.vander([factor], self.coefficients.shape[1], increasing=True)[0]
        return replace(
            self,
            knots=start + (self.knots - self.start) * factor,
            coefficients=self.coefficients / powers[:, None],
            pointing=None if self.pointing is None else self.pointing.retimed(self.start, start, factor),
            form="slowed" if factor > 1.0 and self.form in ("blended", "smooth") else self.form,
        )

    def at(self, t: ArrayLike) -> Motion:
        """Evaluate at instants `t`, (m,) seconds; before `start` and after `end` the UAV stands still.

        Raises
        ------
        InputError
            If `t` is not one instant or a row of instants.
        """
        instants = instants_of(t)
        clipped = np.clip(instants, self.start, self.end)
        piece = np.clip(np.searchsorted(self.knots, clipped, side="right") - 1, 0, len(self.coefficients) - 1)
        local = (clipped - self.knots[piece])[:, None]
        rows = self.coefficients[piece]
        motion = []
        for _ in range(3):
            value = np.zeros((len(clipped), 3))
            for j in range(rows.shape[1] - 1, -1, -1):
                value = value * local + rows[:, j]
            motion.append(value)
            powers = np.arange(rows.shape[1], dtype=np.float64)
            rows = (rows * powers[None, :, None])[:, 1:] if rows.shape[1] > 1 else np.zeros_like(rows)
        holding = (instants < self.start - SAME_INSTANT) | (instants > self.end + SAME_INSTANT)
        motion[1][holding] = 0.0
        motion[2][holding] = 0.0
        return Motion(*motion)

    def heading(self, t: ArrayLike) -> Heading:
        """Return where the UAV's nose and camera point at instants `t`, (m,) seconds."""
        instants = instants_of(t)
        if self.pointing is None:
            return Heading(*np.zeros((3, len(instants))))
        return self.pointing.at(instants, self.at(instants).position)


def joined(parts: Sequence[Trajectory]) -> Trajectory:
    """Return trajectories one after another as one, which begins when the first of them does.

    Each must begin where the one before ends, with the same velocity and acceleration. Form and note are those of the
    first.
    """
    degree = max(part.coefficients.shape[1] for part in parts)
    rows = [np.pad(part.coefficients, ((0, 0), (0, degree - part.coefficients.shape[1]), (0, 0))) for part in parts]
    knots = [parts[0].knots]
    for part in parts[1:]:
        knots.append(knots[-1][-1] + (part.knots[1:] - part.knots[0]))
    return replace(parts[0], knots=np.concatenate(knots), coefficients=np.concatenate(rows))


@dataclass(frozen=True, eq=False)
class TimedPath:
    """Straight pieces of a path, with the earliest and the latest time at which a UAV may be on each.

    Along a piece, both times and the deviation change linearly with the share of its length. A piece whose ends are at
    one place is a stay there.

    Attributes
    ----------
    starts, ends
        (n, 3) metres: the ends of each piece.
    earliest, latest
        (n, 2) seconds at the start and at the end of each piece; the latest may be infinite.
    deviation
        (n, 2) metres: how far the UAV may be from the piece at its start and at its end, because it cuts a corner.
    """

    starts: Floats
    ends: Floats
    earliest: Floats
    latest: Floats
    deviation: Floats
