"""Proofs against dense sampling, at exact contact, and with peaks exactly at limits."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import skyverse as sky
from skyverse.referee.sorties import Tour
from skyverse.referee.trajectory import judge_trajectory
from skyverse.referee.world import referee_world
from skyverse.trajectory import prove, rest_to_rest
from skyverse.trajectory.path_to_trajectory import SLOWDOWN
from worlds import ROOM

WIDE = {"bounds": sky.Bounds(min=(-1e4,) * 3, max=(1e4,) * 3), "lattice": sky.Lattice(step=(100.0, 100.0, 100.0))}
FREE = ROOM.model_copy(update={"obstacles": (), **WIDE})
OPEN = sky.World(FREE)
LOOSE_ENDS = {sky.Fault.TRAJECTORY_ENDS, sky.Fault.CONTINUITY}
"""Faults that the planners' proof does not examine."""
WIDE = {"max_speed": 1e6, "max_acceleration": 1e6, "max_jerk": 1e6, "max_tilt": 89.0, "thrust_to_weight": 1e6}


def uav(**limits):
    return sky.UAV(start=(0, 0, 0), **(WIDE | limits))


def pieces(knots, coefficients):
    return sky.Trajectory(np.array(knots, float), np.array(coefficients, float))


CALM = uav(max_speed=5, max_acceleration=3)


def dense(trajectory, count=1000):
    """The position and its three derivatives at many instants, (m, 3) each, by numpy alone."""
    motion = [[], [], [], []]
    for k, (a, b) in enumerate(itertools.pairwise(trajectory.knots)):
        t = np.linspace(0, b - a, count)
        for order in range(4):
            columns = [np.polynomial.Polynomial(c).deriv(order)(t) for c in trajectory.coefficients[k].T]
            motion[order].append(np.stack(columns, axis=1))
    return [np.concatenate(m) for m in motion]


def usage(scenario, uav, trajectory):
    """How much of each demand is used at many instants: above 1 is a violation."""
    p, v, a, j = dense(trajectory)
    low = np.array([b.min for b in scenario.obstacles]).reshape(-1, 1, 3) - scenario.clearance
    high = np.array([b.max for b in scenario.obstacles]).reshape(-1, 1, 3) + scenario.clearance
    depth = np.minimum(p - low, high - p).min(axis=2).max(axis=0, initial=-np.inf)
    outside = np.maximum(np.array(scenario.bounds.min) - p, p - np.array(scenario.bounds.max)).max(axis=1)
    f = a + np.array([0, 0, 9.81])
    tilt = np.degrees(np.arctan2(np.linalg.norm(f[:, :2], axis=1), f[:, 2]))
    return {
        "speed": np.linalg.norm(v, axis=1) / uav.max_speed,
        "acceleration": np.linalg.norm(a, axis=1) / uav.max_acceleration,
        "jerk": np.linalg.norm(j, axis=1) / uav.max_jerk,
        "thrust": np.linalg.norm(f, axis=1) / uav.thrust_to_weight / 9.81,
        "tilt": np.maximum(tilt / uav.max_tilt, -a[:, 2] / (0.99 * 9.81)),
        "clearance": 1 + depth,
        "bounds": 1 + outside,
    }


@st.composite
def trajectories(draw, count):
    """Draw quintics that wander about the room; they need not join."""
    durations = np.array(draw(st.lists(st.floats(0.1, 10), min_size=count, max_size=count)))
    far = draw(st.sampled_from([0.05, 0.5, 3.0]))
    rows = draw(arrays(float, (count, 6, 3), elements=st.floats(-1, 1))) * far
    rows[:, 0] += [3.5, 2.5, 2]
    return sky.Trajectory(
        np.r_[1.0, 1 + np.cumsum(durations)], rows / durations[:, None, None] ** np.arange(6)[:, None]
    )


LIMITS = st.builds(
    uav,
    max_speed=st.floats(0.1, 30),
    max_acceleration=st.floats(0.1, 100),
    max_jerk=st.floats(1, 1000),
    max_tilt=st.floats(1, 80),
    thrust_to_weight=st.floats(1.01, 5),
)


@given(trajectories(2), LIMITS)
def test_what_is_proven_holds_at_every_sample_and_what_is_refuted_fails_there(trajectory, uav):
    proof = prove(sky.World(ROOM), uav, trajectory)
    used = usage(ROOM, uav, trajectory)
    worst = max(values.max() for values in used.values())
    if proof.verdict is sky.Verdict.PROVEN:
        assert worst <= 1 + 1e-6
    elif proof.verdict is sky.Verdict.REFUTED:
        k = min(np.searchsorted(trajectory.knots, proof.instant, side="right") - 1, 1)
        alone = [at_one(trajectory, i, proof.instant) for i in {k, max(k - (proof.instant == trajectory.knots[k]), 0)}]
        assert max(usage(ROOM, uav, one)[proof.what].max() for one in alone) > 1
    else:
        assert 1 - 1e-5 < worst < 1 + 1e-5


def at_one(trajectory, k, instant):
    """The instant alone: piece k, shifted there, for a moment so short that nothing changes."""
    shifted = [
        np.polynomial.Polynomial(c)(np.polynomial.Polynomial([instant - trajectory.knots[k], 1])).coef
        for c in trajectory.coefficients[k].T
    ]
    rows = np.zeros((trajectory.coefficients.shape[1], 3))
    for axis, c in enumerate(shifted):
        rows[: len(c), axis] = c
    return pieces([0, 1e-12], rows[None])


@given(trajectories(3), LIMITS)
def test_a_trajectory_that_is_stretched_just_keeps_its_limits(trajectory, uav):
    names = "speed", "acceleration", "jerk", "thrust", "tilt"

    def fits(factor):
        used = usage(ROOM, uav, stretched(trajectory, factor))
        return max(used[name].max() for name in names) <= 1

    factor = least_factor(fits) * (1 + 3e-5)  # the peaks may lie between the instants
    longer = stretched(trajectory, factor)
    assert prove(OPEN, uav, longer).verdict is sky.Verdict.PROVEN
    shorter = stretched(trajectory, factor * (1 - 1e-4))
    assert prove(OPEN, uav, shorter).verdict is sky.Verdict.REFUTED


def least_factor(fits):
    """The least factor that fits, to a relative 1e-8."""
    low, high = 1e-3, 1e6
    assume(not fits(low))
    while high > low * (1 + 1e-8):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if fits(middle) else (middle, high)
    return high


def stretched(trajectory, factor):
    knots = trajectory.knots[0] + (trajectory.knots - trajectory.knots[0]) * factor
    powers = factor ** np.arange(trajectory.coefficients.shape[1])
    return sky.Trajectory(knots, trajectory.coefficients / powers[:, None])


@given(arrays(float, (4, 3), elements=st.integers(-50, 50).map(float)), LIMITS)
@example(
    np.array([(0.0, 0, 0)] * 3 + [(0.0, 1, 12)]),
    uav(max_speed=9, max_acceleration=10, max_jerk=37, max_tilt=62, thrust_to_weight=2),
)
def test_rest_to_rest_whose_peaks_are_exactly_at_the_limits_is_not_refuted_and_proven_a_little_slower(waypoints, uav):
    flight = rest_to_rest(waypoints, uav)
    assert prove(OPEN, uav, flight).verdict is not sky.Verdict.REFUTED  # near free fall the tilt is hard to tell
    assert prove(OPEN, uav, flight.retimed(0.0, SLOWDOWN)).verdict is sky.Verdict.PROVEN


@given(trajectories(2), LIMITS)
def test_what_is_proven_at_the_very_limit_the_referee_proves_too(trajectory, uav):
    factor = least_factor(lambda tried: prove(OPEN, uav, stretched(trajectory, tried)).verdict is sky.Verdict.PROVEN)
    at_the_limit = stretched(trajectory, factor)
    for scale in (1 + 1e-6, 1 + 1e-7, 1.0, 1 - 1e-7):
        longer = stretched(at_the_limit, scale)
        if prove(OPEN, uav, longer).verdict is sky.Verdict.PROVEN:
            judged = judge_trajectory(referee_world(FREE.model_copy(update={"uavs": (uav,)})), 0, Tour(), longer)
            assert {v.fault for v in judged.violations} <= LOOSE_ENDS


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_path_that_touches_faces_edges_and_corners_is_clear(axis):
    cube = sky.Box(min=(1, 1, 1), max=(2, 2, 2))
    world = sky.World(ROOM.model_copy(update={"obstacles": (cube,), "clearance": 0.1}))
    face = np.array([[0.5, 0.9, 1.5], [3.0, 0.9, 1.5]])
    edge = np.array([[0.4, 1.4, 1.5], [1.4, 0.4, 1.5]])
    corner = np.array([[0.4, 1.4, 0.9], [1.4, 0.4, 0.9]])
    for way in (face, edge, corner):
        way = np.roll(way, axis, axis=1)
        assert prove(world, CALM, rest_to_rest(way, CALM)).verdict is sky.Verdict.PROVEN
    for way in (face, edge):
        inward = np.roll(way + np.array([2e-6, 2e-6, 0]), axis, axis=1)
        proof = prove(world, CALM, rest_to_rest(inward, CALM))
        assert (proof.verdict, proof.what) == (sky.Verdict.REFUTED, "clearance")


def test_touching_the_bounds_is_in_bounds_and_a_little_more_is_not():
    world = sky.World(ROOM.model_copy(update={"obstacles": ()}))
    way = np.array([[0, 0, 0], [6, 0, 0], [6, 5, 4]], float)
    assert prove(world, CALM, rest_to_rest(way, CALM)).verdict is sky.Verdict.PROVEN
    proof = prove(world, CALM, rest_to_rest(way + np.array([0, 0, 2e-6]), CALM))
    assert (proof.verdict, proof.what) == (sky.Verdict.REFUTED, "bounds")


def test_a_wall_thinner_than_any_sample_step_is_found():
    pane = sky.Box(min=(3, 0, 0), max=(3.00001, 5, 4))
    world = sky.World(ROOM.model_copy(update={"obstacles": (pane,), "clearance": 0.001}))
    proof = prove(world, CALM, rest_to_rest(np.array([[0.1, 1, 1], [5.7, 2, 1]]), CALM))
    assert proof.verdict is sky.Verdict.REFUTED
    assert proof.what == "clearance"


@pytest.mark.parametrize(
    ("what", "limits"),
    [
        ("speed", {"max_speed": 1.87}),
        ("acceleration", {"max_acceleration": 5.77}),
        ("jerk", {"max_jerk": 59}),
        ("thrust", {"thrust_to_weight": 1.16}),
        ("tilt", {"max_tilt": 30}),
    ],
)
def test_each_limit_is_named_when_it_is_broken(what, limits):
    unit = pieces([0, 1], [[[0, 0, 0], [0, 0, 0], [0, 0, 0], [10, 0, 0], [-15, 0, 0], [6, 0, 0]]])
    proof = prove(OPEN, uav(**limits), unit)
    assert (proof.verdict, proof.what) == (sky.Verdict.REFUTED, what)
    assert 0 <= proof.instant <= 1


def test_a_hundredth_of_the_weight_is_carried_so_that_tilt_has_a_meaning():
    strong = uav(max_speed=100, max_acceleration=12)
    descent = rest_to_rest(np.array([[0, 0, 50], [0, 0, 0], [0, 0, 40]], float), strong)
    assert dense(descent)[2][:, 2].min() == pytest.approx(-0.99 * 9.81, rel=1e-6)
    assert prove(OPEN, strong, descent).verdict is sky.Verdict.PROVEN
    judged = judge_trajectory(referee_world(FREE.model_copy(update={"uavs": (strong,)})), 0, Tour(), descent)
    assert {v.fault for v in judged.violations} <= LOOSE_ENDS
    falling = pieces([0, 1], [[[0, 0, 0], [0, 0, 0], [0, 0, -9.8 / 2]]])
    assert prove(OPEN, strong, falling).what == "tilt"


def test_what_is_not_finite_is_not_proven():
    for value in (math.nan, math.inf):
        assert prove(OPEN, uav(), pieces([0, 1], [[[0, 0, 0], [value, 0, 0]]])).verdict is sky.Verdict.REFUTED


def arc(radius, speed, climb=0.0, count=16):
    """A turn to the left as quintics that agree with the circle in value and two derivatives at their ends."""
    step = 2 * math.pi / count
    duration = step * radius / speed
    rate = speed / radius
    ends = []
    for angle in (0.0, step):
        c, s = math.cos(angle), math.sin(angle)
        up = climb * speed
        ends.append(
            [
                (radius * c, radius * s, up * angle / rate),
                (-speed * s, speed * c, up),
                (-speed * rate * c, -speed * rate * s, 0),
            ]
        )
    powers = [
        [math.perm(i, k) * t ** (i - k) if i >= k else 0.0 for i in range(6)] for t in (0.0, duration) for k in range(3)
    ]
    rows = np.linalg.solve(powers, np.concatenate(ends))
    return pieces([0, duration], rows[None])


@pytest.mark.parametrize(
    ("radius", "speed", "climb", "what"),
    [
        (20.01, 10.0, 0.0, ""),
        (20.01, 10.05, 0.1, ""),
        (19.9, 10.0, 0.0, "turn"),
        (40.0, 10.2, 0.0, "airspeed"),
        (40.0, 9.8, 0.0, "airspeed"),
        (40.0, 10.0, 0.2, "climb"),
        (40.0, 10.0, -0.2, "climb"),
    ],
)
def test_an_aeroplane_keeps_its_airspeed_turns_and_climbs_gently(radius, speed, climb, what):
    wing = sky.FixedWing(speed=10, turn_radius=20, climb=math.degrees(math.atan(0.15)))
    plane = sky.UAV(start=(0, 0, 0), max_speed=11, max_acceleration=6, max_jerk=1e-3, max_tilt=1, fixed_wing=wing)
    proof = prove(OPEN, plane, arc(radius, speed, climb))
    assert proof.what == what
    assert proof.verdict is (sky.Verdict.REFUTED if what else sky.Verdict.PROVEN)
