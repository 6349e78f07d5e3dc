import dataclasses
import math
import sys
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from routing_oracle import best, flown, random_case
from skyverse.errors import InputError
from skyverse.mission.given_order import stretches
from skyverse.mission.pyvrp_routing import pyvrp_tours
from skyverse.mission.route import route, told
from skyverse.mission.routing import RouteSearch, TourVehicle, Work, possible
from skyverse.stop import Cancelled


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
    routes = route(vehicles, work, criterion, RouteSearch(order=order))
    values = (routes.finish, routes.price) if criterion == "min-max" else (routes.price,)
    assert (len(routes.unvisited), routes.swaps, *values) == pytest.approx(best(vehicles, work, criterion, order))
    assert routes.optimal
    assert routes.lower_bound == values[0]
    for vehicle, tour, starts, finishes in zip(vehicles, routes.tours, routes.starts, routes.finishes, strict=True):
        _price, departures, landings = flown(vehicle, work, tour)
        assert starts == pytest.approx(departures)
        assert finishes == pytest.approx(landings)


def test_a_tour_beyond_the_battery_is_cut_and_what_has_no_room_is_left_over():
    vehicle, work = plain([(1, 0), (2, 0), (3, 0)], 3, usable=10.0, visit_joules=np.array([6.0, 5.0, 5.0]))
    one = told([vehicle], work, [((0, 1, 2),)], "min-sum", optimal=True)
    assert (one.tours, one.unvisited, one.optimal) == ((((1, 2),),), {0: "left over"}, False)
    two = told([dataclasses.replace(vehicle, most_sorties=2)], work, [((0, 1, 2),)], "min-sum", optimal=True)
    assert (two.tours, two.unvisited, two.swaps) == ((((0,), (1, 2)),), {}, 1)


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
        route([vehicle], plain([(1, 0)], 1)[1], search=RouteSearch(order=[1]))


def on_a_plain(n: int, fleet: int, seed: int = 0, **values) -> tuple[list[TourVehicle], Work]:
    vehicle, work = plain(np.random.default_rng(seed).random((n, 2)) * 100, n, **values)
    return [vehicle] * fleet, work


def test_more_than_ten_targets_need_pyvrp(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvrp", None)
    vehicles, work = on_a_plain(11, 1)
    with pytest.raises(InputError, match=r"\[tours\]"):
        route(vehicles, work)


@pytest.mark.parametrize("seed", range(60))
def test_an_order_is_cut_into_sorties_in_the_best_way(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 8))
    (vehicle,), work = random_case(rng, n, 1)
    order = [int(j) for j in rng.permutation(n)]
    exact = route([vehicle], work, search=RouteSearch(order=order))
    could = [j for j in order if possible(vehicle, work)[j]]
    cut = told([vehicle], work, stretches([vehicle], work, could), "min-sum", optimal=False)
    found, best_value = value(cut, "min-sum"), value(exact, "min-sum")
    assert found == pytest.approx(best_value) if len(exact.unvisited) == n - len(could) else found >= best_value


def test_a_given_order_on_several_batteries_needs_no_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvrp", None)
    vehicles, work = on_a_plain(30, 1, usable=400.0, most_sorties=12)
    vehicles = [dataclasses.replace(vehicles[0], joules=vehicles[0].seconds)]
    order = [int(j) for j in np.random.default_rng(2).permutation(30)]
    routes = route(vehicles, work, search=RouteSearch(order=order))
    assert [j for sortie in routes.tours[0] for j in sortie] == order
    assert flown(vehicles[0], work, routes.tours[0]) is not None


class TestPyVRP:
    @pytest.fixture(autouse=True)
    def _installed(self):
        pytest.importorskip("pyvrp", reason="needs skyverse[tours]")

    @pytest.mark.parametrize("criterion", ["min-sum", "min-max"])
    def test_it_finds_the_best_routes_to_eight_targets_mostly_and_never_better_ones(self, criterion):
        same = 0
        for seed in range(20):
            rng = np.random.default_rng(seed)
            vehicles, work = random_case(rng, 8, int(rng.integers(1, 4)))
            exact = value(route(vehicles, work, criterion), criterion)
            tours, _ = pyvrp_tours(vehicles, work, criterion, RouteSearch(None, 0, None))
            found = value(told(vehicles, work, tours, criterion, optimal=False), criterion)
            assert found >= exact or found == pytest.approx(exact)
            same += found == pytest.approx(exact, rel=1e-3)
        assert same >= 12

    @pytest.mark.parametrize("criterion", ["min-sum", "min-max"])
    def test_the_same_seed_gives_the_same_routes_and_keeps_to_bounds(self, criterion):
        vehicles, work = on_a_plain(30, 3)
        routes = route(vehicles, work, criterion, RouteSearch(seed=4))
        assert routes.tours == route(vehicles, work, criterion, RouteSearch(seed=4)).tours
        assert sorted(j for tour in routes.tours for sortie in tour for j in sortie) == list(range(30))
        assert routes.lower_bound <= (routes.price if criterion == "min-sum" else routes.finish)
        assert (routes.bound, routes.optimal, routes.interrupted) == ("assignment", False, False)

    def test_a_smaller_largest_finish_is_sought_only_if_asked_for(self):
        vehicles, work = on_a_plain(20, 3)
        least, level = (route(vehicles, work, criterion) for criterion in ("min-sum", "min-max"))
        assert level.finish < least.finish
        assert least.price < level.price

    def test_targets_on_a_circle_are_visited_around_it(self):
        angles = np.arange(40) * 2 * np.pi / 40
        points = np.random.default_rng(1).permutation(np.stack([np.cos(angles) - 1, np.sin(angles)], axis=1))
        vehicle, work = plain(points, 40)
        assert route([vehicle], work).price == pytest.approx(40 * 2 * np.sin(np.pi / 40))

    def test_batteries_are_kept_to_and_swapped_seldom(self):
        vehicles, work = on_a_plain(25, 2, usable=300.0, most_sorties=5)
        vehicles = [dataclasses.replace(v, joules=v.seconds) for v in vehicles[:1]] * 2
        routes = route(vehicles, work)
        assert routes.unvisited == {}
        assert routes.swaps <= 1
        for vehicle, tour in zip(vehicles, routes.tours, strict=True):
            assert flown(vehicle, work, tour) is not None

    @pytest.mark.parametrize("limit", ["battery", "capacity", "window", "nobody may", "no way"])
    def test_what_nobody_can_visit_is_left_out_and_told(self, limit):
        vehicles, work = on_a_plain(15, 2)
        vehicle, far = vehicles[0], 3
        changes = {
            "battery": {
                "joules": vehicle.seconds,
                "usable": 300.0,
                "visit_joules": np.where(np.arange(15) == far, 301.0, 0),
            },
            "capacity": {"capacity": 20.0},
            "window": {},
            "nobody may": {"allowed": np.arange(15) != far},
            "no way": {"price": np.where(np.arange(17) == far, np.inf, vehicle.price)},
        }
        if limit == "capacity":
            work = dataclasses.replace(work, demand=np.where(np.arange(15) == far, 21.0, 1.0))
        if limit == "window":
            closes = np.where(np.arange(15) == far, vehicle.seconds[15, far] * 0.9, np.inf)
            work = dataclasses.replace(work, window=np.stack([np.zeros(15), closes], axis=1))
        routes = route([dataclasses.replace(vehicle, **changes[limit])] * 2, work)
        assert routes.unvisited == {far: limit}

    def test_a_given_order_is_kept(self):
        vehicles, work = on_a_plain(14, 2)
        order = [int(j) for j in np.random.default_rng(2).permutation(14)]
        routes = route(vehicles, work, search=RouteSearch(order=order))
        assert routes.unvisited == {}
        for tour in routes.tours:
            ranks = [order.index(j) for sortie in tour for j in sortie]
            assert ranks == sorted(ranks)

    def test_two_keep_a_given_order_on_several_batteries(self):
        vehicles, work = on_a_plain(24, 2, usable=400.0, most_sorties=6)
        vehicles = [dataclasses.replace(vehicles[0], joules=vehicles[0].seconds)] * 2
        order = [int(j) for j in np.random.default_rng(2).permutation(24)]
        routes = route(vehicles, work, search=RouteSearch(order=order))
        assert routes.unvisited == {}
        for tour in routes.tours:
            ranks = [order.index(j) for sortie in tour for j in sortie]
            assert ranks == sorted(ranks)

    def test_a_battery_that_reaches_nothing_leaves_everything_out(self):
        vehicles, work = on_a_plain(12, 1, usable=0.0, visit_joules=np.ones(12), most_sorties=2)
        assert set(route(vehicles, work).unvisited.values()) == {"battery"}

    def test_a_cancelled_search_gives_the_best_so_far_and_says_so(self):
        vehicles, work = on_a_plain(60, 3)
        event = threading.Event()
        event.set()
        routes = route(vehicles, work, search=RouteSearch(stop=Cancelled(event)))
        assert routes.interrupted
        assert routes.unvisited == {}


def value(routes, criterion):
    last = (routes.finish, routes.price) if criterion == "min-max" else (routes.price,)
    return (len(routes.unvisited), routes.swaps, *last)
