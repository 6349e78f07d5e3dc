"""The push of the wind, found while flying."""

from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.flight.feedforward import VERTICAL
from skyverse.flight.vehicle import Vehicle
from skyverse.trajectory.limits import GRAVITY

OBSERVER_BANDWIDTH = 8.0
"""How fast the observer follows, 1/s."""


class WindObserver:
    """Finds the push of the wind: what velocity does beyond what rotors and still air explain, smoothed."""

    def __init__(self, body: Any, kind: Vehicle) -> None:
        self._body, self._mass = body, kind.mass
        self._explained: Floats | None = None

    def push(self, told: dict[str, Floats], dt: float) -> Floats:
        """Return the push, (3,) m/s^2, and take note of the state that is told."""
        turned = _matrix(told["q"])
        if self._explained is None:
            self._explained = told["v"].copy()
        push: Floats = OBSERVER_BANDWIDTH * (told["v"] - self._explained)
        force, _ = self._body.compute_body_wrench(told["w"], told["rotor_speeds"], turned.T @ told["v"])
        self._explained += (turned @ force / self._mass - GRAVITY * VERTICAL + push) * dt
        return push


def _matrix(q: Floats) -> Floats:
    """Return the rotation of a quaternion x, y, z, w."""
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def upward(q: Floats) -> Floats:
    """Return where the rotors thrust to, (3,), at an attitude x, y, z, w."""
    return _matrix(q)[:, 2]
