"""Aeroplanes' trajectories against dense samples, exact arithmetic, and the planners' proof."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.trajectory import fly_aeroplane, prove


def plane(speed=15.0, turn_radius=40.0, climb=15.0, max_acceleration=8.0, start=(0, 0, 0)):
    wing = sky.FixedWing(speed=speed, turn_radius=turn_radius, climb=climb)
    top = speed / math.cos(math.radians(climb)) * (1 + 1e-12)
    return sky.UAV(start=start, max_speed=top, max_acceleration=max_acceleration, fixed_wing=wing)


def scenario(*boxes, high=(400, 400, 100), low=(0, 0, 0), **others):
    return sky.Scenario(
        name="air",
        bounds=sky.Bounds(min=low, max=high),
        obstacles=tuple(sky.Box(min=box[:3], max=box[3:]) for box in boxes),
        clearance=2,
        lattice=sky.Lattice(step=(5, 5, 5)),
        **others,
    )


EMPTY = sky.World(scenario())
PILLAR = sky.World(scenario((150, 150, 0, 250, 250, 100)))
WALL = sky.World(scenario((200, 0, 0, 210, 400, 50)))
SLALOM = sky.World(
    scenario((100, 0, 0, 110, 260, 100), (220, 140, 0, 230, 400, 100), (340, 0, 0, 350, 260, 100), high=(450, 400, 100))
)
WAYS = {
    "straight": (EMPTY, [(10, 10, 10), (300, 200, 10)]),
    "gentle climb": (EMPTY, [(10, 10, 10), (300, 200, 30)]),
    "bend": (EMPTY, [(20, 20, 10), (380, 20, 10), (380, 380, 20)]),
    "steep descent": (EMPTY, [(100, 200, 100), (300, 200, 0)]),
    "straight up": (EMPTY, [(200, 200, 0), (200, 200, 100)]),
    "a step": (EMPTY, [(200, 200, 50), (200.5, 200, 50)]),
    "nowhere": (EMPTY, [(200, 200, 50), (200, 200, 50)]),
    "one pillar": (PILLAR, [(20, 20, 10), (148, 252, 20), (380, 380, 30)]),
    "over a wall": (WALL, [(100, 200, 10), (198, 200, 52), (212, 200, 52), (300, 200, 10)]),
    "over a wall near by": (WALL, [(180, 200, 10), (198, 200, 52), (212, 200, 52), (230, 200, 10)]),
    "slalom": (
        SLALOM,
        [
            (30, 100, 10),
            (98, 262, 15),
            (112, 262, 15),
            (218, 138, 20),
            (232, 138, 20),
            (338, 262, 25),
            (352, 262, 25),
            (420, 100, 30),
        ],
    ),
}


@pytest.fixture(scope="module", params=WAYS)
def flown(request):
    world, waypoints = WAYS[request.param]
    waypoints = np.array(waypoints, float)
    trajectory = fly_aeroplane(world, waypoints, plane())
    assert trajectory is not None
    assert trajectory.form == "dubins"
    return world, waypoints, trajectory


def samples(trajectory, rate=10_000.0):
    return np.arange(trajectory.start, trajectory.end, 1.0 / rate)


def assert_within_limits(trajectory, uav, rate=10_000.0):
    wing = uav.fixed_wing
    _, velocity, acceleration = trajectory.at(samples(trajectory, rate))
    across = np.hypot(velocity[:, 0], velocity[:, 1])
    np.testing.assert_allclose(across, wing.speed, rtol=1e-7)
    turning = velocity[:, 0] * acceleration[:, 1] - velocity[:, 1] * acceleration[:, 0]
    assert (np.abs(turning) * wing.turn_radius / across**3).max() <= 1
    assert np.abs(velocity[:, 2]).max() <= math.tan(math.radians(wing.climb)) * wing.speed
    assert np.linalg.norm(velocity, axis=1).max() <= uav.max_speed
    assert np.linalg.norm(acceleration, axis=1).max() <= uav.max_acceleration


def assert_joined(trajectory, waypoints):
    ends = trajectory.at([trajectory.start, trajectory.end]).position
    np.testing.assert_allclose(ends, waypoints[[0, -1]], atol=1e-6)
    lengths = np.diff(trajectory.knots)
    assert (lengths > 0).all()
    powers = lengths[:, None] ** np.arange(trajectory.coefficients.shape[1])
    landing = np.einsum("kj,kja->ka", powers, trajectory.coefficients)
    leaving = np.arange(1, powers.shape[1])
    final = np.einsum("kj,kja->ka", powers[:, :-1] * leaving, trajectory.coefficients[:, 1:])
    np.testing.assert_allclose(landing[:-1], trajectory.coefficients[1:, 0], atol=1e-7)
    np.testing.assert_allclose(final[:-1], trajectory.coefficients[1:, 1], atol=1e-6)


def test_limits_hold_at_ten_thousand_samples_a_second(flown):
    _, waypoints, trajectory = flown
    assert_within_limits(trajectory, plane())
    assert_joined(trajectory, waypoints)


def test_the_trajectory_is_proven_clear_and_within_limits(flown):
    world, _, trajectory = flown
    assert prove(world, plane(), trajectory).verdict is sky.Verdict.PROVEN


def product(a, b):
    out = [Fraction(0)] * (len(a) + len(b) - 1)
    for (i, x), (j, y) in itertools.product(enumerate(a), enumerate(b)):
        out[i + j] += x * y
    return out


def plus(a, b, share=1):
    return [x + share * y for x, y in itertools.zip_longest(a, b, fillvalue=Fraction(0))]


def derivative(a):
    return [j * x for j, x in enumerate(a)][1:]


def never_negative(power):
    """Bernstein: a polynomial on [0, 1] is not below the least of its coefficients in that basis."""
    n = len(power) - 1
    return all(
        sum(Fraction(math.comb(i, j), math.comb(n, j)) * power[j] for j in range(i + 1)) >= 0 for i in range(n + 1)
    )


@pytest.mark.parametrize("way", ["straight up", "over a wall near by"])
def test_limits_hold_everywhere_in_exact_arithmetic(way):
    world, waypoints = WAYS[way]
    uav = plane()
    wing = uav.fixed_wing
    trajectory = fly_aeroplane(world, np.array(waypoints, float), uav)
    steepest = Fraction(math.tan(math.radians(wing.climb))) * (1 + Fraction(1, 10**6))
    for rows, duration in zip(trajectory.coefficients, np.diff(trajectory.knots), strict=True):
        T = Fraction(float(duration))
        x, y, z = ([Fraction(float(c)) * T**j for j, c in enumerate(rows[:, axis])] for axis in range(3))
        (vx, ax), (vy, ay) = ((derivative(p), derivative(derivative(p))) for p in (x, y))
        square = plus(product(vx, vx), product(vy, vy))
        speed = [(Fraction(wing.speed) * T) ** 2]
        assert never_negative(plus(square, speed, -(Fraction(99, 100) ** 2)))
        assert never_negative(plus([101**2 * speed[0] / 100**2], square, -1))
        turning = plus(product(vx, ay), product(vy, ax), -1)
        radius = Fraction(wing.turn_radius)
        cube = product(product(square, square), square)
        assert never_negative(plus(cube, product(turning, turning), -(radius**2)))
        vz = derivative(z)
        assert never_negative(plus([steepest**2 * c for c in square], product(vz, vz), -1))


def test_where_the_climb_does_not_fit_it_flies_full_turns():
    """100 m at tan 15 degrees take 373 m of way or more; two full turns of the least radius are 503 m."""
    world, waypoints = WAYS["straight up"]
    trajectory = fly_aeroplane(world, np.array(waypoints, float), plane())
    assert 100 / math.tan(math.radians(15)) < trajectory.end * 15.0 < 2 * 2 * math.pi * 40.0
    heights = trajectory.at(samples(trajectory, 100)).position[:, 2]
    assert (np.diff(heights) >= -1e-9).all()


def test_one_place_is_left_and_reached_by_a_full_turn():
    world, waypoints = WAYS["nowhere"]
    trajectory = fly_aeroplane(world, np.array(waypoints, float), plane())
    assert trajectory.end * 15.0 == pytest.approx(2 * math.pi * 40.0, rel=1e-3)
    alone = fly_aeroplane(world, np.array(waypoints[:1], float), plane())
    assert alone == trajectory


LID = sky.World(scenario((0, 0, 50, 400, 400, 60)))
LOW = sky.World(scenario((200, 0, 0, 210, 400, 50), high=(400, 400, 51)))
SHAFT = sky.World(scenario(high=(60, 60, 200)))


@pytest.mark.parametrize(
    ("world", "waypoints"),
    [
        (LID, [(100, 200, 10), (300, 200, 70)]),
        (LOW, [(100, 200, 10), (300, 200, 10)]),
        (SHAFT, [(30, 30, 10), (30, 30, 150)]),
        (EMPTY, [(100, 200, 10), (300, 200, 101)]),
        (EMPTY, [(-1, 200, 10), (300, 200, 50)]),
    ],
    ids=["a lid", "a ceiling too low", "no room to turn", "target out of bounds", "start out of bounds"],
)
def test_where_there_is_no_way_there_is_no_trajectory(world, waypoints):
    assert fly_aeroplane(world, np.array(waypoints, float), plane()) is None


def test_a_narrower_turn_finds_a_way():
    uav = plane(turn_radius=28.5)
    trajectory = fly_aeroplane(SHAFT, np.array([(1.4, 30, 10), (1.4, 30, 150)]), uav)
    assert trajectory is not None
    assert_within_limits(trajectory, uav, 1000)


PLACES = st.tuples(st.floats(0, 400), st.floats(0, 400), st.one_of(st.just(50.0), st.floats(0, 100)))


@st.composite
def planes(draw):
    speed, radius = draw(st.floats(1, 60)), draw(st.floats(0.5, 60))
    share = draw(st.sampled_from([1.0000001, 1.01, 1.5, 10.0]))
    return plane(speed, radius, draw(st.floats(1, 60)), share * speed**2 / radius)


def test_steep_ways_between_close_walls_are_flown_by_helices():
    """Map 2 leads over and under seven walls, with 1.7 m between one wall's clearance and the next one's."""
    problem = sky.Problem(sky.read("map2"))
    world, path = problem.airspace.world, sky.Taut().plan(problem).path
    narrow = plane(speed=1, turn_radius=0.4, climb=30)
    assert prove(world, narrow, fly_aeroplane(world, path, narrow)).verdict is sky.Verdict.PROVEN


@settings(max_examples=25)
@given(st.lists(PLACES, min_size=2, max_size=5), planes())
def test_whatever_is_flown_among_pillars_is_proven(places, uav):
    waypoints = np.array(places)
    trajectory = fly_aeroplane(PILLAR, waypoints, uav)
    if trajectory is not None:
        assert_within_limits(trajectory, uav, 200.0)
        assert_joined(trajectory, waypoints)
        assert prove(PILLAR, uav, trajectory).verdict is sky.Verdict.PROVEN


@settings(max_examples=30)
@given(st.lists(PLACES, min_size=1, max_size=5), planes())
def test_where_there_is_enough_space_a_way_is_always_found(places, uav):
    room = sky.World(scenario(low=(-900, -900, -1), high=(1300, 1300, 101)))
    trajectory = fly_aeroplane(room, np.array(places), uav)
    assert trajectory is not None
    assert_within_limits(trajectory, uav, 200.0)
    assert prove(room, uav, trajectory).verdict is sky.Verdict.PROVEN


def test_a_mission_carries_it_and_the_referee_finds_nothing_wrong():
    start, target = (20, 20, 10), (380, 380, 30)
    given = scenario((150, 150, 0, 250, 250, 100), uavs=(plane(start=start),), targets=(sky.Target(position=target),))
    mission = sky.plan_mission(given, sky.Taut())
    assert mission.trajectories[0].form == "dubins"
    assert mission.violations == ()
    assert mission.certificates[0].verdict is sky.Verdict.PROVEN


def test_a_uav_without_a_fixed_wing_is_refused(refuses):
    with refuses(ValueError):
        fly_aeroplane(EMPTY, np.zeros((2, 3)), sky.UAV(start=(0, 0, 0)))
