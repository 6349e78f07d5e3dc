"""What the referee says of photos of random ground, beside rays; and of ground on which the answer is known."""

import numpy as np
import pytest

import skyverse as sky
from photographed import found_of, random_case
from skyverse.model.photos import Photos
from skyverse.model.uav import TrackingError
from skyverse.referee.coverage import judge_coverage

# slopes, buildings, cells of 1 to 90 m, straight down and aslant: some proven, some refuted
CHEAP = (2, 3, 5, 6, 7, 8, 12, 13, 15, 16, 17, 19)


@pytest.mark.parametrize("seed", CHEAP)
def test_rays_deny_nothing_that_is_claimed_of_random_ground_and_find_little_that_is_not(seed):
    found = found_of(random_case(seed), count=150, seed=seed, random=4)
    assert not found.wrong
    assert found.missed <= 0.01 * found.certain
    assert found.coverage.verdict.value == "proven" or not found.holds


def test_no_photo_shows_what_of_a_facet_is_below_the_ground():
    corners = [((10, 20, 0), (20, 20, 0), (20, 20, 10)), ((10, 20, 0), (20, 20, 10), (10, 20, 10))]
    scenario = sky.Scenario(
        name="sunk",
        bounds={"min": (-5, -5, 0), "max": (35, 35, 60)},
        clearance=1.0,
        lattice={"step": (5, 5, 5)},
        terrain={"origin": (-5, -5), "step": (1, 1), "heights": np.full((41, 41), 5.0)},
        obstacles=({"shape": "box", "name": "hull", "min": (9, 20, 0), "max": (21, 24, 10.5), "solid": False},),
        surveys=(sky.Survey(pattern="facade", facets=corners, camera="mavic-3e", height=20, overlap=(0, 0)),),
        uavs=({"start": (0, 0, 50), "end": "home"},),
    )
    places = np.array([(x, y, z) for x in (12, 15, 18) for y in (2.0, 8.0) for z in (8.0, 14.0)])
    none = np.zeros(len(places))
    photos = Photos(places, none, none - 10, none, none, none.astype(int), none.astype(int) - 1)
    found = judge_coverage(scenario, 0, photos, [TrackingError(horizontal=0.2, vertical=0.2)])
    assert found.verdict.value == "refuted"
    assert found.seen[0] == pytest.approx(0.5, abs=0.02)
    assert sum(gap.area for gap in found.gaps) == pytest.approx(50.0, abs=2.0)


def scenario_of(area, obstacles, relief, **fields):
    heights = np.array([[0.0, 2.0, 1.0], [1.0, 3.0, 0.0], [2.0, 0.0, 1.0]]) if relief else None
    return sky.Scenario(
        name="below",
        bounds={"min": (-100, -100, 0), "max": (200, 200, 120)},
        clearance=1.0,
        terrain={"origin": (-100, -100), "step": (150, 150), "heights": heights} if relief else None,
        obstacles=obstacles,
        surveys=(sky.Survey(area, "mavic-3e", height=60.0, **fields),),
        uavs=({"start": (0, 0, 50), "end": "home"},),
    )


def strips_over(low, high, along, aside):
    """Return photos on straight strips northwards, 60 m high."""
    x, y = np.meshgrid(np.arange(low, high, aside), np.arange(low, high, along), indexing="ij")
    none, strip = np.zeros(x.size), np.repeat(np.arange(len(x)), x.shape[1])
    places = np.column_stack([x.ravel(), y.ravel(), none + 60.0])
    return Photos(places, none, none - 90, none, none, none.astype(int), strip)


BELOW = {
    "a box": [{"shape": "box", "name": "hall", "min": (0, 0, 0), "max": (40, 30, 20)}],
    "a box as large": [{"shape": "box", "name": "hall", "min": (10, 10, 0), "max": (30, 20, 20)}],
    "two boxes": [
        {"shape": "box", "name": "hall", "min": (0, 0, -1), "max": (22, 30, 20)},
        {"shape": "box", "min": (22, 0, -1), "max": (40, 30, 9)},
    ],
    "a prism": [{"shape": "prism", "vertices": [(-20, 0), (60, 0), (20, 60)], "low": -5, "high": 10}],
    "a cylinder": [{"shape": "cylinder", "centre": (20, 15), "radius": 12, "low": -5, "high": 10}],
    "a sphere": [{"shape": "sphere", "centre": (20, 15, 0), "radius": 20}],
    "voxels": [{"shape": "voxels", "origin": (0, 0, -9), "step": (20, 15, 20), "occupied": np.ones((2, 2, 1), bool)}],
}


@pytest.mark.parametrize("relief", [False, True])
@pytest.mark.parametrize("what", BELOW)
def test_an_area_below_what_stands_there_is_refuted_with_what_that_is(what, relief):
    scenario = scenario_of([(10, 10), (30, 10), (30, 20), (10, 20)], BELOW[what], relief)
    found = judge_coverage(scenario, 0, strips_over(0, 40, 10, 20), [TrackingError()])
    assert found.verdict.value == "refuted"
    assert found.sentence.startswith("nothing of it is open ground, it lies below obstacle")
    assert all(repr(one.name) in found.sentence for one in scenario.obstacles if one.name)
    (again,) = sky.check_photos(scenario, strips_over(0, 40, 10, 20))
    assert again.sentence == found.sentence
    assert scenario.surveys[0].without(again) == ()


@pytest.mark.parametrize("relief", [False, True])
def test_buildings_below_the_photos_change_nothing_of_what_neighbours_share(relief):
    area = [(0, 0), (60, 0), (50, 60), (0, 50)]
    boxes = [
        {"shape": "box", "min": (-5, 20, 0), "max": (25, 35, 40)},
        {"shape": "box", "min": (35, 5, 0), "max": (58, 12, 20)},
    ]
    photos = strips_over(-10, 70, 12.0, 30.0)
    bare, built = (
        judge_coverage(scenario_of(area, those, relief), 0, photos, [TrackingError()]) for those in ([], boxes)
    )
    assert built.area < bare.area
    assert bare.pairs > 5
    assert (built.overlap, built.pairs, built.short) == (bare.overlap, bare.pairs, bare.short)


@pytest.mark.parametrize(("hidden", "why"), [(True, "hidden by obstacle 'hall'"), (False, "no photo shows it finely")])
def test_a_wall_that_only_coarse_photos_could_show_is_hidden_by_what_is_before_it(hidden, why):
    wall = [((20, 20, 0), (40, 20, 0), (40, 20, 10)), ((20, 20, 0), (40, 20, 10), (20, 20, 10))]
    survey = sky.Survey(pattern="facade", facets=wall, camera="mavic-3e", height=20, gsd_of="place", overlap=(0, 0))
    hall = {"shape": "box", "name": "hall", "min": (0, 10, 0), "max": (60, 18, 30)}
    given = scenario_of([(0, 0), (90, 0), (90, 90)], [hall] if hidden else [], relief=False)
    given = given.model_copy(update={"surveys": (survey.model_copy(update={"height": None, "gsd": 0.005}),)})
    places, none = np.array([(x, -80.0, 8.0) for x in (20.0, 30.0, 40.0)]), np.zeros(3)
    photos = Photos(places, none, none, none, none, none.astype(int), none.astype(int) - 1)
    found = judge_coverage(given, 0, photos, [TrackingError()])
    assert found.verdict.value == "refuted"
    assert "overlap is not judged" not in found.sentence
    asked = given.model_copy(update={"surveys": (given.surveys[0].model_copy(update={"overlap": (80, 70)}),)})
    said = judge_coverage(asked, 0, photos, [TrackingError()]).sentence
    assert "; how much photos of walls overlap is not judged" in said
    assert {gap.why[: len(why)] for gap in found.gaps} == {why}
