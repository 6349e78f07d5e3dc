"""What is asked for, held against rotorpy's own mechanics."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from handmade import straight
from skyverse.flight import VEHICLES, RungeKutta, thrust_along, vehicle_of

pytest.importorskip("rotorpy", reason='rotorpy is not installed; pip install "skyverse[flight]"')

place = st.tuples(*[st.floats(-4, 4)] * 3)


@given(place, place, st.floats(0, 1), st.sampled_from(list(VEHICLES)))
@settings(max_examples=60)
def test_the_thrust_found_makes_rotorpys_vehicle_accelerate_as_the_trajectory_does(start, end, share, name):
    from rotorpy.vehicles.multirotor import Multirotor

    vehicle, flight = vehicle_of(name), straight(start, end, 4.0)
    t = 4.0 * share
    (up,), (thrust,) = thrust_along(flight, vehicle, np.array([t]))
    motion = flight.at(t)
    left = np.cross(up, [1.0, 0.0, 0.0])
    left /= np.linalg.norm(left)
    turned = Rotation.from_matrix(np.column_stack([np.cross(left, up), left, up]))
    speeds = np.full(4, np.sqrt(thrust / 4 / vehicle.parameters["k_eta"]))
    state = {
        "x": motion.position[0],
        "v": motion.velocity[0],
        "q": turned.as_quat(),
        "w": np.zeros(3),
        "wind": np.zeros(3),
        "rotor_speeds": speeds,
    }
    body = Multirotor(vehicle.parameters, state)
    found = body.statedot(state, {"cmd_motor_speeds": speeds}, 0.01)["vdot"]
    assert found == pytest.approx(motion.acceleration[0], abs=2e-3)


def test_steps_of_runge_kutta_agree_with_scipys_own():
    from scipy.integrate import solve_ivp

    def pendulum(t, y):
        return np.array([y[1], -np.sin(y[0]) - 0.1 * y[1]])

    exact = solve_ivp(pendulum, (0, 2), [1.0, 0.0], rtol=1e-11, atol=1e-12).y[:, -1]
    errors = []
    for step in (0.2, 0.1):
        found = solve_ivp(pendulum, (0, 2), [1.0, 0.0], method=RungeKutta, max_step=step)
        assert len(found.t) == round(2 / step) + 1
        errors.append(np.abs(found.y[:, -1] - exact).max())
    assert errors[1] < 1e-5
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.3)  # of fourth order
