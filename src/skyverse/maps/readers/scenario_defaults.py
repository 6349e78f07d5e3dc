"""The clearance and the lattice of scenarios made of maps, which say nothing of either."""

import math

from skyverse.model.scenario import Bounds, Lattice

DEFAULT_CLEARANCE = 0.25
"""Metres from a map's obstacles, as in the maps of the MEAM 620 course."""
MAX_LATTICE_NODES = 1e6
"""Nodes at most in a lattice."""


def default_lattice(bounds: Bounds, step: float) -> Lattice:
    """Return a lattice of cubes whose side is a step, metres, doubled until there are at most `MAX_LATTICE_NODES`."""
    sides = [high - low for low, high in zip(bounds.min, bounds.max, strict=True)]
    while math.prod(side / step + 1 for side in sides) > MAX_LATTICE_NODES:
        step *= 2
    x, y, z = (min(step, side) for side in sides)
    return Lattice(step=(x, y, z))
