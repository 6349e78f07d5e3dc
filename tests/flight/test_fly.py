import itertools
import math
import sys
from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from handmade import mission, straight
from skyverse.flight import VEHICLES, vehicle_of

pytest.importorskip("rotorpy", reason='rotorpy is not installed; pip install "skyverse[flight]"')

THESIS = 0.176 * 9.81  # newtons


@pytest.fixture(scope="module")
def hover():
    return sky.fly(mission(straight((0, 0, 2), (0, 0, 2), 1.0)))


@pytest.fixture(scope="module")
def shaken():
    """Two UAVs in noise, of a seed that was drawn."""
    return sky.fly(mission(*[straight((0, y, 2), (0, y, 2), 0.3) for y in (0, 3)]), sky.Conditions(noise=0.01))


@pytest.fixture(scope="module")
def pair():
    """Two UAVs past a box, in wind and noise."""
    flights = straight((0, 0, 2), (2, 0, 2), 1.5), straight((2, 1, 2), (0, 1.2, 2.5), 1.5, begin=0.255)
    flown = mission(*flights, None, boxes=[((1, -1, 0), (1.5, -0.3, 3)), ((0, 4, 0), (1, 5, 1))])
    return sky.fly(flown, sky.Conditions(wind=(0, 1, 0), noise=0.01), rng=5)


def test_a_hovering_uav_holds_still_at_the_thrust_and_power_of_its_weight(hover):
    flown = hover.flown[0]
    assert flown.largest < 1e-6
    assert flown.times == pytest.approx(np.arange(201) / 100)
    assert flown.mean_thrust == pytest.approx(1 / 2.5, rel=1e-6)
    made = vehicle_of("thesis").parameters
    speed = math.sqrt(THESIS / 4 / made["k_eta"])
    assert flown.energy == pytest.approx(4 * made["k_m"] * speed**3 * 2.0, rel=1e-6)
    assert flown.peak_tilt < 1e-3
    assert flown.clearance == math.inf
    assert hover.safe


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_a_straight_flight_arrives_on_time_and_stays_within_15_mm(vehicle):
    flight = sky.fly(mission(straight((0, 0, 2), (1.5, 1, 2.5), 2.0)), sky.Conditions(vehicle=vehicle))
    flown = flight.flown[0]
    assert flown.largest < 0.015
    assert flown.positions[-1] == pytest.approx([1.5, 1, 2.5], abs=0.005)
    assert np.linalg.norm(flown.velocities[-1]) < 0.02
    halfway = flown.positions[100]
    assert halfway == pytest.approx([0.75, 0.5, 2.25], abs=0.015)
    assert flight.safe


def test_without_being_told_of_drag_and_lag_it_flies_far_worse(monkeypatch):
    from skyverse.flight import commands

    flown = mission(straight((0, 0, 2), (2, 0, 2), 1.6))
    told = sky.fly(flown).largest
    monkeypatch.setattr(commands, "reference", lambda t, *_: t.at(_[1]))
    assert sky.fly(flown).largest > 5 * told


def test_a_steady_wind_is_compensated_when_the_uav_departs():
    flight = mission(straight((0, 0, 2), (0, 0, 2), 1.0))
    flown = sky.fly(flight, sky.Conditions(wind=(2, 0, 0))).flown[0]
    assert flown.largest < 0.004
    assert flown.peak_tilt > 2.0  # it leans against the wind


def test_gusts_push_and_are_compensated():
    flight = mission(straight((0, 0, 2), (0, 0, 2), 1.0))
    gusts = {"gusts": True}
    flown = sky.fly(flight, sky.Conditions(wind=(8, 0, 0), **gusts), rng=1)
    assert 0.005 < flown.largest < 0.1
    assert flown.conditions == sky.Conditions(vehicle="thesis", wind=(8, 0, 0), **gusts)
    turned = sky.fly(flight, sky.Conditions(wind=sky.wind_from(8, 90), **gusts), rng=1)
    pushed = (flown.flown[0].positions, turned.flown[0].positions)
    assert pushed[1][:, 0] == pytest.approx(-pushed[0][:, 0], abs=2e-3)


@pytest.mark.parametrize(
    ("verb", "options"), [("fly", {}), ("fly_until_safe", {}), ("fly_until_safe", {"conditions": None, "rounds": 0})]
)
def test_conditions_of_another_kind_and_no_rounds_are_refused(verb, options, refuses):
    still = mission(straight((0, 0, 2), (0, 0, 2), 0.3))
    with refuses():
        getattr(sky, verb)(still, **{"conditions": {"wind": (1, 0, 0)}, **options})


def test_the_seed_drawn_is_told_and_flies_the_same_also_in_other_processes(shaken):
    assert sky.fly(shaken.mission, sky.Conditions(noise=0.01), rng=shaken.seed, workers=2) == shaken


def test_a_flight_without_chance_has_no_seed(hover):
    assert hover.seed is None
    still = mission(straight((0, 0, 2), (0, 0, 2), 0.3))
    assert sky.fly(still, sky.Conditions(wind=(1, 0, 0), delay=0.02), rng=3).seed is None
    assert sky.fly(still, sky.Conditions(mismatch=0.1), rng=3).seed == 3
    assert sky.fly(still, sky.Conditions(wind=(1, 0, 0), gusts=True), rng=3).seed == 3


def test_another_seed_flies_otherwise_and_is_told(shaken):
    other = sky.fly(shaken.mission, sky.Conditions(noise=0.01), rng=5)
    assert not np.array_equal(other.flown[0].positions, shaken.flown[0].positions)
    assert other.seed == 5


def test_noise_shakes_each_its_own_way(shaken):
    one, other = (flown.positions - flown.commanded for flown in shaken.flown)
    assert not np.allclose(one, other, atol=1e-3)
    assert all(0.0005 < flown.rms < 0.02 for flown in shaken.flown)


def test_all_numbers_follow_from_the_samples(pair):
    scenario, made = pair.mission.scenario, vehicle_of("thesis").parameters
    for flown in pair.flown[:2]:
        trajectory = pair.mission.trajectories[flown.uav]
        errors = [math.dist(p, trajectory.at(t).position[0]) for t, p in zip(flown.times, flown.positions, strict=True)]
        assert flown.largest == pytest.approx(max(errors))
        assert flown.rms == pytest.approx(math.sqrt(sum(e * e for e in errors) / len(errors)))
        gaps = [_gap(p, box) for p in flown.positions for box in scenario.obstacles]
        assert flown.clearance == pytest.approx(min(gaps))
        when = flown.positions[list(flown.times).index(flown.clearance_time)]
        assert min(_gap(when, box) for box in scenario.obstacles) == pytest.approx(flown.clearance)
        assert 1 / 2.5 * 0.9 < flown.mean_thrust < flown.peak_thrust <= 1.0
        hovering = 4 * made["k_m"] * (THESIS / 4 / made["k_eta"]) ** 1.5 * (flown.times[-1] - flown.times[0])
        assert flown.energy == pytest.approx(hovering, rel=0.1)
        assert flown.times[0] <= trajectory.start < flown.times[0] + 0.011
        assert flown.times[-1] >= trajectory.end + 1.0
    places = [_places(pair, uav) for uav in range(3)]
    assert [passing.uavs for passing in pair.passings] == [(0, 1), (0, 2), (1, 2)]
    for passing in pair.passings:
        i, j = passing.uavs
        apart = np.array([np.subtract(a, b) for a, b in zip(places[i], places[j], strict=True)])
        nearness = [math.hypot(math.hypot(x, y) / 0.5, z / 1.0) for x, y, z in apart]
        k = min(range(len(nearness)), key=nearness.__getitem__)
        assert passing.nearness == pytest.approx(nearness[k], rel=1e-9)
        assert passing.distance == pytest.approx(math.dist(places[i][k], places[j][k]))
        assert passing.time == pytest.approx(k / 100)


def _gap(point, box):
    return math.dist(point, [min(max(p, a), b) for p, a, b in zip(point, box.min, box.max, strict=True)])


def _places(flight, uav):
    """Return where a UAV is at every hundredth of a second, waiting at first and last."""
    flown, count = flight.flown[uav], 277
    if flown is None:
        return [flight.mission.scenario.uavs[uav].start] * count
    known = {round(t * 100): p for t, p in zip(flown.times, flown.positions, strict=True)}
    return [known[min(max(k, min(known)), max(known))] for k in range(count)]


def test_contact_is_found_where_an_obstacle_stands_in_the_way():
    flights = straight((0, 0, 2), (2, 0, 2), 1.6)
    flight = sky.fly(mission(flights, boxes=[((0.9, -0.2, 0), (1.1, 0.2, 3))]))
    assert not flight.safe
    (violation,) = flight.violations
    assert violation.fault is sky.Fault.TRAJECTORY_CLEARANCE
    assert "touches" in violation.message
    assert violation.position[0] == pytest.approx(1.0, abs=0.1)
    assert flight.flown[0].clearance == pytest.approx(-0.1, abs=0.03)  # inside, half the box's thickness deep
    assert flight.sentence == "Not safe: 1 thing went wrong."


@pytest.mark.parametrize(("gap", "safe"), [(0.14, True), (0.11, False), (0.0, False)])
def test_half_the_clearance_must_be_left(gap, safe):
    flight = sky.fly(mission(straight((0, 0, 2), (0.3, 0, 2), 0.6), boxes=[((-1, gap, 0), (2, gap + 1, 3))]))
    assert flight.flown[0].clearance == pytest.approx(gap, abs=0.01)
    assert flight.safe == safe


def test_leaving_the_bounds_is_found():
    flight = sky.fly(mission(straight((19.8, 0, 2), (20.2, 0, 2), 1.0)))
    assert [v.fault for v in flight.violations] == [sky.Fault.TRAJECTORY_BOUNDS]
    assert flight.flown[0].outside == pytest.approx(0.2, abs=0.01)
    assert sky.fly(flight.mission, margin=0.3).safe


@pytest.mark.parametrize(("offset", "safe"), [(0.45, True), (0.2, False)])
def test_two_uavs_may_stray_by_a_margin_each_into_their_separation(offset, safe):
    flights = straight((0, 0, 2), (0.5, 0, 2), 0.8), straight((0.5, offset, 2), (0, offset, 2), 0.8)
    flight = sky.fly(mission(*flights))
    assert flight.safe == safe
    assert flight.passings[0].nearness == pytest.approx(offset / 0.5, abs=0.03)
    assert flight.passings[0].planned == pytest.approx(offset / 0.5, abs=0.01)
    assert all(v.fault is sky.Fault.SEPARATION and v.uavs == (0, 1) for v in flight.violations)


@pytest.mark.parametrize(("first", "second", "safe"), [(-0.4, 0.6, True), (0.6, -0.4, False)])
def test_uavs_that_start_too_close_may_part_but_not_collide(first, second, safe):
    flight = sky.fly(mission(straight((0, 0, 2), (first, 0, 2), 0.8), straight((0.2, 0, 2), (second, 0, 2), 0.8)))
    assert flight.safe == safe
    assert flight.passings[0].nearness == pytest.approx(0.4 if safe else 0.0, abs=0.05)
    assert all("0.40 as their starts or targets are given" in violation.message for violation in flight.violations)


def test_a_uav_that_departs_later_waits_at_its_start(pair):
    assert pair.flown[1].times[0] == pytest.approx(0.25)
    assert pair.flown[1].positions[0] == pytest.approx([2, 1, 2], abs=0.01)


def test_an_aeroplane_is_not_flown_but_others_are_judged_against_it():
    plane = sky.Trajectory(np.array([0.0, 2.0]), np.array([[[0.0, 0.1, 2.0], [3.0, 0.0, 0.0]]]))
    made = mission(straight((2, 0, 2), (2.5, 0, 2), 1.0), plane)
    wing = sky.FixedWing(speed=3, turn_radius=10, climb=20)
    uavs = made.scenario.uavs[0], made.scenario.uavs[1].model_copy(update={"fixed_wing": wing})
    flight = sky.fly(sky.Mission(**{**vars(made), "scenario": made.scenario.model_copy(update={"uavs": uavs})}))
    assert flight.flown[1] is None
    assert [v.fault for v in flight.violations] == [sky.Fault.SEPARATION]


def test_a_storm_is_reported_not_raised():
    flight = sky.fly(mission(straight((0, 0, 2), (0.5, 0, 2), 1.0)), sky.Conditions(wind=(60, 0, 0)))
    assert not flight.safe
    assert flight.largest > 1.0


def test_the_tilt_is_limited_in_a_wind_that_asks_for_more(monkeypatch):
    still = mission(straight((0, 0, 2), (0, 0, 2), 0.5))
    limited = sky.fly(still, sky.Conditions(wind=(25, 0, 0))).flown[0].peak_tilt
    unlimited = replace(vehicle_of("thesis"), max_tilt=None)
    monkeypatch.setitem(VEHICLES, "thesis", lambda: unlimited)
    assert 35 < limited < 50 < sky.fly(still, sky.Conditions(wind=(25, 0, 0))).flown[0].peak_tilt


def test_progress_is_told():
    told = []
    flights = [straight((x, 0, 2), (x, 0.1, 2), 0.3) for x in (0, 3)]
    sky.fly(mission(*flights), on_progress=lambda done, total: told.append((done, total)))
    assert told == [(1, 2), (2, 2)]


SHORT = mission(straight((0, 0, 2), (0.1, 0, 2), 0.3))


@pytest.mark.parametrize(
    ("conditions", "options"),
    [
        *(({"wind": wind}, {}) for wind in ((1,), "gale", (1, math.nan, 0), (8, 270), 8, (101, 0, 0), {"speed": 8})),
        ({"vehicle": "zeppelin"}, {}),
        ({"noise": -1}, {}),
        ({}, {"margin": math.inf}),
        ({}, {"margin": 1.0, "runs": 2}),
        ({}, {"workers": 0}),
        ({}, {"rng": "seed"}),
        ({"mismatch": 0.7}, {}),
        ({"position_noise": -1}, {}),
        ({"delay": "late"}, {}),
        ({"gusts": 1}, {}),
        ({"gusts": True}, {}),
        ({"vehicle": "zeppelin"}, {"runs": 2}),
        *(({}, {"runs": runs}) for runs in (0, 1.5)),
    ],
)
def test_bad_options_end_in_one_sentence(conditions, options, refuses):
    with refuses():
        sky.fly(SHORT, sky.Conditions(**conditions), **options)


def test_what_cannot_fly_is_refused(refuses):
    with refuses():
        sky.fly(mission(None))
    strong = mission(straight((0, 0, 2), (0.1, 0, 2), 0.3), max_acceleration=20, max_tilt=80, thrust_to_weight=4)
    for vehicle in ("crazyflie", "thesis"):
        with refuses():
            sky.fly(strong, sky.Conditions(vehicle=vehicle))
    leaning = mission(straight((0, 0, 2), (0.1, 0, 2), 0.3), max_acceleration=8, max_tilt=60)
    with refuses():
        sky.fly(leaning)


def test_without_rotorpy_the_sentence_says_what_to_install(monkeypatch, refuses):
    monkeypatch.setitem(sys.modules, "rotorpy", None)
    with refuses():
        sky.fly(SHORT)


def test_the_thesis_vehicle_is_as_given():
    made = vehicle_of("thesis")
    assert made.mass == 0.176
    assert made.thrust_to_weight == pytest.approx(2.5)
    assert made.max_tilt == 40
    small, large = (vehicle_of(name).parameters for name in ("crazyflie", "hummingbird"))
    for name, value in made.parameters.items():  # in size between the two
        if isinstance(value, float) and small[name] and name not in ("Izz", "rotor_speed_min", "kp_att", "kd_att"):
            low, high = sorted([small[name], large[name]])
            assert low <= value <= high, name
    assert {len(p.parameters["rotor_pos"]) for p in itertools.starmap(vehicle_of, [[n] for n in VEHICLES])} == {4}
