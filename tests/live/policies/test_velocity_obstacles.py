"""Velocity obstacles choose what meets nothing, and as near as can be to straight ahead."""

import numpy as np
import pytest

import skyverse as sky
from replanned import BALL, hall
from skyverse.live import Situation, Span, Way, make_policy
from skyverse.model.temporary_zones import TimedShape

POLICY = make_policy("velocity-obstacles")
TARGET = np.array([19.0, 5.0, 1.0])


def known(*movers, velocity=(2.0, 0.0, 0.0), place=(4.0, 5.0, 1.0), scenario=None):
    scenario = hall() if scenario is None else scenario
    state = np.array([place, velocity, (0.0, 0.0, 0.0)])
    return Situation(
        scenario=scenario, uav=0, target=0, world=sky.World(scenario), span=Span(0.0, 0.0, 2.5, 2.5), state=state,
        stop=np.array(place), movers=movers, guidance=Way(TARGET[None], np.zeros(1), np.zeros(1, int)), memory=None,
        rng=np.random.default_rng(0),
    )  # fmt: skip


def ball(at, velocity):
    motion = sky.WaypointMotion(points=[at, np.array(at) + 10 * np.array(velocity)], times=[0, 10])
    return TimedShape(BALL, motion, sky.Doubt(), 0.2)


def velocity_of(found, place=(4.0, 5.0, 1.0)):
    return (found.way.points[0] - np.array(place)) / POLICY.horizon


def test_nothing_in_the_way_leads_straight_to_the_target():
    found = POLICY.find(known())
    assert np.array_equal(found.way.points, TARGET[None])
    assert found.share == 1.0


@pytest.mark.parametrize("at", [(6.0, 5.0, 1.0), (6.0, 5.2, 1.1)])
def test_the_chosen_velocity_meets_no_mover_by_dense_sampling(at):
    one = ball(at, (-1.0, 0.0, 0.0))
    velocity = velocity_of(POLICY.find(known(one)))
    t = np.linspace(0.0, POLICY.horizon, 2001)[:, None]
    gaps = np.linalg.norm(np.array((4.0, 5.0, 1.0)) + t * velocity - one.motion.at(t[:, 0]), axis=1)
    assert gaps.min() >= BALL.radius + 0.2


def test_a_mover_that_goes_away_is_no_obstacle():
    assert np.array_equal(POLICY.find(known(ball((6.0, 5.0, 1.0), (6.0, 0, 0)))).way.points, TARGET[None])


def test_velocities_that_leave_the_bounds_or_meet_walls_are_not_chosen():
    walls = [sky.Box(min=(0, 6, 0), max=(20, 10, 4)), sky.Box(min=(0, 0, 0), max=(20, 4, 4))]
    scenario = hall(*walls)
    velocity = velocity_of(POLICY.find(known(ball((6.0, 5.0, 1.2), (-1.0, 0, 0)), scenario=scenario)))
    end = np.array((4.0, 5.0, 1.0)) + 0.5 * velocity
    assert 4.2 <= end[1] <= 5.8
    assert 0.0 <= end[2] <= 4.0


@pytest.mark.parametrize(
    ("settings", "said"),
    [({"horizon": 0}, "horizon is a number above 0, not 0"), ({"proven": 1}, "true or false")],
)
def test_wrong_settings_are_refused(settings, said):
    with pytest.raises(ValueError, match=said):
        make_policy("velocity-obstacles", **settings)
    with pytest.raises(
        ValueError, match="there is no setting 'horizont'; VelocityObstacles has horizon, moment, proven"
    ):
        make_policy("velocity-obstacles", horizont=1)
    with pytest.raises(ValueError, match="there is no policy 'fly'; there are from-scratch"):
        make_policy("fly")
