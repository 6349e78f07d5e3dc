"""Segments run through boxes where dense sampling says so, however thin the boxes are."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from judged_missions import SCENARIO
from skyverse.model.shapes import Box
from skyverse.referee.boxes import deepest_in_boxes, grown_boxes
from skyverse.referee.solid_shapes import solid_shapes

THICK = Box(min=(5, 0, 0), max=(7, 6, 4))


def test_a_path_may_end_just_before_the_thinnest_wall():
    wall = Box(min=(5, 0, 0), max=(5 + 1e-7, 6, 4))
    boxes = grown_boxes(solid_shapes(SCENARIO.model_copy(update={"obstacles": (wall,), "clearance": 0.001})))
    start = np.array([[4.0, 3, 2]])
    assert deepest_in_boxes(boxes, start, np.array([[4.999, 3, 2.5]])) is None
    assert deepest_in_boxes(boxes, start, np.array([[4.999 + 2e-6, 3, 2.5]])) is not None


coordinate = st.floats(-1, 5, allow_nan=False).map(lambda value: round(value, 3))
point = st.tuples(coordinate, coordinate, coordinate)
side = st.sampled_from([1e-7, 1e-3, 0.2, 1.0, 3.0])


@settings(max_examples=150, deadline=None)
@given(
    start=point,
    end=point,
    corner=point,
    sides=st.tuples(side, side, side),
    clearance=st.sampled_from([0.001, 0.25]),
)
def test_the_segment_test_agrees_with_dense_sampling(start, end, corner, sides, clearance):
    box = Box(min=corner, max=tuple(np.add(corner, sides)))
    scenario = SCENARIO.model_copy(update={"obstacles": (box,), "clearance": clearance})
    start, end = np.array([start]), np.array([end])
    met = deepest_in_boxes(grown_boxes(solid_shapes(scenario)), start, end)
    low, high = np.array(box.min) - clearance, np.array(box.max) + clearance
    points = start + np.linspace(0, 1, 4001)[:, None] * (end - start)
    depth = np.minimum(points - low, high - points).min(axis=1).max()
    if depth > 1.001e-6:
        assert met is not None
        assert clearance - met.gap >= depth - 0.05
    if met is not None:
        on_segment = start[0] + met.fraction * (end - start)[0]
        np.testing.assert_allclose(met.position, on_segment, atol=1e-12)
        assert (met.position > low).all()
        assert (met.position < high).all()


def test_only_the_part_of_a_segment_that_is_flown_is_inside_a_box():
    boxes = grown_boxes(solid_shapes(SCENARIO.model_copy(update={"obstacles": (THICK,), "clearance": 0.001})))
    starts = np.array([[4.0, 1.0, 2.0], [4.0, 3.0, 2.0], [8.0, 3.0, 2.0]])
    ends = np.array([[5.5, 1.0, 2.0], [4.5, 3.0, 2.0], [9.0, 3.0, 2.0]])  # on, they would be in the middle of it
    met = deepest_in_boxes(boxes, starts, ends)
    assert met.segment == 0
    assert met.position.tolist() == [5.5, 1.0, 2.0]
    assert met.gap == -0.5


def test_the_farthest_coordinate_of_boxes_bounds_their_rounding():
    boxes = grown_boxes(solid_shapes(SCENARIO.model_copy(update={"obstacles": (THICK,), "clearance": 0.5})))
    assert boxes.farthest == boxes.grown_high.max() == np.abs([boxes.grown_low, boxes.grown_high]).max()
    assert boxes.error(np.zeros((1, 2, 3)), np.array([1e-9]))[0] > 1e-9
