import dataclasses
import importlib.util
import itertools
import math
import threading
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from routing_oracle import cuts, flown, random_case
from skyverse.errors import InputError
from skyverse.mission import strip_routing
from skyverse.mission.routing import RouteSearch, TourVehicle, Work
from skyverse.mission.strip_routing import route_strips
from skyverse.stop import Cancelled
from skyverse.survey.leg_time import LegTime

specification = importlib.util.spec_from_file_location(
    "strip_bounds", Path(__file__).parents[2] / "benchmarks" / "strip_bounds.py"
)
strip_bounds = importlib.util.module_from_spec(specification)
specification.loader.exec_module(strip_bounds)


def best(vehicles, work, strips, criterion) -> tuple[float, ...]:
    """Return how many strips stay unflown, the swaps, and the value of the best routes; every way is looked at."""
    ways = [[(a,)] if a == b else [(a, b), (b, a)] for a, b in strips]
    tables = []
    for vehicle in vehicles:
        table = {(): [(0, 0.0, 0.0)]}
        for size in range(1, len(strips) + 1):
            for held in itertools.combinations(range(len(strips)), size):
                found = []
                for order in itertools.permutations(held):
                    for cut in cuts(order):
                        if len(cut) > vehicle.most_sorties:
                            continue
                        for sides in itertools.product(*(ways[k] for k in order)):
                            way = dict(zip(order, sides, strict=True))
                            tour = [[place for k in sortie for place in way[k]] for sortie in cut]
                            may = all(vehicle.allowed[place] for sortie in tour for place in sortie)
                            if may and (one := flown(vehicle, work, tour)):
                                found.append((len(cut) - 1, one[2][-1], one[0]))
                if found:
                    table[held] = found
        tables.append(table)
    answer = (math.inf,)
    for chosen in itertools.product(*tables):
        held = [k for part in chosen for k in part]
        if len(set(held)) < len(held):
            continue
        for parts in itertools.product(*(table[part] for table, part in zip(tables, chosen, strict=True))):
            finish, price = max(p[1] for p in parts), sum(p[2] for p in parts)
            value = (finish, price) if criterion == "min-max" else (price,)
            answer = min(answer, (len(strips) - len(held), sum(p[0] for p in parts), *value))
    return answer


def random_strips(rng, fleet: int):
    """Return vehicles, work and strips among random places, some of which are targets, or are not visited."""
    n = int(rng.integers(1, 9))
    vehicles, work = random_case(rng, n, fleet, alike=rng.random() < 0.3)
    places, strips = rng.permutation(n).tolist(), []
    while places and len(strips) < 4:
        a = places.pop()
        strips.append((a, places.pop() if places and rng.random() < 0.7 else a))
    window = work.window.copy()
    window[[place for a, b in strips if a != b for place in (a, b)]] = 0.0, math.inf
    return vehicles, dataclasses.replace(work, window=window), strips


def require_sound(vehicles, work, strips, routes) -> None:
    """Every strip is flown once, along it, or told as unvisited; times and price are those of the legs."""
    pairs = {(a,) if a == b else (a, b) for a, b in strips} | {(b, a) for a, b in strips if a != b}
    seen, price = [], 0.0
    for vehicle, tour, starts, finishes in zip(vehicles, routes.tours, routes.starts, routes.finishes, strict=True):
        for sortie in tour:
            rest = list(sortie)
            while rest:
                size = 1 if (rest[0],) in pairs else 2
                assert tuple(rest[:size]) in pairs
                seen += rest[:size]
                rest = rest[size:]
        if tour:
            own, departures, landings = flown(vehicle, work, tour)
            price += own
            assert starts == pytest.approx(departures)
            assert finishes == pytest.approx(landings)
    assert len(set(seen)) == len(seen)
    assert sorted([*seen, *routes.unvisited]) == sorted({place for pair in strips for place in pair})
    assert routes.price == pytest.approx(price)


def best_of(found, exact, criterion) -> float:
    """Return what no bound of the strips that were found goes above, if the best routes fly the same ones."""
    value = exact.finish if criterion == "min-max" else exact.price
    return value * (1 + 1e-9) if found.unvisited == exact.unvisited else math.inf


def worth(routes, strips, criterion) -> tuple[float, ...]:
    left = sum(a in routes.unvisited for a, _ in strips)
    return (left, routes.swaps, *((routes.finish, routes.price) if criterion == "min-max" else (routes.price,)))


@settings(deadline=None, max_examples=60)
@given(seed=st.integers(0, 10**6), fleet=st.integers(1, 2), criterion=st.sampled_from(["min-sum", "min-max"]))
def test_no_other_routes_are_better(seed, fleet, criterion):
    vehicles, work, strips = random_strips(np.random.default_rng(seed), fleet)
    routes = route_strips(vehicles, strips, work, criterion)
    require_sound(vehicles, work, strips, routes)
    assert worth(routes, strips, criterion) == pytest.approx(best(vehicles, work, strips, criterion))
    assert routes.optimal
    assert routes.lower_bound == (routes.finish if criterion == "min-max" else routes.price)


@settings(deadline=None, max_examples=150)
@given(seed=st.integers(0, 10**6), fleet=st.integers(1, 3), criterion=st.sampled_from(["min-sum", "min-max"]))
def test_a_search_is_sound_and_no_better_than_what_is_best(seed, fleet, criterion):
    vehicles, work, strips = random_strips(np.random.default_rng(seed), fleet)
    exact = route_strips(vehicles, strips, work, criterion)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(strip_routing, "MOST_EXACT", 0)
        found = route_strips(vehicles, strips, work, criterion, RouteSearch(quick=True))
    require_sound(vehicles, work, strips, found)
    value, truth = worth(found, strips, criterion), worth(exact, strips, criterion)
    assert value >= truth or value == pytest.approx(truth)
    assert strip_bounds.routes_bound(vehicles, strips, work, found, criterion) <= best_of(found, exact, criterion)


def field(strips: int, fleet: int = 1, seed: int = 0, **given_values):
    """Return UAVs at a corner of a field of strips 3 m apart that fly at 1 m/s and stop at each end for a second."""
    rng, n = np.random.default_rng(seed), 2 * strips
    places = np.zeros((n + 2, 2))
    places[:n:2] = np.stack([rng.random(strips) * 30, rng.permutation(strips) * 3.0], axis=1)
    places[1:n:2] = places[:n:2] + np.stack([40 + rng.random(strips) * 30, np.zeros(strips)], axis=1)
    metres = np.linalg.norm(places[:, None] - places[None], axis=2)
    seconds = metres + (metres > 0)
    values = {
        "price": seconds, "seconds": seconds, "joules": seconds, "visit_joules": np.zeros(n), "usable": math.inf,
        "most_sorties": 1, "swap": 0.0, "capacity": math.inf, "allowed": np.ones(n, dtype=bool), "returns": True,
    } | given_values  # fmt: skip
    work = Work(np.zeros(n), np.tile((0.0, math.inf), (n, 1)), np.zeros(n))
    return [TourVehicle(**values)] * fleet, np.arange(n).reshape(-1, 2), work


def test_a_field_is_mown_in_few_sorties_near_the_bound():
    vehicles, strips, work = field(30)
    routes = route_strips(vehicles, strips, work)
    require_sound(vehicles, work, strips.tolist(), routes)
    bound = strip_bounds.routes_bound(vehicles, strips, work, routes)
    assert bound <= routes.price <= 1.03 * bound
    usable = routes.price / 2 + 100.0
    vehicles, strips, work = field(30, usable=usable, most_sorties=9, swap=60.0)
    cut = route_strips(vehicles, strips, work)
    require_sound(vehicles, work, strips.tolist(), cut)
    assert (cut.swaps, cut.unvisited) == (1, {})
    assert cut.price <= 1.1 * routes.price


def test_three_share_a_field_evenly():
    vehicles, strips, work = field(30, fleet=3)
    routes = route_strips(vehicles, strips, work, "min-max")
    require_sound(vehicles, work, strips.tolist(), routes)
    ends = [finishes[-1] for finishes in routes.finishes]
    assert min(ends) > 0.9 * max(ends)
    bound = strip_bounds.routes_bound(vehicles, strips, work, routes, "min-max")
    assert bound <= routes.finish <= 1.12 * bound


def test_a_seed_gives_the_same_routes_again_and_another_may_give_others():
    vehicles, strips, work = field(20, usable=900.0, most_sorties=4)
    one, same, other = (route_strips(vehicles, strips, work, search=RouteSearch(seed=k, quick=True)) for k in (1, 1, 2))
    assert (one.tours, one.price) == (same.tours, same.price)
    assert other.price == pytest.approx(one.price, rel=0.05)


def test_one_way_strips_are_flown_one_way():
    vehicles, strips, work = field(12)
    price = vehicles[0].price.copy()
    price[strips[:, 1], strips[:, 0]] = math.inf
    vehicle = dataclasses.replace(vehicles[0], price=price)
    routes = route_strips([vehicle], strips, work)
    (sortie,) = routes.tours[0]
    assert sorted(zip(sortie[::2], sortie[1::2], strict=True)) == [tuple(pair) for pair in strips.tolist()]
    assert routes.price > route_strips(vehicles, strips, work).price


@pytest.mark.parametrize("strips", [3, 12])
def test_a_strip_that_exceeds_a_battery_is_told(strips):
    vehicles, pairs, work = field(strips, most_sorties=strips, usable=60.0 + 36.0 * 2)
    joules = vehicles[0].joules.copy()
    a, b = pairs[0]
    joules[a, b] = joules[b, a] = 1000.0
    routes = route_strips([dataclasses.replace(vehicles[0], joules=joules)], pairs, work)
    assert routes.unvisited[a] == routes.unvisited[b] == "battery"


def test_a_cancelled_search_returns_what_it_has():
    vehicles, strips, work = field(40)
    event = threading.Event()
    event.set()
    routes = route_strips(vehicles, strips, work, search=RouteSearch(stop=Cancelled(event)))
    require_sound(vehicles, work, strips.tolist(), routes)
    assert routes.interrupted
    assert not routes.unvisited


def test_an_order_that_is_given_is_refused():
    vehicles, _, work = field(2)
    with pytest.raises(InputError, match="free order"):
        route_strips(vehicles, [(0, 1)], work, search=RouteSearch(order=[0]))


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_no_order_of_strips_is_below_the_bound(seed, count):
    rng = np.random.default_rng(seed)
    places = rng.random((2 * count + 2, 2))
    costs = np.hypot(*np.moveaxis(places[None] - places[:, None], -1, 0)) * rng.uniform(1, 1.2, (2 * count + 2,) * 2)
    strips = np.arange(2 * count).reshape(-1, 2)
    best = np.inf
    for order in itertools.permutations(range(count)):
        for flipped in itertools.product((0, 1), repeat=count):
            at, total = 2 * count, 0.0
            for strip, back in zip(order, flipped, strict=True):
                total += costs[at, 2 * strip + back] + costs[2 * strip + back, 2 * strip + 1 - back]
                at = 2 * strip + 1 - back
            best = min(best, total + costs[at, 2 * count + 1])
    bound = strip_bounds.these_strips_bound(costs, strips, 2 * count, 2 * count + 1)
    assert bound <= best + 1e-9
    assert bound > 0.5 * best


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(0.1, 50.0), min_size=1, max_size=8))
def test_no_strips_of_a_length_in_all_are_faster_than_the_bound(lengths):
    cost, legs = LegTime(3.0, 1.0), np.array([[length, 0.0] for length in lengths])
    bound = strip_bounds.any_strips_bound(sum(lengths), 50.0, cost)
    assert bound <= cost(legs).sum() + 1e-9
    assert strip_bounds.any_strips_bound(100.0, 50.0, cost) == pytest.approx(2 * (50 / 3 + 3))


@pytest.mark.parametrize(("usable", "flown_places"), [(100.0, {0, 1, 2, 3}), (25.0, {0, 1}), (1.0, set())])
def test_a_search_that_errs_leaves_strips_out_and_breaks_no_battery(monkeypatch, usable, flown_places):
    places = np.array([(0.0, 5.0), (5.0, 5.0), (5.0, 25.0), (0.0, 25.0), (0.0, 0.0), (0.0, 0.0)])
    metres = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    vehicle = TourVehicle(metres, metres, metres, np.zeros(4), usable, 1, 0.0, math.inf, np.ones(4, dtype=bool), True)
    work = Work(np.zeros(4), np.tile((0.0, math.inf), (4, 1)), np.zeros(4))
    monkeypatch.setattr(strip_routing, "exact_tours", lambda *given, **more: [((0, 1),)])
    routes = route_strips([vehicle], [(0, 1), (2, 3)], work)
    assert {place for sortie in routes.tours[0] for place in sortie} == flown_places
    assert set(routes.unvisited) == {0, 1, 2, 3} - flown_places
    assert routes.optimal == (len(flown_places) == 4)
