"""An observer that estimates the acceleration by the wind during the flight."""

from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.flight.feedforward import VERTICAL
from skyverse.flight.vehicle import Vehicle
from skyverse.trajectory.limits import GRAVITY

OBSERVER_BANDWIDTH = 8.0
"""The bandwidth of the observer, 1/s."""


class WindObserver:
    """Estimates the wind's acceleration as the smoothed change of velocity that rotors and still air do not explain."""

    def __init__(self, body: Any, kind: Vehicle) -> None:
        self._body, self._mass = body, kind.mass
        self._explained: Floats | None = None

    def push(self, told: dict[str, Floats], dt: float) -> Floats:
        """Update the estimate with a measured state, and return it, (3,) m/s^2."""
        turned = _matrix(told["q"])
        if self._explained is None:
            self._explained = told["v"].copy()
        push: Floats = OBSERVER_BANDWIDTH * (told["v"] - self._explained)
        force, _ = self._body.compute_body_wrench(told["w"], told["rotor_speeds"], turned.T @ told["v"])
        self._explained += (turned @ force / self._mass - GRAVITY * VERTICAL + push) * dt
        return push


def _matrix(q: Floats) -> Floats:
    """Return the rotation matrix of a quaternion x, y, z, w."""
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
