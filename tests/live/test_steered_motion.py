"""Motions from any state that was flown join it without a jump, keep the limits, and come to rest in time."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import skyverse as sky
from replanned import hall
from skyverse.live import braking_motion, steered_motion
from skyverse.model.wind import STILL_AIR
from skyverse.referee.sorties import Tour
from skyverse.referee.trajectory import judge_trajectory
from skyverse.referee.world import RefereeWorlds
from skyverse.trajectory.limits import limits_of

UAVS = (
    sky.UAV(start=(0, 0, 0)),
    sky.UAV(start=(0, 0, 0), max_speed=12.0, max_acceleration=6.0, max_jerk=20.0, max_climb=3.0, max_descent=2.0),
    sky.UAV(start=(0, 0, 0), max_speed=2.0, max_acceleration=3.0, max_jerk=400.0, max_tilt=10.0),
)
numbers = st.floats(-20, 20)
points = st.lists(st.tuples(numbers, numbers, numbers), min_size=1, max_size=4)


def trajectory(durations, rows):
    return sky.Trajectory(np.append(0.0, np.cumsum(durations)), rows)


def steered(state, way, uav, share, seconds):
    most = np.full(len(way), 0.5)
    return steered_motion(state, np.array(way), most, limits_of(uav, -1e-9, STILL_AIR), share, seconds, 0.5 * seconds)


def faults(uav, motion):
    """What the referee finds wrong with a motion in empty space that may begin and end anywhere."""
    wide = sky.Bounds(min=(-500, -500, -500), max=(500, 500, 500))
    lattice = sky.Lattice(step=(10, 10, 10))
    scenario = hall(uavs=[uav]).model_copy(update={"bounds": wide, "lattice": lattice, "clearance": 0.001})
    found = judge_trajectory(RefereeWorlds(scenario).of(0), 0, Tour(), motion).violations
    return [one for one in found if one.fault is not sky.Fault.TRAJECTORY_ENDS]


@settings(max_examples=60)
@given(st.sampled_from(UAVS), points, points, st.floats(0, 1), st.sampled_from([1.0, 0.6, 0.3]), st.floats(2, 5))
def test_a_motion_joins_what_is_flown_and_comes_to_rest_in_time(uav, before, way, when, share, seconds):
    durations, rows, _, _ = steered(np.zeros((3, 3)), before, uav, 1.0, 8.0)
    assume(len(durations))
    flown = trajectory(durations, rows)
    state = np.concatenate(flown.at([when * flown.end]))
    durations, rows, passed, arrival = steered(state, way, uav, share, seconds)
    if not len(durations):
        durations, rows = braking_motion(state, limits_of(uav, -1e-9, STILL_AIR))
        assume(len(durations))
    else:
        assert durations.sum() <= seconds
        assert arrival >= min(durations.sum(), 0.5 * seconds) - 1e-9
        for point, t in zip(way, passed, strict=True):
            if np.isfinite(t):
                assert np.linalg.norm(trajectory(durations, rows).at([t]).position[0] - point) <= 0.5 + 1e-6
    motion = trajectory(durations, rows)
    for now, then in zip(motion.at([0.0]), state, strict=True):
        assert np.abs(now[0] - then).max() < 1e-7
    end = motion.at([motion.end])
    assert np.abs(end.velocity).max() < 1e-7
    assert np.abs(end.acceleration).max() < 1e-6
    assert faults(uav, motion) == []


def test_a_speed_that_rounding_leaves_above_the_largest_one_makes_no_jump():
    state = np.array(
        [
            (2.6644596128810454, 6.734945108394341, 3.1346854722474595),
            (-0.33926677755941437, 4.967959134609287, 0.4402017229260437),
            (0.28614755840452233, 0.27995009617477695, 0.03127427728126761),
        ]
    )
    way, most = np.array([(2.0, 16.5, 4.0), (2.0, 17.0, 3.0)]), np.array([0.14861387112643157, 0.0])
    durations, rows, _, _ = steered_motion(
        state, way, most, limits_of(UAVS[0], -1e-9, STILL_AIR), 1.0, 1.998571428571429, 0.95
    )
    assert len(durations) > 1
    assert faults(UAVS[0], trajectory(durations, rows)) == []
