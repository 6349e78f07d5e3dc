import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from routing_oracle import best, flown, random_case
from skyverse.errors import InputError
from skyverse.mission.route import route
from skyverse.mission.routing import TourVehicle, Work


def plain(places, targets, returns=True, **given_values) -> tuple[TourVehicle, Work]:
    """Return a UAV at home that flies straight at 1 m/s, without limits unless given, and targets without."""
    points = np.array([*places, *[(0.0, 0.0)] * 2], dtype=float)
    metres = np.linalg.norm(points[:, None] - points[None], axis=2)
    values = {
        "price": metres, "seconds": metres, "joules": np.zeros_like(metres), "visit_joules": np.zeros(targets),
        "usable": math.inf, "most_sorties": 1, "swap": 0.0, "capacity": math.inf,
        "allowed": np.ones(targets, dtype=bool), "returns": returns,
    } | given_values  # fmt: skip
    return TourVehicle(**values), Work(np.zeros(targets), np.tile((0.0, math.inf), (targets, 1)), np.zeros(targets))


@settings(deadline=None, max_examples=150)
@given(
    seed=st.integers(0, 10**6),
    n=st.integers(0, 5),
    fleet=st.integers(1, 3),
    criterion=st.sampled_from(["min-sum", "min-max"]),
    ordered=st.booleans(),
)
def test_no_other_routes_are_better(seed, n, fleet, criterion, ordered):
    rng = np.random.default_rng(seed)
    vehicles, work = random_case(rng, n, fleet, alike=rng.random() < 0.3)
    order = [int(j) for j in rng.permutation(n)] if ordered else None
    routes = route(vehicles, work, criterion, order=order)
    values = (routes.finish, routes.price) if criterion == "min-max" else (routes.price,)
    assert (len(routes.unvisited), routes.swaps, *values) == pytest.approx(best(vehicles, work, criterion, order))
    assert routes.optimal
    assert routes.lower_bound == values[0]
    for vehicle, tour, starts, finishes in zip(vehicles, routes.tours, routes.starts, routes.finishes, strict=True):
        _price, departures, landings = flown(vehicle, work, tour)
        assert starts == pytest.approx(departures)
        assert finishes == pytest.approx(landings)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"allowed": np.array([True, False])}, "nobody may"),
        ({"price": np.array([[0, np.inf, 1, 1], [1, 0, 1, 1], [1, np.inf, 0, 0], [1, np.inf, 0, 0]])}, "no way"),
        ({"price": np.array([[0, 1, 1, 1], [np.inf, 0, np.inf, np.inf], [1, 1, 0, 0], [1, 1, 0, 0]])}, "no way"),
        ({"capacity": 1.5}, "capacity"),
        ({"usable": 10.0, "visit_joules": np.array([0.0, 11.0])}, "battery"),
        ({"seconds": np.array([[0, 9, 9, 9], [9, 0, 9, 9], [1, 9, 0, 0], [1, 9, 0, 0]], dtype=float)}, "window"),
        ({"usable": 10.0, "visit_joules": np.array([6.0, 5.0])}, "left over"),
    ],
)
def test_what_stays_unvisited_is_told_with_why(changes, reason):
    vehicle, work = plain([(1, 0), (2, 0)], 2, **changes)
    work = dataclasses.replace(work, demand=np.array([0.0, 2.0]), window=np.array([(0.0, np.inf), (0.0, 8.0)]))
    routes = route([vehicle], work)
    assert list(routes.unvisited.values()) == [reason]


def test_windows_that_exclude_each_other_leave_one_over():
    vehicle, work = plain([(10, 0), (-10, 0)], 2)
    routes = route([vehicle], dataclasses.replace(work, window=np.array([(10.0, 12.0), (10.0, 12.0)])))
    assert list(routes.unvisited.values()) == ["left over"]


def test_targets_that_coincide_are_all_visited():
    vehicle, work = plain([(3, 4)] * 8, 8)
    routes = route([vehicle, vehicle], work)
    assert (routes.price, routes.unvisited) == (10.0, {})


def test_no_targets_and_no_vehicles():
    vehicle, work = plain([], 0)
    assert route([vehicle], work).tours == ((),)
    _, work = plain([(1, 0)], 1)
    assert route([], work).unvisited == {0: "nobody may"}


def test_a_battery_is_swapped_no_more_often_than_needed():
    # both targets fit into one battery by the dear way only
    vehicle, work = plain([(10, 0), (-10, 0)], 2, most_sorties=2, usable=40.0)
    vehicle = dataclasses.replace(vehicle, joules=vehicle.seconds)
    assert route([vehicle], work).swaps == 0
    assert len(route([dataclasses.replace(vehicle, usable=39.0)], work).tours[0]) == 2


@pytest.mark.parametrize(
    ("changes", "said"),
    [({"price": np.zeros((2, 2))}, "price"), ({"usable": math.nan}, "usable"), ({"most_sorties": 0}, "most_sorties")],
)
def test_numbers_that_do_not_fit_are_refused(changes, said):
    with pytest.raises(InputError, match=said):
        plain([(1, 0)], 1, **changes)
    vehicle, _ = plain([(1, 0)], 1)
    with pytest.raises(InputError, match="2 targets"):
        route([vehicle], plain([(1, 0), (2, 0)], 2)[1])
    with pytest.raises(InputError, match="every target once"):
        route([vehicle], plain([(1, 0)], 1)[1], order=[1])
