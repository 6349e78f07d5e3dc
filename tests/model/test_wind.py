"""The wind of a scenario: what is stated, how it is written, and what vehicles make of it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.wind import WindBall, good_speed, told_wind

SPEEDS = st.floats(-12, 12)
VELOCITIES = st.tuples(SPEEDS, SPEEDS, SPEEDS)
ROOM = sky.Scenario(
    name="room",
    bounds={"min": (0, 0, 0), "max": (60, 60, 40)},
    clearance=0.0,
    uavs=[{"start": (1, 1, 1)}],
    targets=[{"position": (50, 50, 30)}],
)


def windy(scenario, **wind):
    return scenario.model_copy(update={"wind": sky.Wind.model_validate(wind)})


def test_a_wind_is_written_as_pilots_tell_it():
    assert windy(ROOM, speed=8, **{"from": 270}, gust=3).wind == sky.Wind(velocity=(8, 0, 0), gust=3)
    layers = [{"altitude": 0, "speed": 2, "from": 180}, {"altitude": 100, "velocity": (0, 6, 1)}]
    assert windy(ROOM, layers=layers).wind.layers[0].velocity == pytest.approx((0, 2, 0))


def test_between_layers_the_wind_is_linear_and_beyond_them_constant():
    layers = [
        {"altitude": 10, "velocity": (2, 0, 0)},
        {"altitude": 20, "velocity": (6, 4, 0)},
        {"altitude": 40, "velocity": (6, 0, 0)},
    ]
    found = windy(ROOM, layers=layers).wind.at([-5, 10, 15, 25, 40, 1e9])
    assert found.tolist() == [[2, 0, 0], [2, 0, 0], [4, 2, 0], [6, 3, 0], [6, 0, 0], [6, 0, 0]]


@pytest.mark.parametrize(
    ("wind", "said"),
    [
        ({}, "velocity, for all altitudes, or layers"),
        ({"velocity": (1, 0, 0), "layers": [{"altitude": 0, "velocity": (1, 0, 0)}]}, "or layers"),
        ({"speed": 8}, "both speed and from"),
        ({"speed": 8, "from": 270, "velocity": (1, 0, 0)}, "either velocity"),
        ({"speed": -8, "from": 270}, "speed"),
        ({"speed": "strong", "from": 270}, "speed"),
        ({"velocity": (0, 0, 200)}, "100"),
        ({"velocity": (0, 0, 1), "gust": -1}, "gust"),
        ({"layers": [{"altitude": 3, "velocity": (1, 0, 0)}, {"altitude": 3.05, "velocity": (2, 0, 0)}]}, "rise"),
    ],
)
def test_a_wind_that_says_nothing_or_too_much_is_refused(wind, said):
    with pytest.raises(sky.InputError, match=said):
        sky.Scenario.model_copy(ROOM, update={"wind": wind})


def test_a_scenario_without_wind_has_the_digest_that_it_had(tmp_path):
    blown = windy(ROOM, velocity=(3, 0, 0), gust=0.5)
    assert "wind" not in ROOM.model_dump_json(exclude_defaults=True)
    assert blown.digest != ROOM.digest
    for name in ("room.yaml", "room.json"):
        sky.write(blown, tmp_path / name)
        assert sky.read_scenario(tmp_path / name) == blown


@given(st.lists(st.tuples(st.integers(0, 100), VELOCITIES), min_size=1, max_size=5, unique_by=lambda row: row[0]))
def test_the_ball_of_winds_holds_the_wind_at_every_altitude(rows):
    layers = [{"altitude": z, "velocity": velocity} for z, velocity in sorted(rows)]
    wind = sky.Wind(layers=layers, gust=1.5)
    ball = wind.between(20, 70)
    winds = wind.at(np.linspace(20, 70, 501))
    assert (np.linalg.norm(winds - ball.velocity, axis=1) + 1.5 <= ball.radius + 1e-9).all()
    assert ball.radius <= 1.5 + np.linalg.norm(np.ptp(winds, axis=0)) + 0.5  # 0.5: layers between the samples


@given(VELOCITIES, st.floats(0, 3), st.floats(0.5, 30), st.floats(0, 6.28), st.floats(-1, 1))
def test_the_speed_made_good_is_the_largest_that_no_wind_of_the_ball_makes_too_fast(velocity, radius, top, turn, up):
    ball = WindBall(velocity, radius)
    airspeed = ball.strongest + 0.1
    way = np.array([math.cos(turn) * math.sqrt(1 - up * up), math.sin(turn) * math.sqrt(1 - up * up), up])
    uav = sky.UAV(start=(0, 0, 0), max_speed=top, max_airspeed=airspeed)
    (good,) = good_speed(uav, ball, way[None])

    def needed(speed):
        return np.linalg.norm(speed * way - velocity) + radius

    low, high = 0.0, top
    if needed(top) > airspeed:
        for _ in range(80):
            middle = (low + high) / 2
            low, high = (middle, high) if needed(middle) <= airspeed else (low, middle)
        high = low
    assert good == pytest.approx(high, abs=1e-7)


def test_an_aeroplane_holds_its_speed_in_the_wind_that_its_profile_states():
    plane = sky.UAV(start=(0, 0, 0), vehicle="mapping")
    assert good_speed(plane, WindBall((0, 4, 0), 0.5), np.eye(3)).tolist() == [15.0] * 3
    told = sky.UAV(
        start=(0, 0, 0), max_speed=20, max_acceleration=9, fixed_wing={"speed": 15, "turn_radius": 40, "climb": 10}
    )
    assert told.max_wind == pytest.approx(20 - 15 / math.cos(math.radians(10)))


@pytest.mark.parametrize(
    ("velocity", "said"),
    [
        ((8, 0, 0), "8 m/s from 270 degrees"),
        ((0, -3, -1), "3 m/s from 0 degrees and 1 m/s downwards"),
        ((0, 0, 2), "2 m/s upwards"),
        ((0, 0, 0), "0 m/s"),
    ],
)
def test_a_wind_is_told_in_words(velocity, said):
    assert told_wind(velocity) == said
