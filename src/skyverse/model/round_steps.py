"""The steps of a lattice where they are not given."""

import math
from collections.abc import Sequence

MAX_DEFAULT_NODES = 2e6
"""Nodes of the lattice at most where its step is not given."""
_ROUND = [digit * 10.0**power for power in range(-3, 13) for digit in (1, 2, 5)]


def round_steps(sizes: Sequence[float], least: float = 0.0) -> tuple[float, float, float]:
    """Return the shortest round step, the same along each axis, for which the lattice has few enough nodes, metres.

    Parameters
    ----------
    sizes
        The lengths of the bounds along x, y and z, metres; along a shorter one, the step is its length.
    least
        Metres: no step is shorter.
    """
    tried = ([min(step, size) for size in sizes] for step in _ROUND if step >= least)
    x, y, z = next(steps for steps in tried if _nodes(sizes, steps) <= MAX_DEFAULT_NODES)
    return x, y, z


def _nodes(sizes: Sequence[float], steps: Sequence[float]) -> float:
    return math.prod(size / step + 1 for size, step in zip(sizes, steps, strict=True))
