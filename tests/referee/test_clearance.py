"""Every shape, and the ground: what is proven clear is so at all samples, and what is refuted at the named place."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import skyverse as sky
from depths import depth
from drawn_shapes import SQUARE, grounds, places, shapes
from judged_clearance import LET_PASS, ROUNDING, judged, legs, of, rest_to_rest, samples, straight, verdict, world
from skyverse.model.quantities import derived
from skyverse.referee.clearance import judge_curve
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.polynomial import bernstein
from skyverse.referee.world import referee_world


def agrees(scenario, curve):
    """Referee and samples agree; what the verdict was."""
    met, deep = judged(scenario, curve), depth(scenario, samples(curve))
    if met.incursion is None:
        assert met.peaks.proven[0], "undecided"
        assert deep.max() <= LET_PASS + ROUNDING
        return "proven"
    there = depth(scenario, met.incursion.position[None])[0]
    assert there > LET_PASS - ROUNDING
    if not any(isinstance(shape, sky.Voxels) for shape in scenario.obstacles):  # cells that are one box are deeper
        assert there == pytest.approx(met.incursion.depth, abs=1e-7)
        assert there >= deep.max() - 1e-7
    at = curve.motion(met.incursion.segment, met.incursion.fraction * curve.durations[met.incursion.segment])[0]
    assert np.allclose(at, met.incursion.position, atol=1e-9)
    return "refuted"


@st.composite
def curves(draw):
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    degree, pieces = draw(st.integers(1, 7)), draw(st.integers(1, 3))
    durations = rng.uniform(0.3, 2, pieces)
    rows = rng.normal(0, 4, (pieces, degree + 1, 3)) / (1.0 + np.arange(degree + 1))[None, :, None] ** 2
    rows[0, 0] = rng.uniform(0, 10, 3)
    for k in range(1, pieces):
        rows[k, 0] = np.sum(rows[k - 1] * durations[k - 1] ** np.arange(degree + 1)[:, None], axis=0)
    return of(np.r_[0.0, np.cumsum(durations)], rows)


@given(st.lists(shapes(), min_size=1, max_size=4), curves(), st.sampled_from([0.001, 0.25, 1.0]))
def test_curves_among_shapes_are_judged_as_dense_sampling_does(obstacles, curve, clearance):
    agrees(world(*obstacles, clearance=clearance), curve)


@given(grounds(), curves(), st.floats(-1, 8))
def test_curves_over_ground_are_judged_as_dense_sampling_does(terrain, curve, lift):
    scenario = world(terrain=terrain)
    seen = samples(curve)
    assume((seen[:, :2].min() > 0) and (seen[:, :2].max() < 10))
    rows = curve.pieces.copy()
    rows[:, 0, 2] += lift
    agrees(scenario, PolynomialCurve(curve.knots, rows))


@given(shapes() | grounds(), curves(), st.sampled_from([-1e-3, -1e-5, 0.0, 5e-7, 2e-6, 1e-3]))
def test_a_curve_that_just_keeps_or_just_breaks_the_clearance_is_decided(shape, curve, off):
    terrain = shape if isinstance(shape, sky.Terrain) else None
    if terrain is not None:
        terrain = terrain.model_copy(update={"clearance": None})
    least = 1e-3
    scenario = world(*([] if terrain else [shape]), clearance=least, terrain=terrain)
    seen = samples(curve)
    assume(terrain is None or (seen[:, :2].min() > 0 and seen[:, :2].max() < 10))
    # the least distance, refined about the best sample
    piece, k = divmod(int(np.argmax(depth(scenario, seen))), 4001)
    step = curve.durations[piece] / 4000
    best = k * step
    for _ in range(4):
        local = np.clip(np.linspace(best - step, best + step, 401), 0, curve.durations[piece])
        values = depth(scenario, curve.motions(np.full(401, piece), local)[:, 0])
        best, step = local[np.argmax(values)], step / 200
    gap = -values.max()
    assume(1e-2 < gap < 20)
    update = {"clearance": least + gap + off}
    met = judged(scenario.model_copy(update=update), curve)
    if off > 1e-6:
        assert met.incursion is not None
        assert met.incursion.depth == pytest.approx(off, abs=2e-7)
    elif off < 5e-7:
        assert verdict(met) == "proven"


@given(st.lists(shapes(), max_size=3), st.none() | grounds(), st.lists(places, min_size=2, max_size=5))
def test_paths_are_judged_as_dense_sampling_does(obstacles, terrain, points):
    scenario = world(*obstacles, terrain=terrain)
    met = legs(scenario, *points)
    path = np.array(points, float)
    at = np.concatenate([a + np.linspace(0, 1, 4001)[:, None] * (b - a) for a, b in pairwise(path)])
    deep = depth(scenario, at).max()
    if met.incursion is None:
        assert verdict(met) == "proven"
        assert deep <= LET_PASS + ROUNDING
    else:
        assert depth(scenario, met.incursion.position[None])[0] > LET_PASS - ROUNDING
        boxes = any(
            isinstance(shape, sky.Box | sky.Voxels) for shape in obstacles
        )  # of a box a hundred places are looked at
        assert met.incursion.depth >= deep - (0.2 if boxes else 1e-7)


SLANTED = sky.Prism(vertices=((0, 0), (40, 30), (34, 38), (-6, 8)), low=0, high=10)
ALONG = np.array([4, 3]) / 5
COURTYARD = sky.Prism(vertices=SQUARE, holes=(((3, 3), (6, 3), (6, 6), (3, 6)),), low=0, high=9)
BESIDE = np.array([3, -4]) / 5


def beside(metres, begin=-100.0, end=100.0, z=5.0):
    """Ends of a line parallel to the slanted wall, so far from it."""
    return [(*(BESIDE * metres + ALONG * t), z) for t in (begin, end)]


@pytest.mark.parametrize(
    ("shape", "a", "b"),
    [
        (SLANTED, *beside(0.25)),
        (SLANTED, *beside(0.25, z=0.0)),
        (SLANTED, (-50, 3, 10.25), (50, 20, 10.25)),
        (
            sky.Prism(vertices=SQUARE, holes=(((3, 3), (6, 3), (6, 6), (3, 6)),), low=0, high=9),
            (3.25, 3.25, 1),
            (3.25, 5.75, 8),
        ),
        (sky.Cylinder(centre=(5, 5), radius=2, low=0, high=9), (7.25, 5, -50), (7.25, 5, 50)),
        (sky.Cylinder(centre=(5, 5), radius=2, low=0, high=9), (-500, 7.25, 2), (500, 7.25, 3)),
        (sky.Cylinder(centre=(5, 5), radius=2, low=0, high=9), (-50, 5, 9.25), (50, 5, 9.25)),
        (sky.Sphere(centre=(5, 5, 5), radius=2), (-500, 5, 7.25), (500, 5, 7.25)),
        (sky.Box(min=(2, 2, 2), max=(4, 4, 4)), (-500, 4.25, 3), (500, 4.25, 3)),
        (sky.Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=np.ones((40, 3, 3))), (-9, 3.25, 1), (50, 3.25, 1)),
    ],
)
def test_a_long_flight_that_touches_is_proven_at_once_and_a_millimetre_in_is_not(shape, a, b):
    scenario, a, b = world(shape), np.array(a, float), np.array(b, float)
    for motion in (straight(a, b), rest_to_rest(a, b)):
        met = judged(scenario, motion)
        assert verdict(met) == "proven"
        assert met.peaks.halvings[0] <= 64
    assert verdict(legs(scenario, a, b)) == "proven"
    pushes = [sign * way / 1000 for way in (*np.eye(3), np.array([*BESIDE, 0])) for sign in (-1, 1)]
    inward = max(pushes, key=lambda push: depth(scenario, samples(straight(a + push, b + push))).max())
    assert agrees(scenario, straight(a + inward, b + inward)) == "refuted"
    met = legs(scenario, a + inward, b + inward)
    assert met.incursion.depth == pytest.approx(1e-3, abs=1e-6)


SLOPE = sky.Terrain(
    origin=(-200, -200), step=(1, 1), heights=np.add.outer(np.arange(501) * 0.5, np.arange(501) * 0.25), clearance=15
)


def on_slope(x, y, metres=15.0):
    return x, y, (x + 200) * 0.5 + (y + 200) * 0.25 + metres


@pytest.mark.parametrize(("a", "b"), [((-150, -150), (250, 230)), ((-150, 7), (250, 7)), ((3.5, -190), (3.5, 290))])
def test_a_long_flight_parallel_to_a_slope_is_proven_and_a_millimetre_in_is_not(a, b):
    scenario = world(terrain=SLOPE)
    for motion in (straight, rest_to_rest):
        met = judged(scenario, motion(on_slope(*a), on_slope(*b)))
        assert verdict(met) == "proven"
        assert met.peaks.halvings[0] < 4000
        met = judged(scenario, motion(on_slope(*a, 14.999), on_slope(*b, 14.999)))
        assert met.incursion.gap == pytest.approx(14.999, abs=1e-9)
    assert verdict(legs(scenario, on_slope(*a), on_slope(*b))) == "proven"
    assert verdict(legs(scenario, on_slope(*a, 14.999), on_slope(*b, 14.999))) == "refuted"


def test_a_flight_that_touches_a_ridge_is_proven_and_a_millimetre_lower_is_refuted_at_the_ridge():
    heights = np.zeros((11, 2))
    heights[5] = 3
    scenario = world(terrain=sky.Terrain(origin=(0, 0), step=(1, 10), heights=heights), clearance=2.0)
    assert verdict(judged(scenario, straight((0, 1, 5), (10, 4, 5)))) == "proven"
    met = judged(scenario, straight((0, 1, 4.999), (10, 4, 4.999), seconds=4))
    assert met.incursion.fraction == pytest.approx(0.5, abs=1e-7)
    assert met.incursion.gap == pytest.approx(1.999)
    assert verdict(legs(scenario, (0, 1, 5), (10, 4, 5))) == "proven"
    assert legs(scenario, (0, 1, 4.999), (10, 4, 4.999)).incursion.fraction == pytest.approx(0.5, abs=1e-7)


@pytest.mark.parametrize(
    ("a", "b"),
    [
        ((2, 2, 4), (7, 7, 4)),
        ((0, 0, 4), (9, 9, 4)),
        ((2, 2, 4), (7, 4, 4)),
        ((2, 7, 4), (7, 2, 4)),
        ((2, 4, 4), (7, 5, 4)),
    ],
)
def test_a_flight_from_corner_to_corner_goes_through(a, b):
    scenario = world(sky.Prism(vertices=SQUARE, low=0, high=9), clearance=0.001)
    assert agrees(scenario, straight(a, b)) == "refuted"
    assert agrees(scenario, rest_to_rest(a, b)) == "refuted"
    assert legs(scenario, a, b).incursion is not None


def test_a_flight_along_a_wall_of_many_edges_is_proven():
    wall = (*((float(x), 2.0) for x in range(9)), (8.0, 5.0), (0.0, 5.0))
    for clearance in (0.001, 0.25):
        scenario = world(sky.Prism(vertices=wall, low=0, high=9), clearance=clearance)
        y = 2 - clearance
        assert agrees(scenario, straight((-5, y, 1), (15, y, 3))) == "proven"
        assert verdict(legs(scenario, (-5, y, 1), (15, y, 3))) == "proven"
        assert verdict(legs(scenario, (-5, y + 0.001, 1), (15, y + 0.001, 3))) == "refuted"


def mission(scenario, trajectory):
    ends = [trajectory.at(t).position[0] for t in (trajectory.start, trajectory.end)]
    agile = {"max_speed": 1e3, "max_acceleration": 1e4, "max_jerk": 1e6, "max_tilt": 89.9, "thrust_to_weight": 1e3}
    update = {
        "uavs": (sky.UAV(start=ends[0], name="alpha", **agile),),
        "targets": (sky.Target(position=ends[1], name="t"),),
    }
    made = sky.Provenance("", "by hand", "", None, "")
    return sky.Mission(scenario.model_copy(update=update), (0,), (None,), (trajectory,), (), made)


def said(scenario, a, b):
    curve = rest_to_rest(a, b)
    judged = mission(scenario, sky.Trajectory(curve.knots, curve.pieces))
    return sky.certify(judged.scenario, judged).trajectories[0]


@pytest.mark.parametrize(
    ("named", "words"),
    [
        ({"name": "Town hall", "kind": "building"}, "obstacle 0 (building 'Town hall')"),
        ({"name": "Town hall"}, "obstacle 0 ('Town hall')"),
        ({"kind": "no-fly zone"}, "obstacle 0 (no-fly zone)"),
        ({}, "obstacle 0"),
    ],
)
def test_an_obstacle_is_called_by_its_kind_and_name(named, words):
    prism = sky.Prism(vertices=SQUARE, low=0, high=9, **named)
    found = said(world(prism), (0, 1.95, 4), (9, 1.95, 4))
    assert found.verdict is sky.Verdict.REFUTED
    assert f"alpha comes within 0.05 m of {words} at t = 0." in found.sentence
    assert found.sentence.endswith("; 0.25 m are required.")
    assert found.time is not None


@pytest.mark.parametrize(("radius", "deeper"), [(0.1, 0), (1.0, 1)])
def test_of_shapes_of_two_kinds_the_one_entered_deeper_is_told(radius, deeper):
    shapes = sky.Box(min=(2, 4.8, 4), max=(3, 5.2, 6)), sky.Sphere(centre=(7, 5, 5), radius=radius)
    met = legs(world(*shapes, clearance=0.001), (0, 5, 5), (10, 5, 5))
    assert met.incursion.obstacle == deeper


def test_the_ground_is_called_the_ground():
    ground = sky.Terrain(origin=(0, 0), step=(10, 10), heights=np.full((2, 2), 2.0), clearance=3.0)
    scenario = world(terrain=ground)
    assert "alpha is only 2.75 m above ground at t = " in said(scenario, (1, 1, 4.75), (9, 9, 4.75)).sentence
    assert "; 3 m are required." in said(scenario, (1, 1, 4.75), (9, 9, 4.75)).sentence
    assert "alpha is 0.5 m below ground at t = " in said(scenario, (1, 1, 1.5), (9, 9, 1.5)).sentence
    proven = said(scenario, (1, 1, 5), (9, 9, 5))
    assert proven.verdict is sky.Verdict.PROVEN
    assert "alpha is 3 m above ground, inside the bounds" in proven.sentence


def test_twenty_thousand_prisms_are_judged_in_a_moment():
    rng = np.random.default_rng(0)
    corners = rng.uniform(0, 10_000, (20_000, 2))
    square = np.array([(0, 0), (20, 0), (20, 15), (0, 15)])
    prisms = tuple(
        sky.Prism.model_construct(vertices=corner + square, holes=(), low=0.0, high=30.0) for corner in corners
    )
    scenario = derived(world(size=1e4), obstacles=prisms)
    space = referee_world(scenario)
    points = np.column_stack([np.arange(61) * 150, np.arange(61) * 140, np.full(61, 29)])
    high = of(np.arange(61), [rest_to_rest(a, b).pieces[0] for a, b in pairwise(points)])
    met = judge_curve(space, high, bernstein(high.pieces, high.durations))
    assert met.incursion is not None


def test_a_minute_over_wide_ground_is_judged_as_samples_see_it():
    rng = np.random.default_rng(0)
    x, y = np.meshgrid(np.arange(500) * 10.0, np.arange(500) * 10.0, indexing="ij")
    heights = 300 * np.sin(x / 700) * np.cos(y / 500) + rng.uniform(0, 3, x.shape)
    terrain = sky.Terrain(origin=(0, 0), step=(10, 10), heights=heights)
    scenario = world(terrain=terrain, clearance=20.0, size=4990.0)
    route = np.column_stack([np.linspace(100, 4800, 61), 2400 + 1500 * np.sin(np.arange(61) / 9)])
    space = referee_world(scenario)
    lift = space.ground.height(route) + 120
    points = np.column_stack([route, lift])
    curve = of(np.arange(61), [rest_to_rest(a, b).pieces[0] for a, b in pairwise(points)])
    met = judge_curve(space, curve, bernstein(curve.pieces, curve.durations))
    assert (met.incursion is None) == (depth(scenario, samples(curve, 101)).max() <= LET_PASS)


def test_a_slanted_wall_thinner_than_what_is_let_pass_is_still_a_wall():
    wall = sky.Prism(vertices=((1, 1), (9, 9), (9 - 1e-6, 9 + 1e-6), (1 - 1e-6, 1 + 1e-6)), low=0, high=9)
    flight = straight((3, 7, 4), (7, 3, 4))
    scenario = world(wall, clearance=0.001)
    assert (
        verdict(judge_curve(referee_world(scenario), flight, bernstein(flight.pieces, flight.durations))) == "refuted"
    )
