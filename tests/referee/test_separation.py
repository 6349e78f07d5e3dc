"""The fleet's separation is judged at every instant, pair by pair, and what is given is told apart."""

from itertools import combinations, pairwise
from math import factorial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline

import skyverse as sky

MADE_BY = sky.Provenance("0", "by hand", "", None, "")
AGILE = {"max_speed": 1e3, "max_acceleration": 1e4, "max_jerk": 1e6, "max_tilt": 89.9, "thrust_to_weight": 1e3}


def stops(*waypoints, seconds=1.0, start=0.0):
    """From rest to rest at every waypoint."""
    pieces = []
    for a, b in pairwise(np.array(waypoints, float)):
        shape = np.array([0, 0, 0, 10, -15, 6]) / seconds ** np.arange(6)
        pieces.append(shape[:, None] * (b - a))
        pieces[-1][0] = a
    return sky.Trajectory(start + seconds * np.arange(len(waypoints)), np.array(pieces))


def fleet(*flights, separation=(0.5, 1.0), uavs=None):
    """Flights, or places where UAVs stand; each with the separation, or with fields of its own."""
    fields = {"separation": separation[0], "vertical_separation": separation[1]}
    uavs = uavs or [{}] * len(flights)
    starts, ends, flown = [], [], []
    for flight in flights:
        flies = isinstance(flight, sky.Trajectory)
        starts.append(tuple(flight.coefficients[0, 0].tolist()) if flies else flight)
        flown.append(flight if flies else None)
        if flies:
            ends.append(tuple(flight.at(flight.end).position[0].tolist()))
    number = iter(range(len(ends)))
    scenario = sky.Scenario(
        name="fleet",
        bounds=sky.Bounds(min=(-1e4, -1e4, -1e4), max=(1e4, 1e4, 1e4)),
        clearance=0.001,
        lattice=sky.Lattice(step=(1e3, 1e3, 1e3)),
        uavs=tuple(sky.UAV(start=at, **(AGILE | fields | own)) for at, own in zip(starts, uavs, strict=True)),
        targets=tuple(sky.Target(position=place) for place in ends),
    )
    assignment = tuple(None if flight is None else next(number) for flight in flown)
    return sky.Mission(scenario, assignment, (None,) * len(flown), tuple(flown), (), MADE_BY)


def between(mission):
    """What check says of pairs."""
    return [found for found in sky.check(mission.scenario, mission) if len(found.uavs) == 2]


def verdict(mission):
    return sky.certify(mission.scenario, mission).apart.verdict


PASSING = stops((-4, 0, 0), (4, 0, 0), seconds=2.0)


@pytest.mark.parametrize(
    "place", [(0.3, 0.5, 0), (0.3, 0, -1), (0.3, 0.3, 0.8), (0.3, -0.4, 0.6), (0.3, 0.5 * 12 / 13, 5 / 13)]
)
@pytest.mark.parametrize("less", [0.0, 9e-7, 1.1e-6, 1e-3])
def test_an_ellipsoid_may_be_touched(place, less):
    # shrunk towards the flight in proportion: on both axes by at most what is let pass
    x, y, z = place
    mission = fleet(PASSING, (x, y * (1 - less), z * (1 - less)))
    if less <= 9e-7:
        assert between(mission) == []
        assert verdict(mission) is sky.Verdict.PROVEN
    elif less > 3e-6:
        (found,) = between(mission)
        assert found.fault is sky.Fault.SEPARATION
        assert found.position[0] == pytest.approx(0.3, abs=1e-3)
        assert f"{1 - less:.6g} of the separation" in found.message
        assert "given" not in found.message  # nothing of it was
        assert verdict(mission) is sky.Verdict.REFUTED


def test_a_separation_missed_by_the_tolerance_itself_is_undecided():
    mission = fleet(PASSING, (0.3, 0.5 - 1e-6, 0))
    (found,) = between(mission)
    assert (found.fault, found.uavs) == (sky.Fault.UNDECIDED, (0, 1))
    assert "could not be decided" in found.message
    assert found.position == pytest.approx((0.3, 0.25, 0), abs=1e-3)
    assert verdict(mission) is sky.Verdict.UNDECIDED


@pytest.mark.parametrize("axes", [(0.5, 1.0), (1.0, 0.3)])
def test_of_two_uavs_the_larger_axes_count_each(axes):
    one, other = (
        {"separation": axes[0], "vertical_separation": 0.01},
        {"separation": 0.01, "vertical_separation": axes[1]},
    )
    for first, second in ((one, other), (other, one)):
        for place, close in (((0, axes[0] - 0.01, 0), True), ((0, 0, axes[1] - 0.01), True), ((0, axes[0], 0), False)):
            found = between(fleet(PASSING, place, uavs=[first, second]))
            assert bool(found) == close


def test_a_separation_of_zero_is_always_kept():
    assert between(fleet(PASSING, PASSING, separation=(0.0, 0.0))) == []
    assert verdict(fleet(PASSING)) is sky.Verdict.PROVEN


def test_uavs_stand_still_before_they_start_and_after_they_end():
    late = stops((0, 0, 0), (0, 9, 0), start=5.0)  # in the way until then
    (found,) = between(fleet(PASSING, late))
    assert (found.fault, found.time) == (sky.Fault.SEPARATION, pytest.approx(1.0, abs=1e-3))
    early = stops((0, 9, 0), (0.1, 0, 0), seconds=0.4)  # in the way from then on
    (found,) = between(fleet(stops((-4, 0, 0), (4, 0, 0), seconds=2.0, start=7.0), early))
    assert found.time == pytest.approx(8.0, abs=0.1)
    away = stops((0, 0, 0), (0, 9, 0), seconds=0.6)
    assert between(fleet(PASSING, away)) == []


def test_a_late_start_takes_no_longer_to_judge():
    far = stops((0, 0.4, 0), (0, 9, 0), start=9e8)
    (found,) = between(fleet(PASSING, far))
    assert found.time == pytest.approx(1.0, abs=1e-4)


# ---------------------------------------------------------------- what is given


def test_starts_too_close_are_given_until_first_apart():
    out, back = stops((0, 0, 0), (-3, 0, 0)), stops((0, 0, 0), (-3, 0, 0), (-0.1, 0, 0), (0, 3, 0))
    (found,) = between(fleet(out, (0.2, 0, 0)))
    assert (found.fault, found.uavs) == (sky.Fault.GIVEN, (0, 1))
    assert "as their starts or targets are given" in found.message
    given, blamed = between(fleet(back, (0.2, 0, 0)))
    assert (given.fault, blamed.fault) == (sky.Fault.GIVEN, sky.Fault.SEPARATION)
    assert given.time == 0 < 1 < blamed.time < 3
    assert sky.certify(fleet(back, (0.2, 0, 0)).scenario, fleet(back, (0.2, 0, 0))).apart.time == blamed.time


def test_starts_that_are_never_left_stay_given():
    (found,) = between(fleet((0, 0, 0), (0.2, 0, 0)))
    assert (found.fault, found.time) == (sky.Fault.GIVEN, 0)
    assert "already at the start" in found.message


def test_targets_too_close_are_given_from_when_last_apart():
    there = stops((0, 9, 0), (0, 0, 0), seconds=2.0)
    (found,) = between(fleet(there, stops((9, 0, 0), (0.3, 0, 0), seconds=2.0)))
    assert found.fault is sky.Fault.GIVEN
    # the other comes by, goes away, and comes for good
    visits = stops((9, 0, 0), (0.3, 0, 0), (5, 0, 0), (0.3, 0, 0), seconds=2.0)
    blamed, given = sorted(between(fleet(there, visits)), key=lambda found: found.time)
    assert (blamed.fault, given.fault) == (sky.Fault.SEPARATION, sky.Fault.GIVEN)
    assert blamed.time < 4 < given.time


@pytest.mark.parametrize("far", [0.0, 5e5])
@pytest.mark.parametrize("at_start", [True, False])
def test_what_is_given_excuses_nothing_that_is_nearer(far, at_start):
    # 0.4 m of 0.5 m are given; then one flies through the other
    one, other = [(far, 0, 0), (far + 8, 0.01, 0)], [(far + 0.4, 0, 0), (far - 8, 0, 0)]
    through = fleet(*(stops(*(way if at_start else way[::-1])) for way in (one, other)))
    found = {violation.fault: violation for violation in between(through)}
    assert set(found) == {sky.Fault.GIVEN, sky.Fault.SEPARATION}
    assert (found[sky.Fault.GIVEN].time < 1e-9) == at_start
    assert "0.8 of the separation" in found[sky.Fault.GIVEN].message
    assert "nearer than their starts or targets are given" in found[sky.Fault.SEPARATION].message
    assert nearness_in(found[sky.Fault.SEPARATION]) < 0.02
    judged = sky.certify(through.scenario, through).apart
    assert (judged.verdict, judged.sentence) == (sky.Verdict.REFUTED, found[sky.Fault.SEPARATION].message)


def nearness_in(violation):
    return float(violation.message.split(": ")[-1].split()[0])


@pytest.mark.parametrize(
    ("nearer", "faults"),
    [(0, {sky.Fault.GIVEN}), (9e-7, {sky.Fault.GIVEN}), (1.1e-6, {sky.Fault.GIVEN, sky.Fault.SEPARATION})],
)
def test_the_nearness_that_is_given_is_kept_but_for_the_tolerance(nearer, faults):
    flight = stops((0, 0, 0), (nearer, 0, 0), (-3, 0, 0))
    assert {violation.fault for violation in between(fleet(flight, (0.4, 0, 0)))} == faults
    assert {violation.fault for violation in between(fleet(flight, (0, 0, 0)))} == {sky.Fault.GIVEN}  # nothing to keep


def test_a_pair_that_is_never_apart_may_come_as_near_as_either_end_is_given():
    for gaps, faults in (
        ((0.4, 0.2), {sky.Fault.GIVEN}),
        ((0.2, 0.4), {sky.Fault.GIVEN}),
        ((0.4, 0.1, 0.2), {sky.Fault.GIVEN, sky.Fault.SEPARATION}),
    ):
        steps = np.linspace(0, 5, len(gaps))
        both = [stops(*((x, y, 0) for x, y in zip(steps, ys, strict=True))) for ys in (gaps, np.zeros(len(gaps)))]
        assert {violation.fault for violation in between(fleet(*both))} == faults


def test_starts_that_miss_by_what_is_let_pass_excuse_no_more():
    flight = stops((9e-7, 0, 0), (1.8e-6, 0, 0), (-3, 0, 0))
    (found,) = between(fleet(flight, (0.5, 0, 0)))
    assert found.fault is sky.Fault.SEPARATION


def test_what_the_instant_named_does_not_show_is_undecided():
    # so late that instants are 0.12 us from one another, which is 12 mm of a flight at 10^5 m/s
    for nearest, faults in ((2**-7 + 2**-24, [sky.Fault.UNDECIDED]), (2**-7 + 2**-23, [sky.Fault.SEPARATION])):
        line = np.array([[[-nearest * 1e5, 0.5 - 1e-5, 0], [1e5, 0, 0]]])
        mission = fleet(sky.Trajectory(2.0**29 + np.array([0, 2**-6]), line), (0, 0, 0))
        assert [found.fault for found in between(mission)] == faults


def test_a_uav_that_stands_at_anothers_target_is_not_given():
    (found,) = between(fleet(stops((0, 9, 0), (0, 0, 0)), (0.3, 0, 0)))
    assert found.fault is sky.Fault.SEPARATION


def test_targets_too_close_excuse_nobody_who_does_not_fly_there():
    mission = fleet(stops((0, 9, 0), (5, 0, 0)), stops((5.2, 0, 0), (5.3, 0, 0)))
    for stands in (0, 1):
        flown = tuple(None if uav == stands else flight for uav, flight in enumerate(mission.trajectories))
        scenario = mission.scenario
        if stands == 0:  # the first one stands where the second arrives
            first = scenario.uavs[0].model_copy(update={"start": (5.3, 0.1, 0)})
            second = scenario.uavs[1].model_copy(update={"start": (9.2, 0, 0)})
            scenario = scenario.model_copy(update={"uavs": (first, second)})
            flown = (None, stops((9.2, 0, 0), (5.3, 0, 0)))
        (found,) = between(sky.Mission(scenario, mission.assignment, (None, None), flown, (), MADE_BY))
        assert found.fault is sky.Fault.SEPARATION


def test_starts_and_targets_both_given_leave_what_is_between():
    one = stops((0, 0, 0), (5, 0, 0), (10, 0, 0))
    other = stops((0, 0.2, 0), (5, 3, 0), (10, 0.2, 0))
    (found,) = between(fleet(one, other))
    assert found.fault is sky.Fault.GIVEN
    kisses = stops((0, 0.2, 0), (3, 3, 0), (5.0, 0.3, 0), (7, 3, 0), (10, 0.2, 0), seconds=0.5)
    assert {found.fault for found in between(fleet(one, kisses))} == {sky.Fault.GIVEN, sky.Fault.SEPARATION}


# ---------------------------------------------------------------- against dense sampling


def spline(seed, points, start):
    rng = np.random.default_rng(seed)
    t = np.r_[0, np.cumsum(rng.uniform(0.4, 1.2, points - 1))]
    still = [(1, np.zeros(3)), (2, np.zeros(3))]
    curve = make_interp_spline(t, rng.uniform(0, 4, (points, 3)), 5, bc_type=(still, still))
    knots = np.unique(curve.t)
    rows = [curve(knots[:-1], nu=k) / factorial(k) for k in range(6)]
    return sky.Trajectory(start + knots, np.stack(rows, axis=1))


def sampled(flight, t):
    """Return positions alone, (m, 3); velocities of millions of instants would take long."""
    instants = np.clip(t, flight.start, flight.end)
    piece = np.clip(np.searchsorted(flight.knots, instants, side="right") - 1, 0, len(flight.coefficients) - 1)
    local = instants - flight.knots[piece]
    positions = np.empty((len(t), 3))
    for axis in range(3):
        value = np.zeros(len(t))
        for power in range(flight.coefficients.shape[1] - 1, -1, -1):
            value = value * local + flight.coefficients[piece, power, axis]
        positions[:, axis] = value
    return positions


@settings(max_examples=25, deadline=None)
@given(
    seeds=st.tuples(st.integers(0, 10**6), st.integers(0, 10**6)),
    points=st.tuples(st.integers(2, 6), st.integers(2, 6)),
    late=st.sampled_from([0.0, 0.3, 1.7]),
    share=st.sampled_from([0.5, 1 - 5e-5, 1 + 5e-5, 1.2]),
)
def test_pairs_agree_with_dense_sampling(seeds, points, late, share):
    a, b = spline(seeds[0], points[0], 0.0), spline(seeds[1], points[1], late)
    t = np.linspace(0, max(a.end, b.end) + 0.1, 20_001)
    nearness = np.linalg.norm((sampled(a, t) - sampled(b, t)) / [0.5, 0.5, 1], axis=1)
    padded = np.concatenate([[np.inf], nearness, [np.inf]])
    bottoms = (nearness < padded[:-2]) & (nearness <= padded[2:]) & (nearness <= nearness.min() * 1.1 + 0.01)
    close = np.flatnonzero(bottoms)  # fast UAVs pass between samples
    fine = (t[close, None] + np.linspace(-1, 1, 401) * (t[1] - t[0])).ravel().clip(0, t[-1])
    least = np.linalg.norm((sampled(a, fine) - sampled(b, fine)) / [0.5, 0.5, 1], axis=1).min()
    wide = 0.5 * least * share
    if wide < 0.02:
        return
    mission = fleet(a, b, separation=(wide, 2 * wide))
    found = between(mission)
    if share < 1:
        assert found == []
        assert verdict(mission) is sky.Verdict.PROVEN
    else:
        worst = min(found, key=lambda violation: float(violation.message.split(": ")[-1].split()[0]))
        assert (
            worst.time == pytest.approx(t[nearness.argmin()], abs=0.02)
            or nearness.argmin() in (0, len(t) - 1)
            or (nearness[np.abs(t - worst.time).argmin()] <= least * (1 + 1e-5))
        )
        assert verdict(mission) is sky.Verdict.REFUTED


@pytest.mark.parametrize("seed", range(24))
def test_pairs_given_too_close_agree_with_dense_sampling(seed):
    rng = np.random.default_rng(seed)
    a, b = spline(seed, 4, 0.0), spline(seed + 999, 4, 0.4 * (seed % 3))
    there, here = ((a.start, b.start), (a.end, b.end))[seed % 2]  # starts, or targets
    rows = b.coefficients.copy()
    rows[:, 0] += a.at(there).position[0] - b.at(here).position[0] + 0.15 * rng.normal(size=3)
    b = sky.Trajectory(b.knots, rows)
    t = np.linspace(0, max(a.end, b.end) + 0.1, 20_001)
    nearness = np.linalg.norm((sampled(a, t) - sampled(b, t)) / [0.5, 0.5, 1], axis=1)
    apart, kept = nearness >= 1, np.ones(len(t))
    if nearness[0] < 1:
        kept[np.cumsum(apart) == 0] = nearness[0]
    if nearness[-1] < 1:
        kept[np.cumsum(apart[::-1])[::-1] == 0] = nearness[-1]
    if not apart.any():
        kept[:] = min(nearness[0], nearness[-1])
    faults = {violation.fault for violation in between(fleet(a, b))}
    assert (sky.Fault.GIVEN in faults) == (kept.min() < 1)
    assert (sky.Fault.SEPARATION in faults) == ((nearness / kept).min() < 1 - 1e-5)


def test_a_fleet_is_judged_as_its_pairs_are():
    flights = [spline(seed, 4, 0.2 * seed) for seed in range(12)]
    whole = fleet(*flights, separation=(0.5, 0.8))
    found = {(violation.uavs, violation.fault) for violation in between(whole)}
    assert 5 < len(found) < 60
    for i, j in combinations(range(12), 2):
        pair = {fault for uavs, fault in found if uavs == (i, j)}
        assert pair == {violation.fault for violation in between(fleet(flights[i], flights[j], separation=(0.5, 0.8)))}


@pytest.mark.parametrize(("at_start", "at_end"), [(0.2, 0.3), (0.3, 0.2)])
def test_of_starts_and_targets_given_too_close_the_nearer_are_told(at_start, at_end):
    one = stops((0, 0, 0), (0, 0, 9), (20, 0, 9))
    other = stops((at_start, 0, 0), (at_start, 9, 0), (20 + at_end, 0, 9))
    (told,) = [found for found in between(fleet(one, other)) if found.fault is sky.Fault.GIVEN]
    assert f"{min(at_start, at_end):g} m" in told.message
    assert told.time == (0.0 if at_start < at_end else 2.0)
