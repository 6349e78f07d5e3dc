"""Voxels as boxes: exactly the occupied cells, without gaps between them, and quickly."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from judged_clearance import legs, straight, verdict, world
from skyverse.model.shapes import Voxels
from skyverse.referee.boxes import disjoint_boxes
from skyverse.referee.clearance import judge_curve, judge_segments
from skyverse.referee.polynomial import bernstein
from skyverse.referee.world import referee_world


@given(st.integers(0, 10**6), st.sampled_from([0.05, 0.5, 0.95]))
def test_disjoint_boxes_hold_exactly_the_occupied_cells_each_in_one_box(seed, share):
    rng = np.random.default_rng(seed)
    occupied = rng.random(rng.integers(1, 7, 3)) < share
    counted = np.zeros(occupied.shape, dtype=int)
    for first, beyond in zip(*disjoint_boxes(occupied), strict=True):
        counted[tuple(slice(a, b) for a, b in zip(first, beyond, strict=True))] += 1
    assert np.array_equal(counted, occupied.astype(int))


@given(st.integers(0, 2**32), st.sampled_from([0.3, 0.7, 0.9]))
def test_no_border_between_voxels_is_open(seed, share):
    rng = np.random.default_rng(seed)
    occupied = rng.random(rng.integers(1, 6, 3)) < share
    scenario = world(Voxels(origin=(1, 1, 1), step=(0.5, 1, 2), occupied=occupied), clearance=0.001, size=20.0)
    halves = np.argwhere(np.ones(2 * np.array(occupied.shape) + 1, dtype=bool))
    points = 1 + halves * (0.25, 0.5, 1)  # middles, faces, edges and corners of cells
    filled = np.pad(occupied, 1)
    shut = np.array([filled[tuple(slice((c + 1) // 2, c // 2 + 2) for c in half)].any() for half in halves])
    assert np.array_equal(~sky.World(scenario).free(points), shut)
    boxes = referee_world(scenario).boxes
    inside = (points[:, None] > boxes.grown_low) & (points[:, None] < boxes.grown_high)
    assert np.array_equal(inside.all(axis=2).any(axis=1), shut)


def test_no_path_leads_along_the_border_of_voxels():
    grid = np.ones((4, 4, 4), dtype=bool)
    grid[0, 0, 0] = grid[3, 3, 0] = False  # so that it is not one box
    scenario = world(Voxels(origin=(3, 3, 3), step=(1, 1, 1), occupied=grid), clearance=0.001)
    for y, z in ((5, 5), (4, 4), (4, 5.5), (5, 6)):
        met = legs(scenario, (1, y, z), (9, y, z)).incursion
        assert met is not None
        assert 3 - 0.002 < met.position[0] < 7
        assert not sky.World(scenario).segments_free((1, y, z), (9, y, z))[0]
    assert legs(scenario, (1, 5, 7.001), (9, 5, 7.001)).incursion is None  # on the surface


def test_a_solid_block_of_voxels_is_one_box():
    first, beyond = disjoint_boxes(np.ones((5, 4, 3), dtype=bool))
    assert (first.tolist(), beyond.tolist()) == ([[0, 0, 0]], [[5, 4, 3]])


def test_three_hundred_thousand_boxes_of_voxels_are_judged_in_a_moment():
    rng = np.random.default_rng(0)
    voxels = Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=rng.random((128, 128, 64)) < 0.4)
    scenario = world(voxels, clearance=0.1, size=128.0)
    space = referee_world(scenario)
    assert len(space.boxes.low) > 200_000
    flights = [straight((1, 1, 64.1 + k), (127, 120, 64.1 + k)) for k in range(3)]
    for flight in flights:
        assert verdict(judge_curve(space, flight, bernstein(flight.pieces, flight.durations))) == "proven"
    assert judge_segments(space, np.array([[1, 1, 1.0]]), np.array([[127, 120, 60.0]])).incursion is not None
