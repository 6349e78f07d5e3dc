"""Tours beside truth: ``python benchmarks/tours.py brute-force [RUNS]``, or ``... published FOLDER``.

``brute-force`` compares one UAV's tour of nine targets with the best of all orders, on random maps with asymmetric
prices. ``published`` routes the instances of a folder through our interface, beside PyVRP alone, which is given as much
time. The folder holds pairs such as A-n32-k5.vrp and A-n32-k5.sol (CVRPLIB's, distances rounded) or C101.txt and
C101.sol (Solomon's, tenths truncated), as the tests of https://github.com/PyVRP/VRPLIB have them in tests/data/cvrplib.
"""

import itertools
import math
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from machine import describe, table

from skyverse.mission.route import route
from skyverse.mission.routing import RouteSearch, TourVehicle, Work

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
    elif part == "published" and more:
        published(Path(more[0]))
    else:
        sys.exit(__doc__)
