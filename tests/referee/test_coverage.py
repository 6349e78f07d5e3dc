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
