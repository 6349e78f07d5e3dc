"""The power of a vehicle meets its data sheet, agrees with momentum theory, and is refused where it cannot be known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.power import INDUCED_SPEED, aeroplane_curve

CAMERA = {"start": (0, 0, 0), "hover_power": 121.6, "power": ((9, 102.7), (14, 121.3)), "mass": 0.915}
GLIDER = {"start": (0, 0, 0), "fixed_wing": {"speed": 15, "turn_radius": 100, "climb": 5}, "max_speed": 20, "mass": 1.4}


def watts(power, airspeed, climb=0.0, load=1.0):
    return float(power.at(np.array([airspeed]), np.array([climb]), np.array([load]))[0])


def any_power(draw):
    speeds = st.floats(0.5, 25)
    kind = draw(st.sampled_from(["hover", "momentum", "measured", "aeroplane", "measured aeroplane"]))
    laden = {"payload": draw(st.sampled_from([0.0, 0.3]))}
    if kind == "momentum":
        hover, share, drag = draw(st.floats(10, 3000)), draw(st.floats(0, 1)), draw(st.floats(0, 1e-3))
        points = []
        for speed in draw(st.lists(speeds, min_size=1, max_size=2, unique=True)):
            induced = share * momentum_share(speed)
            points.append((speed, hover * (induced + 1 - share + drag * speed**3)))
        return sky.UAV(**CAMERA | laden | {"hover_power": hover, "power": points}).power_model
    points = [(v, draw(st.floats(20, 300))) for v in sorted(draw(st.sets(speeds, min_size=1, max_size=5)))]
    if kind == "hover":
        return sky.UAV(**CAMERA | laden | {"power": None}).power_model
    if kind == "measured":
        return sky.UAV(**CAMERA | laden | {"power": None, "power_curve": points}).power_model
    if kind == "measured aeroplane":
        return sky.UAV(**GLIDER | laden, power_curve=points).power_model
    return sky.UAV(**GLIDER | laden, power=((10, 41.2), (12, 43.5))).power_model


POWERS = st.composite(any_power)()


def momentum_share(speed, load=1.0):
    """Thrust times the speed v of the air below the rotors, found by bisection of v sqrt(v^2 + a^2) = load v0^2."""
    low, high = 0.0, 10 * INDUCED_SPEED
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if middle * math.hypot(middle, speed) < load * INDUCED_SPEED**2 else (low, middle)
    return load * low / INDUCED_SPEED


def test_the_hover_power_alone_grows_with_the_thrust_to_the_power_of_one_and_a_half_and_with_nothing_else():
    power = sky.UAV(start=(0, 0, 0), hover_power=122).power_model
    for airspeed, climb, load in ((0, 0, 1), (12, 0, 1), (0, 3, 1), (5, -2, 1.7), (0, 0, 0)):
        assert watts(power, airspeed, climb, load) == pytest.approx(122 * load**1.5)


@pytest.mark.parametrize("load", [0.5, 1.0, 1.8])
@pytest.mark.parametrize("speed", [0.0, 3.0, 9.0, 20.0])
def test_the_power_that_pushes_air_down_is_that_of_momentum_theory(speed, load):
    power = sky.UAV(**CAMERA).power_model
    level = 121.6 * (power.induced * momentum_share(speed, load) + (1 - power.induced) * load**1.5)
    assert watts(power, speed, 0.0, load) == pytest.approx(level + power.drag * speed**3, rel=1e-9)


def test_two_points_of_a_data_sheet_and_the_hover_are_met_exactly_and_one_point_too():
    for points in (CAMERA["power"], CAMERA["power"][:1], CAMERA["power"][1:]):
        power = sky.UAV(**CAMERA | {"power": points}).power_model
        assert watts(power, 0.0) == pytest.approx(121.6)
        assert [watts(power, speed) for speed, _ in points] == pytest.approx([given for _, given in points])


def test_an_aeroplane_meets_two_points_and_its_drag_of_lift_grows_with_the_square_of_the_load():
    drag, lift = aeroplane_curve([(10, 41.2), (12, 43.5)])
    power = sky.UAV(**GLIDER, power=((10, 41.2), (12, 43.5))).power_model
    assert (watts(power, 10), watts(power, 12)) == pytest.approx((41.2, 43.5))
    assert watts(power, 11, 0.0, 2.0) == pytest.approx(drag * 11**3 + 4 * lift / 11)
    assert watts(power, 11, 1.0) - watts(power, 11) == pytest.approx(1.4 * 9.81 / 0.5)


def test_measured_points_are_met_with_straight_lines_between_and_a_cube_beyond():
    power = sky.UAV(start=(0, 0, 0), power_curve=[(0, 200), (8, 180), (12, 240)]).power_model
    assert [watts(power, v) for v in (0, 4, 8, 11, 12)] == pytest.approx([200, 190, 180, 225, 240])
    assert watts(power, 24) == pytest.approx(8 * 240)


def test_payload_counts_as_thrust():
    plain = sky.UAV(start=(0, 0, 0), hover_power=100, mass=2.0)
    laden = plain.model_copy(update={"payload": 0.5})
    assert watts(laden.power_model, 7) == pytest.approx(100 * 1.25**1.5)
    climbing = watts(laden.power_model, 0, 2.0) - watts(laden.power_model, 0)
    assert climbing == pytest.approx(2.5 * 9.81 * 2.0)
    assert watts(laden.power_model, 0, -2.0) == watts(laden.power_model, 0)


@given(POWERS, st.floats(0, 30), st.floats(0, 30), st.floats(0, 1))
def test_between_two_corners_the_power_is_largest_at_an_end(power, one, other, share):
    low, high = sorted((one, other))
    within = low + share * (high - low)
    ends = max(watts(power, speed) for speed in (low, high, *np.clip(power.corners, low, high)))
    assert watts(power, within) <= ends * (1 + 1e-9)


@given(POWERS, st.floats(0, 30), st.floats(-5, 5), st.floats(0, 3), st.floats(0, 2), st.floats(0, 2))
def test_the_power_rises_with_climb_and_load(power, airspeed, climb, load, faster, more):
    assert watts(power, airspeed, climb, load) <= watts(power, airspeed, climb + faster, load + more) * (1 + 1e-9)


@pytest.mark.parametrize(
    "wrong",
    [
        {"power_curve": [(0, 100)]},
        {"hover_power": None},
        {"power": [(3, 200), (9, 100)]},
        {"power": None, "power_curve": [(0, 100)]},
        {"power": None, "power_curve": [(5, 100), (5, 110)]},
        {"power": None, "hover_power": None, "power_curve": [(5, 100)]},
        {"power": []},
        {"power": [(3, -1)]},
        {"mass": None, "payload": 1.0},
        {"mass": None, "battery": 77.0},
        {"power": None, "hover_power": None, "battery": 77.0},
        {"fixed_wing": {"speed": 4, "turn_radius": 40, "climb": 7}, "power": [(12, 40)]},
        {"fixed_wing": {"speed": 4, "turn_radius": 40, "climb": 7}, "power": None, "battery": 77.0},
        {"reserve": 0.9},
        {"batteries": 0},
        {"swap": -1.0},
    ],
)
def test_powers_and_batteries_that_mean_nothing_are_refused(wrong, refuses):
    with refuses():
        sky.UAV(**CAMERA | wrong)


def test_a_battery_gives_what_is_trusted_of_it_less_the_reserve():
    uav = sky.UAV(**CAMERA, battery=77.0, reserve=0.25)
    assert uav.usable_energy == pytest.approx(77 * 3600 * 0.65)
    assert sky.UAV(**CAMERA).usable_energy is None
