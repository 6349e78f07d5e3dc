"""That a place is sealed is proven only where no curve beside the flight leads past it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from judged_clearance import world
from skyverse.model.shapes import Box, Cylinder, Prism, Sphere
from skyverse.referee.sealed import CORNERS, is_sealed
from skyverse.referee.seams import find_seam
from skyverse.referee.world import referee_world

SPAN = {"low": -1.0, "high": 11.0}


def sealed(scenario, share, *points):
    """Whether the place after a share of the first leg through points is proven to be sealed."""
    path = np.array(points, float)
    legs = np.stack([path[:-1], path[1:]], axis=1)
    return is_sealed(referee_world(scenario), legs, np.zeros(len(legs)), 0, share)


def found(scenario, *points):
    path = np.array(points, float)
    legs = np.stack([path[:-1], path[1:]], axis=1)
    return find_seam(referee_world(scenario), legs, np.zeros(len(legs)))


def test_a_cube_has_eight_corners():
    assert sorted(map(tuple, CORNERS)) == [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]


def pair(kind, gap):
    """Two shapes that leave a gap at x = 5 and y = 5."""
    if kind == "boxes":
        return Box(min=(1, 4, -1), max=(5 - gap / 2, 6, 11)), Box(min=(5 + gap / 2, 4, -1), max=(9, 6, 11))
    if kind == "knives":
        return tuple(
            Prism(vertices=((5 + s * gap / 2, 5), (5 + s * 3, 4), (5 + s * 3, 6)), **SPAN) for s in (-1.0, 1.0)
        )
    if kind == "cylinders":
        return tuple(Cylinder(centre=(5 + s * (2 + gap / 2), 5), radius=2, **SPAN) for s in (-1, 1))
    return tuple(Sphere(centre=(5 + s * (2 + gap / 2), 5, 5), radius=2) for s in (-1, 1))


KINDS = ("boxes", "knives", "cylinders", "spheres")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("gap", "proven"), [(-1e-3, True), (0.0, True), (9.9e-7, True), (1.1e-6, False), (1e-5, False)]
)
def test_a_gap_between_two_shapes_is_sealed_exactly_below_a_micrometre(kind, gap, proven):
    gap = 5e-7 if (kind, gap) == ("knives", 9.9e-7) else gap  # between edges, there is a proof only well below it
    scenario = world(*pair(kind, gap), clearance=0.0)
    assert sealed(scenario, 0.5, (5, 2, 5), (5, 8, 5)) == proven
    assert sealed(scenario, 1.0, (5, 2, 5), (5, 5, 5), (5, 8, 5)) == proven
    slanted = (5 - 1e-3, 2, 4.5), (5 + 1e-3, 8, 5.5)
    assert sealed(scenario, 0.5, *slanted) == proven


@given(
    st.sampled_from(KINDS), st.sampled_from([1.1e-6, 1e-5, 1e-3]), st.floats(-1, 1), st.floats(0, 1), st.floats(0, 6.28)
)
def test_no_place_is_sealed_on_a_curve_that_has_another_beside_it(kind, gap, aside, share, turn):
    scenario = world(*pair(kind, gap), clearance=0.0)
    way = np.array([0.2 * np.cos(turn), 3.0, np.sin(turn)])
    middle = np.array([5 + aside * gap / 2, 5, 5])
    legs = (middle - way, middle + way)
    if found(scenario, *legs) is None:
        for near in (0.5, 0.5 + 1e-6 * (share - 0.5), share):
            assert not sealed(scenario, near, *legs)


@pytest.mark.parametrize(("opening", "proven"), [(4.0, True), (20.0, False), (90.0, False)])
def test_the_tip_of_a_notch_is_sealed_where_it_is_so_sharp_that_its_sides_leave_no_space(opening, proven):
    half = np.radians(opening / 2)
    notch = (5 - 4 * np.tan(half), 1.0), (5.0, 5.0), (5 + 4 * np.tan(half), 1.0)
    scenario = world(Prism(vertices=(*notch, (9.9, 1), (9.9, 9), (0.1, 9), (0.1, 1)), **SPAN), clearance=0.0)
    assert sealed(scenario, 1.0, (5, 0, 5), (5, 5, 5), (5, 0, 5)) == proven


def test_a_notch_that_no_step_leads_out_of_but_another_curve_does_is_undecided():
    turn, half = np.radians(11.25), np.radians(7)
    sides = [(5 + 4 * np.sin(turn + s), 5 - 4 * np.cos(turn + s)) for s in (-half, half)]
    beside = (9.9, 0.1), (9.9, 9.9), (0.1, 9.9), (0.1, 0.1)
    scenario = world(Prism(vertices=(sides[0], (5, 5), sides[1], *beside), **SPAN), clearance=0.0)
    away = (5 + 3 * np.sin(turn), 5 - 3 * np.cos(turn), 5)
    seam = found(scenario, away, (5, 5, 5), away)
    assert seam is not None
    assert not seam.decided
    assert "Whether uav-1 leads through a gap in obstacle 0 could not be decided" in seam.sentence(
        scenario, "uav-1", ""
    )


def test_where_a_curve_begins_or_stands_in_a_seam_it_is_sealed_too():
    scenario = world(*pair("boxes", 0.0), clearance=0.0)
    assert sealed(scenario, 0.0, (5, 5, 5), (5, 8, 5))
    assert sealed(scenario, 0.5, (5, 5, 5), (5, 5, 5))
    assert not sealed(scenario, 0.0, (5, 2, 5), (5, 8, 5))


def test_between_a_shape_and_the_bounds_there_is_a_seam():
    for gap, proven in ((0.0, True), (9.9e-7, True), (1.2e-6, False)):
        scenario = world(Box(min=(-1, 4, gap), max=(11, 6, 11)), clearance=0.0)
        assert sealed(scenario, 0.5, (5, 2, gap / 2), (5, 8, gap / 2)) == proven
