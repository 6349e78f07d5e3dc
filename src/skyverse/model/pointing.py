"""Where a UAV's nose and camera point during a flight."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.arrays import ArrayRecord, FloatArray, arctan2
from skyverse.model.quantities import Point


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
