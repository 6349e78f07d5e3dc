"""How long a straight leg takes from rest to rest."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.tolerances import SWEEP_CONTACT


@dataclass(frozen=True)
class LegTime:
    """What straight legs cost: from rest to rest, in seconds.

    Attributes
    ----------
    speed
        m/s, the fastest one.
    acceleration
        m/s2, speeding up and braking.
    turn
        Seconds that each leg takes besides.
    ground_speed
        Gives for unit vectors (..., 2) the speed over ground in m/s, where that differs by direction (wind); None:
        `speed` everywhere.
    """

    speed: float
    acceleration: float
    turn: float = 0.0
    ground_speed: Callable[[Floats], Floats] | None = None

    def __call__(self, legs: Floats) -> Floats:
        """Return the seconds that legs (..., 2), in metres, take: l / v + v / a, or 2 sqrt(l / a) if they are short."""
        length = np.hypot(legs[..., 0], legs[..., 1])
        speed: Any = self.speed
        if self.ground_speed is not None:
            speed = self.ground_speed(legs / np.maximum(length, SWEEP_CONTACT)[..., None])
        short = length < speed**2 / self.acceleration
        ramps = np.where(short, 2 * np.sqrt(length / self.acceleration), length / speed + speed / self.acceleration)
        return np.where(length > 0.0, ramps + self.turn, 0.0)
