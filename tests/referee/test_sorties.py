"""A valid mission of tours passes, every planted fault is found alone and named, and nothing malformed raises."""

import math
from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from handmade import hall
from skyverse.model.sortie import Sortie, Unvisited, Visit
from skyverse.model.trajectory import Pointing, Trajectory

ALPHA, BRAVO = range(2)
SCENARIO = hall(
    (40, 20, 10),
    [
        {"name": "alpha", "start": (2, 2, 1), "end": "home", "capacity": 2.0, "batteries": 2, "swap": 5.0},
        {"name": "bravo", "start": (2, 18, 1), "end": "home"},
    ],
    [
        {
            "name": "a", "position": (20, 4, 4), "stay": 3.0, "window": (0, 60), "demand": 1, "heading": 90,
            "uavs": ("alpha",),
        },
        {"name": "b", "position": (30, 2, 4), "demand": 1, "uavs": ("alpha",)},
        {"name": "c", "position": (10, 2, 6), "stay": 2.0, "demand": 1, "uavs": ("alpha",)},
        {"name": "d", "position": (30, 18, 4), "uavs": ("bravo",)},
    ],
)  # fmt: skip


def planned():
    mission = sky.plan_mission(SCENARIO, sky.Taut())
    assert [[[visit.target for visit in one.visits] for one in own] for own in mission.sorties] == [
        [[1, 0], [2]],
        [[3]],
    ]
    return mission


VALID = planned()
(FIRST, SECOND), (ONLY,) = VALID.sorties
AT_B, AT_A = FIRST.visits
FLIGHT = VALID.trajectories[ALPHA]


def test_a_valid_mission_of_tours_passes():
    assert sky.check(SCENARIO, VALID) == []
    assert VALID.violations == ()


def target(name, **changes):
    """The same flights, where a target asks for something else."""
    targets = [one.model_copy(update=changes if one.name == name else {}) for one in SCENARIO.targets]
    return replace(VALID, scenario=SCENARIO.model_copy(update={"targets": tuple(targets)}))


def alpha(**changes):
    """The same flights, where alpha is another."""
    uavs = SCENARIO.uavs[ALPHA].model_copy(update=changes), SCENARIO.uavs[BRAVO]
    return replace(VALID, scenario=SCENARIO.model_copy(update={"uavs": uavs}))


def sorties(*own, **changes):
    return replace(VALID, sorties=(own, VALID.sorties[BRAVO]), **changes)


def drifting(begin, end, metres):
    """Alpha drifts eastwards and back while it stands between two instants."""
    piece = int(np.searchsorted(FLIGHT.knots, (begin + end) / 2)) - 1
    assert np.allclose(FLIGHT.coefficients[piece, 1:], 0)
    rows = np.pad(FLIGHT.coefficients, ((0, 0), (0, 7 - FLIGHT.coefficients.shape[1]), (0, 0)))
    a, b = FLIGHT.knots[piece : piece + 2]
    shares = 64 * metres * np.array([1.0, -3.0, 3.0, -1.0])  # of t^3 (1 - t)^3, a half at most, cubed twice
    rows[piece, 3:7, 0] += shares / (b - a) ** np.arange(3, 7)
    return replace(VALID, trajectories=(replace(FLIGHT, coefficients=rows), VALID.trajectories[BRAVO]))


def pointing(**changes):
    return replace(FLIGHT, pointing=replace(FLIGHT.pointing, **changes))


def glancing():
    """Alpha turns its nose by three degrees, and back at once, in the midst of its stay at a."""
    middle = (AT_A.arrival + AT_A.departure) / 2
    nose = Pointing(0.0, np.array([middle - 0.7, middle + 0.7]), np.radians([3.0, -3.0]), 0.8, 0.4)
    return replace(VALID, trajectories=(replace(FLIGHT, pointing=nose), VALID.trajectories[BRAVO]))


PLANTED = {
    "visited twice": (
        (),
        replace(VALID, sorties=(VALID.sorties[ALPHA], (replace(ONLY, visits=ONLY.visits * 2),))),
        "d is visited 2 times.",
    ),
    "neither visited nor named": (
        (),
        sorties(replace(FIRST, visits=(AT_A,)), SECOND),
        "b is neither visited nor named.",
    ),
    "visited, but named": ((), replace(VALID, unvisited=(Unvisited(1, "no way"),)), "b is visited, but named"),
    "the wrong UAV": ((ALPHA,), target("b", uavs=("bravo",)), "is not its own: only bravo may go there."),
    "after its window": ((ALPHA,), target("a", window=(0.0, 10.0)), "does not begin within its window, 0 to 10 s."),
    "before its window": ((ALPHA,), target("a", window=(30.0, 90.0)), "does not begin within its window, 30 to 90 s."),
    "too short a stay": ((ALPHA,), target("a", stay=3.01), "lasts 3 s, not 3.01 s."),
    "a drift of a millimetre": ((ALPHA,), drifting(AT_A.arrival, AT_A.departure, 1e-3), "m from (20, 4, 4)."),
    "off the target": ((ALPHA,), target("a", position=(20, 4.001, 4)), "is 0.001 m from (20, 4.001, 4)."),
    "nose off the heading": ((ALPHA,), target("a", heading=93.0), "points its nose 3 degrees off."),
    "nose off what it looks at": (
        (ALPHA,),
        target("a", heading=None, look_at=(20, 9, 0)),
        "points its nose 90 degrees off.",
    ),
    "nose off for a moment": ((ALPHA,), glancing(), "points its nose 3 degrees off."),
    "over capacity": ((ALPHA,), alpha(capacity=1.999), "has 2 kg to carry at once, but its capacity is 1.999 kg."),
    "more sorties than batteries": ((ALPHA,), alpha(batteries=1), "flies 2 sorties, but has 1 battery."),
    "too short a swap": ((ALPHA,), alpha(swap=5.01), "5 s at home between two sorties, but needs 5.01 s there."),
    "away from home between sorties": (
        (ALPHA,),
        sorties(replace(FIRST, end=FIRST.end - 1.0), SECOND),
        "m from home between two sorties",
    ),
    "a sortie that begins before the flight": (
        (ALPHA,),
        sorties(replace(FIRST, begin=-1.0), SECOND),
        "do not follow one another from take-off to landing.",
    ),
    "a sortie that ends before the flight": (
        (ALPHA,),
        sorties(FIRST, replace(SECOND, end=SECOND.end - 0.1)),
        "do not follow one another from take-off to landing.",
    ),
    "sorties in the wrong order": (
        (ALPHA,),
        sorties(SECOND, FIRST, assignment=(0, 3)),
        "do not follow one another from take-off to landing.",
    ),
    "visits in the wrong order": (
        (ALPHA,),
        sorties(replace(FIRST, visits=(AT_A, AT_B)), SECOND),
        "do not follow one another from take-off to landing.",
    ),
    "the last visit not the target": (
        (ALPHA,),
        replace(VALID, assignment=(1, 3)),
        "flies, but its last visit is not that of its target.",
    ),
    "a target that does not exist": (
        (ALPHA,),
        sorties(replace(FIRST, visits=(Visit(99, 0.0, 0.0), AT_B, AT_A)), SECOND),
        "visits a target that does not exist.",
    ),
}


@pytest.mark.parametrize("name", PLANTED)
def test_every_planted_fault_is_found_alone_and_named(name):
    uavs, mission, words = PLANTED[name]
    (found,) = sky.check(mission.scenario, mission)
    assert (found.fault, found.uavs) == (sky.Fault.VISIT, uavs)
    assert words in found.message
    if uavs:
        certificate = sky.certify(mission.scenario, mission).trajectories[ALPHA]
        assert certificate.verdict is sky.Verdict.REFUTED


def test_a_drift_of_a_nanometre_is_none():
    assert sky.check(SCENARIO, drifting(AT_A.arrival, AT_A.departure, 1e-9)) == []


def test_a_flight_that_does_not_end_at_home_is_refuted():
    away = FLIGHT.knots[FLIGHT.knots <= SECOND.visits[0].departure]
    cut = Trajectory(away, FLIGHT.coefficients[: len(away) - 1], pointing=FLIGHT.pointing)
    mission = sorties(FIRST, replace(SECOND, end=cut.end), trajectories=(cut, VALID.trajectories[BRAVO]))
    (found,) = sky.check(SCENARIO, mission)
    assert found.fault is sky.Fault.TRAJECTORY_ENDS
    assert "from (2, 2, 1); it must be there at rest." in found.message


def test_visits_that_nobody_flies_do_not_count():
    mission = replace(VALID, trajectories=(FLIGHT, None))
    assert "d is neither visited nor named." in [one.message for one in sky.check(SCENARIO, mission)]


@pytest.mark.parametrize("sorties", [(), None])
def test_a_mission_that_hides_its_sorties_is_judged_by_what_the_scenario_asks_for(sorties):
    found = {one.message for one in sky.check(SCENARIO, replace(VALID, sorties=sorties))}
    assert "alpha flies, but its last visit is not that of its target." in found
    assert "The mission has sorties of no UAVs, but there are 2." in found


def test_an_interrupted_mission_may_leave_targets_unnamed_but_may_not_visit_them_falsely():
    left = sorties(replace(FIRST, visits=(AT_A,)), SECOND, interrupted=True)
    assert sky.check(SCENARIO, left) == []
    assert sky.check(SCENARIO, replace(PLANTED["visited twice"][1], interrupted=True))


STRANGE = [None, "3", b"3", True, [], {}, math.nan, math.inf, -math.inf, 10**400, -(10**400), 1e308, np.float64("nan")]
STRANGE += [np.array([1.0, 2.0]), np.zeros(0), 1j, object(), (1.0,)]


@pytest.mark.parametrize("value", STRANGE, ids=lambda value: repr(value)[:20])
@pytest.mark.parametrize("field", ["begin", "end", "visits", "target", "arrival", "departure"])
def test_nothing_malformed_in_a_sortie_raises_or_passes(field, value):
    if field in ("begin", "end", "visits"):
        mission = sorties(replace(FIRST, **{field: value}), SECOND)
    else:
        mission = sorties(replace(FIRST, visits=(replace(AT_B, **{field: value}), AT_A)), SECOND)
    assert sky.check(SCENARIO, mission)
    sky.certify(SCENARIO, mission)


@pytest.mark.parametrize(
    "column",
    [
        None, 5, "ab", [], (None, None), (5, 5), ((5,), (None,)), ((), ()), VALID.sorties * 2, (VALID.sorties[0],) * 2,
        (list(VALID.sorties[0]), VALID.sorties[1]), ((FIRST, None), (ONLY,)), ((Sortie(0.0, 1.0, ()),), (ONLY,)),
        {0: VALID.sorties[0]}, np.zeros(2),
    ],
    ids=range(15),
)  # fmt: skip
def test_no_malformed_column_of_sorties_raises_or_passes(column):
    mission = replace(VALID, sorties=column)
    assert sky.check(SCENARIO, mission)
    sky.certify(SCENARIO, mission)


@pytest.mark.parametrize("named", [None, 5, "ab", (None,), (5, "x"), (Unvisited(99, "x"),), (Unvisited(None, 5),)])
def test_no_malformed_list_of_what_is_unvisited_raises(named):
    assert sky.check(SCENARIO, replace(VALID, unvisited=named)) == []
    left = sorties(replace(FIRST, visits=(AT_A,)), SECOND, unvisited=named)
    assert [one.message for one in sky.check(SCENARIO, left)] == ["b is neither visited nor named."]


@pytest.mark.parametrize(
    "changes",
    [{"turns": np.zeros(3)}, {"yaw": math.nan}, {"yaw": 10**400}, {"look_at": "x"}, {"spread": None}, {"rise": -1.0}],
)
def test_a_malformed_pointing_does_not_raise(changes):
    mission = replace(VALID, trajectories=(pointing(**changes), VALID.trajectories[BRAVO]))
    sky.check(SCENARIO, mission)
