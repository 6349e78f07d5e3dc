"""Policies find ways among what moves: those that ask a planner, among boxes that hold it, and velocity obstacles."""

from itertools import pairwise

import numpy as np
import pytest

import skyverse as sky
from replanned import BALL, hall
from skyverse.live import Situation, Span, Way, make_policy, problem_now, swept_boxes
from skyverse.model.timed_shapes import TimedShape

TARGET = (19.0, 5.0, 1.0)
VELOCITIES = make_policy("velocity-obstacles")
BRICK = sky.Box(min=(-0.5, -0.1, 0), max=(0.5, 0.1, 1))
TUBE = sky.Cylinder(centre=(0.2, 0), radius=0.3, low=-1, high=2)
DISC = sky.Ellipsoid(centre=(0, 0, 0), semi_axis_xy=1.0, semi_axis_z=0.5)


def situation(*movers, place=(4.0, 5.0, 1.0), velocity=(0.0, 0.0, 0.0), scenario=None, memory=None, now=3.0):
    scenario = hall() if scenario is None else scenario
    return Situation(
        scenario=scenario, uav=0, target=0, world=sky.World(scenario), span=Span(now, now + 0.1, now + 2.5, now + 2.5),
        state=np.array([place, velocity, (0.0, 0, 0)]), stop=np.array(place), movers=movers,
        guidance=Way(np.array([TARGET]), np.zeros(1), np.zeros(1, int)), memory=memory, rng=np.random.default_rng(0),
    )  # fmt: skip


def ball(at, velocity=(0.0, 0.0, 0.0)):
    motion = sky.WaypointMotion(points=[at, np.array(at) + 10 * np.array(velocity)], times=[3, 13])
    return TimedShape(BALL, motion, sky.Doubt(), 0.2)


@pytest.mark.parametrize(
    ("name", "planner"),
    [
        *(("from-scratch", planner) for planner in ("astar", "mvo", "hybrid-mvo", "auto")),
        *(("kept-population", planner) for planner in ("mvo", "hybrid-mvo")),
    ],
)
def test_ways_lead_to_the_target_and_keep_clear_of_where_a_mover_is(name, planner):
    found = make_policy(name, planner=planner, paths=60).find(situation(ball((10.0, 5.0, 1.0))))
    assert tuple(found.way.points[-1]) == TARGET
    path = np.vstack([(4.0, 5.0, 1.0), found.way.points])
    along = np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(path)])
    assert np.linalg.norm(along - (10.0, 5.0, 1.0), axis=1).min() >= BALL.radius + 0.2


def test_no_way_is_found_where_movers_shut_the_hall():
    shut = TimedShape(
        sky.Box(min=(0, -5, -2), max=(1, 5, 4)), sky.WaypointMotion(points=[(10, 5, 1)], times=[0]), sky.Doubt(), 0.2
    )
    assert make_policy("from-scratch", planner="astar").find(situation(shut)).way is None


def test_timed_planners_are_told_the_movers_and_when_the_uav_departs():
    problem = problem_now(situation(ball((10.0, 5.0, 1.0))), 1.0, timed=True)
    assert problem.departs == pytest.approx(3.1)
    assert [mover.shape for mover in problem.scenario.movers] == [BALL]
    assert problem.scenario.obstacles == ()
    boxed = problem_now(situation(ball((10.0, 5.0, 1.0))), 1.0, timed=False)
    assert boxed.scenario.movers == ()
    assert len(boxed.scenario.obstacles) == 4


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("fly", {}),
        ("velocity-obstacles", {"horizont": 1}),
        ("velocity-obstacles", {"horizon": 0}),
        ("velocity-obstacles", {"proven": 1}),
        ("from-scratch", {"planner": "astar", "timed": True}),
        *(("kept-population", {"planner": planner}) for planner in ("astar", "auto")),
    ],
)
def test_wrong_settings_are_refused(name, settings, refuses):
    with refuses():
        make_policy(name, **settings)


def test_a_population_that_is_kept_is_no_worse_than_its_best_path_before():
    policy = make_policy("kept-population", planner="mvo", paths=400)
    wall = sky.Box(min=(9, 2, 0), max=(10, 8, 4))
    scenario = hall(wall)
    first = policy.find(situation(scenario=scenario))
    again = policy.find(situation(scenario=scenario, memory=first.memory))
    assert len(first.memory) > 1
    assert steps(again.memory[0]) <= steps(first.memory[0])
    assert again.effort.generated_paths > 0


def steps(path):
    return len(path)


def test_a_kept_population_is_taken_up_where_the_uav_is_now():
    policy = make_policy("kept-population", planner="mvo", paths=60)
    first = policy.find(situation())
    later = policy.find(situation(place=(8.0, 5.0, 1.0), memory=first.memory))
    assert np.allclose(later.memory[0][0], (8.0, 5.0, 1.0))
    assert tuple(later.way.points[-1]) == TARGET


def test_memory_is_from_the_last_answer_alone():
    policy = make_policy("from-scratch", planner="mvo", paths=60)
    assert policy.find(situation()).memory is None


def flying(*movers, **more):
    return situation(*movers, velocity=(2.0, 0.0, 0.0), now=2.9, **more)


def velocity_of(found, place=(4.0, 5.0, 1.0)):
    return (found.way.points[0] - np.array(place)) / VELOCITIES.horizon


def test_nothing_in_the_way_leads_straight_to_the_target():
    found = VELOCITIES.find(flying())
    assert found.way.points.tolist() == [list(TARGET)]
    assert found.share == 1.0


@pytest.mark.parametrize("at", [(6.0, 5.0, 1.0), (6.0, 5.2, 1.1)])
def test_the_chosen_velocity_meets_no_mover_by_dense_sampling(at):
    one = ball(at, (-1.0, 0.0, 0.0))
    velocity = velocity_of(VELOCITIES.find(flying(one)))
    t = np.linspace(0.0, VELOCITIES.horizon, 2001)[:, None]
    gaps = np.linalg.norm(np.array((4.0, 5.0, 1.0)) + t * velocity - one.motion.at(3.0 + t[:, 0]), axis=1)
    assert gaps.min() >= BALL.radius + 0.2


def test_a_mover_that_goes_away_is_no_obstacle():
    assert VELOCITIES.find(flying(ball((6.0, 5.0, 1.0), (6.0, 0, 0)))).way.points.tolist() == [list(TARGET)]


def test_velocities_that_leave_the_bounds_or_meet_walls_are_not_chosen():
    walls = [sky.Box(min=(0, 6, 0), max=(20, 10, 4)), sky.Box(min=(0, 0, 0), max=(20, 4, 4))]
    scenario = hall(*walls)
    velocity = velocity_of(VELOCITIES.find(flying(ball((6.0, 5.0, 1.2), (-1.0, 0, 0)), scenario=scenario)))
    end = np.array((4.0, 5.0, 1.0)) + 0.5 * velocity
    assert 4.2 <= end[1] <= 5.8
    assert 0.0 <= end[2] <= 4.0


def mover(shape, doubt, keep=0.2):
    motion = sky.WaypointMotion(points=[(0, 0, 0), (4, 2, 1)], times=[0, 4])
    return TimedShape(shape, motion, doubt, keep)


def inside(boxes, point, keep):
    return any(
        np.all((np.array(b.min) - keep <= point + 1e-9) & (point <= np.array(b.max) + keep + 1e-9)) for b in boxes
    )


@pytest.mark.parametrize("shape", [BALL, BRICK, TUBE, DISC])
@pytest.mark.parametrize(
    "doubt", [sky.Doubt(radius=0.1), sky.Doubt(growth=0.5), sky.Doubt(growth=0.5, since=1.0, top_speed=0.6)]
)
def test_a_mover_is_in_them_wherever_it_may_be(shape, doubt):
    one, rng = mover(shape, doubt), np.random.default_rng(3)
    boxes = swept_boxes([one], 1.0, 3.0, 0.2, ())
    for t in np.linspace(1.0, 3.0, 41):
        at, off = one.motion.at([t])[0], float(doubt.at(t)[0])
        for _ in range(20):
            way = rng.normal(size=3)
            moved = at + off * way / np.linalg.norm(way)
            if doubt.top_speed is not None:
                seen = one.motion.at([doubt.since])[0]
                if np.linalg.norm(moved - seen) > doubt.radius + doubt.top_speed * (t - doubt.since):
                    continue
            for corner in rng.uniform(-1, 1, (20, 3)) * 2.5:
                if contains(shape, corner):
                    assert inside(boxes, moved + corner, 0.0)


def contains(shape, at):
    """Whether a point is in a shape, by its definition."""
    if isinstance(shape, sky.Box):
        return np.all((np.array(shape.min) <= at) & (at <= np.array(shape.max)))
    if isinstance(shape, sky.Sphere):
        return np.linalg.norm(at - np.array(shape.centre)) <= shape.radius
    if isinstance(shape, sky.Cylinder):
        return np.hypot(*(at[:2] - np.array(shape.centre))) <= shape.radius and shape.low <= at[2] <= shape.high
    level, up = np.hypot(at[0], at[1]) / shape.semi_axis_xy, at[2] / shape.semi_axis_z
    return level**2 + up**2 <= 1


def test_boxes_around_the_ends_of_a_path_are_left_out():
    one = mover(BALL, sky.Doubt())
    whole = swept_boxes([one], 0.0, 4.0, 0.2, ())
    assert len(whole) == 4
    assert len(swept_boxes([one], 0.0, 4.0, 0.2, [np.array([-0.5, 0.0, 0.0])])) == 3
    assert len(swept_boxes([one], 0.0, 4.0, 0.2, [np.array([-0.7, 0.0, 0.0])])) == 4
