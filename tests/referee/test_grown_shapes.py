"""Grown boxes, voxels and prisms as the referee has them, their chords, and bounds on rounding."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import skyverse as sky
from judged_clearance import straight, verdict, world
from judged_missions import SCENARIO
from skyverse.referee.boxes import deepest_in_boxes, disjoint_boxes, grown_boxes
from skyverse.referee.clearance import judge_curve, judge_segments
from skyverse.referee.overlaps import blocks
from skyverse.referee.polynomial import bernstein
from skyverse.referee.prisms import grown_prisms
from skyverse.referee.solid_shapes import solid_shapes
from skyverse.referee.solids import chords, distance_error, distance_to_segment, grown
from skyverse.referee.world import referee_world

EPS = float(np.finfo(float).eps)


THICK = sky.Box(min=(5, 0, 0), max=(7, 6, 4))


def boxes_of(box, clearance):
    return grown_boxes(solid_shapes(SCENARIO.model_copy(update={"obstacles": (box,), "clearance": clearance})))


def test_a_path_may_end_just_before_the_thinnest_wall():
    wall = sky.Box(min=(5, 0, 0), max=(5 + 1e-7, 6, 4))
    boxes = boxes_of(wall, 0.001)
    start = np.array([[4.0, 3, 2]])
    assert deepest_in_boxes(boxes, start, np.array([[4.999, 3, 2.5]])) is None
    assert deepest_in_boxes(boxes, start, np.array([[4.999 + 2e-6, 3, 2.5]])) is not None


def test_only_the_part_of_a_segment_that_is_flown_is_inside_a_box():
    boxes = boxes_of(THICK, 0.001)
    starts = np.array([[4.0, 1.0, 2.0], [4.0, 3.0, 2.0], [8.0, 3.0, 2.0]])
    ends = np.array([[5.5, 1.0, 2.0], [4.5, 3.0, 2.0], [9.0, 3.0, 2.0]])  # on, they would be in the middle of it
    met = deepest_in_boxes(boxes, starts, ends)
    assert met.segment == 0
    assert met.position.tolist() == [5.5, 1.0, 2.0]
    assert met.gap == -0.5


def test_the_farthest_coordinate_of_boxes_bounds_their_rounding():
    boxes = boxes_of(THICK, 0.5)
    assert boxes.farthest == boxes.grown_high.max() == np.abs([boxes.grown_low, boxes.grown_high]).max()
    assert boxes.error(np.zeros((1, 2, 3)), np.array([1e-9]))[0] > 1e-9


@given(st.integers(0, 10**6), st.sampled_from([0.05, 0.5, 0.95]))
def test_disjoint_boxes_hold_exactly_the_occupied_cells_each_in_one_box(seed, share):
    rng = np.random.default_rng(seed)
    occupied = rng.random(rng.integers(1, 7, 3)) < share
    counted = np.zeros(occupied.shape, dtype=int)
    for first, beyond in zip(*disjoint_boxes(occupied), strict=True):
        counted[tuple(slice(a, b) for a, b in zip(first, beyond, strict=True))] += 1
    assert np.array_equal(counted, occupied.astype(int))


def test_a_solid_block_of_voxels_is_one_box():
    first, beyond = disjoint_boxes(np.ones((5, 4, 3), dtype=bool))
    assert (first.tolist(), beyond.tolist()) == ([[0, 0, 0]], [[5, 4, 3]])


def test_three_hundred_thousand_boxes_of_voxels_are_judged_in_a_moment():
    rng = np.random.default_rng(0)
    voxels = sky.Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=rng.random((128, 128, 64)) < 0.4)
    scenario = world(voxels, clearance=0.1, size=128.0)
    space = referee_world(scenario)
    assert len(space.boxes.low) > 200_000
    flights = [straight((1, 1, 64.1 + k), (127, 120, 64.1 + k)) for k in range(3)]
    for flight in flights:
        assert verdict(judge_curve(space, flight, bernstein(flight.pieces, flight.durations))) == "proven"
    assert judge_segments(space, np.array([[1, 1, 1.0]]), np.array([[127, 120, 60.0]])).incursion is not None


SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
COURT = ((0.5, 0.5), (1.5, 0.5), (1.5, 1.5), (0.5, 1.5))
OUTLINES = {
    "square": (SQUARE, ()),
    "courtyard": (SQUARE, (COURT,)),
    "two courtyards": (tuple((2 * x, y) for x, y in SQUARE), (COURT, tuple((x + 2, y) for x, y in COURT))),
    "L": (((0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)), ()),
}


def prisms_of(*names, clearance=0.001):
    prisms = [sky.Prism(vertices=OUTLINES[name][0], holes=OUTLINES[name][1], low=1, high=3) for name in names]
    return grown_prisms(solid_shapes(world(*prisms, clearance=clearance)))


def test_of_no_prisms_there_are_no_boxes():
    assert [corners.shape for corners in prisms_of().hulls()] == [(0, 3), (0, 3)]


@pytest.mark.parametrize("below", [5e-6, 0.5])
def test_a_place_beside_a_prism_is_outside_however_little_it_is_below_the_roof(below):
    place = np.array([[[5.0, 1.0, 3.001 - below]]])
    assert prisms_of("square").depth(place, np.array([0]))[0] == pytest.approx(0.001 - 3, abs=1e-5)


def test_some_prisms_keep_their_own_outlines_and_altitudes():
    prisms = prisms_of(*OUTLINES, clearance=0.25)
    some = prisms.of(np.array([3, 1]))
    for name, k in (("L", 0), ("courtyard", 1)):
        alone = prisms_of(name, clearance=0.25)
        for one, other in zip(some.outlines.of(np.array([k])), alone.outlines, strict=True):
            assert one.tolist() == other.tolist()
        assert [corners[k].tolist() for corners in some.hulls()] == [corners[0].tolist() for corners in alone.hulls()]


@given(arrays.arrays(float, (3, 4, 3), elements=st.integers(-50, 50).map(lambda n: n / 7)))
def test_a_part_is_no_farther_from_its_chord_than_said_and_the_chord_no_longer_than_the_part(part):
    chord = chords(part)
    for k in range(4):
        assert (distance_to_segment(part[:, k], chord.a, chord.b) <= chord.off + 1e-12).all()
    reach = np.linalg.norm(part[:, :, None] - part[:, None], axis=3).max(axis=(1, 2))
    assert (np.linalg.norm(chord.b - chord.a, axis=1) <= reach + 1e-12).all()
    # the chord lies along the coefficient that is farthest from the first one, which is not off at all
    far = part[np.arange(3), np.linalg.norm(part - part[:, :1], axis=2).argmax(axis=1)]
    assert (distance_to_segment(far, chord.a, chord.b) <= 1e-12).all()


@pytest.mark.parametrize("size", [1.0, 1e3, 1e6])
@pytest.mark.parametrize("count", [2, 6])
def test_rounding_errors_of_distances_are_bounded_from_both_sides(size, count):
    b = np.full((1, count, 3), size)
    own, far = (float(distance_error(each, np.zeros(1), farthest)[0]) for each, farthest in ((b, 0.0), (0 * b, size)))
    assert 45 * count * EPS * size <= own <= 500 * count * EPS * size  # 45 halvings of as many coefficients
    assert 8 * EPS * size <= far <= 100 * EPS * size
    assert distance_error(b, np.full(1, 1e-3), 0.0)[0] == pytest.approx(own + 4e-3)


def test_walls_give_way_by_a_micrometre():
    low, high = grown(np.array([1.0]), np.array([1.0 + 1e-7]), 0.5)
    np.testing.assert_allclose([low[0], high[0]], [0.5 + 1e-6, 1.5 + 1e-7 - 1e-6], rtol=1e-12)


@pytest.mark.parametrize(
    ("count", "most", "size", "lengths"),
    [
        (0, 5, 1, []),
        (7, 3, 1, [3, 3, 1]),
        (6, 3, 1, [3, 3]),
        (7, 8, 3, [2, 2, 2, 1]),
        (3, 4, 5, [1, 1, 1]),
        (2, 9, 4, [2]),
        (5, 3, 0, [3, 2]),
    ],
)
def test_all_items_are_in_blocks_of_bounded_size(count, most, size, lengths):
    held = [range(count)[block] for block in blocks(count, most, size)]
    assert [len(items) for items in held] == lengths
    assert [k for items in held for k in items] == list(range(count))


def test_items_take_one_number_unless_more_is_said():
    assert list(blocks(4, 2)) == [slice(0, 2), slice(2, 4)]
