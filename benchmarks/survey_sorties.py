"""AC maps flown in sorties of 1,200 s: how many there are, and their sum beside one route and a proven bound.

A part of ``python benchmarks/survey.py sorties FOLDER COSTS [EVERY]``: strips of our sweep, from the start of Agarwal
and Akella, of every so manieth map. The sum is that of flights; batteries are swapped at once.
"""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from machine import table
from strip_bounds import routes_bound
from survey_ac import COST, Map, maps, planned

from skyverse.mission.routing import TourVehicle, Work
from skyverse.mission.strip_routing import route_strips
from skyverse.survey.visibility import way_prices

SORTIE = 1200.0
MOST_SUM = 1.003


def routing(one: Map) -> tuple[TourVehicle, np.ndarray, Work, float]:
    """Return a vehicle without limits, the ends of the sweep's strips, the work, and the seconds of the sweep's route.

    Seconds are the prices, and the joules.
    """
    route, _ = planned(one, one.start)
    places = np.concatenate([route.strips.reshape(-1, 2), one.start[None], one.start[None]])
    seconds = way_prices(one.area, places, COST)
    n = len(places) - 2
    vehicle = TourVehicle(
        price=seconds,
        seconds=seconds,
        joules=seconds,
        visit_joules=np.zeros(n),
        usable=np.inf,
        most_sorties=1,
        swap=0.0,
        capacity=np.inf,
        allowed=np.ones(n, dtype=bool),
        returns=True,
    )
    work = Work(np.zeros(n), np.tile((0.0, np.inf), (n, 1)), np.zeros(n))
    return vehicle, np.arange(n).reshape(-1, 2), work, route.cost


def sorties(folder: Path, costs: Path, every: int = 1) -> None:
    """Print sorties of 1,200 s beside one route."""
    if not folder.exists():
        print(f"skipped: no maps in {folder}")
        return
    found, rows = [], []
    for one in maps(folder, costs)[::every]:
        vehicle, strips, work, single = routing(one)
        begun = time.perf_counter()
        flown = [replace(vehicle, usable=SORTIE, most_sorties=9)]
        routes = route_strips(flown, strips, work)
        seconds = time.perf_counter() - begun
        alone = route_strips([vehicle], strips, work).price
        assert not routes.unvisited
        one_route = min(single, alone)
        found.append(
            (
                one.holes,
                routes.swaps + 1,
                routes.price / one_route,
                routes_bound(flown, strips, work, routes) / one_route,
                seconds,
                alone / single,
            )
        )
        print(one.name, len(strips), *(f"{value:.5g}" for value in found[-1][1:]), flush=True)
    numbers = np.array(found)
    for holes in sorted(set(numbers[:, 0])):
        part = numbers[numbers[:, 0] == holes]
        two, sums = (part[:, 1] == 2).sum(), part[:, 2]
        within = f"{(sums <= MOST_SUM).sum()} of {len(part)}"
        rows.append(
            [
                *(f"{holes:.0f}", f"{two} of {len(part)}", f"{np.median(sums):.4f}", f"{sums.max():.4f}", within),
                *(f"{np.median(part[:, 3]):.4f}", f"{part[:, 4].mean():.2f}"),
            ]
        )
    table(["holes", "two sorties", "sum / one route", "most", f"<= {MOST_SUM}", "bound", "s"], rows)
    sums = numbers[:, 2]
    print(
        f"all {len(numbers)}: two sorties on {(numbers[:, 1] == 2).sum()}, sum / one route {np.median(sums):.4f} in the"
    )
    print(f"median, {sums.max():.4f} at most, {(sums <= MOST_SUM).sum()} within {MOST_SUM}")
