import dataclasses
import math
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.draw import TRACKS, few, in_space, of_search, sample, scene, surface
from traces import columns


def test_a_track_carries_names_places_and_arrival(mission):
    ada, ben = scene(mission).tracks
    assert (ada.name, ada.target_name, ada.start, ada.target) == ("ada", "north", (5, -4, 3), (5, 9, 3))
    assert (ada.arrival, ben.arrival) == (8.0, 5.0)
    np.testing.assert_array_equal(ada.path, mission.results[0].path)
    assert ada.colour != ben.colour


def test_sampled_tracks_stay_close_to_the_true_trajectory(mission):
    for track, trajectory in zip(scene(mission).tracks, mission.trajectories, strict=True):
        assert len(track.times) < 400
        assert set(trajectory.knots) <= set(track.times)
        instants = np.linspace(trajectory.start, trajectory.end, 2000)
        drawn = np.array([track.at(t) for t in instants])
        assert np.abs(drawn - trajectory.at(instants).position).max() < 25 / 3500


@given(st.integers(0, 2**32 - 1), st.floats(0.001, 1))
def test_a_line_of_few_points_strays_by_the_tolerance_at_most(seed, tolerance):
    rng = np.random.default_rng(seed)
    points = rng.normal(0, 0.3, (rng.integers(0, 60), 3)).cumsum(axis=0)
    kept = np.flatnonzero(few(points, tolerance))
    if len(points):
        assert kept[0] == 0
        assert kept[-1] == len(points) - 1
    for first, last in pairwise(kept):
        share = np.linspace(0, 1, 2001)[:, None]
        line = points[first] * (1 - share) + points[last] * share
        for point in points[first:last]:
            assert np.linalg.norm(line - point, axis=1).min() <= tolerance + 0.01


def test_a_uav_waits_before_its_trajectory_and_holds_after_it(mission):
    ben = scene(mission).tracks[1]
    np.testing.assert_allclose(ben.at(0.5), (2, 19, 3))
    np.testing.assert_allclose(ben.at(3.0), (2, 15.5, 3.5), atol=1e-9)
    np.testing.assert_allclose(ben.at(99.0), (2, 12, 4))


def test_the_flown_trail_ends_at_the_uav(mission):
    ada = scene(mission).tracks[0]
    trail = ada.flown(2.0)
    np.testing.assert_allclose(trail[0], (5, -4, 3))
    np.testing.assert_allclose(trail[-1], ada.at(2.0))
    assert len(ada.flown(8.0)) > len(trail)


def test_only_searches_with_iterations_have_a_curve(mission):
    ((track, result),) = scene(mission).curves
    assert (track.name, result.bound) == ("ada", 40.0)
    np.testing.assert_array_equal(result.history.generated_paths, [25, 50, 75, 100])
    np.testing.assert_array_equal(result.history.cost, [90.0, 60.0, 50.0, 44.0])


def test_targets_without_a_uav_are_spare(mission):
    drawn = scene(mission)
    assert drawn.spare_targets == (("spare", (8, 8, 2)),)
    assert drawn.complete
    assert not drawn.notes


def test_trouble_is_told(troubled):
    drawn = scene(troubled)
    assert not drawn.complete
    assert drawn.interrupted
    assert [finding.severity for finding in drawn.findings] == ["warning", "error"]
    assert drawn.findings[0].uavs == (troubled.scenario.uavs[0].name, troubled.scenario.uavs[1].name)
    assert len(drawn.notes) == 3
    assert drawn.notes[0].endswith(f": {sky.Status.NO_PATH.sentence.text}; give lattice step for it")


def test_a_path_without_trajectory_is_complete_where_nobody_flies(grounded):
    drawn = scene(grounded)
    assert drawn.complete
    assert drawn.makespan is None
    np.testing.assert_array_equal(drawn.tracks[0].at(3.0), (5, -4, 3))


def test_a_missing_trajectory_is_noted_where_others_fly(mission):
    drawn = scene(dataclasses.replace(mission, trajectories=(mission.trajectories[0], None)))
    assert not drawn.complete
    assert drawn.notes == ("ben has a path but no trajectory along it.",)


def test_missions_that_only_the_referee_can_judge_are_still_drawn(mission):
    broken = sky.Trajectory(np.array([0.0, np.nan]), np.zeros((1, 6, 3)))
    drawn = scene(dataclasses.replace(mission, assignment=(7, 1), results=(None,), trajectories=(broken,)))
    assert [track.target for track in drawn.tracks] == [None, (2, 12, 4)]
    assert all(len(track.times) == 0 for track in drawn.tracks)


def test_every_uav_of_a_swarm_looks_different(swarm):
    tracks = scene(swarm).tracks
    assert len({(track.colour, track.lap) for track in tracks}) == 30
    assert tracks[len(TRACKS)].colour == TRACKS[0]


def test_brisk_pieces_get_more_samples():
    slow = sky.Trajectory(np.array([0.0, 10.0]), np.array([[[0.0, 0, 0], [1.0, 0, 0]]]))
    brisk = sky.Trajectory(np.array([0.0, 10.0]), np.array([[[0.0, 0, 0], [0.0, 0, 0], [1.0, 0, 0]]]))
    assert len(sample(slow, 0.01)[0]) == 3
    assert len(sample(brisk, 0.01)[0]) > 40


def test_all_boxes_are_one_mesh_and_one_line(mission):
    mesh, edges = in_space(scene(mission))[:2]
    boxes = sorted(mission.scenario.obstacles, key=lambda box: -math.dist(box.min, box.max))
    points, faces = columns(mesh, "xyz"), columns(mesh, "ijk")
    assert len(points) == 8 * len(boxes)
    assert len(faces) == 12 * len(boxes)
    triangles = points[faces]
    areas = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1) / 2
    for number, box in enumerate(boxes):
        a, b, c = np.subtract(box.max, box.min)
        assert areas[12 * number : 12 * number + 12].sum() == pytest.approx(2 * (a * b + b * c + a * c))
    stroke = list(map(tuple, columns(edges, "xyz")[:16]))
    sides = {frozenset(side) for side in pairwise(stroke)}
    assert len(sides) == 12
    assert all(sum(p != q for p, q in zip(*side, strict=True)) == 1 for side in sides)


def test_the_optimum_is_a_dashed_line(mission):
    optimum, best = of_search(scene(mission))
    assert optimum["line"]["dash"] == "dash"
    assert optimum["y"] == [40.0, 40.0]
    assert best["meta"]["paths"] == [25, 50, 75, 100]
    assert best["y"] == [90.0, 60.0, 50.0, 44.0]


def test_zones_are_closed_surfaces_of_the_area_that_they_have(mission):
    comb = ((0, 0), (10, 0), (10, 8), (8, 8), (8, 2), (6, 2), (6, 8), (0, 8))
    zones = (
        sky.Cylinder(centre=(1, 2), radius=2, low=1, high=4, risk=1),
        sky.Prism(vertices=comb, low=0, high=2, risk=1),
        sky.Prism(vertices=comb[::-1], low=0, high=2, risk=1),
    )
    for zone, area in zip(zones, (math.pi * 4, 68.0, 68.0), strict=True):
        points, faces = surface(zone)
        edges = Counter(frozenset(pair) for a, b, c in faces for pair in ((a, b), (b, c), (c, a)))
        assert set(edges.values()) == {2}
        floor = [points[face][:, :2] for face in faces if np.all(points[face, 2] == zone.low)]
        areas = [np.linalg.det([b - a, c - a]) / 2 for c, b, a in floor]
        assert min(areas) > 0
        assert sum(areas) == pytest.approx(area, rel=0.01)
    drawn = scene(dataclasses.replace(mission, scenario=mission.scenario.model_copy(update={"zones": zones})))
    mesh = next(trace for trace in in_space(drawn) if trace["name"] == "zone")
    assert columns(mesh, "ijk").max() < len(columns(mesh, "xyz"))
    assert not any(trace["name"] == "zone" for trace in in_space(scene(mission)))


def test_a_bound_is_called_an_optimum_only_where_it_is_one(mission):
    first, *others = mission.results
    assert scene(mission).bound == "exact optimum"
    for inexact in (
        dataclasses.replace(first, any_angle=True),
        dataclasses.replace(first, terms=first.terms | {"risk": 2.0}),
    ):
        drawn = scene(dataclasses.replace(mission, results=(inexact, *others)))
        assert drawn.bound == "lower bound"
        assert of_search(drawn)[0]["name"].endswith("lower bound")
