"""Many runs: what is counted, what touches, and that the answer depends on the seed alone."""

import re
from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from handmade import mission, straight
from skyverse.flight import fly_run, is_no_worse, prepare, vehicle_of

GUSTY = {"gusts": True, "mismatch": 0.2}
WEST = sky.wind_from(8, 270)
RADIUS = vehicle_of("thesis").radius
PAIR = mission(
    straight((0, 0, 2), (2, 0, 2), 1.5),
    straight((2, 2, 2), (0, 2.2, 2.5), 1.5, begin=0.255),
    None,
    boxes=[((1, -1.5, 0), (1.5, -0.6, 3))],
)


@pytest.fixture(scope="module")
def gusty():
    return sky.fly(PAIR, sky.Conditions(wind=WEST, **GUSTY), runs=24, rng=5)


def test_all_numbers_follow_from_the_samples_of_the_runs(gusty):
    fleet = prepare(PAIR, vehicle_of("thesis"), sky.Conditions(wind=WEST, **GUSTY))
    level, upright = [], []
    for k, seed in enumerate(gusty.seeds.tolist()):
        run = fly_run(fleet, seed)
        gaps, apart = [], []
        places = {}
        for uav in (0, 1):
            flown = run.samples[uav]
            away = flown.positions - PAIR.trajectories[uav].at(flown.times).position
            level.append(np.hypot(away[:, 0], away[:, 1]))
            upright.append(np.abs(away[:, 2]))
            assert gusty.largest[k, uav] == pytest.approx([level[-1].max(), upright[-1].max()])
            box = PAIR.scenario.obstacles[0]
            nearest = np.clip(flown.positions, box.min, box.max)
            gaps.append(np.linalg.norm(flown.positions - nearest, axis=1).min())
            times = np.arange(0, 276) / 100
            places[uav] = np.column_stack(
                [np.interp(times, flown.times, flown.positions[:, axis]) for axis in range(3)]
            )
        places[2] = np.tile(PAIR.scenario.uavs[2].start, (276, 1))
        for i, j in ((0, 1), (0, 2), (1, 2)):
            apart.append(np.linalg.norm(places[i] - places[j], axis=1).min())
        assert gusty.clearance[k] == pytest.approx(min(gaps), abs=1e-3)
        assert gusty.separation[k] == pytest.approx(min(apart), abs=1e-3)
    for told, errors in ((gusty.all_errors.horizontal, level), (gusty.all_errors.vertical, upright)):
        errors = np.concatenate(errors)
        assert told.largest == pytest.approx(errors.max())
        assert told.median == pytest.approx(np.quantile(errors, 0.5), abs=1.1e-3)
        assert told.percentile_99 == pytest.approx(np.quantile(errors, 0.99), abs=2e-3)
        assert 0.005 < told.largest < 0.5
    assert gusty.errors[2] is None
    assert max(errors.horizontal.largest for errors in gusty.errors[:2]) == gusty.all_errors.horizontal.largest


def test_the_seed_alone_decides(gusty):
    again = sky.fly(PAIR, sky.Conditions(wind=WEST, **GUSTY), runs=24, rng=5, workers=1)
    assert again == gusty
    other = sky.fly(PAIR, sky.Conditions(wind=WEST, **GUSTY), runs=24, rng=6)
    assert not np.array_equal(other.clearance, gusty.clearance)


def test_a_run_flies_alone_in_rotorpy_by_its_seed(gusty):
    pytest.importorskip("rotorpy", reason='rotorpy is not installed; pip install "skyverse[flight]"')
    alone = sky.fly(PAIR, sky.Conditions(wind=WEST, **GUSTY), rng=int(gusty.seeds[3]))
    assert min(flown.clearance for flown in alone.flown if flown) == pytest.approx(gusty.clearance[3], abs=1e-3)
    assert min(passing.distance for passing in alone.passings) == pytest.approx(gusty.separation[3], abs=1e-3)


@pytest.mark.parametrize(("gap", "touched"), [(RADIUS + 0.03, False), (RADIUS - 0.03, True)])
def test_a_wall_is_touched_by_the_vehicle_s_radius_and_the_referee_agrees(gap, touched):
    beside = mission(straight((0, 0, 2), (1, 0, 2), 1.2), boxes=[((-1, gap, 0), (2, gap + 1, 3))])
    flown = sky.fly(beside, runs=3, rng=1)
    assert flown.safe != touched
    assert flown.clearance.min() == pytest.approx(gap, abs=0.02)
    assert flown.checks == (
        f"Nearest to an obstacle: {flown.clearance.min():.3f} m; the referee's code agrees in the nearest 3.",
    )
    if touched:
        assert len(flown.violations) == 3
        assert flown.sentence == "Not safe: something went wrong in 3 of 3 runs."
        assert "uav-1 touches an obstacle at" in flown.violations[0].message
    else:
        assert flown.sentence.startswith("Safe: nothing was touched in any of 3 runs")


@pytest.mark.parametrize(("offset", "touched"), [(2 * RADIUS + 0.05, False), (2 * RADIUS - 0.05, True)])
def test_two_uavs_touch_within_two_radii(offset, touched):
    flights = straight((0, 0, 2), (1, 0, 2), 1.2), straight((1, offset, 2), (0, offset, 2), 1.2)
    flown = sky.fly(mission(*flights), runs=2, rng=1)
    assert flown.safe != touched
    assert flown.separation.min() == pytest.approx(offset, abs=0.02)
    assert "the referee's code agrees" in flown.checks[0]


def test_the_referee_agrees_of_a_pair_that_is_nearer_to_an_obstacle_than_to_each_other():
    flights = straight((0, 0, 2), (1, 0, 2), 1.2), straight((1, 1.5, 2), (0, 1.5, 2), 1.2)
    beside = mission(*flights, boxes=[((-1, -1.4, 0), (2, -0.4, 3))])
    flown = sky.fly(beside, sky.Conditions(wind=WEST, **GUSTY), runs=3, rng=1)
    assert flown.separation.min() > flown.clearance.min()
    assert [check.partition("; ")[2] for check in flown.checks] == ["the referee's code agrees in the nearest 3."] * 2


@pytest.mark.parametrize(("tube", "held"), [((1.0, 1.0), True), ((0.02, 1.0), False), ((1.0, 0.001), False)])
def test_the_stated_tracking_error_is_held_or_not(tube, held):
    error = sky.TrackingError(horizontal=tube[0], vertical=tube[1])
    flown = mission(straight((0, 0, 2), (2, 0, 2), 1.5), tracking_error=error)
    runs = sky.fly(flown, sky.Conditions(wind=WEST, **GUSTY), runs=4, rng=1)
    assert all(runs.held) == held
    assert ("held in all of 4 runs" in runs.tube_sentence) == held


def test_over_terrain_the_ground_is_touched():
    low = mission(straight((0, 0, 2), (2, 0, 2), 1.5))
    ground = sky.Terrain(origin=(-20, -20), step=(40, 40), heights=[[1.9, 1.9], [1.9, 1.9]])
    scenario = low.scenario.model_copy(update={"terrain": ground})
    flown = sky.fly(sky.Mission(**{**vars(low), "scenario": scenario}), runs=2, rng=1)
    assert "ground" in flown.violations[0].message
    assert flown.clearance.min() == pytest.approx(0.1, abs=0.02)
    assert "Nearest to the ground" in flown.checks[0]


def test_a_lost_uav_is_not_safe():
    flown = sky.fly(mission(straight((0, 0, 2), (2, 0, 2), 1.5)), sky.Conditions(wind=(60, 0, 0)), runs=2, rng=1)
    assert "uav-1 is lost" in flown.violations[0].message


THROUGH = mission(straight((-1, 0, 2), (2.2, 0, 2), 2.0), boxes=[((0.5, -0.2, 0), (0.7, 0.2, 3))])
TUNNEL = mission(
    straight((0, 0, 2), (3, 0, 2), 2.0),
    boxes=[((1, -20, 0), (2, -0.15, 10)), ((1, 0.15, 0), (2, 20, 10))],
    clearance=0.1,
)


def test_a_mission_that_is_too_tight_is_refused_in_one_sentence():
    flown = sky.fly_until_safe(TUNNEL, sky.Conditions(wind=WEST, **GUSTY), runs=20, rng=1)
    assert not flown.safe
    assert flown.sentence == flown.refusal
    assert re.match(r"Refused: by hand at \d+% of its speed is too tight for wind 8, 0, 0 m/s", flown.refusal)
    assert "there is no way left" in flown.refusal
    assert "\n" not in flown.refusal


def test_what_a_mission_says_that_the_referee_found_excuses_nothing():
    told = (sky.Violation(sky.Fault.SEPARATION, (0, 1), "They come too close."),)
    assert not is_no_worse(replace(THROUGH, violations=told), replace(THROUGH, violations=told))
    assert is_no_worse(replace(THROUGH, violations=told), replace(THROUGH, violations=()))
