"""Forged missions: every way that we know to make a false mission look proven is refused."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from judged_missions import (
    ALPHA,
    ALPHA_ENDS,
    BEND,
    SCENARIO,
    VALID,
    alpha,
    flying,
    given_uav,
    grounded,
    knots,
    no_result,
    resulting,
    row,
    stops,
    walking,
)

PROVEN = sky.Certificate(sky.Verdict.PROVEN, "All is well.")
ALPHA_FLIES = VALID.trajectories[0]


def claimed(mission):
    """The same mission, which says of itself that everything is proven and that nothing is wrong."""
    own = tuple(None if flight is None else PROVEN for flight in mission.trajectories)
    return replace(mission, certificates=own, apart=PROVEN, violations=())


def rows_of(trajectory, **changes):
    return flying(replace(trajectory, **changes))


def changed_rows(index, value):
    rows = ALPHA_FLIES.coefficients.copy()
    rows[index] = value
    return rows_of(ALPHA_FLIES, coefficients=rows)


def in_pieces(count, seconds):
    """Alpha jumps from its start to its target in equal steps."""
    places = np.linspace(ALPHA, ALPHA_ENDS, count)
    return sky.Trajectory(np.arange(count + 1) * seconds, places[:, None])


def with_knots_at(far):
    return flying(replace(ALPHA_FLIES, knots=far + ALPHA_FLIES.knots))


def of_degree(degree, last=0.0):
    rows = np.zeros((2, degree + 1, 3))
    rows[:, :6] = ALPHA_FLIES.coefficients
    rows[:, degree] += last
    return flying(replace(ALPHA_FLIES, coefficients=rows))


def a_piece_between(begin, end, row):
    """Alpha's first piece, one more piece between two instants after it, and its second piece."""
    first, second = ALPHA_FLIES.coefficients
    return flying(sky.Trajectory(np.array([0.0, begin, end, end + 3]), np.array([first, row, second])))


def still(place):
    rows = np.zeros((6, 3))
    rows[0] = place
    return rows


def moving(power, value, place=BEND):
    rows = still(place)
    rows[power] += value
    return rows


NAN, INF = float("nan"), float("inf")
STRAIGHT = VALID.results[0].path

FORGED = {
    # jumps and durations
    "one jump from start to target": flying(in_pieces(2, 1.0)),
    "a thousand jumps": flying(in_pieces(1000, 1e-3)),
    "a hundred thousand small jumps": flying(in_pieces(10**5, 1e-8)),
    "pieces that last a hundredth of a femtosecond": flying(in_pieces(1000, 1e-17)),
    "pieces that last the smallest number of seconds": flying(in_pieces(1000, 5e-324)),
    "one piece of 0 s": flying(sky.Trajectory(np.zeros(2), still(ALPHA)[None])),
    "one piece of 0 s between two others": a_piece_between(3.0, 3.0, moving(1, 1.0)),
    "a piece that rounding makes last 0 s": a_piece_between(3.0, 3.0 + 1e-16, still(BEND)),
    "a very short piece that is very fast": a_piece_between(3.0, np.nextafter(3.0, 4.0), moving(1, 1e15)),
    "a very short piece that is very bent": a_piece_between(3.0, np.nextafter(3.0, 4.0), moving(2, 1e15)),
    "a very short piece that jerks": a_piece_between(3.0, np.nextafter(3.0, 4.0), moving(3, 1e15)),
    "a place that two pieces pass at different speeds": a_piece_between(3.0, 4.0, moving(1, 1e-5)),
    "knots that fall": knots(0, 4, 3),
    "knots twice": knots(0, 0, 3),
    "knots that begin before the mission": knots(-3, 0, 3),
    "knots too large to tell apart": with_knots_at(1e17),
    "knots beyond all missions": with_knots_at(1e12),
    "too few knots": knots(0, 6),
    "too many knots": knots(0, 2, 4, 6),
    "knots in a matrix": flying(replace(ALPHA_FLIES, knots=ALPHA_FLIES.knots[None])),
    # numbers that are none
    "a NaN among the coefficients": changed_rows((0, 3, 0), NAN),
    "an infinite coefficient": changed_rows((1, 5, 2), INF),
    "a NaN among the knots": knots(0, NAN, 6),
    "an infinite last knot": knots(0, 3, INF),
    "coefficients too large to square": changed_rows((0, 5, 1), 1e200),
    "coefficients as large as numbers get": changed_rows((0, 5, 1), 1.7e308),
    "no coefficients": flying(replace(ALPHA_FLIES, coefficients=np.zeros((2, 0, 3)))),
    "coefficients in two dimensions": flying(replace(ALPHA_FLIES, coefficients=np.zeros((2, 6, 2)))),
    "words for coefficients": flying(replace(ALPHA_FLIES, coefficients=np.full((2, 6, 3), "far"))),
    "a degree beyond all trajectories": of_degree(2000),
    "a large last coefficient of a high degree": of_degree(29, 1e-3),
    # what others fly
    "the trajectory of another UAV": flying(VALID.trajectories[1]),
    "trajectories exchanged": replace(VALID, trajectories=(*VALID.trajectories[1::-1], None)),
    "results exchanged": replace(VALID, results=(*VALID.results[1::-1], None)),
    "targets exchanged": replace(VALID, assignment=(0, 1, None)),
    "a trajectory flown backwards": flying(stops([ALPHA_ENDS, BEND, ALPHA])),
    "a trajectory that goes on beyond its target": flying(stops([ALPHA, ALPHA_ENDS, BEND])),
    "a trajectory that only waits": flying(sky.Trajectory(np.array([0.0, 9.0]), still(ALPHA)[None])),
    "a trajectory with axes exchanged": flying(stops([ALPHA[::-1], BEND, ALPHA_ENDS])),
    "many jumps of a mission that was interrupted": replace(flying(in_pieces(40, 0.1)), interrupted=True),
    "a target that two UAVs have": replace(VALID, assignment=(1, 1, None)),
    "a target that is not there": replace(VALID, assignment=(5, 0, None)),
    "a target counted from the end": replace(VALID, assignment=(-1, 0, None)),
    "a target given as a truth value": replace(VALID, assignment=(True, 0, None)),
    "nobody sent anywhere": sky.Mission(SCENARIO, (None,) * 3, (None,) * 3, (None,) * 3, (), VALID.provenance),
    "fewer UAVs than there are": replace(
        VALID, assignment=(1, 0), results=VALID.results[:2], trajectories=VALID.trajectories[:2]
    ),
    "more UAVs than there are": replace(VALID, trajectories=(*VALID.trajectories, ALPHA_FLIES)),
    "a UAV that stays behind": grounded(VALID),
    "a flight although there is no path": resulting(no_result()),
    # results
    "a path through an obstacle": walking(row((0, 4, 1), ("y", -2), ("x", 9), ("y", 2), ("z", 1)), 15, 0.9),
    "a path with a NaN": alpha(path=np.where(STRAIGHT == 4.0, NAN, STRAIGHT)),
    "a path that ends short of its goal": alpha(path=STRAIGHT[:-1]),
    "a path that jumps": alpha(path=STRAIGHT[[0, 1, -2, -1]]),
    "a path called straight that counts nodes": alpha(any_angle=True),
    "a path called neither": alpha(any_angle="no"),
    "the goal of another UAV": alpha(goal=VALID.results[1].goal),
    "the start of another UAV": alpha(start=VALID.results[1].start),
    "a status that is none": alpha(status="optimal"),
    "a UAV not planned although nothing was interrupted": resulting(
        no_result(sky.Status.NOT_PLANNED), mission=grounded(VALID)
    ),
    "a start called out of bounds": resulting(no_result(sky.Status.START_OUT_OF_BOUNDS), mission=grounded(VALID)),
    # other worlds
    "a scenario without obstacles": replace(VALID, scenario=SCENARIO.model_copy(update={"obstacles": ()})),
    "a scenario with less clearance": replace(VALID, scenario=SCENARIO.model_copy(update={"clearance": 0.001})),
    "a scenario with another name": replace(VALID, scenario=SCENARIO.model_copy(update={"name": "elsewhere"})),
    "a scenario with a faster UAV": given_uav(0, max_speed=500),
    "a scenario with a UAV elsewhere": given_uav(0, start=(0.3, 4.1, 1.2)),
}


def test_the_mission_that_is_forged_was_proven():
    assert sky.check(SCENARIO, claimed(VALID)) == []


@pytest.mark.parametrize("forged", FORGED.values(), ids=FORGED)
def test_a_forged_mission_is_refused(forged):
    assert sky.check(SCENARIO, forged) != []
    assert sky.check(SCENARIO, claimed(forged)) != []


FLIGHTS = [name for name, mission in FORGED.items() if mission.trajectories != VALID.trajectories]


@pytest.mark.parametrize("forged", [FORGED[name] for name in FLIGHTS if "UAV" not in name], ids=lambda mission: "")
def test_a_forged_flight_is_not_certified(forged):
    found = sky.certify(SCENARIO, forged).trajectories[0]
    assert found is None or found.verdict is not sky.Verdict.PROVEN or forged.trajectories[0] is ALPHA_FLIES


def test_a_million_smaller_jumps_are_refused():
    forged = flying(in_pieces(10**6, 1e-9))
    assert sky.check(SCENARIO, claimed(forged)) != []
    assert sky.certify(SCENARIO, forged).trajectories[0].verdict is not sky.Verdict.PROVEN


@pytest.mark.parametrize("form", ["blended", "smooth", "slowed", "straightened", "stop-and-go", "dubins"])
def test_no_name_of_a_form_saves_a_forged_flight(form):
    for name in ("a thousand jumps", "a very short piece that is very bent"):
        flight = replace(FORGED[name].trajectories[0], form=form)
        assert sky.check(SCENARIO, flying(flight)) == sky.check(SCENARIO, FORGED[name])
        assert sky.check(SCENARIO, flying(flight)) != []
    assert sky.check(SCENARIO, flying(replace(ALPHA_FLIES, form=form))) == []


def test_a_certificate_that_a_mission_brings_along_counts_for_nothing():
    proven = sky.certify(SCENARIO, VALID)
    stale = replace(VALID, certificates=proven.trajectories, apart=proven.apart)
    forged = FORGED["a thousand jumps"].trajectories[0]
    assert sky.check(SCENARIO, stale) == []
    assert sky.check(SCENARIO, flying(forged, mission=stale)) == sky.check(SCENARIO, flying(forged)) != []
