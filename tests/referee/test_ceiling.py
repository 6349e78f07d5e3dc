"""The ceiling above ground and obstacles that are closed above, as the referee judges them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from judged_clearance import judged, legs, of, straight, verdict, world
from skyverse.model.shapes import Terrain
from skyverse.space.world import World

ROUGH = Terrain(origin=(0, 0), step=(2.5, 2.0), heights=np.random.default_rng(3).uniform(0, 3, (5, 6)), clearance=0.5)


def under(max_height, terrain=ROUGH):
    return world(terrain=terrain).model_copy(update={"max_height": max_height})


@given(st.integers(0, 10_000), st.integers(1, 5), st.floats(2.0, 5.0))
def test_a_curve_is_proven_exactly_where_dense_samples_stay_below_the_ceiling(seed, degree, most):
    rng = np.random.default_rng(seed)
    a, b = rng.uniform((0, 0, 3.5), (10, 10, 6.0), (2, 3))
    rows = np.zeros((1, degree + 1, 3))
    rows[0, 0], rows[0, 1] = a, b - a
    rows[0, 2:] = rng.uniform(-0.4, 0.4, (degree - 1, 3))
    times = np.linspace(0, 1, 4001)
    positions = sum(rows[0, k] * times[:, None] ** k for k in range(degree + 1))
    above = positions[:, 2] - ROUGH.height(positions[:, :2])
    excess = max((above - most).max(), (0.5 - above).max())
    found = judged(under(most), of([0, 1], rows))
    if excess > 1e-5:
        assert verdict(found) == "refuted"
        assert found.incursion.depth >= excess - 1e-6
    elif excess < -0.01:
        assert verdict(found) == "proven"


@pytest.mark.parametrize(("z", "expected"), [(5.0, "proven"), (5.0 + 5e-7, "proven"), (5.001, "refuted")])
def test_the_ceiling_may_be_touched(z, expected):
    flat = Terrain(origin=(0, 0), step=(10, 10), heights=np.zeros((2, 2)), clearance=0.5)
    scenario = under(5.0, flat)
    assert verdict(judged(scenario, straight((1, 1, z), (9, 9, z)))) == expected
    assert verdict(legs(scenario, (1, 1, z), (9, 9, z), (9, 1, z))) == expected


def test_a_message_says_how_far_above_which_ceiling():
    flat = Terrain(origin=(0, 0), step=(10, 10), heights=np.ones((2, 2)), clearance=0.5)
    scenario = under(5.0, flat)
    found = judged(scenario, straight((1, 1, 3), (9, 9, 7.5)))
    assert found.incursion.sentence(scenario, "uav-1", "at t = 1 s") == (
        "uav-1 is 1.5 m above the ceiling of 5 m above ground at t = 1 s, position (9, 9, 7.5)."
    )


LOWER = ROUGH.model_copy(update={"lowest": ROUGH.heights - np.random.default_rng(4).uniform(0, 2, (5, 6))})


@given(st.integers(0, 10_000), st.floats(4.0, 6.0))
def test_the_ceiling_is_counted_from_the_lowest_heights_where_there_are_such(seed, most):
    rng = np.random.default_rng(seed)
    a, b = rng.uniform((0, 0, 3.5), (10, 10, 6.0), (2, 3))
    positions = np.linspace(a, b, 2001)
    excess = (positions[:, 2] - LOWER.lowest_ground.height(positions[:, :2]) - most).max()
    excess = max(excess, (0.5 - (positions[:, 2] - LOWER.height(positions[:, :2]))).max())
    if abs(excess) > 1e-4:
        found = judged(under(most, LOWER), straight(a, b))
        assert verdict(found) == ("refuted" if excess > 0 else "proven")
        assert World(under(most, LOWER)).segments_free([a], [b]).tolist() == [excess < 0]


CLOSED = (
    sky.Box(min=(4, 4, 0), max=(6, 6, 2), closed_above=True),
    sky.Cylinder(centre=(5, 5), radius=1, low=0, high=2, closed_above=True),
    sky.Sphere(centre=(5, 5, 1), radius=1, closed_above=True),
    sky.Prism(vertices=((4, 4), (6, 4), (6, 6), (4, 6)), low=0, high=2, closed_above=True),
    sky.Voxels(origin=(4, 4, 0), step=(1, 1, 1), occupied=np.ones((2, 2, 2)), closed_above=True),
)


@pytest.mark.parametrize("shape", CLOSED, ids=lambda shape: shape.shape)
@pytest.mark.parametrize("z", [1.5, 5.0, 10.0])
def test_nothing_may_fly_over_an_obstacle_that_is_closed_above(shape, z):
    scenario = world(shape)
    over, beside = ((0, 5, z), (10, 5, z)), ((0, 3.74, z), (10, 3.74, z))
    assert verdict(judged(scenario, straight(*over))) == "refuted"
    assert verdict(legs(scenario, *over)) == "refuted"
    assert verdict(judged(scenario, straight(*beside))) == "proven"
    opened = world(shape.model_copy(update={"closed_above": False}))
    assert verdict(judged(opened, straight(*over))) == ("refuted" if z < 2 else "proven")
    found = judged(scenario, straight(*over)).incursion
    assert "inside obstacle 0" in found.sentence(scenario, "uav-1", "at t = 1 s")


@pytest.mark.parametrize("clearance", [0.001, 0.5, 2.5])
@pytest.mark.parametrize("z", [0.0, 4.0, 10.0, 10.5, 11.5, 13.0])
def test_about_the_rim_of_a_sphere_that_is_closed_above_players_and_referee_agree(z, clearance):
    scenario = world(sky.Sphere(centre=(5, 5, z), radius=1.5, closed_above=True), clearance=clearance)
    rim = 1.5 + clearance
    out, up = np.meshgrid(rim + np.array([-0.3, -1e-4, 1e-4, 0.3]), np.r_[-1.01, -0.99, -0.5, -1e-3, 1e-3, 1] * rim + z)
    turn = np.linspace(0, 6, out.size)
    places = np.column_stack([5 + out.ravel() * np.cos(turn), 5 + out.ravel() * np.sin(turn), up.ravel()])
    places = places[((places >= 0.01) & (places <= 9.99)).all(axis=1)]
    judged_free = [verdict(legs(scenario, place, place)) == "proven" for place in places]
    assert (World(scenario).free(places) == judged_free).all()


@pytest.mark.parametrize("clearance", [0.001, 0.25])
def test_the_rim_of_a_sphere_that_is_closed_above_may_be_touched(clearance):
    scenario = world(sky.Sphere(centre=(5, 5, 5), radius=1, closed_above=True), clearance=clearance)
    rim = 6 + clearance
    for begin, end in (((rim, 5, 1), (rim, 5, 9)), ((rim, 1, 5), (rim, 9, 5)), ((rim, 1, 1), (rim, 9, 9))):
        assert verdict(legs(scenario, begin, end)) == "proven"
        inside = [(x - 1e-4, y, z) for x, y, z in (begin, end)]
        assert verdict(legs(scenario, *inside)) == "refuted"
