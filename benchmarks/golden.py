"""Golden missions: what every planner, shape and map answers, so that a change can show that no answer moved.

``python benchmarks/golden.py make`` writes ``tests/golden/missions.json``; ``check`` computes everything again and
names what differs: to the last bit on x86-64 processors with the numpy that the file was made with and a C library that
rounds alike, and elsewhere in costs, makespans and violations. ``tests/test_golden.py`` runs the same cases. Times,
versions and sentences are left out: they may change, and so are headings, which follow from the rest of a flight.
"""

import argparse
import dataclasses
import hashlib
import json
import math
import platform
import re
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import skyverse as sky

FILE = Path(__file__).parent.parent / "tests" / "golden" / "missions.json"
LEFT_OUT = {"seconds", "platform", "skyverse", "message", "note", "format", "straight_bound", "pointing", "source"}
FEW = sky.MaxIterations(6)
SAME = 1e-9
"""The share by which numbers may differ where not all bits are compared."""
OF_OTHERS = ("CMAES", "LSHADE")
"""Planners whose optimisers, which other packages make, call LAPACK and numpy's tangent: only numbers are compared."""


def mixed_shapes() -> sky.Scenario:
    """Make a scenario that holds a shape of every kind above a terrain."""
    y, x = np.mgrid[0:31, 0:31] * 2.0
    solid = np.zeros((4, 3, 5), dtype=bool)
    solid[1:3, 1, :4] = True
    return sky.Scenario(
        name="mixed shapes",
        bounds=sky.Bounds(min=(0, 0, 0), max=(60, 60, 30)),
        obstacles=(
            sky.Box(min=(10, 0, 0), max=(14, 25, 20)),
            sky.Cylinder(centre=(25, 30), radius=6, low=0, high=24),
            sky.Sphere(centre=(40, 20, 10), radius=7),
            sky.Prism(vertices=((30, 40), (45, 42), (40, 55), (28, 50)), low=0, high=26),
            sky.Voxels(origin=(48, 30, 0), step=(3.0, 3.0, 3.0), occupied=solid),
        ),
        terrain=sky.Terrain(origin=(0, 0), step=(2.0, 2.0), heights=3.0 + 2.0 * np.sin(x / 9) * np.cos(y / 7)),
        clearance=0.5,
        lattice=sky.Lattice(step=(2, 2, 2), connectivity=26),
        uavs=(sky.UAV(start=(3, 3, 8)), sky.UAV(start=(3, 55, 10))),
        targets=(sky.Target(position=(57, 57, 9)), sky.Target(position=(56, 5, 12))),
    )


def cases() -> dict[str, Callable[[], Any]]:
    """Return what is computed, by name."""
    one_uav = {
        **{type(p).__name__: p for p in (sky.AStar(), sky.ThetaStar(), sky.Taut(), sky.Cheapest(), sky.HybridMVO())},
        **{type(p).__name__: p for p in (sky.RandomRestart(), sky.MVO(), sky.GSO(), sky.BBO())},
        **{f"{kind.__name__} as run": kind(as_run=True) for kind in (sky.MVO, sky.GSO, sky.BBO)},
    }
    waypoints = (sky.CMAES, sky.LSHADE, sky.DE, sky.PSO, sky.GA, sky.WOA, sky.MFO, sky.GWO, sky.DA)
    found: dict[str, Callable[[], Any]] = {}
    for world in ("map1", "map2", "map3"):
        for name, planner in one_uav.items():
            found[f"{name} on {world}"] = lambda p=planner, w=world: plan(p, sky.read(w))
    for kind in waypoints:
        found[f"{kind.__name__} on map1"] = lambda k=kind: plan(k(), sky.read("map1"))
    for name in ("AStar", "ThetaStar", "Taut", "Cheapest", "MVO", "HybridMVO"):
        found[f"{name} among mixed shapes"] = lambda n=name: plan(one_uav[n], mixed_shapes())
        found[f"{name} among threats"] = lambda n=name: plan(one_uav[n], sky.random_threats())
        found[f"{name} over jacksboro"] = lambda n=name: plan(one_uav[n], sky.read("jacksboro"))
    for name in ("AStar", "ThetaStar", "Taut"):
        found[f"{name} in a room"] = lambda n=name: plan(one_uav[n], sky.random_room())
        found[f"{name} in a city"] = lambda n=name: plan(one_uav[n], sky.random_city(300, seed=3))
    for fleet in ("table-4.8", "table-4.9-2", "table-4.9-3", "table-4.9-4", "table-4.11", "table-4.12", "table-4.13"):
        found[f"fleet {fleet}, Taut"] = lambda f=fleet: fly(sky.read(f), sky.Taut())
    found["fleet table-4.8, MVO"] = lambda: fly(sky.read("table-4.8"), sky.MVO())
    for shape in ("minimum-jerk", "stop-and-go"):
        found[f"fleet table-4.8, {shape}"] = lambda s=shape: fly(sky.read("table-4.8"), sky.Taut(), shape=s)
    found["fleet over jacksboro"] = over_jacksboro
    for fleet in ("table-4.8", "jacksboro"):
        found[f"fleet {fleet}, no planner named"] = lambda f=fleet: fly(sky.read(f))
    found["fleet among mixed shapes"] = lambda: fly(mixed_shapes(), sky.Taut())
    found["fleet of eight changing places"] = lambda: fly(sky.circle_swap(8), sky.Taut(), assignment="identity")
    window = sky.window_swap(sky.read("map1"), uavs=6)
    found["fleet through a window"] = lambda: fly(window, sky.Taut(), assignment="identity")
    found["aeroplane"] = lambda: fly(aeroplane(), sky.Taut())
    for name, scenario in surveys().items():
        found[f"survey {name}"] = lambda s=scenario: fly(s, criterion="min-max")
    for suffix in ("plan", "waypoints", "kml", "gpx", "csv"):
        found[f"export as {suffix}"] = lambda s=suffix: exported(s)
    return found


def aeroplane() -> sky.Scenario:
    """Make a scenario for an aeroplane among three towers."""
    towers = ((150, 120), (300, 220), (420, 60))
    wing = sky.FixedWing(speed=15.0, turn_radius=80.0, climb=10)
    return sky.Scenario(
        name="aeroplane",
        bounds=sky.Bounds(min=(0, 0, 0), max=(600, 400, 120)),
        obstacles=tuple(sky.Box(min=(x, y, 0), max=(x + 60, y + 80, 100)) for x, y in towers),
        clearance=5.0,
        lattice=sky.Lattice(step=(10, 10, 10)),
        uavs=(sky.UAV(start=(20, 200, 50), max_speed=20, fixed_wing=wing),),
        targets=(sky.Target(position=(580, 200, 60)),),
    )


def surveys() -> dict[str, sky.Scenario]:
    """Make a field over hills with a zone for two UAVs, a level field for an aeroplane, and a tower, by name."""
    east, north = np.meshgrid(np.arange(0, 201, 10.0), np.arange(0, 201, 10.0), indexing="ij")
    pilots = {"end": "home", "max_speed": 10, "max_acceleration": 3, "max_climb": 3, "separation": 3}
    wing = sky.FixedWing(speed=12.0, turn_radius=30.0, climb=10)
    field = sky.Survey([(40, 40), (160, 50), (150, 150), (100, 120), (40, 150)], "mavic-3e", gsd="2 cm")
    tower = sky.Survey(structures=["tower"], camera="mavic-3e", gsd="8 mm", pattern="facade", overlap=(60, 50))
    level: dict[str, Any] = {"clearance": 2.0, "lattice": {"step": (10, 10, 10)}}
    hills = level | {
        "bounds": {"min": (0, 0, -20), "max": (200, 200, 130)},
        "obstacles": [sky.Cylinder(centre=(100, 90), radius=12, low=-20, high=130, solid=False)],
        "terrain": {"origin": (0, 0), "step": (10, 10), "heights": 8 * np.sin(east / 30) + 6 * np.cos(north / 25)},
        "uavs": [sky.UAV(start=(x, 15, 25), **pilots) for x in (15, 30)],
        "surveys": [field],
    }
    flat = level | {
        "bounds": {"min": (-200, -200, 0), "max": (400, 400, 130)},
        "uavs": [sky.UAV(start=(10, -100, 60), end="home", max_speed=18, max_acceleration=9, fixed_wing=wing)],
        "surveys": [field],
    }
    built = level | {
        "bounds": {"min": (0, 0, 0), "max": (100, 100, 60)},
        "obstacles": [sky.Box(min=(40, 40, 0), max=(50, 56, 24), name="tower")],
        "uavs": [sky.UAV(start=(10, 10, 10), **pilots)],
        "surveys": [tower],
    }
    named = {"over hills": hills, "by an aeroplane": flat, "of a tower": built}
    return {name: sky.Scenario(name=name, **given) for name, given in named.items()}


def plan(planner: sky.Planner, scenario: sky.Scenario) -> sky.Result:
    """Plan the first UAV's path with six iterations and seed 1."""
    return planner.plan(sky.Problem(scenario), stop=FEW, rng=1)


def fly(scenario: sky.Scenario, planner: sky.Planner | None = None, **options: Any) -> sky.Mission:
    """Plan a fleet's mission with six iterations and seed 1."""
    how = sky.MissionOptions(shape=options.pop("shape", "minimum-time"), criterion=options.pop("criterion", "min-sum"))
    return sky.plan_mission(scenario, planner, stop=FEW, rng=1, options=how, **options)


@cache
def over_jacksboro() -> sky.Mission:
    """Plan the fleet over Jacksboro, once for all that is asked of it."""
    return fly(sky.read("jacksboro"), sky.Taut())


def exported(suffix: str) -> list[list[str]]:
    """Return all numbers of the files that the mission over Jacksboro is exported to."""
    mission = over_jacksboro()
    with tempfile.TemporaryDirectory() as folder:
        sky.export(mission, Path(folder) / f"jacksboro.{suffix}")
        texts = [file.read_text(encoding="utf-8") for file in sorted(Path(folder).iterdir())]
    return [re.findall(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", text) for text in texts]


def computed(name: str) -> dict[str, Any]:
    """Return what is kept of a case, computed now."""
    found = facts(cases()[name]())
    return {key: value for key, value in found.items() if key != "digest" or name.split()[0] not in OF_OTHERS}


def facts(answer: Any) -> dict[str, Any]:
    """Return a digest of an answer to the last bit, and a few of its numbers.

    Of files, these are how many numbers they hold and the sum of their magnitudes.
    """
    found: dict[str, Any] = {"digest": hashlib.sha256(json.dumps(plain(answer)).encode()).hexdigest()[:16]}
    if isinstance(answer, sky.Result):
        found |= {"cost": answer.cost, "bound": answer.bound, "points": len(answer.path)}
    elif isinstance(answer, sky.Mission):
        found |= {"cost": answer.cost, "makespan": answer.makespan, "violations": len(answer.violations)}
    else:
        numbers = [abs(float(number)) for file in answer for number in file]
        found |= {"numbers": len(numbers), "sum": math.fsum(numbers)}
    return found


def same(found: dict[str, Any], known: dict[str, Any], *, to_the_last_bit: bool) -> bool:
    """Tell whether an answer is the known one: to the last bit, or in all its numbers within `SAME`."""
    if to_the_last_bit:
        return found == known
    numbers = found.keys() - {"digest"}
    return numbers == known.keys() - {"digest"} and all(
        math.isclose(found[name], known[name], rel_tol=SAME) for name in numbers
    )


def roundings() -> str:
    """Return a digest of how the C library rounds: otherwise where the processor cannot multiply and add at once."""
    places = [0.37 * k - 31.0 for k in range(2000)]
    sizes = [abs(x) for x in places]
    values = [[f(x) for x in places] for f in (math.sin, math.cos, math.atan, math.exp)]
    values += [[math.log(x) for x in sizes], [x**1.37 for x in sizes], [math.atan2(x, 3.3) for x in places]]
    return hashlib.sha256(json.dumps(values).encode()).hexdigest()[:16]


def rounds_alike(numpy: str, rounded: str) -> bool:
    """Tell whether all bits are as on an x86-64 processor with a version of numpy and `roundings` of the C library."""
    return platform.machine().lower() in ("x86_64", "amd64") and np.__version__ == numpy and roundings() == rounded


LATER = {
    "FlightSummary": ("energy_bound", "left"),
    "Mission": ("sorties", "unvisited", "unseen", "coverage"),
    "Coverage": ("left_out",),
}
"""Fields that answers have got since the known ones were computed, which are left out where they hold nothing."""


def plain(value: Any) -> Any:
    """Return an answer as lists, numbers and texts, without what may change."""
    if dataclasses.is_dataclass(value):
        names = sorted(f.name for f in dataclasses.fields(value) if f.name not in LEFT_OUT and f.name != "scenario")
        names = [name for name in names if name not in LATER.get(type(value).__name__, ()) or getattr(value, name)]
        return [[name, plain(getattr(value, name))] for name in names]
    if isinstance(value, np.ndarray):
        return [list(value.shape), value.ravel().tolist()]
    if isinstance(value, dict):
        return [[key, plain(value[key])] for key in sorted(value)]
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    return value if isinstance(value, int | float | str | None) else str(value)


def main() -> int:
    """Make or check the file; return 1 if anything differs."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("verb", choices=["make", "check"])
    parser.add_argument("only", nargs="*", help="parts of the names of the cases; all by default")
    options = parser.parse_args()
    file = json.loads(FILE.read_text(encoding="utf-8"))
    known, version = file["answers"], file["numpy"] if options.only or options.verb == "check" else np.__version__
    exact = rounds_alike(version, file["roundings"])
    if options.verb == "make" and not exact:
        parser.error(f"the file is made on x86-64 with FMA, and in parts only with numpy {file['numpy']}")
    chosen = [name for name in cases() if not options.only or any(part in name for part in options.only)]
    found = {}
    for name in chosen:
        found[name] = computed(name)
        print(f"{name}: {found[name]}", flush=True)
    if options.verb == "make":
        both = known | found if options.only else found
        answers = {name: both[name] for name in cases() if name in both}
        made = {"numpy": version, "roundings": roundings(), "answers": answers}
        FILE.write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")
        return 0
    different = [name for name in chosen if not same(found[name], known.get(name, {}), to_the_last_bit=exact)]
    for name in different:
        print(f"DIFFERS {name}: {known.get(name)} before, {found[name]} now", file=sys.stderr)
    how = "to the last bit" if exact else f"within a share of {SAME:g}"
    print(f"{len(chosen) - len(different)} of {len(chosen)} answers are the same {how}")
    return 1 if different else 0


if __name__ == "__main__":
    raise SystemExit(main())
