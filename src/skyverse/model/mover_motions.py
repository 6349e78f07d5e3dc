"""How the point that a mover is drawn about moves, and how fast it ever is: along waypoints, polynomials, or a curve.

Every motion is defined at all instants: before its first and after its last instant the point stands still, unless the
motion repeats. Lengths are in metres, times in seconds.
"""

import math
from functools import lru_cache
from itertools import pairwise
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Discriminator, Field, Tag, model_validator

from skyverse._typing import Floats
from skyverse.model.arrays import instants_of
from skyverse.model.quantities import MAX_INSTANT, Instant, Model, Number, Point, Positive, named_type

LEAST_PERIOD = 0.01
"""Seconds: no mover turns back, or round, in less."""
Seconds = Annotated[Positive, Field(ge=LEAST_PERIOD, le=MAX_INSTANT)]
"""The period of a motion."""


def _require_rising(name: str, instants: tuple[float, ...]) -> None:
    for k, (before, after) in enumerate(pairwise(instants), 1):
        if not before < after:
            raise ValueError(f"{name} must rise, but {name}[{k}] is {after:g} s after {before:g} s")


class WaypointMotion(Model):
    """Straight from waypoint to waypoint, each at its instant.

    Attributes
    ----------
    points
        x, y, z of at least one waypoint, metres.
    times
        The instant of each, seconds into the mission, rising.
    then
        What follows the last one: the mover ``"stays"`` there; it ``"repeats"`` the motion from the first waypoint,
        which must be the last one too; or it ``"returns"`` the way that it came, and so on, back and forth.
    """

    motion: Literal["waypoints"] = "waypoints"
    points: Annotated[tuple[Point, ...], Field(min_length=1)]
    times: tuple[Instant, ...]
    then: Literal["stays", "repeats", "returns"] = "stays"

    @model_validator(mode="after")
    def _sound(self) -> Self:
        if len(self.points) != len(self.times):
            raise ValueError(f"times must be as many as points, {len(self.points)}, but they are {len(self.times)}")
        _require_rising("times", self.times)
        if self.then != "stays" and len(self.points) < 2:
            raise ValueError(f"a motion that {self.then} needs two points or more")
        if self.then != "stays" and self.times[-1] - self.times[0] < LEAST_PERIOD:
            span = f"{LEAST_PERIOD:g} s or more, but they span {self.times[-1] - self.times[0]:.3g} s"
            raise ValueError(f"times of a motion that {self.then} must span {span}")
        if self.then == "repeats" and self.points[0] != self.points[-1]:
            raise ValueError("a motion that repeats must end where it begins, but the last point is not the first one")
        return self

    def at(self, instants: ArrayLike) -> Floats:
        """Return the positions (m, 3), metres, at instants (m,), seconds into the mission."""
        t = instants_of(instants)
        times, points = np.array(self.times), np.array(self.points)
        length = times[-1] - times[0]
        since = t - times[0]
        if self.then == "repeats":
            since = np.where(since > 0, since % length, since)
        elif self.then == "returns":
            since = np.where(since > 0, length - np.abs(since % (2 * length) - length), since)
        return np.column_stack([np.interp(since, times - times[0], points[:, axis]) for axis in range(3)])


class CircularMotion(Model):
    """Round a horizontal circle, for ever.

    Attributes
    ----------
    centre, radius
        Metres.
    period
        Seconds for one turn.
    bearing
        Where on the circle it is at 0 s: degrees clockwise from north, seen from its centre.
    clockwise
        Which way it goes round, seen from above.
    """

    motion: Literal["circle"] = "circle"
    centre: Point
    radius: Positive
    period: Seconds
    bearing: Number = 0.0
    clockwise: Annotated[bool, Field(strict=True)] = False

    def at(self, instants: ArrayLike) -> Floats:
        """Return the positions (m, 3), metres, at instants (m,), seconds into the mission."""
        return self.as_periodic.at(instants)

    @property
    def as_periodic(self) -> "PeriodicMotion":
        """The same motion as a sum of sines and cosines."""
        angle, r = math.radians(self.bearing), self.radius
        east, north, turn = r * math.sin(angle), r * math.cos(angle), 1.0 if self.clockwise else -1.0
        return PeriodicMotion(
            centre=self.centre,
            period=self.period,
            cosine=((east, north, 0.0),),
            sine=((turn * north, -turn * east, 0.0),),
        )


class PeriodicMotion(Model):
    """A closed curve: the centre, and the sum over k = 1, 2, ... of c_k cos(2 pi k t / T) + s_k sin(2 pi k t / T).

    Attributes
    ----------
    centre
        Metres.
    period
        T, seconds.
    cosine, sine
        c_k and s_k, x, y, z in metres; as many of one as of the other.
    """

    motion: Literal["periodic"] = "periodic"
    centre: Point
    period: Seconds
    cosine: Annotated[tuple[Point, ...], Field(min_length=1, max_length=32)]
    sine: Annotated[tuple[Point, ...], Field(min_length=1, max_length=32)]

    @model_validator(mode="after")
    def _as_many(self) -> Self:
        if len(self.cosine) != len(self.sine):
            raise ValueError(f"sine must have as many terms as cosine, {len(self.cosine)}, but it has {len(self.sine)}")
        return self

    def at(self, instants: ArrayLike) -> Floats:
        """Return the positions (m, 3), metres, at instants (m,), seconds into the mission."""
        t = instants_of(instants)
        turns = (t / self.period) % 1.0
        angle = 2.0 * np.pi * turns[:, None] * np.arange(1, len(self.cosine) + 1)
        waves, terms = np.hstack([np.cos(angle), np.sin(angle)]), np.vstack([self.cosine, self.sine])
        return np.einsum("ij,jk->ik", waves, terms) + self.centre


class PolynomialMotion(Model):
    """Along polynomial pieces between knots, as a trajectory.

    Attributes
    ----------
    knots
        Two instants or more, seconds into the mission, rising.
    coefficients
        For each piece, the x, y, z of its coefficients, metres: piece k is the sum over j of
        ``coefficients[k][j] * (t - knots[k])**j``. Where one piece ends, the next one must begin.
    """

    motion: Literal["polynomials"] = "polynomials"
    knots: Annotated[tuple[Instant, ...], Field(min_length=2)]
    coefficients: tuple[Annotated[tuple[tuple[Number, Number, Number], ...], Field(min_length=1, max_length=12)], ...]

    @model_validator(mode="after")
    def _sound(self) -> Self:
        _require_rising("knots", self.knots)
        if len(self.coefficients) != len(self.knots) - 1:
            raise ValueError(
                f"coefficients must have one piece between each two of {len(self.knots)} knots, but has "
                f"{len(self.coefficients)}"
            )
        for k in range(1, len(self.coefficients)):
            ends = self._on_piece(k - 1, np.array([self.knots[k]]))[0]
            apart = float(np.abs(ends - np.array(self.coefficients[k][0])).max())
            if not apart <= MAX_JUMP:
                raise ValueError(
                    f"coefficients must not jump, but piece {k} begins {apart:g} m from where {k - 1} ends"
                )
        return self

    def at(self, instants: ArrayLike) -> Floats:
        """Return the positions (m, 3), metres, at instants (m,), seconds into the mission."""
        t = np.clip(instants_of(instants), self.knots[0], self.knots[-1])
        piece = np.clip(np.searchsorted(self.knots, t, side="right") - 1, 0, len(self.coefficients) - 1)
        places = np.empty((len(t), 3))
        for k in np.unique(piece):
            places[piece == k] = self._on_piece(int(k), t[piece == k])
        return places

    def _on_piece(self, k: int, t: Floats) -> Floats:
        value = np.zeros((len(t), 3))
        for row in self.coefficients[k][::-1]:
            value = value * (t - self.knots[k])[:, None] + np.array(row)
        return value


MAX_JUMP = 1e-6
"""Metres from where a piece ends to where the next one begins, which rounding may cause."""


MoverMotion = Annotated[
    Annotated[WaypointMotion, Tag("waypoints")]
    | Annotated[CircularMotion, Tag("circle")]
    | Annotated[PeriodicMotion, Tag("periodic")]
    | Annotated[PolynomialMotion, Tag("polynomials")],
    Discriminator(named_type("motion", "waypoints")),
]
"""Any motion; its field `motion` names the type, and a motion without it moves along waypoints."""


SAMPLES = 4097
"""Instants of a period at which a closed curve is looked at."""
SAME_VELOCITY = 1e-9
"""M/s by which the velocities on both sides of a knot may differ because of rounding."""


@lru_cache(maxsize=256)
def motion_bounds(motion: MoverMotion) -> tuple[float, float | None]:
    """Return bounds of a motion's speed and acceleration at all instants.

    Returns
    -------
    tuple
        M/s and m/s^2 that are not exceeded; ``None`` for the acceleration where the velocity changes in an instant.
    """
    match motion:
        case CircularMotion():
            return _of_closed_curve(motion.as_periodic)
        case PeriodicMotion():
            return _of_closed_curve(motion)
        case WaypointMotion():
            steps = np.diff(np.array(motion.points), axis=0)
            speeds = np.linalg.norm(steps, axis=1) / np.diff(np.array(motion.times))
            fastest = float(speeds.max(initial=0.0))
            return fastest, 0.0 if fastest == 0.0 else None
        case PolynomialMotion():
            return _of_polynomials(motion)


def _of_closed_curve(motion: PeriodicMotion) -> tuple[float, float]:
    """Return the bounds of a closed curve: the largest values at samples, and what they can change by in between."""
    cosine, sine = np.array(motion.cosine), np.array(motion.sine)
    squares, mixed = (np.sum(cosine**2, axis=1), np.sum(sine**2, axis=1)), np.sum(cosine * sine, axis=1)
    # of each ellipse the larger semi-axis: the norm of the two vectors that span it, as a matrix
    sizes = np.sqrt((squares[0] + squares[1]) / 2 + np.hypot((squares[0] - squares[1]) / 2, mixed))
    rates = 2.0 * math.pi * np.arange(1, len(sizes) + 1) / motion.period
    if len(sizes) == 1:
        return float(np.sum(sizes * rates)), float(np.sum(sizes * rates**2))
    angles = np.linspace(0.0, 2.0 * math.pi, SAMPLES)[:, None] * np.arange(1, len(sizes) + 1)
    half = 0.5 * motion.period / (SAMPLES - 1)
    c, s = np.cos(angles), np.sin(angles)
    velocity = np.einsum("ij,jk->ik", c * rates, sine) - np.einsum("ij,jk->ik", s * rates, cosine)
    acceleration = -np.einsum("ij,jk->ik", c * rates**2, cosine) - np.einsum("ij,jk->ik", s * rates**2, sine)
    fastest = np.linalg.norm(velocity, axis=1).max() + half * float(np.sum(sizes * rates**2))
    hardest = np.linalg.norm(acceleration, axis=1).max() + half * float(np.sum(sizes * rates**3))
    return float(fastest), float(hardest)


def _of_polynomials(motion: PolynomialMotion) -> tuple[float, float | None]:
    seconds, fastest, hardest = np.diff(np.array(motion.knots)), 0.0, 0.0
    before, jumps = np.zeros(3), False  # it stands before its first knot
    for given, lasts in zip(motion.coefficients, seconds, strict=True):
        rows: Floats = np.array(given)
        velocity: Floats = rows[1:] * np.arange(1, len(rows))[:, None]
        acceleration: Floats = velocity[1:] * np.arange(1, len(velocity))[:, None]
        fastest = max(fastest, _largest(velocity, lasts))
        hardest = max(hardest, _largest(acceleration, lasts))
        begins = velocity[0] if len(velocity) else np.zeros(3)
        jumps = jumps or bool(np.abs(begins - before).max() > SAME_VELOCITY)
        before = np.array([_value(velocity[:, axis], lasts) for axis in range(3)])
    jumps = jumps or bool(np.abs(before).max() > SAME_VELOCITY)  # it stands after its last knot
    return fastest, None if jumps else hardest


def _largest(rows: Floats, lasts: float) -> float:
    """Return a bound of the norm of a polynomial (k, 3) between 0 and `lasts` seconds."""
    return float(np.sum(np.linalg.norm(rows, axis=1) * np.vander([lasts], len(rows), increasing=True)[0]))


def _value(row: Floats, t: float) -> float:
    return float(np.sum(row * np.vander([t], len(row), increasing=True)[0]))
