"""The referee judges the limits on the yaw at every instant."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.trajectory import Pointing
from skyverse.referee.limits import judge_heading
from speed_zones import world_of


@settings(max_examples=100)
@given(
    instants=st.lists(st.floats(0, 10), min_size=1, max_size=6).map(sorted),
    turns=st.lists(st.floats(-2, 2), min_size=6, max_size=6),
    windows=st.tuples(st.floats(0.2, 3), st.floats(0.1, 0.9)),
    uav=st.builds(
        sky.UAV, start=st.just((0, 0, 0)), max_yaw_rate=st.floats(5, 300), max_yaw_acceleration=st.floats(5, 1000)
    ),
)
def test_noses_that_turn_too_fast_are_found_and_no_others(instants, turns, windows, uav):
    spread, share = windows
    pointing = Pointing(0.0, np.array(instants), np.array(turns[: len(instants)]), spread, share * spread)

    def rate(t):
        return np.degrees(pointing.at(t, np.zeros((len(t), 3))).yaw_rate)

    half, flat = 0.5 * spread * (1 + share), 0.5 * spread * (1 - share)
    corners = np.sort(np.add.outer(instants, [-half, -flat, flat, half]).ravel())
    gaps = np.diff(corners)
    assume(gaps.min() > 1e-6)
    slopes = (rate(corners[:-1] + 0.75 * gaps) - rate(corners[:-1] + 0.25 * gaps)) / (0.5 * gaps)
    used = max(np.abs(rate(corners)).max() / uav.max_yaw_rate, np.abs(slopes).max() / uav.max_yaw_acceleration)
    dense = np.linspace(-5, 15, 4001)
    assert np.abs(rate(dense)).max() / uav.max_yaw_rate <= used * (1 + 1e-9)
    assume(abs(used - 1) > 1e-5)
    found = list(judge_heading(uav, 0, pointing))
    assert bool(found) == (used > 1)
    assert all(violation.fault is sky.Fault.YAW for violation in found)


@pytest.fixture(scope="module")
def mission():
    uav, target = sky.UAV(start=(-70, 0, 12), look_at=(0, 30, 0)), sky.Target(position=(70, 0, 12))
    return sky.plan_mission(world_of(uavs=(uav,), targets=(target,)), sky.Taut())


def turned(mission, **changes):
    (flown,) = mission.trajectories
    return replace(mission, trajectories=(replace(flown, pointing=replace(flown.pointing, **changes)),))


def test_planned_headings_are_proven(mission):
    assert sky.check(mission.scenario, mission) == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"instants": np.array([3.0]), "turns": np.array([50.0]), "spread": 0.01, "rise": 0.01}, "yaw rate"),
        ({"instants": np.array([3.0]), "turns": np.array([0.5]), "spread": 2.0, "rise": 0.01}, "yaw acceleration"),
    ],
)
def test_a_nose_that_turns_too_fast_is_refuted(mission, changes, words):
    wrong = turned(mission, **changes)
    certificate = sky.certify(wrong.scenario, wrong).trajectories[0]
    assert certificate.verdict is sky.Verdict.REFUTED
    assert words in certificate.sentence
    assert certificate.time == pytest.approx(3.0, abs=1.1)


@pytest.mark.parametrize(
    "changes",
    [
        {"rise": 0.0},
        {"spread": np.nan},
        {"yaw": "east"},
        {"yaw": np.inf},
        {"turns": np.zeros(1)},
        {"turns": np.array([np.nan, 0.1])},
        {"instants": None},
        {"instants": np.array([1.0, np.inf])},
        {"instants": np.ones((1, 2)), "turns": np.ones((1, 2))},
    ],
)
def test_malformed_turns_are_refuted_in_one_sentence(mission, changes):
    wrong = turned(mission, **{"instants": np.array([1.0, 2.0]), "turns": np.array([0.1, 0.1])} | changes)
    (found,) = [one for one in sky.check(wrong.scenario, wrong) if one.fault is sky.Fault.TRAJECTORY_SHAPE]
    assert "pointing is malformed" in found.message
