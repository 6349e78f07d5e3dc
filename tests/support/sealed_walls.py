"""Walls from bound to bound whose shapes leave less than twice the clearance between them, or just twice of it."""

from typing import NamedTuple

import numpy as np
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.shapes import Box, Cylinder, Prism, Terrain, Voxels

SHARES = (0.0, 1e-6, 0.5, 1.0)
"""How much of twice the clearance, less four micrometres, is left between neighbours along the wall."""
OVERLAPS = (0.0, 1e-9, 1e-6, 1e-3)
"""Metres by which neighbours overlap instead."""
KINDS = ("box", "prism", "diamond", "cylinder", "voxels")
WALL = 4.5
"""Where the wall stands along y, metres."""


class SealedWall(NamedTuple):
    """A scenario with a wall, the places x where its shapes meet, and the height at which UAVs are to pass it."""

    scenario: sky.Scenario
    joints: tuple[float, ...]
    height: float


@st.composite
def sealed_walls(draw, kinds=KINDS):
    """Draw a wall of one to four shapes across a space of 10 m, with or without ground below it."""
    clearance = draw(st.sampled_from([0.001, 0.001, 0.1, 1.0]))
    offset = draw(st.sampled_from([0.0, 0.0, 1234.5, -5e4]))
    some = draw(st.lists(st.sampled_from(kinds), min_size=1, max_size=3))
    gap = st.sampled_from(SHARES).map(lambda share: share * 2 * (clearance - 2e-6)) | st.sampled_from(OVERLAPS).map(
        lambda overlap: -overlap
    )
    gaps = [draw(gap) for _ in range(len(some) + 1)]
    ridge = draw(st.sampled_from([None, None, 1.0]))
    places = np.linspace(0.0, 10.0, len(some) + 1)
    low = -2.0 if ridge is None else ridge + draw(gap)
    top = 8.0 if draw(st.booleans()) else 5.0 - draw(gap) / 2
    shapes = []
    for k, kind in enumerate(some):  # beside the bounds, which do not grow, half of a gap is left
        begin, end = places[k] + gaps[k] / 2, places[k + 1] - gaps[k + 1] / 2
        shapes.append(piece(kind, begin + offset, end + offset, (low, top), offset))
    scenario = sky.Scenario(
        name="sealed",
        bounds=sky.Bounds(min=(offset, offset, 0.0), max=(10 + offset, 10 + offset, 5)),
        obstacles=tuple(shapes),
        terrain=None if ridge is None else ridged(ridge, offset, clearance),
        clearance=clearance,
        lattice=sky.Lattice(step=(0.5, 0.5, 0.5), connectivity=draw(st.sampled_from([6, 26]))),
        objective=sky.Objective(unit="metres"),
        uavs=(sky.UAV(start=(5 + offset, 0.5 + offset, 3)),),
        targets=(sky.Target(position=(5 + offset, 9 + offset, 3)),),
    )
    return SealedWall(scenario, tuple((places + offset).tolist()), 3.0)


def piece(kind, begin, end, span, offset):
    """Return a shape that meets its neighbours at `begin` and `end` along x, at least where y is `WALL`."""
    middle, y, (low, high) = (begin + end) / 2, WALL + offset, span
    if kind == "cylinder":
        return Cylinder(centre=(middle, y), radius=(end - begin) / 2, low=low, high=high)
    if kind == "diamond":
        return Prism(vertices=((begin, y), (middle, y - 0.3), (end, y), (middle, y + 0.3)), low=low, high=high)
    if kind == "prism":
        a, b = y - 0.25, y + 0.5
        return Prism(vertices=((begin, a), (end, a), (end, b), (begin, b)), low=low, high=high)
    if kind == "voxels":
        step = ((end - begin) / 2, 0.25, high - low)
        return Voxels(origin=(begin, y - 0.25, low), step=step, occupied=np.ones((2, 2, 1)))
    return Box(min=(begin, y - 0.5, low), max=(end, y + 0.5, high))


def ridged(height, offset, clearance):
    """Return ground that is flat but for a ridge under the wall."""
    heights = np.full((4, 12), -3.0)
    heights[:, 4:6] = height
    return Terrain(origin=(offset - 5, offset - 0.5), step=(10.0, 1.0), heights=heights, clearance=clearance)


def with_ends(scenario, start, end):
    """Return the scenario with other ends of the flight."""
    uavs = (scenario.uavs[0].model_copy(update={"start": tuple(map(float, start))}),)
    targets = (scenario.targets[0].model_copy(update={"position": tuple(map(float, end))}),)
    return scenario.model_copy(update={"uavs": uavs, "targets": targets})
