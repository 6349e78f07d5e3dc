"""What disturbs a simulated flight beside a steady wind."""

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
class Disturbances:
    """What disturbs a simulated flight beside a steady wind and white noise.

    Attributes
    ----------
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
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")

    gusts: Flag = False
    mismatch: Real = 0.0
    position_noise: Real = 0.0
    delay: Real = 0.0

    def __post_init__(self) -> None:
        for name, unit, most in (
            ("mismatch", "a share", MAX_MISMATCH),
            ("position_noise", "metres", MAX_NOISE),
            ("delay", "seconds", MAX_DELAY),
        ):
            require_number(getattr(self, name), name, unit, 0.0, most)
        if not isinstance(self.gusts, bool):
            raise InputError(f"expected true or false, found {self.gusts!r}", field="gusts")

    @property
    def sentence(self) -> str:
        """What disturbs, in words; empty where nothing does."""
        told = [
            "gusts (Dryden)" if self.gusts else "",
            f"mismatch of {self.mismatch:.0%}" if self.mismatch else "",
            f"position noise of {self.position_noise:g} m" if self.position_noise else "",
            f"delay of {math.floor(1000 * self.delay + 0.5)} ms" if self.delay else "",
        ]
        return ", ".join(filter(None, told))


def _told_wind(wind: Sequence[float]) -> str:
    """Say where a wind goes, and where it comes from as pilots tell it."""
    east, north, up = wind
    said = f"wind {', '.join(f'{speed:.3g}' for speed in wind)} m/s"
    if up or not (east or north):
        return said
    return f"{said} ({math.hypot(east, north):.3g} m/s from {math.degrees(math.atan2(-east, -north)) % 360:.3g}°)"


def told_weather(wind: Sequence[float], noise: float, disturbances: Disturbances, seed: int | None) -> str:
    """Say in words what disturbed a flight.

    Parameters
    ----------
    wind
        The steady wind, m/s towards east, north and up.
    noise
        The standard deviation of white noise, metres of position and m/s of velocity.
    disturbances
        What disturbed it beside these.
    seed
        The seed of what was drawn at random; ``None`` where nothing was, or where it is not known.
    """
    told = [
        _told_wind(wind) if any(wind) else "no wind",
        f"noise {noise:g} m" if noise else "no noise",
        disturbances.sentence,
        "" if seed is None else f"seed {seed}",
    ]
    return ", ".join(filter(None, told))
