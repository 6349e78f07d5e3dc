"""Moving obstacles: a shape about a point that moves in a stated way, and how far it may be from there."""

import math
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import AfterValidator, Discriminator, Tag, model_validator

from skyverse._typing import Floats
from skyverse.model.arrays import instants_of
from skyverse.model.mover_motions import MoverMotion, motion_bounds
from skyverse.model.quantities import Amount, Instant, Limit, Model, Point, Positive, named_type
from skyverse.model.shapes import Box, Cylinder, Shape, Sphere


class Ellipsoid(Shape):
    """An upright ellipsoid, such as other UAVs must stay out of about a UAV.

    Where it grows, it keeps its proportions, and grows by at least as much as is asked for in every direction.

    Attributes
    ----------
    centre
        Metres.
    semi_axis_xy, semi_axis_z
        Its horizontal and its vertical semi-axis, metres.
    """

    shape: Literal["ellipsoid"] = "ellipsoid"
    centre: Point
    semi_axis_xy: Positive
    semi_axis_z: Positive


ROUNDING = 1e-3
"""The share by which a bound of a motion's speed may be above it."""


def _plain(shape: Shape) -> Shape:
    if shape.risk is not None:
        raise ValueError("a mover has no risk; nothing may fly through it")
    if shape.max_speed is not None:
        raise ValueError("a mover has no max_speed for others; nothing may fly through it")
    if shape.closed_above:
        raise ValueError("a mover cannot be closed above; make it as high as the bounds")
    if shape.active is not None:
        raise ValueError("a mover has no active times; what is there only at times belongs to zones")
    return shape


MoverShape = Annotated[
    Annotated[Box, Tag("box")]
    | Annotated[Cylinder, Tag("cylinder")]
    | Annotated[Sphere, Tag("sphere")]
    | Annotated[Ellipsoid, Tag("ellipsoid")],
    Discriminator(named_type("shape", "box")),
    AfterValidator(_plain),
]
"""The shape of a mover, in a frame whose zero is the moving point and whose axes do not turn."""


class Doubt(Model):
    """How far a mover may be from its stated motion.

    At an instant t the point of the mover lies within `radius` + `growth` (t - `since`) + `acceleration`
    (t - `since`)^2 / 2 of where its motion has it; before `since`, within `radius`. If a top speed is given, then from
    `since` on it lies also within `radius` + `top_speed` (t - `since`) of where its motion had it at that instant,
    whatever it does after that. What an acceleration adds to the growth ends at twice the top speed.

    Attributes
    ----------
    radius
        Metres.
    growth
        Metres a second.
    acceleration
        Metres a second squared, as of a mover whose velocity was seen; only together with a top speed.
    since
        The instant of the last observation, seconds into the mission.
    top_speed
        Metres a second; ``None`` where nothing is known of it.
    """

    radius: Amount = 0.0
    growth: Amount = 0.0
    acceleration: Amount = 0.0
    since: Instant = 0.0
    top_speed: Limit | None = None

    @model_validator(mode="after")
    def _with_top_speed(self) -> Self:
        if self.acceleration > 0.0 and self.top_speed is None:
            raise ValueError("acceleration needs a top_speed, which the mover never exceeds")
        return self

    @property
    def grows(self) -> bool:
        """Whether it grows with time."""
        return self.growth + self.acceleration > 0.0

    @property
    def accelerating_for(self) -> float:
        """For how many seconds its growth grows, since the instant of the last observation."""
        return 2.0 * self.top_speed / self.acceleration if self.top_speed and self.acceleration else math.inf

    def at(self, instants: ArrayLike) -> Floats:
        """Return how far the mover may be from its stated motion at instants (m,) seconds, (m,) metres."""
        after = np.maximum(instants_of(instants) - self.since, 0.0)
        quick = np.minimum(after, self.accelerating_for)
        doubt: Floats = self.radius + self.growth * after + self.acceleration * quick * (after - 0.5 * quick)
        return doubt


class Mover(Model):
    """An obstacle that moves.

    UAVs keep the scenario's clearance from it, as from any obstacle, wherever within its doubt it may be.

    Attributes
    ----------
    name
        Unique in its scenario; ``mover-1``, ``mover-2`` and so on if it is left out.
    kind
        What it stands for, such as ``"crane"``.
    shape
        In a frame whose zero is the moving point and whose axes do not turn.
    motion
        How that point moves.
    doubt
        How far it may be from there; not at all if this is left out.
    """

    name: str = ""
    kind: str | None = None
    shape: MoverShape
    motion: MoverMotion
    doubt: Doubt = Doubt()

    @model_validator(mode="after")
    def _bounded(self) -> Self:
        if self.doubt.top_speed is not None and self.doubt.growth > 0 and self.doubt.top_speed < self.doubt.growth:
            raise ValueError(
                f"doubt.growth, {self.doubt.growth:g} m/s, must not be above doubt.top_speed, "
                f"{self.doubt.top_speed:g} m/s"
            )
        fastest, _ = motion_bounds(self.motion)
        if self.doubt.top_speed is not None and fastest > (self.doubt.top_speed + self.doubt.growth) * (1.0 + ROUNDING):
            raise ValueError(
                f"doubt.top_speed is how fast the mover is at most, whatever it does, but it is "
                f"{self.doubt.top_speed:g} m/s, and the motion is as fast as {fastest:.6g} m/s"
            )
        return self

    def at(self, instants: ArrayLike) -> Floats:
        """Return where its point is by its stated motion, (m, 3) metres, at instants (m,), seconds into the mission."""
        return self.motion.at(instants)
