"""A motion along a path: position, velocity and acceleration as functions of time."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.model.arrays import ArrayRecord, FloatArray, instants_of
from skyverse.model.pointing import Heading, Pointing
from skyverse.model.short_lines import as_lines, counted, told_point, told_seconds

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
