"""What is proven holds at every instant; what is refuted is so at the instant that is named."""

import re
from dataclasses import replace
from itertools import pairwise
from math import factorial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline

import skyverse as sky
from skyverse.referee.curve import PolynomialCurve

MADE_BY = sky.Provenance("0", "by hand", "", None, "")
AGILE = {"max_speed": 1e3, "max_acceleration": 1e4, "max_jerk": 1e6, "max_tilt": 89.9, "thrust_to_weight": 1e3}
WEIGHT = np.array([0, 0, 9.81])
PROVEN, REFUTED, UNDECIDED = sky.Verdict.PROVEN, sky.Verdict.REFUTED, sky.Verdict.UNDECIDED


def stops(*waypoints, seconds=1.0, start=0.0):
    """From rest to rest at every waypoint."""
    pieces = []
    for a, b in pairwise(np.array(waypoints, float)):
        shape = np.array([0, 0, 0, 10, -15, 6]) / seconds ** np.arange(6)
        pieces.append(shape[:, None] * (b - a))
        pieces[-1][0] = a
    return sky.Trajectory(start + seconds * np.arange(len(waypoints)), np.array(pieces))


def hermite(t, p, v, a, form="dubins"):
    """Quintics through places, velocities and accelerations."""
    T = np.diff(t)[:, None]
    d, v0, v1, a0, a1 = p[1:] - p[:-1], v[:-1], v[1:], a[:-1], a[1:]
    rows = [
        p[:-1],
        v0,
        a0 / 2,
        (20 * d - (8 * v1 + 12 * v0) * T - (3 * a0 - a1) * T**2) / (2 * T**3),
        (-30 * d + (14 * v1 + 16 * v0) * T + (3 * a0 - 2 * a1) * T**2) / (2 * T**4),
        (12 * d - 6 * (v1 + v0) * T - (a0 - a1) * T**2) / (2 * T**5),
    ]
    return sky.Trajectory(t, np.stack(rows, axis=1), form=form)


def mission(*flights, boxes=(), clearance=0.001, top=100.0, starts=None, targets=None):
    """UAVs that fly as told: pairs of a UAV's fields and a trajectory, or ``None`` for one that stands at its start."""
    given = [fields | ({"start": ends(flight)[0]} if flight is not None else {}) for fields, flight in flights]
    uavs = tuple(sky.UAV(**fields) for fields in given)
    flown = [flight for _, flight in flights]
    places = [ends(flight)[1] for flight in flown if flight is not None]
    number = iter(range(len(places)))
    scenario = sky.Scenario(
        name="flights",
        bounds=sky.Bounds(min=(-100, -100, -100), max=(100, 100, top)),
        obstacles=tuple(sky.Box(min=low, max=high) for low, high in boxes),
        clearance=clearance,
        lattice=sky.Lattice(step=(10, 10, 10)),
        uavs=uavs,
        targets=tuple(sky.Target(position=place) for place in places),
    )
    assignment = tuple(None if flight is None else next(number) for flight in flown)
    return sky.Mission(scenario, assignment, (None,) * len(uavs), tuple(flown), (), MADE_BY)


def ends(flight):
    return tuple(flight.at(flight.start).position[0].tolist()), tuple(flight.at(flight.end).position[0].tolist())


def certified(judged):
    return sky.certify(judged.scenario, judged)


def faults(judged):
    """What check finds wrong with the flights."""
    return [found for found in sky.check(judged.scenario, judged) if found.fault is not sky.Fault.ASSIGNMENT]


def alone(**fields):
    """The certificate of one UAV's flight, agile but for some fields."""

    def of(flight, **world):
        return certified(mission((AGILE | fields, flight), **world)).trajectories[0]

    return of


# ---------------------------------------------------------------- one trajectory


def test_what_is_proven_is_said_in_a_sentence():
    flown = mission((AGILE, stops((0, 0, 0), (3, 0, 0))), boxes=[((1, 1, 1), (2, 2, 2))], clearance=0.25)
    judged, digest = certified(flown), flown.scenario.digest
    assert judged.trajectories[0].verdict is PROVEN
    assert judged.trajectories[0].sentence == (
        "uav-1 is clear of every obstacle by 0.25 m, inside the bounds and within its limits of speed, acceleration, "
        "jerk, thrust, tilt and yaw, at every instant from t = 0 s to 1 s, "
        f"in scenario 'flights' (sha256 {digest[:12]})."
    )
    assert [one.scenario for one in (*judged.trajectories, judged.apart)] == [digest, digest]
    assert judged.trajectories[0].time is None
    assert judged.apart.verdict is PROVEN
    assert "tracking error" not in judged.apart.sentence


@pytest.mark.parametrize(
    ("field", "peak", "when", "fault"),
    [
        ("max_speed", 15 / 8 * 3 / 2, 1.0, sky.Fault.SPEED),
        ("max_acceleration", 10 / 3**0.5 * 3 / 4, 1 - 1 / 3**0.5, sky.Fault.ACCELERATION),
        ("max_jerk", 60 * 3 / 8, 0.0, sky.Fault.JERK),
        ("max_climb", 15 / 8 * 3 / 2, 1.0, sky.Fault.CLIMB_RATE),
        ("max_descent", 15 / 8 * 3 / 2, 1.0, sky.Fault.DESCENT_RATE),
    ],
)
@pytest.mark.parametrize(("share", "verdict"), [(1, PROVEN), (1 - 9e-7, PROVEN), (1 - 1.1e-6, REFUTED)])
def test_a_peak_that_reaches_a_limit_exactly_is_proven(field, peak, when, fault, share, verdict):
    # 3 m in 2 s by 10 s^3 - 15 s^4 + 6 s^5, of which the peaks are known
    flight = stops((0, 0, 0), (0, 0, -3 if field == "max_descent" else 3), seconds=2.0)
    judged = mission((AGILE | {field: peak * share}, flight))
    found = certified(judged).trajectories[0]
    assert found.verdict is verdict
    if verdict is REFUTED:
        (violation,) = faults(judged)
        assert violation.fault is fault
        assert min(abs(violation.time - when), abs(violation.time - (2 - when))) < 1e-4
        assert (found.time, found.sentence) == (violation.time, violation.message)


def test_a_flight_may_climb_as_fast_as_it_likes_where_only_its_descent_is_limited():
    up = mission((AGILE | {"max_descent": 0.1}, stops((0, 0, 0), (0, 0, 3), seconds=2.0)))
    (found,) = certified(up).trajectories
    assert "its limits of speed, acceleration, jerk, thrust, tilt, yaw and descent rate, at every" in found.sentence
    down = mission((AGILE | {"max_climb": 0.1}, stops((0, 0, 3), (0, 0, 0), seconds=2.0)))
    assert certified(down).trajectories[0].verdict is PROVEN


def test_a_certificate_says_that_it_holds_for_every_flight_within_the_tracking_error():
    astray = AGILE | {"tracking_error": {"horizontal": 1.5, "vertical": 2}}
    flights = (astray, stops((0, 0, 0), (3, 0, 0))), (AGILE, stops((0, 20, 0), (3, 20, 0)))
    judged = certified(mission(*flights))
    end = ", for every flight within 1.5 m horizontally and 2 m vertically of it."
    assert judged.trajectories[0].sentence.endswith(end)
    assert "every flight" not in judged.trajectories[1].sentence
    assert judged.apart.sentence.endswith(", in every flight of theirs within their tracking errors.")


@pytest.mark.parametrize("direction", [(3, 0, 0), (0, 0, -3), (1, 1, 2)])
@pytest.mark.parametrize(("noun", "fault"), [("max_tilt", sky.Fault.TILT), ("thrust_to_weight", sky.Fault.THRUST)])
@pytest.mark.parametrize(("share", "verdict"), [(1 + 1e-7, PROVEN), (1 - 3e-6, REFUTED)])
def test_thrust_and_tilt_count_the_weight(direction, noun, fault, share, verdict):
    flight = stops((0, 0, 0), direction, seconds=1.7)
    f = flight.at(np.linspace(0, 1.7, 170_001)).acceleration + WEIGHT
    tilt = np.degrees(np.arctan2(np.hypot(f[:, 0], f[:, 1]), f[:, 2])).max()
    peak = {"max_tilt": tilt, "thrust_to_weight": np.linalg.norm(f, axis=1).max() / 9.81}[noun]
    if noun == "max_tilt" and tilt < 1e-6:
        share, peak, verdict = 1, 0.1, PROVEN  # straight up and down
    judged = mission((AGILE | {noun: peak * share}, flight))
    assert certified(judged).trajectories[0].verdict is verdict
    assert [violation.fault for violation in faults(judged)] == ([fault] if verdict is REFUTED else [])


def test_falling_faster_than_gravity_tilts_over():
    plunge = stops((0, 0, 50), (0, 0, 0), seconds=3.0)  # 32 m/s^2 downwards: thrust must point down
    assert [violation.fault for violation in faults(mission((AGILE, plunge)))] == [sky.Fault.TILT]


@pytest.mark.parametrize(("seconds", "wide"), [(0.05, 2e-4), (0.005, 1e-5)])
def test_a_spike_between_samples_is_found(seconds, wide):
    """A peak above the limit for `wide` s: 10 kHz sampling just sees the first, and misses the second."""
    hop = stops((0, 0, 0), (0, 0, 0.02), seconds=seconds, start=0.3 + 3.3e-5)
    whole = sky.Trajectory(np.r_[0, hop.knots], np.concatenate([np.zeros((1, 6, 3)), hop.coefficients]))
    peak = 15 / 8 * 0.02 / seconds
    limit = peak * (1 - 16 * ((wide / 2) / seconds) ** 2 / 2)
    t = np.arange(0, whole.end, 1e-4)
    seen = np.linalg.norm(whole.at(t).velocity, axis=1).max() > limit * (1 + 1e-6)
    assert seen == (wide > 1e-4)
    judged = mission((AGILE | {"max_speed": limit}, whole))
    speeding = [violation for violation in faults(judged) if violation.fault is sky.Fault.SPEED]
    (found,) = speeding
    assert abs(found.time - (hop.start + seconds / 2)) < wide / 2
    easier = mission((AGILE | {"max_speed": peak}, whole))
    assert sky.Fault.SPEED not in {violation.fault for violation in faults(easier)}


def parabola(apex, height, bend):
    """Along x at 1 m/s for a second, z at most `height`, where x is `apex`; led in and out of it from rest."""
    t = np.array([0.0, 2, 3, 5])
    x = np.array([-2.0, 0, 1, 3])
    z = height - bend / 2 * (x - apex) ** 2
    p = np.column_stack([x, 0 * x, z])
    p[0, 2], p[3, 2] = 0, 0
    v = np.column_stack([[0, 1, 1, 0], np.zeros(4), [0, bend * apex, -bend * (1 - apex), 0]])
    a = np.column_stack([np.zeros(4), np.zeros(4), [0, -bend, -bend, 0]])
    return hermite(t, p, v, a, form="stop-and-go")


@pytest.mark.parametrize(("inside", "verdict"), [(0, PROVEN), (9e-7, PROVEN), (1.1e-6, REFUTED), (1e-3, REFUTED)])
def test_a_face_that_is_touched_between_knots_is_no_fault(inside, verdict):
    above = [((-0.5, -1, 1.25 - inside), (1.5, 1, 2))]
    found = alone()(parabola(0.3337, 1.0, 3), boxes=above, clearance=0.25)
    assert found.verdict is verdict
    if verdict is REFUTED:
        assert found.time == pytest.approx(2.3337, abs=1e-4)
        assert found.position == pytest.approx((0.3337, 0, 1), abs=1e-4)


@pytest.mark.parametrize(("beyond", "verdict"), [(0, PROVEN), (9e-7, PROVEN), (1.1e-6, REFUTED)])
def test_the_bounds_may_be_touched(beyond, verdict):
    assert alone()(parabola(0.71, 1.0, 5), top=1.0 - beyond).verdict is verdict


def test_what_is_wrong_by_the_tolerance_itself_is_undecided():
    level = stops((0, 0, 1), (8, 0, 1))
    edge = 0.75 + 1e-6  # the flight is inside by what is let pass, but for rounding
    judged = mission((AGILE, level), boxes=[((2, -1, -1), (6, 1, edge))], clearance=0.25)
    found = certified(judged).trajectories[0]
    assert found.verdict is UNDECIDED
    assert "clearance could not be decided" in found.sentence
    assert 0 < found.time < 1
    assert [violation.fault for violation in faults(judged)] == [sky.Fault.UNDECIDED]


def test_a_wild_trajectory_is_undecided_not_endless():
    wild = sky.Trajectory(
        np.array([0.0, 1.0]), np.full((1, 6, 3), [[0.0], [1e200], [-1e200], [1e200], [-1e200], [0.0]])
    )
    assert certified(mission((AGILE, stops((0, 0, 0), (1, 0, 0))), (AGILE, wild))).trajectories[1].verdict is not PROVEN
    jitter = sky.Trajectory(np.array([0.0, 1.0]), np.random.default_rng(0).normal(0, 1e10, (1, 31, 3)))
    assert alone()(jitter).verdict is REFUTED


def test_a_misshapen_trajectory_leaves_the_fleet_undecided():
    judged = mission((AGILE, stops((0, 0, 0), (1, 0, 0))), (AGILE, stops((0, 5, 0), (1, 5, 0))))
    broken = replace(judged.trajectories[1], knots=np.array([1.0, 0.0]))
    found = certified(replace(judged, trajectories=(judged.trajectories[0], broken)))
    assert [one.verdict for one in found.trajectories] == [PROVEN, REFUTED]
    assert found.apart.verdict is UNDECIDED
    assert "uav-2" in found.apart.sentence


def test_a_hover_of_a_month_is_proven():
    month = sky.Trajectory(np.array([0, 3e6]), np.array([[[1.0, 2, 3]]]))
    found = alone()(month, boxes=[((1.1, 1, 1), (2, 3, 4))])
    assert (found.verdict, found.subdivisions) == (PROVEN, 0)


def smooth(rng, count):
    t = np.cumsum(rng.uniform(0.7, 1.5, count))
    curve = make_interp_spline(
        t - t[0], rng.uniform(0, 3, (count, 3)), 5, bc_type=([(1, np.zeros(3)), (2, np.zeros(3))],) * 2
    )
    knots = np.unique(curve.t)
    return sky.Trajectory(knots, np.stack([curve(knots[:-1], nu=k) / factorial(k) for k in range(6)], axis=1), "smooth")


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    count=st.integers(2, 6),
    share=st.sampled_from([0.9, 1 - 1e-5, 1, 1 + 1e-5, 1.1]),
    field=st.sampled_from(["max_speed", "max_acceleration", "max_jerk", "max_tilt", "thrust_to_weight", "box"]),
)
def test_certificates_agree_with_dense_sampling(seed, count, share, field):
    rng = np.random.default_rng(seed)
    flight = smooth(rng, count)
    t = np.linspace(0, flight.end, 20_001)
    p, v, a = flight.at(t)
    f = a + WEIGHT
    jerk = np.gradient(a, t, axis=0) if field == "max_jerk" else np.zeros_like(a)
    lean = np.degrees(np.arctan2(np.hypot(f[:, 0], f[:, 1]), f[:, 2]))
    norms = {
        "max_speed": np.linalg.norm(v, axis=1),
        "max_acceleration": np.linalg.norm(a, axis=1),
        "max_jerk": np.linalg.norm(jerk, axis=1),
        "max_tilt": lean,
        "thrust_to_weight": np.linalg.norm(f, axis=1) / 9.81,
        "box": p[:, 2],
    }
    peak = norms[field].max()
    high = peak if field == "box" else 0.0
    box = [((-50, -50, high + (share - 1)), (50, 50, 60))] if field == "box" else []
    easy = AGILE | {"max_tilt": min(lean.max() + 1, 89.99)}
    limit = {} if field == "box" else {field: min(peak * share, 89.99) if field == "max_tilt" else peak * share}
    if lean.max() > 88 or (field == "thrust_to_weight" and limit[field] <= 1):
        return
    found = alone(**(easy | limit))(flight, boxes=box)
    assert found.verdict is not UNDECIDED
    if share < 1:
        assert found.verdict is REFUTED
        near = np.abs(t - found.time).argmin()
        some = slice(max(near - 1, 0), near + 2)
        bad = norms[field][some].max()
        worst = share if field == "max_tilt" else 1  # of tilt a bad instant is told, but not always the worst
        assert bad >= peak * worst * (1 - 1e-3) - 1e-3
    if share > 1 and (field != "max_jerk" or share > 1.05):  # finite differences are not that good
        assert found.verdict is PROVEN, found.sentence


# ---------------------------------------------------------------- aeroplanes


def arc(speed=10.0, radius=20.0, rise=0.0, sense=1, pieces=8):
    """A helix flown for 8 tenths of a radian each."""
    t = np.arange(pieces + 1) * 0.2 * radius / speed
    angle = sense * speed / radius * t
    along = np.column_stack([np.cos(angle), np.sin(angle)])
    across = sense * np.column_stack([-along[:, 1], along[:, 0]])
    p = np.column_stack([-radius * across, rise * t])
    v = np.column_stack([speed * along, np.full(len(t), rise)])
    return hermite(t, p, v, np.column_stack([speed**2 / radius * across, np.zeros(len(t))]))


def aeroplane(speed=10.0, radius=19.99, climb=10.0, **more):
    return (
        {"max_speed": 15, "max_acceleration": 8}
        | more
        | {"fixed_wing": sky.FixedWing(speed=speed, turn_radius=radius, climb=climb)}
    )


RISE = 10 * np.tan(np.radians(8))


@pytest.mark.parametrize("sense", [-1, 1])
@pytest.mark.parametrize(
    ("fields", "rise", "fault"),
    [
        ({}, 0, None),
        ({}, RISE, None),
        ({}, -RISE, None),
        ({"climb": 8 + 1e-4}, RISE, None),
        ({"climb": 8 - 1e-4}, -RISE, sky.Fault.CLIMB),
        ({"radius": 20 - 1e-4}, 0, None),
        ({"radius": 20 + 1e-3}, 0, sky.Fault.TURN),
        ({"speed": 10 / 1.009, "radius": 19}, 0, None),
        ({"speed": 10 / 1.011, "radius": 19}, 0, sky.Fault.AIRSPEED),
        ({"speed": 10 / 0.991, "radius": 19}, 0, None),
        ({"speed": 10 / 0.989, "radius": 19}, 0, sky.Fault.AIRSPEED),
        ({"max_acceleration": 4.995, "speed": 9.95, "radius": 20 - 1e-4}, 0, sky.Fault.ACCELERATION),
        ({"max_jerk": 0.01}, 0, None),  # only of multirotors
    ],
)
def test_aeroplanes_keep_their_airspeed_turn_and_climb(sense, fields, rise, fault):
    judged = mission((aeroplane(**fields), arc(rise=rise, sense=sense)))
    assert [violation.fault for violation in faults(judged)] == ([] if fault is None else [fault])
    assert certified(judged).trajectories[0].verdict is (PROVEN if fault is None else REFUTED)


@pytest.mark.parametrize(
    ("field", "most", "words", "measured"),
    [
        ("max_speed", 1.0, r"flies (\S+) m/s \(of 1\)", lambda v, a, j: np.linalg.norm(v)),
        ("max_acceleration", 1.0, r"accelerates by (\S+) m/s\^2 \(of 1\)", lambda v, a, j: np.linalg.norm(a)),
        ("max_jerk", 1.0, r"jerks by (\S+) m/s\^3 \(of 1\)", lambda v, a, j: np.linalg.norm(j)),
        ("max_climb", 0.1, r"climbs at (\S+) m/s \(of 0.1\)", lambda v, a, j: v[2]),
        ("max_descent", 0.1, r"descends at (\S+) m/s \(of 0.1\)", lambda v, a, j: -v[2]),
        (
            "max_tilt",
            9.0,
            r"tilts by (\S+) degrees \(of 9\)",
            lambda v, a, j: np.degrees(np.arctan2(np.hypot(*a[:2]), a[2] + WEIGHT[2])),
        ),
        (
            "thrust_to_weight",
            1.01,
            r"needs a thrust of (\S+) times its weight \(of 1.01\)",
            lambda v, a, j: np.linalg.norm(a + WEIGHT) / WEIGHT[2],
        ),
    ],
)
def test_a_limit_that_is_broken_is_told_in_numbers(field, most, words, measured):
    places = [(0, 0, 5), (2, 1, 6)][:: -1 if field == "max_descent" else 1]
    flight = stops(*places)
    (found,) = faults(mission((AGILE | {field: most}, flight)))
    curve = PolynomialCurve(flight.knots, flight.coefficients)
    told = re.search(words + " at t = ", found.message)
    assert float(told[1]) == pytest.approx(measured(*curve.motion(0, found.time)[1:]), rel=1e-5)
    assert float(told[1]) > most


def test_a_turn_and_a_climb_that_are_too_tight_are_told_in_numbers():
    (turn,) = faults(mission((aeroplane(radius=25), arc())))
    radius = re.search(r"turns at a radius of (\S+) m \(of 25\) at t = ", turn.message)
    assert float(radius[1]) == pytest.approx(20, rel=1e-4)
    (climb,) = faults(mission((aeroplane(climb=5), arc(rise=RISE))))
    degrees = re.search(r"climbs or descends by (\S+) degrees \(of 5\) at t = ", climb.message)
    assert float(degrees[1]) == pytest.approx(8, rel=1e-4)


def test_aeroplanes_need_not_rest_and_may_begin_a_turn_at_once():
    bend, on = arc(pieces=4), arc(pieces=4)
    straight_p = np.array([[-20.0, 0, 0], [0, 0, 0]]) + bend.coefficients[0, 0]
    before = hermite(np.array([0.0, 2]), straight_p, np.full((2, 3), [10.0, 0, 0]), np.zeros((2, 3)))
    knots = np.r_[before.knots, 2 + on.knots[1:]]
    both = sky.Trajectory(knots, np.concatenate([before.coefficients, bend.coefficients]), form="dubins")
    assert faults(mission((aeroplane(), both))) == []
    found = {violation.fault for violation in faults(mission((AGILE, both)))}
    assert found == {sky.Fault.TRAJECTORY_ENDS, sky.Fault.CONTINUITY}  # a multirotor has to


@pytest.mark.parametrize("far", [0.0, 5e5])
@pytest.mark.parametrize(
    ("jump", "found"), [(0.0, []), (9e-7, []), (1.1e-6, [sky.Fault.CONTINUITY]), (0.4, [sky.Fault.CONTINUITY])]
)
def test_a_position_jumps_as_little_far_from_zero_as_near_it(far, jump, found):
    there, on = stops((far, 0, 0), (far + 1, 0, 0)), stops((far + 1 + jump, 0, 0), (far + 2, 0, 0))
    flight = sky.Trajectory(np.arange(3.0), np.concatenate([there.coefficients, on.coefficients]))
    judged = mission((AGILE, flight))
    wide = judged.scenario.model_copy(update={"bounds": sky.Bounds(min=(-1e6, -100, -100), max=(1e6, 100, 100))})
    assert [violation.fault for violation in faults(replace(judged, scenario=wide))] == found


# ---------------------------------------------------------------- claims


def test_values_that_are_no_certificates_are_ignored():
    fine = mission((AGILE, stops((0, 0, 0), (3, 0, 0))))
    for junk in (None, 3, "proven", ("proven",), [None, None, 5]):
        assert faults(replace(fine, certificates=junk, apart=junk)) == []


def test_check_is_empty_exactly_where_all_is_proven():
    for seed in range(12):
        rng = np.random.default_rng(seed)
        flights = [(AGILE | {"max_speed": rng.uniform(3, 12), "separation": 0.4}, smooth(rng, 3)) for _ in range(3)]
        judged = mission(*flights)
        true = certified(judged)
        proven = all(one.verdict is PROVEN for one in (*true.trajectories, true.apart))
        assert proven == (faults(judged) == [])
