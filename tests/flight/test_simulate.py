"""The compiled simulator against rotorpy: the same flights, to less than a thousandth of a millimetre."""

import numpy as np
import pytest

import skyverse as sky
from handmade import mission, straight
from skyverse.flight import (
    HOVER_SECONDS,
    VEHICLES,
    commands_to,
    draw,
    simulate,
    simulate_in_rotorpy,
    vehicle_of,
)

pytest.importorskip("rotorpy", reason='rotorpy is not installed; pip install "skyverse[flight]"')

CALM = sky.Conditions()
STORMY = sky.Conditions(wind=(3.0, -7.0, 0.5), noise=0.02, gusts=True, mismatch=0.2, position_noise=0.3, delay=0.03)
CURVED = mission(straight((0, 0, 2), (3, 1, 3.5), 1.7, begin=0.4))


def job(vehicle, weather, seed=3, of=CURVED):
    kind = vehicle_of(vehicle)
    return commands_to(of, 0, kind), kind, weather, seed


@pytest.mark.parametrize("vehicle", VEHICLES)
@pytest.mark.parametrize("weather", [CALM, STORMY], ids=["calm", "stormy"])
def test_the_compiled_simulator_flies_as_rotorpy_does(vehicle, weather):
    ours, theirs = simulate(*job(vehicle, weather)), simulate_in_rotorpy(*job(vehicle, weather))
    assert np.array_equal(ours.times, theirs.times)
    assert np.abs(ours.positions - theirs.positions).max() < 1e-6
    assert np.abs(ours.velocities - theirs.velocities).max() < 1e-6
    assert np.abs(ours.rotors - theirs.rotors).max() < 1e-3
    assert np.abs(ours.tilt - theirs.tilt).max() < 1e-4
    assert not ours.lost
    moved = np.linalg.norm(ours.positions - ours.positions[0], axis=1)
    assert moved.max() > 3


def test_both_lose_a_uav_at_the_same_instant():
    storm = sky.Conditions(wind=(60.0, 0.0, 0.0))
    ours, theirs = simulate(*job("thesis", storm)), simulate_in_rotorpy(*job("thesis", storm))
    assert ours.lost
    assert theirs.lost
    assert np.array_equal(ours.times, theirs.times)


def test_samples_begin_at_the_departure_after_a_hover_in_the_wind():
    told = commands_to(CURVED, 0, vehicle_of("thesis"))
    assert told.times[0] == pytest.approx(0.4 - HOVER_SECONDS)
    assert told.times[told.hover] == pytest.approx(0.4)
    flown = simulate(*job("thesis", sky.Conditions(wind=(8.0, 0.0, 0.0))))
    assert flown.times[0] == pytest.approx(0.4)
    assert np.linalg.norm(flown.positions[0] - (0, 0, 2)) < 0.005  # the controller has found the wind
    assert flown.tilt[0] > 10  # and leans against it


def test_the_delay_makes_the_same_flight_worse():
    still = mission(straight((0, 0, 2), (0, 0, 2), 1.0))
    gusty = [sky.Conditions(wind=(8.0, 0.0, 0.0), gusts=True, delay=delay) for delay in (0.0, 0.1)]
    prompt, late = (np.linalg.norm(simulate(*job("thesis", w, of=still)).positions - (0, 0, 2), axis=1) for w in gusty)
    assert late.max() > 1.2 * prompt.max()


def test_mismatch_changes_mass_thrust_drag_and_inertia_each_on_its_own_within_its_share():
    kind = vehicle_of("thesis")
    told = commands_to(CURVED, 0, kind)
    weather = sky.Conditions(mismatch=0.2)
    shares = []
    for seed in range(200):
        made = draw(told, kind, weather, seed)[0].parameters
        for one, other in (("c_Dx", "k_z"), ("Ixx", "Izz")):
            assert made[one] / kind.parameters[one] == pytest.approx(made[other] / kind.parameters[other])
        shares.append([made[name] / kind.parameters[name] for name in ("mass", "k_eta", "c_Dx", "Ixx")])
    assert np.min(shares, axis=0) == pytest.approx(np.full(4, 0.8), abs=0.01)
    assert np.max(shares, axis=0) == pytest.approx(np.full(4, 1.2), abs=0.01)
    assert np.abs(np.corrcoef(np.transpose(shares)) - np.eye(4)).max() < 0.25


def test_the_drift_of_positions_has_the_stated_deviation_and_hardly_changes_in_a_second():
    kind = vehicle_of("thesis")
    told = commands_to(CURVED, 0, kind)
    weather = sky.Conditions(position_noise=0.5)
    errors = [draw(told, kind, weather, seed)[1].position_error for seed in range(400)]
    assert np.std([error[0] for error in errors], axis=0) == pytest.approx(np.full(3, 0.5), rel=0.12)
    moved = np.array([error[100] - error[0] for error in errors])
    assert np.std(moved) == pytest.approx(0.5 * np.sqrt(2 / 1100), rel=0.12)


@pytest.mark.parametrize(
    ("direction", "towards"), [(270, (8, 0)), (0, (0, -8)), (90, (-8, 0)), (225, (32**0.5, 32**0.5))]
)
def test_a_wind_is_named_by_where_it_comes_from(direction, towards):
    assert sky.wind_from(8, direction) == pytest.approx((*towards, 0))
