"""Nothing is proven that leads between grown shapes that touch, overlap a little or leave less than a micrometre."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import handmade
import skyverse as sky
from judged_clearance import world
from sealed_walls import WALL, ridged, sealed_walls, with_ends
from skyverse.model.shapes import Box, Cylinder, Prism, Sphere, Voxels
from skyverse.model.verdict import Verdict
from skyverse.referee import seams
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.polynomial import bernstein
from skyverse.referee.seams import STEPS, find_seam
from skyverse.referee.tolerances import HALF_SEAM, SEAM_SEARCH
from skyverse.referee.world import referee_world

SPAN = {"low": -1.0, "high": 11.0}
EASY = {"max_speed": 50.0, "max_acceleration": 200.0, "max_jerk": 5000.0, "thrust_to_weight": 50.0, "max_tilt": 89.0}


def seam(scenario, *points):
    """The seam on a path through points, or None."""
    path = np.array(points, float)
    with np.errstate(all="ignore"):
        return find_seam(referee_world(scenario), np.stack([path[:-1], path[1:]], axis=1), np.zeros(len(path) - 1))


def walls(kind, gap, clearance=0.0):
    """Two shapes side by side across a space of 10 m, whose grown faces are so far apart at x = 5."""
    c, a, b = clearance, 5 - clearance - gap / 2, 5 + clearance + gap / 2
    if kind == "box":
        return Box(min=(-1, 4, -1), max=(a, 5, 11)), Box(min=(b, 4, -1), max=(11, 5, 11))
    if kind == "prism":
        return tuple(Prism(vertices=((x, 4), (y, 4), (y, 5), (x, 5)), low=-1, high=11) for x, y in ((-1, a), (b, 11)))
    if kind == "cylinder":
        return tuple(Cylinder(centre=(x, 4.5), radius=4 - c, low=-1, high=11) for x in (1 - gap / 2, 9 + gap / 2))
    if kind == "sphere":
        return tuple(Sphere(centre=(x, 4.5, 5), radius=4 - c) for x in (1 - gap / 2, 9 + gap / 2))
    cells = {"step": (1, 1, 12), "occupied": np.ones((6, 1, 1))}
    return Voxels(origin=(a - 6, 4, -1), **cells), Voxels(origin=(b, 4, -1), **cells)


@pytest.mark.parametrize("kind", ["box", "prism", "cylinder", "sphere", "voxels"])
@pytest.mark.parametrize("clearance", [0.0, 1e-9, 0.1])
@pytest.mark.parametrize("gap", [0.0, 1e-9, 5e-7, 9.9e-7, -1e-9, -5e-7, -1.9e-6])
def test_a_flight_between_two_grown_shapes_that_leave_less_than_a_micrometre_is_refuted(kind, clearance, gap):
    scenario = world(*walls(kind, gap, clearance), clearance=clearance)
    found = seam(scenario, (5, 1, 5), (5, 9, 5))
    assert found is not None
    assert found.obstacles == (0, 1)
    assert np.allclose(found.position[[0, 2]], 5)
    assert found.decided
    assert "passes between obstacle 0 and obstacle 1, which leave less than a micrometre" in found.sentence(
        scenario, "uav-1", "at t = 1 s"
    )


@pytest.mark.parametrize("far", [0.0, 1e5])
def test_beside_the_narrowest_place_between_round_shapes_the_gap_there_counts(far):
    gap, radius = 0.9e-6, 2.5
    ball = Sphere(centre=(far - radius - gap / 2, far + 5, 5), radius=radius)
    block = Box(min=(far + gap / 2, far + 4, -1), max=(far + 4, far + 6, 11))
    bounds = sky.Bounds(min=(far - 6, far, 0), max=(far + 6, far + 10, 10))
    scenario = world(ball, block, clearance=0.0).model_copy(update={"bounds": bounds})
    for beside, sealed in ((0.0, True), (0.4e-3, True), (1.5e-3, False)):  # it widens by the square of this over 5 m
        found = seam(scenario, (far, far + 1, 5 + beside), (far, far + 9, 5 + beside))
        assert (found is not None and found.decided) == sealed


@pytest.mark.parametrize("kind", ["box", "prism", "cylinder", "sphere", "voxels"])
@pytest.mark.parametrize("clearance", [0.0, 0.1])
def test_a_gap_of_a_millimetre_may_be_passed_along_either_side(kind, clearance):
    scenario = world(*walls(kind, 1e-3, clearance), clearance=clearance)
    for x in (5 - 0.5e-3, 5, 5 + 0.5e-3):
        assert seam(scenario, (x, 1, 5), (x, 9, 5)) is None


def test_a_slot_within_one_prism_that_fits_exactly_is_a_seam_and_a_wider_one_is_not():
    for wide, sealed in ((0.5, True), (0.5 + 9e-7, True), (0.501, False)):
        corners = ((-1, 3), (5 - wide / 2, 3), (5 - wide / 2, 6), (5 + wide / 2, 6), (5 + wide / 2, 3), (11, 3))
        scenario = world(Prism(vertices=(*corners, (11, 7), (-1, 7)), low=-1, high=11), clearance=0.25)
        found = seam(scenario, (5, 1, 5), (5, 5.5, 5))
        assert (found is not None) == sealed
        if found is not None:
            said = found.sentence(scenario, "uav-1", "here")
            if wide == 0.5:
                assert "passes through a gap in obstacle 0 that leaves less than a micrometre here" in said
            else:  # hardly less, and no proof within one shape that is not convex
                assert not found.decided
                assert "Whether uav-1 leads through a gap in obstacle 0 could not be decided here" in said


@pytest.mark.parametrize("height", [1.0, 1.0 + 5e-7, 1.0 - 1e-6])
def test_between_the_ground_and_what_stands_on_it_there_is_a_seam(height):
    over = Box(min=(-1, 4, 1.0), max=(11, 5, 11))
    scenario = world(over, clearance=0.0, terrain=ridged(1.0, 0.0))
    found = seam(scenario, (5, 1, height), (5, 9, height))
    assert found is not None
    assert found.obstacles[0] == -1
    assert "the ground and obstacle 0" in found.sentence(scenario, "uav-1", "here")


def test_between_the_bounds_and_a_shape_there_is_a_seam_unless_a_millimetre_is_left():
    for gap, sealed in ((0.0, True), (5e-7, True), (9e-7, True), (1e-3, False)):
        scenario = world(Box(min=(-1, 4, gap), max=(11, 5, 11)), clearance=0.0)
        found = seam(scenario, (5, 1, 0), (5, 9, 0))
        assert (found is not None) == sealed
        if found is not None:
            assert "passes between the bounds and obstacle 0" in found.sentence(scenario, "uav-1", "here")


def test_through_an_edge_that_two_boxes_share_there_is_no_way():
    two = Box(min=(-1, -1, -1), max=(5, 5, 11)), Box(min=(5, 5, -1), max=(11, 11, 11))
    for begin, end in (((9, 1, 5), (1, 9, 5)), ((5.5, 4, 5), (4.25, 6.5, 5)), ((9, 1, 3), (1, 9, 7))):
        found = seam(world(*two, clearance=0.0), begin, end)
        assert found is not None
        assert np.allclose(found.position[:2], 5)
        assert seam(world(*two, clearance=0.0), begin, (5, 5, 5), end) is not None
    one = Box(min=(-1, -1, -1), max=(4.999, 4.999, 11)), two[1]
    assert seam(world(*one, clearance=0.0), (9, 1, 5), (1, 9, 5)) is None


def test_from_one_side_of_a_thin_wall_no_flight_is_proven_by_a_flight_on_its_other_side():
    thin = Box(min=(5, 1, -1), max=(5 + 1e-7, 9, 11))
    beside = Box(min=(-1, 1, -1), max=(5, 9, 11))
    assert seam(world(thin, beside, clearance=0.0), (5, 0.5, 5), (5, 9.5, 5)) is not None
    assert seam(world(thin, clearance=0.0), (5, 0.5, 5), (5, 9.5, 5)) is None


FLUSH = {
    "a facade of two houses": ((Box(min=(0, 2, 0), max=(4, 5, 9)), Box(min=(0, 5, 0), max=(4, 8, 9))), (4, 1, 2)),
    "two roofs": ((Box(min=(0, 2, 0), max=(4, 5, 2)), Box(min=(4, 2, 0), max=(9, 5, 2))), (4, 1, 2)),
    "an inner corner": ((Box(min=(0, 0, 0), max=(4, 10, 9)), Box(min=(4, 0, 0), max=(9, 10, 2))), (4, 1, 2)),
    "three walls": (
        (
            Box(min=(0, 0, 0), max=(4, 10, 9)),
            Box(min=(4, 0, 0), max=(9, 10, 2)),
            Box(min=(4, 9, 2), max=(9, 10, 9)),
        ),
        (4, 1, 2),
    ),
    "a slanted notch": ((Prism(vertices=((0, 0), (9, 0), (4, 3), (8, 9), (0, 9)), **SPAN),), (4, 3, 2)),
    "a cylinder": ((Cylinder(centre=(2, 5), radius=2, **SPAN),), (4, 1, 2)),
    "a sphere": ((Sphere(centre=(2, 5, 2), radius=2),), (4, 1, 2)),
}


@pytest.mark.parametrize("clearance", [0.0, 0.25])
@pytest.mark.parametrize("case", FLUSH)
def test_outer_faces_edges_and_inner_corners_may_be_touched(case, clearance):
    shapes, begin = FLUSH[case]
    clearance = 0.0 if case == "a slanted notch" else clearance
    if clearance and case in ("two roofs", "an inner corner", "three walls"):
        begin = tuple(np.array(begin) + clearance)
    elif clearance:
        begin = (begin[0] + clearance, *begin[1:])
    scenario = world(*shapes, clearance=clearance)
    end = begin if case == "a slanted notch" else (begin[0], 9 - clearance, begin[2])
    assert seam(scenario, begin, end) is None


@given(sealed_walls(), st.data())
def test_a_forged_flight_through_a_sealed_wall_is_refuted(wall, data):
    x = data.draw(st.sampled_from(wall.seams))
    y = wall.scenario.bounds.min[1]
    begin, end = (x, y + 1, wall.height), (x, y + 8, wall.height)
    scenario = with_ends(wall.scenario, begin, end)
    uav = scenario.uavs[0].model_copy(update=EASY)
    scenario = scenario.model_copy(update={"uavs": (uav,)})
    mission = replace(handmade.mission(handmade.straight(begin, end, 3.0)), scenario=scenario)
    certificate = sky.certify(scenario, mission).trajectories[0]
    assert certificate.verdict is Verdict.REFUTED, certificate.sentence
    assert WALL - 1 < certificate.position[1] - y < WALL + 1


def test_a_flight_between_knife_edges_that_meet_is_refuted_and_both_are_named():
    noses = [
        Prism(vertices=((x, 4.5), (x + 2.5, 4.2), (x + 5, 4.5), (x + 2.5, 4.8)), low=-2, high=12) for x in (0.0, 5.0)
    ]
    uav = sky.UAV(name="uav-1", start=(5, 1, 3), **EASY)
    target = sky.Target(name="target-1", position=(5, 8, 3))
    scenario = world(*noses, clearance=0.0).model_copy(update={"uavs": (uav,), "targets": (target,)})
    mission = replace(handmade.mission(handmade.straight((5, 1, 3), (5, 8, 3), 3.0)), scenario=scenario)
    (certificate,) = sky.certify(scenario, mission).trajectories
    assert certificate.verdict is Verdict.REFUTED, certificate.sentence
    assert "passes between obstacle 0 and obstacle 1" in certificate.sentence


def test_a_flight_along_the_bounds_is_refuted_where_rounding_leaves_its_clearance_undecided():
    walls = Box(min=(0, 4, -2), max=(5, 5, 12)), Box(min=(5, 4, -2), max=(10.000001000000001, 5, 12))
    begin, end = (10, 1, 3), (10, 8, 3)
    uav, target = sky.UAV(name="uav-1", start=begin, **EASY), sky.Target(name="target-1", position=end)
    scenario = world(*walls, clearance=0.0).model_copy(update={"uavs": (uav,), "targets": (target,)})
    mission = replace(handmade.mission(handmade.straight(begin, end, 3.0)), scenario=scenario)
    (certificate,) = sky.certify(scenario, mission).trajectories
    assert certificate.verdict is Verdict.REFUTED, certificate.sentence


def test_no_step_is_longer_than_half_of_what_is_searched_and_some_leave_a_seam():
    assert SEAM_SEARCH == 10e-6  # as docs/referee.md says
    lengths = np.linalg.norm(STEPS, axis=1)
    assert lengths[0] == 0
    assert np.all((lengths[1:] > HALF_SEAM) & (lengths[1:] <= SEAM_SEARCH / 2))
    directions = STEPS[1:] / lengths[1:, None]
    assert len(np.unique(directions.round(9), axis=0)) == 50
    assert np.abs(directions.sum(axis=0)).max() < 1e-9


def test_what_is_not_found_by_cutting_often_enough_is_undecided_where_it_begins(monkeypatch):
    monkeypatch.setattr(seams, "MAX_DEPTH", 0)
    scenario = world(*walls("box", 0.0), clearance=0.0)
    for ends in (((5, 1, 5), (5, 9, 5)), ((1, 4, 5), (3, 4, 5))):  # through the seam, and along a wall's face
        found = seam(scenario, *ends)
        assert found is not None
        assert not found.decided
        assert (found.piece, found.share) == (0, 0.0)


def test_curves_are_judged_as_paths_are():
    scenario = world(*walls("prism", 0.0), clearance=0.0)
    flown = handmade.straight((5, 1, 5), (5, 9, 5), 3.0)
    curve = PolynomialCurve(flown.knots, flown.coefficients)
    position = bernstein(curve.pieces, curve.durations)
    b = np.stack([part.b for part in position], axis=2)
    found = find_seam(referee_world(scenario), b, np.max([part.error for part in position], axis=0))
    assert found is not None
    assert found.obstacles == (0, 1)
