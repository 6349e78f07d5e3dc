"""The wind: its velocity, the same everywhere or by altitude, how far off that may be, and what vehicles make of it."""

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BeforeValidator, Field, model_validator

from skyverse._typing import Floats
from skyverse.errors import InputError, require_number
from skyverse.model.quantities import Coordinate, Model, NonNegative, Number, listed

if TYPE_CHECKING:
    from skyverse.model.uav import UAV

MAX_WIND = 100.0
"""m/s."""
LEAST_RISE = 0.1
"""Metres from one layer of the wind to the next at least."""
LEAST_SPARE = 1e-3
"""M/s by which a multirotor's airspeed must exceed a wind against which it holds its place."""


def wind_from(speed: float, direction: float) -> tuple[float, float, float]:
    """Return the velocity of a wind as pilots tell it, m/s towards east, north and up.

    Parameters
    ----------
    speed
        m/s.
    direction
        Where it blows from: degrees from north, clockwise, so that 270 is a west wind, which blows towards east.
    """
    require_number(speed, "speed", "m/s", 0.0)
    require_number(direction, "direction", "degrees")
    angle = math.radians(direction)
    return round(-speed * math.sin(angle), 12) + 0.0, round(-speed * math.cos(angle), 12) + 0.0, 0.0


def told_wind(velocity: ArrayLike) -> str:
    """Return a wind in words, such as ``8 m/s from 270 degrees``."""
    east, north, up = np.asarray(velocity, dtype=np.float64).tolist()
    level = math.hypot(east, north)
    if not level:
        return f"{abs(up):.3g} m/s {'downwards' if up < 0 else 'upwards'}" if up else "0 m/s"
    also = f" and {abs(up):.3g} m/s {'downwards' if up < 0 else 'upwards'}" if up else ""
    direction = round(math.degrees(math.atan2(-east, -north)) % 360) % 360
    return f"{level:.3g} m/s from {direction} degrees{also}"


class WindBall(NamedTuple):
    """All winds that may blow somewhere: those within a distance of one of them.

    Attributes
    ----------
    velocity
        (3,) of the wind in the middle, m/s towards east, north and up.
    radius
        How far others may be from it, m/s.
    """

    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    radius: float = 0.0

    @property
    def strongest(self) -> float:
        """The speed of the strongest of them, m/s."""
        return math.hypot(*self.velocity) + self.radius

    @property
    def told(self) -> str:
        """The winds in words."""
        return told_wind(self.velocity) + (f" (up to {self.radius:.3g} m/s off)" if self.radius else "")


STILL_AIR = WindBall()
"""No wind."""


def _as_velocity(data: Any) -> Any:
    """Return the data of a wind with a velocity where they have a speed and where it blows from."""
    if not isinstance(data, dict) or not {"speed", "from"} & data.keys():
        return data
    rest = {key: value for key, value in data.items() if key not in ("speed", "from")}
    if not {"speed", "from"} <= data.keys() or "velocity" in data:
        raise ValueError("give either velocity, or both speed and from, the degrees that the wind blows from")
    return rest | {"velocity": wind_from(data["speed"], data["from"])}


_Speed = Annotated[Number, Field(ge=-MAX_WIND, le=MAX_WIND)]
Velocity = Annotated[tuple[_Speed, _Speed, _Speed], BeforeValidator(listed)]
"""m/s towards east, north and up."""


class WindLayer(Model):
    """The wind at an altitude.

    Attributes
    ----------
    altitude
        z in the scenario's frame, metres.
    velocity
        m/s towards east, north and up; files may give `speed` and `from` in its place, as those of `Wind`.
    """

    altitude: Coordinate
    velocity: Velocity

    @model_validator(mode="before")
    @classmethod
    def _of_pilots(cls, data: Any) -> Any:
        return _as_velocity(data)


class Wind(Model):
    """The wind in which missions are planned: what the air does at all times, as far as it is known.

    Attributes
    ----------
    velocity
        Of the air, m/s towards east, north and up, at all altitudes. Files may give `speed`, m/s, and `from`, degrees
        from north, clockwise, from where it blows, in its place.
    layers
        In place of `velocity`: the winds at altitudes that rise by 0.1 m or more. Between them the wind changes
        linearly with altitude, and below the first and above the last it is as there.
    gust
        How far the velocity of the true wind may be from that, m/s, in any direction at any instant.
    """

    velocity: Velocity | None = None
    layers: tuple[WindLayer, ...] = ()
    gust: NonNegative = 0.0

    @model_validator(mode="before")
    @classmethod
    def _of_pilots(cls, data: Any) -> Any:
        return _as_velocity(data)

    @model_validator(mode="after")
    def _one_table(self) -> Self:
        if (self.velocity is None) == (not self.layers):
            raise ValueError("give either velocity, for all altitudes, or layers")
        for below, above in pairwise(self.layers):
            if not above.altitude - below.altitude >= LEAST_RISE:
                raise ValueError(
                    f"layers must rise by {LEAST_RISE:g} m or more, but one at {below.altitude:g} m is followed by "
                    f"one at {above.altitude:g} m"
                )
        return self

    @property
    def told(self) -> str:
        """The wind in words."""
        (z, winds), gusts = self.table, f", with gusts of up to {self.gust:.6g} m/s" if self.gust else ""
        if len(z) == 1:
            return told_wind(winds[0]) + gusts
        first, last = (f"{told_wind(winds[k])} at z = {z[k]:.6g} m" for k in (0, -1))
        return f"{first}, by {len(z)} layers, to {last}{gusts}"

    @property
    def table(self) -> tuple[Floats, Floats]:
        """The altitudes (n,) of the layers, metres, and the velocities there, (n, 3) m/s; a single one if constant."""
        if self.velocity is not None:
            return np.zeros(1), np.array([self.velocity])
        return np.array([one.altitude for one in self.layers]), np.array([one.velocity for one in self.layers])

    def at(self, z: ArrayLike) -> Floats:
        """Return the velocities at altitudes z (n,), metres, without gusts: (n, 3) m/s towards east, north and up."""
        altitudes, velocities = self.table
        return np.stack([np.interp(np.asarray(z, dtype=np.float64), altitudes, one) for one in velocities.T], axis=-1)

    def between(self, low: float, high: float) -> WindBall:
        """Return a ball of all winds that may blow between two altitudes, metres, with their gusts."""
        z = self.table[0]
        found = self.at([low, *z[(low < z) & (z < high)], high])
        middle = 0.5 * (found.min(axis=0) + found.max(axis=0))
        off = float(np.linalg.norm(found - middle, axis=1).max())
        east, north, up = middle.tolist()
        return WindBall((east, north, up), off + self.gust)


def refuse_wind(uav: "UAV", winds: WindBall) -> None:
    """Raise `InputError` if a UAV cannot fly in winds: a multirotor must hold its place, an aeroplane its speed."""
    wing, against = uav.fixed_wing, f"against {winds.told}"
    if wing is None and winds.strongest + LEAST_SPARE > uav.max_wind:
        raise InputError(
            f"{against}, {uav.name}, whose airspeed is at most {uav.max_wind:.4g} m/s, cannot hold its place",
            field="wind",
        )
    if wing is not None and winds.strongest > uav.max_wind:
        raise InputError(
            f"{against}, {uav.name} cannot hold its speed over ground of {wing.speed:.4g} m/s: it flies in winds of "
            f"{uav.max_wind:.4g} m/s at most",
            field="wind",
        )


def good_speed(uav: "UAV", winds: WindBall, ways: Floats) -> Floats:
    """Return the speeds over ground, (n,) m/s, that a UAV makes good along unit vectors (n, 3) in any of some winds.

    A multirotor flies through the air as fast as it can, at the airspeed A less the radius of the winds, and across its
    way it flies against what the wind blows it aside: it makes ``w.d + sqrt(A^2 - |w - (w.d) d|^2)`` along d, but never
    more than its `max_speed`. An aeroplane holds its speed.
    """
    if uav.fixed_wing is not None:
        return np.full(len(ways), uav.fixed_wing.speed)
    w = np.array(winds.velocity)
    along = np.einsum("ij,j->i", ways, w)
    aside = np.linalg.norm(w - along[:, None] * ways, axis=1)
    left = uav.airspeed - winds.radius
    made = along + np.sqrt(np.maximum(left**2 - aside**2, 0.0))
    return np.clip(made, 0.0, uav.max_speed)


def slow_down(uav: "UAV", winds: WindBall, velocities: Floats) -> Floats:
    """Return the factors (...), 1 or more, by which velocities over ground (..., 3), m/s, are too fast for a UAV.

    So many times as slowly it can fly that way in any of some winds, and within its climb and descent rates. The factor
    is convex in the velocity: with that for some velocities it can fly all that lie between them. An aeroplane has 1.
    """
    if uav.fixed_wing is not None:
        return np.ones(velocities.shape[:-1])
    w, left = np.array(winds.velocity), uav.airspeed - winds.radius
    room = left**2 - float((w**2).sum())
    if left <= 0.0 or room <= 0.0:
        return np.full(velocities.shape[:-1], np.inf)
    along, up = (velocities * w).sum(axis=-1), velocities[..., 2]
    gauge = (np.sqrt(along**2 + (velocities**2).sum(axis=-1) * room) - along) / room
    steep = np.maximum(up / (uav.max_climb or np.inf), -up / (uav.max_descent or np.inf))
    return np.maximum(np.maximum(gauge, steep), 1.0)
