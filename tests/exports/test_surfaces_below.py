"""What is below a place: the highest roof that is not above it, or the ground; another library says what is inside."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.exports.landing import surfaces_below

CORNERS = st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8)), min_size=3, max_size=8, unique=True)
LEVELS = st.sampled_from([1.0, 2.0, 3.0, 4.0])
EAST, NORTH = (st.integers(0, 31).map(lambda k, off=off: k / 4 + off) for off in (0.1257, 0.1731))  # on no outline
PLACES = st.lists(st.tuples(EAST, NORTH, st.sampled_from([0.5, 1.0, 2.5, 3.0, 9.0])), min_size=1, max_size=20)


@st.composite
def solids(draw):
    """A shape of each kind, the prism with a hole if that is sound; the sphere is a half one in the ground."""
    (a, c), (b, d) = (sorted(draw(st.tuples(st.integers(0, 4), st.integers(5, 8)))) for _ in range(2))
    centre, radius = draw(st.tuples(EAST, NORTH)), draw(st.sampled_from([0.7, 1.9, 3.3]))
    kinds = [
        sky.Box(min=(a, b, 0), max=(c, d, draw(LEVELS))),
        sky.Cylinder(centre=centre, radius=radius, low=0.0, high=draw(LEVELS)),
        sky.Sphere(centre=(*centre, 0.0), radius=radius),
        sky.Voxels(
            origin=(0.0, 0.0, 0.0),
            step=(2.0, 2.0, 1.0),
            occupied=np.random.default_rng(draw(st.integers(0, 99))).random((4, 4, 4)) < 0.4,
        ),
    ]
    for holes in ([draw(CORNERS)], []):
        try:
            kinds.append(sky.Prism(vertices=draw(CORNERS), holes=holes, low=0.0, high=draw(LEVELS)))
        except ValueError:
            continue
    return draw(st.lists(st.sampled_from(kinds), max_size=4, unique_by=id))


def tops(solid, x, y):
    """z of the tops of a shape above a place; shapely says what is inside of a prism."""
    if isinstance(solid, sky.Box):
        return [solid.max[2]] * (solid.min[0] <= x <= solid.max[0] and solid.min[1] <= y <= solid.max[1])
    if isinstance(solid, sky.Prism):
        shapely = pytest.importorskip("shapely", reason="the oracle is shapely")
        return [solid.high] * shapely.Polygon(solid.vertices, solid.holes).contains(shapely.Point(x, y))
    if isinstance(solid, sky.Voxels):
        column = [*solid.occupied[int(x // 2), int(y // 2)], False]
        return [k + 1.0 for k in range(4) if column[k] and not column[k + 1]]
    away = math.dist(solid.centre[:2], (x, y))
    if away > solid.radius:
        return []
    return [solid.high if isinstance(solid, sky.Cylinder) else math.sqrt(solid.radius**2 - away**2)]


@settings(max_examples=100, deadline=None)
@given(solids(), PLACES)
def test_the_highest_surface_that_is_not_above_a_place_is_below_it(shapes, places):
    scenario = sky.Scenario(
        name="roofs",
        bounds=sky.Bounds(min=(-10, -10, -5), max=(20, 20, 30)),
        clearance=1.0,
        obstacles=tuple(shapes),
        lattice=sky.Lattice(step=(1, 1, 1)),
        uavs=[sky.UAV(start=(-5, -5, 20))],
        targets=[sky.Target(position=(15, 15, 20))],
    )
    tops_at = [[t for one in shapes for t in tops(one, x, y) if t <= z + 0.02] for x, y, z in places]  # files round
    expected = [min(z, max([0.25, *found])) for found, (_, _, z) in zip(tops_at, places, strict=True)]
    ground = np.full(len(places), 0.25)
    assert surfaces_below(scenario, np.array(places), ground) == pytest.approx(np.array(expected))
