"""Tours beside truth: ``python benchmarks/tours.py brute-force|maps|city|windy|published``, some with a number.

- ``brute-force [RUNS]``: one UAV's tour of nine targets beside the best of all orders, with asymmetric random prices.
- ``maps [ROOMS]``: the same with the true costs of all pairs by A*, on the thesis's maps and in random rooms.
- ``city``: fleets on Map 3 and in a city of 2,000 buildings: seconds, and gaps to the lower bound of an assignment.
- ``windy [RUNS]``: random missions with wind, gusts and batteries; each sortie is flown anew at steps of 10 ms by the
  same power, in random gusts at the rim of the margin.
- ``published FOLDER``: instances through our interface, beside PyVRP alone, which is given as much time. The folder
  holds pairs such as A-n32-k5.vrp and A-n32-k5.sol (CVRPLIB's, distances rounded) or C101.txt and C101.sol (Solomon's,
  tenths truncated), as the tests of https://github.com/PyVRP/VRPLIB have them in tests/data/cvrplib.
"""

import itertools
import math
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse.mission.assignment import lattice_prices
from skyverse.mission.leg_planning import LegPlanning
from skyverse.mission.route import lower_bound, route
from skyverse.mission.routing import RouteSearch, TourVehicle, Work
from skyverse.mission.tour_legs import TourLegs
from skyverse.problem import snap_endpoint
from skyverse.samples.city import random_city
from skyverse.space.world import point_free

TARGETS = 9


def brute_force(runs: int) -> None:
    orders = np.array(list(itertools.permutations(range(TARGETS))))
    equal, seconds = 0, []
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        places = rng.random((TARGETS + 1, 2))[[*range(TARGETS + 1), TARGETS]]
        price = np.linalg.norm(places[:, None] - places[None], axis=2) * rng.uniform(1, 1.5, (TARGETS + 2,) * 2)
        begun = time.perf_counter()
        routes = route([uav(price, price, returns=bool(seed % 2))], work(TARGETS))
        seconds.append(time.perf_counter() - begun)
        sums = price[TARGETS, orders[:, 0]] + price[orders[:, :-1], orders[:, 1:]].sum(axis=1)
        if seed % 2:
            sums = sums + price[orders[:, -1], TARGETS + 1]
        equal += math.isclose(routes.price, sums.min(), rel_tol=1e-12)
    print(f"{equal} of {runs} tours of {TARGETS} targets equal the best of all orders; ", end="")
    print(f"each took {np.median(seconds) * 1e3:.0f} ms, at most {max(seconds) * 1e3:.0f} ms")


class Instance(NamedTuple):
    """A published instance in whole numbers; row 0 is the depot."""

    distance: np.ndarray
    demand: np.ndarray
    capacity: int
    stay: np.ndarray
    window: np.ndarray | None
    vehicles: int


def read(path: Path) -> Instance:
    import vrplib

    if path.suffix == ".vrp":
        found = vrplib.read_instance(path)
        n = len(found["demand"])
        distance = np.rint(found["edge_weight"]).astype(int)
        return Instance(distance, found["demand"], int(found["capacity"]), np.zeros(n, int), None, n)
    found = vrplib.read_instance(path, instance_format="solomon")
    distance = np.floor(found["edge_weight"] * 10 + 1e-9).astype(int)
    stay, window = found["service_time"] * 10, found["time_window"] * 10
    return Instance(distance, found["demand"], int(found["capacity"]), stay, window, int(found["vehicles"]))


def alone(instance: Instance, seconds: float) -> float:
    """Return the cost that PyVRP finds without us."""
    import pyvrp
    from pyvrp.stop import MaxRuntime

    window = instance.window
    clients = [
        pyvrp.Client(
            j,
            [int(instance.demand[j])],
            service_duration=int(instance.stay[j]),
            **({} if window is None else {"tw_early": int(window[j, 0]), "tw_late": int(window[j, 1])}),
        )
        for j in range(1, len(instance.demand))
    ]
    late = {} if window is None else {"tw_late": int(window[0, 1])}
    fleet = [pyvrp.VehicleType(instance.vehicles, [instance.capacity], **late)]
    depot = pyvrp.Depot(0)
    matrices = [instance.distance], [instance.distance]
    data = pyvrp.ProblemData([pyvrp.Location(0, 0)] * len(instance.demand), clients, [depot], fleet, *matrices)
    return float(pyvrp.solve(data, MaxRuntime(seconds), seed=1, collect_stats=False).cost())


def ours(instance: Instance) -> float:
    """Return the price that our interface finds, or infinity if it leaves out a target."""
    rows = [*range(1, len(instance.demand)), 0, 0]
    price = instance.distance[np.ix_(rows, rows)].astype(float)
    n = len(rows) - 2
    window = None if instance.window is None else instance.window[1:].astype(float)
    if instance.window is not None:  # who visits a target is home by the time that the depot closes
        window[:, 1] = np.minimum(window[:, 1], instance.window[0, 1] - instance.stay[1:] - price[:n, n])
    vehicle = uav(price, price, capacity=float(instance.capacity))
    routes = route(
        [vehicle] * instance.vehicles,
        work(n, instance.stay[1:], window, instance.demand[1:]),
        search=RouteSearch(seed=1),
    )
    return math.inf if routes.unvisited else routes.price


def published(folder: Path) -> None:
    import vrplib

    rows = []
    for path in sorted(folder.iterdir()):
        if path.suffix not in (".vrp", ".txt"):
            continue
        instance = read(path)
        best = float(vrplib.read_solution(path.with_suffix(".sol"))["cost"]) * (1 if path.suffix == ".vrp" else 10)
        begun = time.perf_counter()
        price = ours(instance)
        seconds = time.perf_counter() - begun
        peer = alone(instance, seconds)
        rows.append(
            [path.stem, f"{best:g}", *(f"{x:g} ({x / best - 1:+.2%})" for x in (price, peer)), f"{seconds:.1f}"]
        )
    table(["instance", "best known", "ours", "PyVRP alone", "s each"], rows)


def free_places(scenario: sky.Scenario, count: int, rng: np.random.Generator) -> list[tuple[float, float, float]]:
    """Return random places that A* can reach, metres."""
    airspace, low, high = sky.Airspace(scenario), np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    found: list[tuple[float, float, float]] = []
    while len(found) < count:
        place = np.round(low + (high - low) * rng.uniform(0.03, 0.97, 3), 2)
        if point_free(airspace.world.space, place) and snap_endpoint(airspace, place, start=True)[1] is None:
            found.append(tuple(place.tolist()))
    return found


def with_tours(scenario: sky.Scenario, uavs: int, targets: int, rng: np.random.Generator, **fields) -> sky.Scenario:
    """Return a scenario with other UAVs, which return, and other targets, at random places."""
    places = free_places(scenario, uavs + targets, rng)
    given = scenario.model_dump(exclude_defaults=True)
    given["uavs"] = [given["uavs"][0] | {"name": "", "start": place, "end": "home"} | fields for place in places[:uavs]]
    return sky.Scenario.model_validate(given | {"targets": [{"position": place} for place in places[uavs:]]})


def maps(rooms: int) -> None:
    rows, orders = [], np.array(list(itertools.permutations(range(TARGETS))))
    cases = [(name, sky.read(name)) for name in ("map1", "map2", "map3")] * 5
    cases += [("room", sky.random_room(seed=seed)) for seed in range(rooms)]
    equal: dict[str, list[bool]] = {}
    for seed, (name, base) in enumerate(cases):
        scenario = with_tours(base, 1, TARGETS, np.random.default_rng(seed))
        mission = sky.plan_mission(scenario, sky.AStar(), rng=1)
        places = [scenario.uavs[0].start, *(target.position for target in scenario.targets)]
        price = lattice_prices(sky.Airspace(scenario), 0, places, places)
        sums = (
            price[0, 1 + orders[:, 0]]
            + price[1 + orders[:, :-1], 1 + orders[:, 1:]].sum(axis=1)
            + price[1 + orders[:, -1], 0]
        )
        shared = TARGETS if scenario.objective.unit == "nodes" else 0  # a node that two legs share is counted once
        best = float(sums.min()) - shared
        if not math.isfinite(best):
            continue  # a target is shut in
        sound = mission.violations == () and mission.complete
        equal.setdefault(name, []).append(sound and math.isclose(mission.cost, best, rel_tol=1e-9))
    rows = [[name, str(len(found)), str(sum(found))] for name, found in equal.items()]
    table(["scenario", f"tours of {TARGETS} targets", "equal to the best of all orders by true costs"], rows)


def city() -> None:
    rows = []
    block = random_city(2000)
    for name, base, fleet, targets in (
        ("Map 3", sky.read("map3"), 5, 50),
        ("city", block, 5, 50),
        ("city", block, 20, 200),
    ):
        scenario = with_tours(base, fleet, targets, np.random.default_rng(1))
        sky.plan_mission(with_tours(base, 2, 3, np.random.default_rng(2)), rng=1)  # compiles what it needs
        for criterion in ("min-sum", "min-max"):
            options = sky.MissionOptions(criterion=criterion)
            begun = time.perf_counter()
            mission = sky.plan_mission(scenario, options=options, rng=1)
            seconds = time.perf_counter() - begun
            bound = lower_bound(*numbers(scenario), range(targets), criterion)
            value = mission.cost if criterion == "min-sum" else mission.makespan
            found = "nothing" if not mission.violations and mission.complete else "!"
            rows.append(
                [
                    name,
                    f"{fleet}, {targets}",
                    criterion,
                    f"{seconds:.1f}",
                    f"{value:.0f}",
                    f"{value / bound - 1:.0%}",
                    found,
                ]
            )
    table(
        ["scenario", "UAVs, targets", "criterion", "s", "cost, or s", "above the assignment bound", "found wrong"], rows
    )
    begun = time.perf_counter()
    numbers(with_tours(block, 1, 50, np.random.default_rng(1)))
    print(f"rough prices of 51 x 51 pairs in the city, airspace included: {time.perf_counter() - begun:.2f} s")


def numbers(scenario: sky.Scenario) -> tuple[list[TourVehicle], Work]:
    """Return the numbers of a scenario as routing has them, by straight lines, or on the lattice."""
    how = LegPlanning(planner=sky.Auto().choose(scenario), stop=None, seed=0, shape="minimum-time", workers=2)
    stay = np.zeros(len(scenario.targets))
    return TourLegs(sky.Airspace(scenario), how, timed=False).vehicles(stay, None), work(len(stay))


AIR = sky.Scenario.model_validate(
    {"name": "air", "bounds": {"min": (0, 0, 0), "max": (800, 800, 80)}, "clearance": 1.0}
    | {"uavs": [{"start": (1, 1, 1)}], "lattice": {"step": (20, 20, 20)}, "objective": {"unit": "metres"}}
)


def windy(runs: int) -> None:
    refuted, broken, sorties, least = 0, 0, 0, math.inf
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        fields = {
            "vehicle": "camera",
            "battery": float(rng.uniform(4, 12)),
            "tracking_error": {"horizontal": 0, "vertical": 0},
        }
        given = with_tours(AIR, int(rng.integers(1, 3)), int(rng.integers(2, 7)), rng, **fields).model_dump()
        gust = float(rng.choice([0.0, 1.0, 2.0]))
        given["wind"] = {"speed": float(rng.uniform(0, 9)), "from": float(rng.uniform(0, 360)), "gust": gust}
        mission = sky.plan_mission(sky.Scenario.model_validate(given), sky.Taut(), rng=1)
        refuted += bool(mission.violations)
        for number, own in enumerate(mission.sorties):
            for sortie in own if not mission.violations else ():
                sorties += 1
                spent = flown_joules(mission, number, sortie, rng)
                left = mission.scenario.uavs[number].usable_energy - spent
                broken += left < 0
                least = min(least, left / mission.scenario.uavs[number].usable_energy)
    print(f"{runs} windy missions: {refuted} refuted; of {sorties} proven sorties {broken} broke the reserve as flown,")
    print(f"and at least {least:.1%} of what is usable was left")


def flown_joules(mission: sky.Mission, number: int, sortie: sky.Sortie, rng: np.random.Generator) -> float:
    """Return what a sortie takes in random gusts at the rim of the margin, changing every 10 ms, J."""
    vehicle, wind = mission.scenario.uavs[number], mission.scenario.wind
    times = np.arange(sortie.begin, sortie.end, 0.01)
    motion = mission.trajectories[number].at(times)
    gusts = rng.normal(size=(len(times), 3))
    gusts *= wind.gust / np.linalg.norm(gusts, axis=1)[:, None]
    through = motion.velocity - wind.at(motion.position[:, 2]) - gusts
    load = np.linalg.norm(motion.acceleration + np.array([0.0, 0.0, 9.81]), axis=1) / 9.81
    watts = vehicle.power_model.at(np.linalg.norm(through[:, :2], axis=1), through[:, 2], load)
    return float(watts.sum() * 0.01)


def uav(price: np.ndarray, seconds: np.ndarray, *, capacity: float = math.inf, returns: bool = True) -> TourVehicle:
    n = len(price) - 2
    return TourVehicle(
        price=price,
        seconds=seconds,
        joules=np.zeros_like(price),
        visit_joules=np.zeros(n),
        usable=math.inf,
        most_sorties=1,
        swap=0.0,
        capacity=capacity,
        allowed=np.ones(n, dtype=bool),
        returns=returns,
    )


def work(n: int, stay=None, window=None, demand=None) -> Work:
    return Work(
        np.zeros(n) if stay is None else stay.astype(float),
        np.tile((0.0, math.inf), (n, 1)) if window is None else window,
        np.zeros(n) if demand is None else demand.astype(float),
    )


if __name__ == "__main__":
    print(describe("pyvrp"), end="\n\n")
    part, *more = sys.argv[1:] or ["brute-force"]
    if part == "brute-force":
        brute_force(int(more[0]) if more else 100)
    elif part == "maps":
        maps(int(more[0]) if more else 100)
    elif part == "city":
        city()
    elif part == "windy":
        windy(int(more[0]) if more else 500)
    elif part == "published" and more:
        published(Path(more[0]))
    else:
        sys.exit(__doc__)
