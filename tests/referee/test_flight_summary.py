"""What a mission says is flown is computed anew, and its distance from the path is proven at every instant."""

from dataclasses import replace

import numpy as np
import pytest

from judged_missions import SCENARIO, VALID, flying, put
from skyverse.model.flight_summary import FlightSummary
from skyverse.model.uav import FixedWing
from skyverse.model.verdict import Fault
from skyverse.referee import check
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.flight_summary import _distances, judge_flight_summary
from skyverse.referee.integrals import flight_energy
from skyverse.trajectory.summary import largest_distance

LEGS = np.linalg.norm(np.diff([(0.2, 4.1, 1.2), (4.7, 4.15, 1.8), (9.3, 4.2, 2.4)], axis=0), axis=1).sum()


def dense(trajectory, path):
    """The largest distance of many places from a path."""
    places = trajectory.at(np.linspace(trajectory.start, trajectory.end, 20_001)).position
    a, way = path[:-1], np.diff(path, axis=0)
    share = np.clip(np.einsum("nmk,mk->nm", places[:, None] - a, way) / np.sum(way**2, axis=1), 0, 1)
    return np.linalg.norm(places[:, None] - a - share[..., None] * way, axis=2).min(axis=1).max()


FARTHEST = largest_distance(VALID.trajectories[0], VALID.results[0].path)
CURVE = PolynomialCurve(VALID.trajectories[0].knots, VALID.trajectories[0].coefficients)
ALPHAS = FlightSummary(LEGS, 6.0, flight_energy(CURVE, 120).estimate, FARTHEST)


def stating(summary, mission=VALID):
    return replace(mission, flights=(summary, None, None))


def judged(**changes):
    return check(SCENARIO, stating(replace(ALPHAS, **changes)))


def test_a_true_summary_is_confirmed():
    assert pytest.approx(dense(VALID.trajectories[0], VALID.results[0].path), abs=1e-3) == FARTHEST
    assert judged() == []
    assert judged(deviation=1.0 + FARTHEST) == []
    assert check(SCENARIO, replace(VALID, flights=())) == []


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("length", LEGS * 1.00003, "length of alpha's flight is"),
        ("length", LEGS - 0.001, f"but it is {LEGS:.9g} m"),
        ("time", 5.999, "but it is 6 s"),
        ("energy", ALPHAS.energy * 0.99997, "but it is"),
        ("energy", None, "energy of alpha's flight is None"),
        ("length", np.nan, "length"),
        ("time", np.inf, "time"),
        ("length", "far", "length"),
        ("deviation", np.nan, "which is no distance"),
        ("deviation", np.inf, "which is no distance"),
        ("deviation", -1.0, "which is no distance"),
        ("deviation", FARTHEST - 1e-5, "from the path that was priced at t = "),
        ("deviation", 0.0, f"alpha is {FARTHEST:.6g} m from the path"),
    ],
)
def test_a_false_summary_is_refused(field, value, words):
    (found,) = judged(**{field: value})
    assert (found.fault, found.uavs) == (Fault.FLIGHT, (0,))
    assert words in found.message


@pytest.mark.parametrize(("more", "faults"), [(1e-9, []), (-1e-5, [Fault.FLIGHT])])
def test_a_distance_from_the_path_is_decided_millions_of_metres_from_the_zero_of_the_frame(more, faults):
    far = np.array([5e5, -3e6, 100.0])
    trajectory, path = VALID.trajectories[0], VALID.results[0].path + far
    moved = trajectory.coefficients.copy()
    moved[:, 0] += far
    curve = PolynomialCurve(trajectory.knots, moved)
    claimed = replace(ALPHAS, deviation=FARTHEST + more)
    found = list(judge_flight_summary(SCENARIO, 0, claimed, path, curve))
    assert [one.fault for one in found] == faults


@pytest.mark.parametrize("junk", [3, "fast", VALID.trajectories[0]])
def test_a_value_that_is_no_summary_is_refused(junk):
    assert [found.fault for found in check(SCENARIO, stating(junk))] == [Fault.FLIGHT]


def test_a_summary_of_a_flight_that_is_not_there_is_refused():
    charlie = replace(VALID, flights=(None, None, ALPHAS))
    assert [(found.fault, found.uavs) for found in check(SCENARIO, charlie)] == [(Fault.FLIGHT, (2,))]
    assert [found.fault for found in check(SCENARIO, replace(VALID, flights=(ALPHAS,)))] == [Fault.ASSIGNMENT]


def test_a_path_that_has_nothing_to_do_with_the_flight_is_told_by_how_much():
    path = VALID.results[0].path
    detour = path.copy()
    detour[3:7, 1] = 5.0
    far = dense(VALID.trajectories[0], detour)
    moved = replace(stating(ALPHAS), results=put(VALID.results, 0, replace(VALID.results[0], path=detour)))
    found = [one for one in check(SCENARIO, moved) if one.fault is Fault.FLIGHT]
    assert len(found) == 1
    assert f"alpha is {far:.4g}"[:-1] in found[0].message


@pytest.mark.parametrize(
    "unknown", [{"fixed_wing": FixedWing(speed=1, turn_radius=1, climb=10)}, {"hover_power": None}]
)
def test_an_aeroplane_and_a_uav_of_unknown_power_have_no_energy_that_is_known(unknown):
    plane = SCENARIO.uavs[0].model_copy(update=unknown)
    world = SCENARIO.model_copy(update={"uavs": (plane, *SCENARIO.uavs[1:])})
    faults = [found.fault for found in check(world, replace(stating(replace(ALPHAS, energy=None)), scenario=world))]
    assert Fault.FLIGHT not in faults
    faults = [found.fault for found in check(world, replace(stating(ALPHAS), scenario=world))]
    assert Fault.FLIGHT in faults


def test_a_malformed_flight_is_not_summarised():
    torn = flying(replace(VALID.trajectories[0], knots=np.array([0.0, 0.0, 1.0])))
    assert {found.fault for found in check(SCENARIO, stating(ALPHAS, torn))} == {Fault.TRAJECTORY_SHAPE, Fault.FLIGHT}


def test_distances_from_legs_are_those_from_many_points_of_them():
    rng = np.random.default_rng(2)
    starts = rng.uniform(-1, 1, (40, 3))
    ends = starts + rng.uniform(-1, 1, (40, 3)) * rng.choice([0.0, 1e-3, 0.1, 1.0, 30.0], (40, 1))
    points = rng.uniform(-2, 2, (50, 3))
    shares = np.linspace(0, 1, 4001)[:, None, None]
    legs = starts + shares * (ends - starts)
    found = _distances(points, starts, ends)
    for k, point in enumerate(points):
        least = np.linalg.norm(legs - point, axis=2).min(axis=0)
        assert (found[k] <= least + 1e-12).all()
        assert (found[k] >= least - 0.01).all()
