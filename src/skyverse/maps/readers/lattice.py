"""What maps do not say and scenarios need: a clearance and a lattice."""

import math

from skyverse.model.scenario import Bounds, Lattice

CLEARANCE = 0.25
"""Metres kept from a map's obstacles unless said otherwise, as in the course's maps."""
MAX_NODES = 1e6


def lattice_of(bounds: Bounds, step: float) -> Lattice:
    """Return a lattice of cubes: this step, metres, doubled until there are `MAX_NODES` nodes at most."""
    sides = [high - low for low, high in zip(bounds.min, bounds.max, strict=True)]
    while math.prod(side / step + 1 for side in sides) > MAX_NODES:
        step *= 2
    x, y, z = (min(step, side) for side in sides)
    return Lattice(step=(x, y, z))
