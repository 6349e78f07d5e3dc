"""The steps of a lattice where they are not given."""

import math
from collections.abc import Sequence

MAX_DEFAULT_NODES = 2e6
"""Nodes of the lattice at most where its step is not given."""
MAX_BELOW_CEILING = 5e6
"""The same where there is a ceiling above ground: most nodes are then above it, and never searched."""
ROUND = [digit * 10.0**power for power in range(-3, 13) for digit in (1, 2, 5)]


def round_steps(sizes: Sequence[float], least: float = 0.0, upright: float = math.inf) -> tuple[float, float, float]:
    """Return the shortest round step, the same along each axis, for which the lattice has few enough nodes, metres.

    Parameters
    ----------
    sizes
        The lengths of the bounds along x, y and z, metres; along a shorter one, the step is its length.
    least
        Metres: no step is shorter, but for the one along z where that must be.
    upright
        Metres that the step along z is no longer than, where there is a ceiling above ground.
    """
    most = MAX_DEFAULT_NODES if upright == math.inf else MAX_BELOW_CEILING
    asked = ((step, step, min(step, upright)) for step in ROUND if step >= least)
    tried = ([min(step, size) for step, size in zip(steps, sizes, strict=True)] for steps in asked)
    x, y, z = next(steps for steps in tried if _nodes(sizes, steps) <= most)
    return x, y, z


def _nodes(sizes: Sequence[float], steps: Sequence[float]) -> float:
    return math.prod(size / step + 1 for size, step in zip(sizes, steps, strict=True))
