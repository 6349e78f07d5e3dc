"""Whether missions with a planted fault are mended: proven, otherwise as they were, and hardly longer than must be.

``python benchmarks/repairs.py 300`` makes missions with one planted fault each, as planted_faults.py does, has them
mended and written, and judges what was written. It prints by kind of fault how many are proven then, in how many an
item that nobody had to change is another, and how long the flights are beside shortest ways between the same places;
and how many return along their mission then, where no height clears a straight way home.
"""

import argparse
import json
import math
import statistics
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse.numerics.cores import cores

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "support"))
from planted_missions import FAULTS
from planting import harmed, options_and_settings

JUMP = 177
"""MAV_CMD_DO_JUMP."""


class Outcome(NamedTuple):
    """One case: its fault, what is wrong after the repair, missions that retrace, items lost, length, seconds."""

    kind: str
    seed: int
    wrong: list[str]
    retraces: int
    lost: int
    longer: float
    seconds: float


def outcome(seed: int) -> Outcome:
    """Make, mend and judge one case."""
    fault = FAULTS[seed % len(FAULTS)]
    case = harmed(np.random.default_rng([seed, 1]), fault)
    with tempfile.TemporaryDirectory() as folder:
        files = [one.write(case.world, Path(folder), f"m{k}") for k, one in enumerate(case.flights, 1)]
        where, settings = options_and_settings(case, Path(folder))
        begin = time.perf_counter()
        mended = sky.repair_waypoints([sky.read_waypoints(file) for file in files], where, settings)
        seconds = time.perf_counter() - begin
        written = [file.with_name(f"fixed-{file.name}") for file in files]
        for one, file in zip(mended.missions, written, strict=True):
            sky.write_waypoints(one, file)
        told = {item for changes in mended.changes for change in changes for item in change.items}
        lost = sum(lost_items(old, new, told) for old, new in zip(files, written, strict=True))
        again = [sky.read_waypoints(file) for file in written]
        returns = [  # which stand in files of parameters
            replace(one, return_altitude=new.return_altitude, retraces=new.retraces)
            for one, new in zip(again, mended.missions, strict=True)
        ]
        fleet = sky.check_waypoints(returns, where, sky.FlightSettings(autopilot=settings.autopilot))
    wrong = [
        f"{one.subject.value} {one.items} {one.what}"
        for mission in fleet.missions
        for one in mission.findings
        if one.wrong
    ]
    longer = max(
        ratio(mission.flown, {j for j, order in enumerate(one.orders) if order.item is None}, mission.scenario, k)
        for k, (mission, one) in enumerate(zip(mended.checked.missions, mended.missions, strict=True))
    )
    retraces = sum(one.retraces for one in mended.missions)
    return Outcome(fault, seed, wrong, retraces, lost, longer, seconds)


def lost_items(old: Path, new: Path, told: set[int]) -> int:
    """Return how many items of a file are not in another one, of those of which no change was told."""
    before, after = ([_without_number(item) for item in items(file)] for file in (old, new))
    return sum(item not in after for number, item in enumerate(before, 1) if number not in told)


def items(file: Path) -> list[Any]:
    """Return the items of a ``.plan`` or ``.waypoints`` file as they are written."""
    if file.suffix == ".plan":
        found: list[Any] = json.loads(file.read_text())["mission"]["items"]
        return found
    return [line.split("\t") for line in file.read_text().splitlines()[2:]]


def _without_number(item: Any) -> Any:
    """Return an item without its number, and a jump without that of its target, as these move where items are added."""
    if isinstance(item, dict):
        jump = item["command"] == JUMP
        return {k: v[1:] if jump and k == "params" else v for k, v in item.items() if k != "doJumpId"}
    return item[1:4] + item[5 if item[3] == str(JUMP) else 4 :]


def added_to(mission: sky.Waypoints) -> set[int]:
    """Return which orders of a mended mission were added."""
    return {k for k, order in enumerate(mission.orders) if order.item is None}


def ratio(flown: Any, added: set[int], scenario: sky.Scenario, uav: int) -> float:
    """Return how long a flight with orders that were added is beside the shortest ways between all others."""
    visits, place = flown.visits, {id(order): j for j, order in enumerate(flown.waypoints.orders)}
    kept = [k for k, visit in enumerate(visits) if place[id(visit.order)] not in added]
    if len(kept) == len(visits):
        return 1.0
    flown = shortest = 0.0
    for first, last in pairwise(kept):
        own = sum(math.dist(visits[k].at, visits[k + 1].at) for k in range(first, last))
        flown += own
        shortest += own if last == first + 1 else _shortest(visits[first].at, visits[last].at, scenario, uav) or own
    return flown / shortest


def _shortest(a: Any, b: Any, scenario: sky.Scenario, uav: int) -> float | None:
    vehicle = scenario.uavs[uav].model_copy(update={"start": tuple(a.tolist()), "home": None})
    end = sky.Target(name="end", position=tuple(b.tolist()))
    steps = np.maximum((np.array(scenario.bounds.max) - scenario.bounds.min) / 60, 2.0)
    lattice = scenario.lattice.model_copy(update={"step": tuple(steps.tolist())})
    given = {"uavs": (vehicle,), "targets": (end,), "lattice": lattice}
    result = sky.Auto().plan(sky.Problem(scenario.model_copy(update=given)))
    return sum(math.dist(*leg) for leg in pairwise(result.path)) if result.status.reached else None


def main() -> int:
    """Mend the missions and print what became of them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("count", type=int, nargs="?", default=30, help="missions with a fault")
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--processes", type=int, default=cores(), help="processes side by side; all cores by default")
    options = parser.parse_args()
    print(describe(), flush=True)
    made: list[Outcome] = []
    with ProcessPoolExecutor(options.processes, get_context("spawn")) as pool:
        for one in pool.map(outcome, range(options.seed, options.seed + options.count)):
            made.append(one)
            for said in one.wrong[:2]:
                print(f"seed {one.seed}, fault {one.kind}: not mended: {said}", flush=True)
            if one.lost or one.longer > 1.02:
                print(f"seed {one.seed}, fault {one.kind}: {one.lost} items lost, {one.longer:.3f} as long", flush=True)
    rows = []
    for kind in (*FAULTS, "all"):
        of = [one for one in made if kind in (one.kind, "all")]
        if of:
            proven, lost = sum(not one.wrong for one in of), sum(bool(one.lost) for one in of)
            back = sum(bool(one.retraces) for one in of)
            worst, slow = max(one.longer for one in of), statistics.median(one.seconds for one in of)
            rows.append([kind, str(len(of)), str(proven), str(back), str(lost), f"{worst:.3f}", f"{slow:.1f} s"])
    table(
        (
            "planted fault",
            "missions",
            "proven then",
            "return along them",
            "items lost",
            "longest beside shortest",
            "median repair",
        ),
        rows,
    )
    return 1 if sum(bool(one.wrong) for one in made) > 0.05 * len(made) or any(one.lost for one in made) else 0


if __name__ == "__main__":
    raise SystemExit(main())
