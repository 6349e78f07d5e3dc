"""Photos that were taken: those of a plan are proven, what is missing is found where it is, and flown again."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from planned_surveys import planned_survey

CORNERS = [(0.0, 0.0), (150.0, 0.0), (140.0, 130.0), (0.0, 120.0)]


@cache
def flown(kind, overlap=(75, 40)):
    survey = sky.Survey(CORNERS, "mavic-3e", gsd=0.015, overlap=overlap)
    mission = planned_survey(kind, 1, surveys=[survey])
    return mission.scenario, sky.photos_of(mission)


@cache
def judged(kind):
    """What is found of all photos of a plan."""
    return sky.check_photos(*flown(kind))[0]


def again(scenario, photos, coverage):
    """The photos of a reflight of what is missing."""
    missing = scenario.surveys[0].without(coverage, photos.direction)
    return sky.photos_of(sky.plan_mission(scenario.model_copy(update={"surveys": missing}), rng=1))


@pytest.mark.parametrize("kind", ["flat", "hills", "cross", "corridor", "oblique", "viewpoints"])
def test_the_photos_of_a_plan_are_proven(kind):
    mission = planned_survey(kind, 1)
    assert mission.coverage[0].verdict is sky.Verdict.PROVEN
    (found,) = sky.check_photos(mission.scenario, sky.photos_of(mission))
    assert found.verdict is sky.Verdict.PROVEN, found.sentence
    assert mission.scenario.surveys[0].without(found) == ()


@settings(max_examples=20, deadline=None)
@given(kind=st.sampled_from(["flat", "hills"]), first=st.integers(0, 1000), count=st.sampled_from([1, 3, 10]))
def test_photos_that_are_missing_are_found_where_they_are_and_flown_again(kind, first, count):
    scenario, photos = flown(kind)
    first %= len(photos) - count
    left = np.ones(len(photos), dtype=bool)
    left[first : first + count] = False
    taken = photos.taken(left)
    (found,) = sky.check_photos(scenario, taken)
    if count == 10:
        assert found.gaps
    lost = shapely.union_all(
        shapely.buffer(shapely.points(photos.position[~left][:, :2]), 45.0)
    )  # half a photo's width
    for gap in found.gaps:
        assert shapely.within(shapely.Polygon(gap.outline).centroid, lost)
    if found.gaps:
        assert found.verdict is not sky.Verdict.PROVEN
        (whole,) = sky.check_photos(scenario, taken.joined(again(scenario, taken, found)))
        assert whole.seen[0] > 1 - 1e-9, whole.sentence


LEFT_OUT = {
    "a direction": lambda photos, way: way,
    "all of a direction but two photos": lambda photos, way: way & (np.cumsum(way) > 2),
    "most of a direction": lambda photos, way: way & (photos.position[:, 0] > -10.0),
    "half of a direction": lambda photos, way: way & (photos.position[:, 1] > 60.0),
}


@pytest.mark.parametrize("kind", ["cross", "oblique"])
@pytest.mark.parametrize("left_out", LEFT_OUT)
def test_each_direction_of_a_pattern_must_be_flown_everywhere(kind, left_out):
    survey = sky.Survey(CORNERS, "mavic-3e", gsd=0.015, overlap=(75, 60), pattern=kind, direction=0.0)
    mission = planned_survey(kind, 1, surveys=[survey])
    photos = sky.photos_of(mission)
    assert sky.check_photos(mission.scenario, photos)[0].verdict is sky.Verdict.PROVEN
    heading = np.round(photos.heading) % 360.0
    way = (heading % 180.0 == 0.0) if kind == "cross" else (heading == 90.0) & (photos.pitch > -80.0)
    taken = photos.taken(~LEFT_OUT[left_out](photos, way))
    assert len(taken) < len(photos)
    (found,) = sky.check_photos(mission.scenario, taken)
    assert found.verdict is sky.Verdict.REFUTED, found.sentence


def test_a_few_photos_missing_in_a_strip_are_not_let_pass_however_many_pairs_overlap():
    survey = sky.Survey([(0.0, 0.0), (400.0, 0.0), (400.0, 300.0), (0.0, 300.0)], "mavic-3e", gsd=0.02, direction=0.0)
    mission = planned_survey("flat", 1, surveys=[survey])
    photos = sky.photos_of(mission)
    x, y, _ = photos.position.T
    middle = np.unique(np.round(x, 1))[5]
    lost = (np.abs(x - middle) < 1.0) & (np.abs(y - 150.0) < 40.0)
    (found,) = sky.check_photos(mission.scenario, photos.taken(~lost))
    assert found.short < 0.005 * found.pairs
    assert found.verdict is sky.Verdict.REFUTED, found.sentence


def test_photos_that_look_at_the_horizon_show_nothing_and_harm_nothing():
    scenario, photos = flown("flat")
    middle = photos.position[:, :2] - np.array([70.0, 60.0])
    five = np.argsort(np.hypot(*middle.T), kind="stable")[:5]
    pitch = photos.pitch.copy()
    pitch[five] = 0.0
    tilted = replace(photos, pitch=pitch)
    (found,) = sky.check_photos(scenario, tilted)
    assert found.verdict is sky.Verdict.REFUTED
    (whole,) = sky.check_photos(scenario, tilted.joined(again(scenario, tilted, found)))
    assert whole.verdict is sky.Verdict.PROVEN, whole.sentence


def test_photos_whose_positions_are_not_known_prove_nothing():
    scenario, photos = flown("flat")
    (found,) = sky.check_photos(scenario, photos, position_error=30.0)
    assert found.verdict is not sky.Verdict.PROVEN


def test_the_direction_of_strips_is_that_of_most_photos():
    _, photos = flown("flat")
    turned = np.radians(33.0)
    x, y = photos.position[:, 0], photos.position[:, 1]
    position = np.column_stack(
        [x * np.cos(turned) + y * np.sin(turned), y * np.cos(turned) - x * np.sin(turned), 0 * x]
    )
    assert replace(photos, position=position).direction == pytest.approx((photos.direction + 33.0) % 180.0, abs=0.5)
    assert photos.taken(np.array([0])).direction is None


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"heading": np.nan}, "photos.heading"),
        ({"position": np.inf}, "photos.position"),
        ({"pitch": np.nan}, "photos.pitch"),
    ],
)
def test_numbers_that_are_not_finite_are_refused(change, field):
    scenario, photos = flown("flat")
    (name, value), wrong = next(iter(change.items())), {}
    wrong[name] = getattr(photos, name).copy()
    wrong[name].flat[3] = value
    with pytest.raises(sky.InputError, match=rf"{field}.*expected finite numbers of each photo"):
        sky.check_photos(scenario, replace(photos, **wrong))


def test_photos_that_are_given_more_than_once_count_once():
    scenario, photos = flown("flat")
    once = sky.check_photos(scenario, photos)
    some = np.random.default_rng(1).choice(len(photos), 7)
    for twice in (photos.joined(photos), photos.joined(photos.taken(some)), photos.taken(some).joined(photos)):
        (found,) = sky.check_photos(scenario, twice)
        assert (found.photos, found.seen) == (once[0].photos, once[0].seen)
    assert sky.check_photos(scenario, photos.joined(photos)) == once


@pytest.mark.parametrize("kind", ["flat", "hills"])
def test_cameras_below_the_ground_are_told(kind):
    scenario, photos = flown(kind)
    sunk = replace(photos, position=photos.position - (0.0, 0.0, 1460.0))
    with pytest.raises(sky.InputError, match=r"above the ground.*1,[34]\d\d m below it.*counted from the start"):
        sky.check_photos(scenario, sunk)


BAD = {
    "altitude 0": lambda draw, row: row | {"z": -1000.0},
    "below the ground": lambda draw, row: row | {"z": row["z"] - draw(st.floats(1460.0, 2000.0))},
    "far away": lambda draw, row: (
        row | {"x": row["x"] + draw(st.sampled_from([-1.0, 1.0])) * draw(st.floats(400.0, 1e5))}
    ),
    "too coarse": lambda draw, row: row | {"z": row["z"] + draw(st.floats(60.0, 5000.0))},
    "of the sky": lambda draw, row: row | {"pitch": draw(st.floats(30.0, 90.0))},
}
"""What makes a photo one that shows nothing of what was asked for."""


def with_bad(draw, photos, which):
    """Photos of which some are as if something had gone wrong."""
    position, pitch = photos.position.copy(), photos.pitch.copy()
    for k in which:
        row = {"x": position[k, 0], "z": position[k, 2], "pitch": pitch[k]}
        row = BAD[draw(st.sampled_from(sorted(BAD)))](draw, row)
        position[k, 0], position[k, 2], pitch[k] = row["x"], row["z"], row["pitch"]
    return replace(photos, position=position, pitch=pitch)


@settings(max_examples=20, deadline=None)
@given(data=st.data(), kind=st.sampled_from(["flat", "hills"]))
def test_photos_that_show_nothing_are_left_out_by_name_and_make_no_neighbours_pass(data, kind):
    scenario, photos = flown(kind)
    which = sorted(data.draw(st.sets(st.integers(0, len(photos) - 1), min_size=1, max_size=12)))
    good = np.ones(len(photos), dtype=bool)
    good[which] = False
    names = np.array([f"p{k}" for k in range(len(photos))])
    (without,) = sky.check_photos(scenario, photos.taken(good))
    (corrupt,) = sky.check_photos(scenario, with_bad(data.draw, replace(photos, name=names), which))
    assert sorted(name for some in corrupt.left_out.values() for name in some) == sorted(names[which])
    assert replace(corrupt, left_out={}) == without
    between = np.argsort(np.r_[np.arange(len(photos)), np.array(which) - 0.5])
    more = photos.joined(with_bad(data.draw, photos, which).taken(~good)).taken(between)
    assert replace(sky.check_photos(scenario, more)[0], left_out={}) == judged(kind)


def test_photos_that_are_all_elsewhere_show_nothing():
    scenario, photos = flown("flat")
    (found,) = sky.check_photos(scenario, replace(photos, position=np.add(photos.position, (5000.0, 0.0, 0.0))))
    assert (found.verdict, found.photos, found.seen[0]) == (sky.Verdict.REFUTED, 0, 0.0)
    assert list(map(len, found.left_out.values())) == [len(photos)]
