"""A fixed-step integrator for rotorpy's vehicles, faster than their adaptive default."""

from typing import Any

import numpy as np
from scipy.integrate import OdeSolver

from skyverse._typing import Floats


class RungeKutta(OdeSolver):
    """The classical fourth-order Runge-Kutta method in equal steps of at most `max_step`."""

    def __init__(
        self, fun: Any, t0: float, y0: Floats, t_bound: float, vectorized: bool = False, max_step: float = np.inf
    ) -> None:
        super().__init__(fun, t0, y0, t_bound, vectorized)
        self._step = (t_bound - t0) / max(1, np.ceil((t_bound - t0) / max_step - 1e-9))

    def _step_impl(self) -> tuple[bool, None]:
        f, y, h = self.fun, self.y, self._step
        a = f(self.t, y)
        b = f(self.t, y + h / 2 * a)
        c = f(self.t, y + h / 2 * b)
        self.y = y + h / 6 * (a + 2 * b + 2 * c + f(self.t, y + h * c))
        self.t = self.t + h if self.t + 1.5 * h < self.t_bound else self.t_bound
        return True, None
