"""The jumps of a trajectory have one budget, which no number of pieces and no name for its form makes larger."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import skyverse as sky
from handmade import mission, straight
from skyverse.referee.curve import PolynomialCurve, _rounding, ends_of_pieces, judge_continuity

PLACES = st.integers(-(10**6), 10**6).map(lambda number: 0.7 * number)
CREEPING = {"max_speed": 0.01, "max_acceleration": 0.01, "max_jerk": 0.01}


def faults(judged):
    return {found.fault for found in sky.check(judged.scenario, judged)} - {sky.Fault.ASSIGNMENT}


def verdict(judged):
    return sky.certify(judged.scenario, judged).trajectories[0].verdict


def in_places(places, seconds):
    """A UAV that stands still at one place after another."""
    rows = np.zeros((len(places), 1, 3))
    rows[:, 0, 0] = places
    return sky.Trajectory(np.arange(len(places) + 1) * seconds, rows)


def at_speeds(speeds, seconds, z=5.0):
    """A UAV that flies along x at one constant speed after another."""
    rows = np.zeros((len(speeds), 2, 3))
    rows[:, 0, 0] = np.r_[0, np.cumsum(speeds[:-1] * seconds)]
    rows[:, 0, 2] = z
    rows[:, 1, 0] = speeds
    return sky.Trajectory(np.arange(len(speeds) + 1) * seconds, rows)


@pytest.mark.parametrize("pieces", [2, 10, 1000, 10_000])
@pytest.mark.parametrize(("in_all", "expected"), [(0.9e-6, set()), (1.2e-6, {sky.Fault.CONTINUITY})])
def test_the_jumps_in_position_have_one_budget(pieces, in_all, expected):
    judged = mission(in_places(np.linspace(0, in_all, pieces), 1e-9), **CREEPING)
    assert faults(judged) == expected


def test_ten_thousand_jumps_of_a_micrometre_do_not_carry_a_uav_a_centimetre():
    judged = mission(in_places(np.arange(10_000) * 0.999e-6, 1e-9), **CREEPING)
    assert verdict(judged) is sky.Verdict.REFUTED
    (found,) = [found for found in sky.check(judged.scenario, judged) if found.fault is sky.Fault.CONTINUITY]
    assert "9.99e-07 m" in found.message
    assert "0.009989 m" in found.message


@pytest.mark.parametrize(("in_all", "expected"), [(0.9e-6, set()), (1.2e-6, {sky.Fault.CONTINUITY})])
@pytest.mark.parametrize("pieces", [2, 1000])
def test_the_jumps_in_velocity_have_one_budget(pieces, in_all, expected):
    up_and_down = np.concatenate([np.linspace(0, in_all / 2, pieces), np.linspace(in_all / 2, 0, pieces)])
    assert faults(mission(at_speeds(up_and_down, 1e-8), **CREEPING)) == expected


def test_jumps_in_velocity_do_not_accelerate_a_uav():
    up = np.arange(5000) * 0.99e-6
    judged = mission(at_speeds(np.r_[up, up[::-1]], 1e-8), max_speed=5, max_acceleration=0.001, max_jerk=0.001)
    assert verdict(judged) is sky.Verdict.REFUTED


@pytest.mark.parametrize(("in_all", "expected"), [(0.9e-6, set()), (1.2e-6, {sky.Fault.CONTINUITY})])
def test_the_jumps_in_acceleration_have_one_budget(in_all, expected):
    count, seconds = 500, 1e-3
    up_and_down = np.concatenate([np.linspace(0, in_all / 4, count), np.linspace(in_all / 4, 0, count)])
    accelerations = np.concatenate([up_and_down, -up_and_down])
    rows = np.zeros((len(accelerations), 3, 3))
    speeds = np.r_[0, np.cumsum(accelerations * seconds)[:-1]]
    rows[:, 2, 0], rows[:, 1, 0] = accelerations / 2, speeds
    rows[:, 0, 0] = np.r_[0, np.cumsum(speeds * seconds + accelerations / 2 * seconds**2)[:-1]]
    rows[:, 0, 2] = 5
    assert faults(mission(sky.Trajectory(np.arange(len(rows) + 1) * seconds, rows))) == expected


WIDE = {"bounds": sky.Bounds(min=(-1e7, -1e7, 0), max=(1e7, 1e7, 10)), "lattice": sky.Lattice(step=(1e4, 1e4, 5.0))}


@pytest.mark.parametrize("far", [1e5, 1e6])
def test_rounding_far_from_the_origin_is_no_jump_but_carries_no_uav_either(far):
    there = straight((far, 0, 5), (far + 2, 0, 5), 3)
    cuts = np.linspace(0, 3, 301)
    pieces = [_shifted(there.coefficients[0], cut) for cut in cuts[:-1]]
    fine = mission(sky.Trajectory(cuts, np.array(pieces)))
    assert faults(replace(fine, scenario=fine.scenario.model_copy(update=WIDE))) == set()
    ulp = np.spacing(far)
    fast = mission(in_places(far + np.arange(20_000) * 32 * ulp, 1e-9), **CREEPING)
    assert faults(replace(fast, scenario=fast.scenario.model_copy(update=WIDE))) >= {sky.Fault.CONTINUITY}


def test_what_rounding_may_add_is_no_more_than_a_share_of_the_uavs_limits():
    far = 1e6  # where a jump of 8 units in the last place, 9.3e-10 m, might be rounding alone
    creeping = mission(in_places(far + np.arange(3000) * 8 * np.spacing(far), 1e-3), **CREEPING)
    assert sky.Fault.CONTINUITY in faults(replace(creeping, scenario=creeping.scenario.model_copy(update=WIDE)))


@given(arrays.arrays(float, (2, 6, 3), elements=PLACES), st.floats(1e-3, 1e3))
@example(np.full((2, 6, 3), 1e6) * (np.arange(6) == 0)[:, None], 1.0)
def test_the_motion_at_the_end_of_a_piece_is_within_its_stated_error(pieces, seconds):
    curve = PolynomialCurve(np.array([0.0, seconds, 2 * seconds]), pieces)
    (motion,), (error,) = ends_of_pieces(curve)
    assert motion.shape == (3, 3)
    assert error.shape == (3,)
    rows = [[Fraction(float(value)) for value in pieces[0, :, axis]] for axis in range(3)]
    for order in range(3):
        exact = [sum(c * Fraction(seconds) ** power for power, c in enumerate(row)) for row in rows]
        off = [abs(Fraction(float(value)) - true) for value, true in zip(motion[order], exact, strict=True)]
        size = sum(np.linalg.norm([float(row[k]) for row in rows]) * seconds**k for k in range(len(rows[0])))
        assert float(max(off)) <= error[order] <= 1e-14 * size
        rows = [[k * c for k, c in enumerate(row)][1:] for row in rows]


def _shifted(row, since):
    row = row.copy()
    for i in range(len(row) - 1):
        for j in range(len(row) - 2, i - 1, -1):
            row[j] += since * row[j + 1]
    return row


def test_a_jump_that_large_coefficients_hide_in_rounding_is_not_proven():
    rows = np.zeros((2, 5, 3))
    rows[0, 3, 0], rows[0, 4, 0] = 1e11, -1e11  # they cancel at the end of the piece, but for their rounding
    found = faults(mission(sky.Trajectory(np.array([0.0, 1.0, 2.0]), rows)))
    assert found & {sky.Fault.CONTINUITY, sky.Fault.UNDECIDED}


@pytest.mark.parametrize(("jump", "fault"), [(0.0, sky.Fault.UNDECIDED), (1.0, sky.Fault.CONTINUITY)])
def test_a_jump_is_refuted_only_where_rounding_cannot_have_made_it(jump, fault):
    rows = np.zeros((2, 5, 3))
    rows[0, 3, 0], rows[0, 4, 0] = 3 * 2.0**36, -3 * 2.0**36
    rows[1] = _shifted(rows[0], 1.0)  # whole numbers, so exactly
    rows[1, 0, 1] = jump
    curve = PolynomialCurve(np.array([0.0, 1.0, 2.0]), rows)
    (found,) = judge_continuity(sky.UAV(start=(0, 0, 0)), 0, curve)
    assert (found.fault, found.time, found.position) == (fault, 1.0, (0.0, jump, 0.0))


@pytest.mark.parametrize("worst", [1, 2, 4])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_the_worst_jump_of_any_kind_is_told(worst, order):
    jumps = np.full((5, 3, 3), 1e-5)
    jumps[worst] = 0.0
    jumps[worst, order, 1] = 0.01  # in this kind alone
    motion, rows = np.zeros((3, 3)), []
    for jump in jumps:
        motion += jump
        rows.append([motion[0], motion[1], motion[2] / 2])
        motion = np.array([sum(rows[-1]), motion[1] + motion[2], motion[2]])
    (found,) = judge_continuity(sky.UAV(start=(0, 0, 0)), 0, PolynomialCurve(np.arange(6.0), np.array(rows)))
    assert (found.fault, found.time) == (sky.Fault.CONTINUITY, float(worst))
    assert found.position == pytest.approx(tuple(rows[worst][0]))


@pytest.mark.parametrize(
    "form", ["blended", "smooth", "slowed", "straightened", "stop-and-go", "dubins", "teleported", None]
)
@pytest.mark.parametrize("wing", [None, sky.FixedWing(speed=1, turn_radius=1, climb=10)])
def test_the_form_is_only_a_word(form, wing):
    flight = straight((0, 0, 5), (2, 0, 5), 3)
    there_and_back = sky.Trajectory(
        np.array([0.0, 3.0, 6.0]), np.concatenate([flight.coefficients, straight((2, 0, 5), (0, 1, 5), 3).coefficients])
    )
    limits = {} if wing is None else {"fixed_wing": wing}
    plain = sky.check(*_with_scenario(mission(there_and_back, **limits)))
    named = sky.check(*_with_scenario(mission(replace(there_and_back, form=form), **limits)))
    assert named == plain
    assert (not [found for found in plain if found.fault is not sky.Fault.ASSIGNMENT]) == (wing is None)


def _with_scenario(judged):
    return judged.scenario, judged


def test_short_pieces_do_not_make_a_uav_faster_on_average():
    """Pieces whose speed is within the limit, and which jump ahead, are as slow as the limit allows all in all."""
    count, seconds = 4000, 1e-6
    for gain in (0.0, 1e-12, 1e-9):
        speeds = np.full(count, 0.01)
        flight = at_speeds(speeds, seconds)
        rows = flight.coefficients.copy()
        rows[:, 0, 0] += gain * np.arange(count)
        way = rows[-1, 0, 0] + 0.01 * seconds
        judged = mission(replace(flight, coefficients=rows), **CREEPING)
        if sky.Fault.CONTINUITY not in faults(judged):
            assert way <= 0.01 * (1 + 1e-5) * flight.end + 1e-6


def test_rounding_is_bounded_by_what_the_piece_before_allows():
    curve = PolynomialCurve(np.array([0.0, 1.0, 11.0, 111.0]), np.zeros((3, 6, 3)))
    vehicle = sky.UAV(start=(0, 0, 0), max_speed=1.0, max_acceleration=2.0, max_jerk=3.0)
    huge = np.full((2, 4, 3), 1e15)
    rates = np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(_rounding(vehicle, curve, huge), 1e-6 * np.array([rates, 10 * rates]), rtol=1e-12)
