"""The source of a module with a planner of one's own."""

MODULE = '''
"""A planner for tests."""

from dataclasses import dataclass

import numpy as np

from skyverse import WaypointSearch


@dataclass(frozen=True, kw_only=True)
class Shake(WaypointSearch):
    """Shake every candidate."""

    size: float = 0.2

    def optimise(self, evaluate, first, rng):
        X, fitness = first, evaluate(first)
        while True:
            yield
            shaken = np.clip(X + self.size * rng.standard_normal(X.shape), 0, 1)
            value = evaluate(shaken)
            better = value <= fitness
            X, fitness = np.where(better[:, None], shaken, X), np.where(better, value, fitness)
'''
