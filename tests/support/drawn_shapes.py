"""Random shapes, grounds and worlds of them, in a room of 10 m."""

import numpy as np
from hypothesis import strategies as st

import skyverse as sky
from judged_clearance import world

SQUARE = ((2.0, 2.0), (7.0, 2.0), (7.0, 7.0), (2.0, 7.0))
HOLE = ((3.0, 3.0), (6.0, 3.5), (5.0, 6.0), (3.5, 5.5))
COMB = ((0, 0), (10, 0), (10, 8), (8, 8), (8, 2), (6, 2), (6, 8), (4, 8), (4, 2), (2, 2), (2, 8), (0, 8))
STAR = ((1, 1), (9, 2), (5, 4), (8, 9), (2, 8))

tenths = st.integers(0, 100).map(lambda n: n / 10)
places = st.tuples(tenths, tenths, tenths)
sides = st.just(1e-7) | st.integers(1, 40).map(lambda n: n / 10)


@st.composite
def shapes(draw):
    low = draw(st.integers(0, 8))
    high = low + draw(st.integers(1, 5))
    kind = draw(st.sampled_from(["box", "cylinder", "sphere", "prism", "voxels"]))
    if kind == "box":
        corner = draw(places)
        return sky.Box(min=corner, max=tuple(np.add(corner, draw(st.tuples(sides, sides, sides)))))
    if kind == "cylinder":
        return sky.Cylinder(centre=draw(places)[:2], radius=draw(st.integers(1, 40)) / 10, low=low, high=high)
    if kind == "sphere":
        return sky.Sphere(centre=draw(places), radius=draw(st.integers(1, 40)) / 10)
    if kind == "prism":
        holes = draw(st.sampled_from([(), (HOLE,)]))
        vertices = draw(st.sampled_from([SQUARE, SQUARE[::-1], COMB, STAR])) if not holes else SQUARE
        return sky.Prism(vertices=vertices, holes=holes, low=low, high=high)
    occupied = np.random.default_rng(draw(st.integers(0, 99))).random((4, 3, 5)) < draw(st.sampled_from([0.1, 0.5]))
    return sky.Voxels(origin=(1.0, 1.0, 1.0), step=(2.0, 2.5, 1.5), occupied=occupied)


@st.composite
def grounds(draw):
    rng = np.random.default_rng(draw(st.integers(0, 999)))
    nx, ny = draw(st.integers(2, 14)), draw(st.integers(2, 9))
    kind = draw(st.sampled_from(["rough", "plane", "step"]))
    heights = rng.uniform(0, draw(st.sampled_from([0.5, 6.0])), (nx, ny))
    if kind == "plane":
        heights = np.add.outer(np.arange(nx) * 3 / nx, np.arange(ny) * 2 / ny)
    if kind == "step":
        heights = np.where(heights > 3, 4.0, 1.0)
    clearance = draw(st.sampled_from([None, 0.001, 0.5]))
    return sky.Terrain(origin=(0, 0), step=(10 / (nx - 1), 10 / (ny - 1)), heights=heights, clearance=clearance)


@st.composite
def worlds(draw):
    terrain = draw(st.none() | grounds())
    obstacles = draw(st.lists(shapes(), max_size=3))
    made = world(*obstacles, clearance=draw(st.sampled_from([0.001, 0.25, 1.0])), terrain=terrain)
    lattice = sky.Lattice(step=draw(st.sampled_from([(1, 1, 1), (2.5, 3, 2)])), connectivity=26)
    most = None if terrain is None else draw(st.sampled_from([None, 2.5, 6.0]))
    return made.model_copy(update={"lattice": lattice, "max_height": most})


def along(a, b, n=2001):
    """Places from a to b, (n, 3)."""
    return np.array(a, float) + np.linspace(0, 1, n)[:, None] * (np.array(b, float) - a)
