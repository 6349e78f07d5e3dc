"""How long a straight leg takes from rest to rest."""

from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats


@dataclass(frozen=True)
class LegTime:
    """What straight legs cost: from rest to rest, in seconds.

    Attributes
    ----------
    speed
        m/s, the fastest one.
    acceleration
        m/s2, speeding up and braking.
    """

    speed: float
    acceleration: float

    def __call__(self, legs: Floats) -> Floats:
        """Return the seconds that legs (..., 2), in metres, take: l / v + v / a, or 2 sqrt(l / a) if they are short."""
        length = np.hypot(legs[..., 0], legs[..., 1])
        short = length < self.speed**2 / self.acceleration
        ramps = np.sqrt(length / self.acceleration), length / self.speed + self.speed / self.acceleration
        return np.where(length > 0.0, np.where(short, 2 * ramps[0], ramps[1]), 0.0)
