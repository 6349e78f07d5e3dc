"""What flies in a simulation, in what wind, and what else disturbs it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from pydantic import ConfigDict

from skyverse.errors import InputError, require_number
from skyverse.model.quantities import Flag, Real

MAX_MISMATCH = 0.5
"""The largest share by which a vehicle may differ from its model; beyond, few could hover."""
MAX_NOISE = 10.0
"""Metres."""
MAX_DELAY = 1.0
"""Seconds."""
MAX_WIND = 100.0
"""m/s."""


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


@dataclass(frozen=True)
class Conditions:
    """What flies in a simulation, in what wind, and what else disturbs it.

    Attributes
    ----------
    vehicle
        ``"thesis"``, ``"camera"``, ``"crazyflie"`` or ``"hummingbird"``, which flies in place of every multirotor. By
        default it is the vehicle that the mission was planned for where that is one of them, and otherwise the
        thesis's.
    wind
        The mean velocity of the air, (3,) m/s towards east, north and up. Two numbers are its speed, m/s, and the
        direction in which it moves, degrees counter-clockwise from east.
    noise
        The standard deviation, on each axis, of the white normal noise in what controllers measure: this many metres
        of position and m/s of velocity.
    gusts
        Whether the wind is gusty, by the Dryden model of MIL-F-8785C at low altitude. The intensity follows from the
        horizontal speed of the mean wind.
    mismatch
        The share, from 0 to 0.5, within which mass, thrust, drag and inertia of the vehicle that flies differ from what
        its controller believes; each is drawn uniformly and on its own, for every UAV and run.
    position_noise
        The standard deviation on each axis, metres, of a slowly drifting error of the measured position, as of GPS: a
        first-order Gauss-Markov process with a time constant of 1,100 s (Beard, McLain, "Small Unmanned Aircraft",
        2012, section 7.5).
    delay
        Seconds by which measured positions and velocities are late; rounded to hundredths.

    Raises
    ------
    InputError
        If a value is out of range, or gusts have no wind.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")

    vehicle: str | None = None
    wind: tuple[Real, ...] = (0.0, 0.0, 0.0)
    noise: Real = 0.0
    gusts: Flag = False
    mismatch: Real = 0.0
    position_noise: Real = 0.0
    delay: Real = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "wind", _velocity(self.wind))
        for name, unit, most in (
            ("noise", "metres", MAX_NOISE),
            ("mismatch", "a share", MAX_MISMATCH),
            ("position_noise", "metres", MAX_NOISE),
            ("delay", "seconds", MAX_DELAY),
        ):
            require_number(getattr(self, name), name, unit, 0.0, most)
        if not isinstance(self.gusts, bool):
            raise InputError(f"expected true or false, found {self.gusts!r}", field="gusts")
        if self.gusts and not math.hypot(*self.wind[:2]):
            raise InputError("gusts need a wind, as their strength follows from its horizontal speed", field="gusts")

    @property
    def random(self) -> bool:
        """Whether any of it is drawn at random, so that a seed matters."""
        return self.gusts or max(self.noise, self.mismatch, self.position_noise) > 0

    @property
    def sentence(self) -> str:
        """What disturbs, in words."""
        told = [
            _told_wind(self.wind) if any(self.wind) else "no wind",
            f"noise {self.noise:g} m" if self.noise else "no noise",
            "gusts (Dryden)" if self.gusts else "",
            f"mismatch of {self.mismatch:.0%}" if self.mismatch else "",
            f"position noise of {self.position_noise:g} m" if self.position_noise else "",
            f"delay of {math.floor(1000 * self.delay + 0.5)} ms" if self.delay else "",
        ]
        return ", ".join(filter(None, told))

    def told(self, seed: int | None) -> str:
        """Return the same with the seed of what was drawn at random, if it is known."""
        return self.sentence if seed is None else f"{self.sentence}, seed {seed}"


def _velocity(wind: Sequence[float]) -> tuple[float, ...]:
    """Return the velocity of a wind, (3,) m/s, or raise `InputError`."""
    try:
        numbers = [float(number) for number in wind]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) not in (2, 3) or not all(map(math.isfinite, numbers)):
        raise InputError(f"expected east,north,up in m/s, or speed,degrees, found {wind!r}", field="wind")
    if max(map(abs, numbers if len(numbers) == 3 else numbers[:1])) > MAX_WIND:
        raise InputError(f"expected at most {MAX_WIND:g} m/s, found {wind!r}", field="wind")
    if len(numbers) == 2:
        speed, heading = numbers[0], math.radians(numbers[1])
        return round(speed * math.cos(heading), 12), round(speed * math.sin(heading), 12), 0.0
    return tuple(numbers)


def _told_wind(wind: Sequence[float]) -> str:
    """Say where a wind goes, and where it comes from as pilots tell it."""
    east, north, up = wind
    said = f"wind {', '.join(f'{speed:.3g}' for speed in wind)} m/s"
    if up or not (east or north):
        return said
    return f"{said} ({math.hypot(east, north):.3g} m/s from {math.degrees(math.atan2(-east, -north)) % 360:.3g}°)"
