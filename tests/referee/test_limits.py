"""Each limit of a UAV may be reached, and not exceeded by more than a millionth: by slow UAVs and by fast ones."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.model.uav import GRAVITY

Fault = sky.Fault
FREE = {"max_speed": 1e4, "max_acceleration": 1e4, "max_jerk": 1e6, "max_tilt": 89.9, "thrust_to_weight": 1e3}
MADE_BY = sky.Provenance("0", "by hand", "", None, "")
ASLANT = np.array([12.0, -4, 3]) / 13
LEVEL = np.array([3.0, -4, 0]) / 5
UP = np.array([0.0, 0, 1])


def flown(rows, seconds=1.0, begin=0.0, **fields):
    """What is said of one UAV along one polynomial, of its ends apart."""
    rows = np.array(rows, dtype=float)[None]
    flight = sky.Trajectory(begin + np.array([0.0, seconds]), rows)
    start = tuple(rows[0, 0].tolist())
    scenario = sky.Scenario(
        name="limits",
        bounds=sky.Bounds(min=(-1e5, -1e5, -1e5), max=(1e5, 1e5, 1e5)),
        clearance=0.1,
        lattice=sky.Lattice(step=(1e3, 1e3, 1e3)),
        uavs=(sky.UAV(start=start, **fields),),
        targets=(sky.Target(position=tuple(flight.at(flight.end).position[0].tolist())),),
    )
    mission = sky.Mission(scenario, (0,), (None,), (flight,), (), MADE_BY)
    return [one for one in sky.check(scenario, mission) if one.fault not in (Fault.ASSIGNMENT, Fault.TRAJECTORY_ENDS)]


def multirotor(name, share, top):
    """A flight that uses a share of one limit, and what is given."""
    place = np.array([1.0, 2, 3])
    speed, slope, jerk = share * top * ASLANT, share * top / 2 * ASLANT, share * top / 6 * ASLANT
    up = share * top * UP
    leaning = LEVEL * GRAVITY * np.tan(np.radians(share * top)) / 2
    pushed = np.array([0.6 * share * top * GRAVITY, 0, 0.8 * share * top * GRAVITY - GRAVITY]) / 2
    rows = {
        "max_speed": [place, speed],
        "max_acceleration": [place, -slope, slope],
        "max_jerk": [place, 0 * jerk, -3 * jerk / 2, jerk],
        "max_climb": [place, up],
        "max_descent": [place, -up],
        "thrust_to_weight": [place, 0 * pushed, pushed],
        "max_tilt": [place, 0 * leaning, leaning],
    }
    return {"rows": rows[name], **FREE, name: top}


def aeroplane(name, share, top):
    """The same of an aeroplane; the top is its speed, and in proportion to that are turns and climbs."""
    place, radius, steep = np.array([1.0, 2, 3]), 3 * top, min(top, 40.0)
    rise = np.sin(np.arccos(0.99)) * top  # as fast as it should be, but for a climb
    angle = np.radians(share * steep)
    seconds = 0.1
    bend = share * top**2 / radius  # with the vertex of a parabola in the middle
    rows = {
        "fast": [place, LEVEL * top * 1.01 * share],
        "slow": [place, LEVEL * top * 0.99 / share + UP * rise],
        "climb": [place, LEVEL * top + UP * top * np.tan(angle)],
        "descent": [place, LEVEL * top - UP * top * np.tan(angle)],
        "left": [place, (top, -bend * seconds / 2, 0.7 * top), (0, bend / 2, 0)],
        "right": [place, (-bend * seconds / 2, top, -0.7 * top), (bend / 2, 0, 0)],
    }
    wing = sky.FixedWing(speed=top, turn_radius=radius, climb=steep if "d" in name or "c" in name else 80.0)
    return {"rows": rows[name], "seconds": seconds, **FREE, "fixed_wing": wing}


LIMITS = {
    "max_speed": Fault.SPEED,
    "max_acceleration": Fault.ACCELERATION,
    "max_jerk": Fault.JERK,
    "max_climb": Fault.CLIMB_RATE,
    "max_descent": Fault.DESCENT_RATE,
    "thrust_to_weight": Fault.THRUST,
    "max_tilt": Fault.TILT,
    "fast": Fault.AIRSPEED,
    "slow": Fault.AIRSPEED,
    "climb": Fault.CLIMB,
    "descent": Fault.CLIMB,
    "left": Fault.TURN,
    "right": Fault.TURN,
}


def using(name, share, top):
    return flown(**(multirotor if "_" in name else aeroplane)(name, share, top))


@pytest.mark.parametrize("top", [0.3, 1.7, 35.0])
@pytest.mark.parametrize("name", LIMITS)
def test_a_limit_may_be_reached_and_not_exceeded(name, top):
    if name == "thrust_to_weight":
        top += 1
    for share in (0.99, 1 - 1e-9, 1.0, 1 + 5e-7):
        assert using(name, share, top) == [], share
    for share in (1 + 3e-6, 1.2):
        assert [one.fault for one in using(name, share, top)] == [LIMITS[name]], share
    assert {one.fault for one in using(name, 1 + 1e-6, top)} <= {Fault.UNDECIDED, LIMITS[name]}
