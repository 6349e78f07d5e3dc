"""The time that importing maps and planning on them takes: ``python benchmarks/maps.py FOLDER [--buildings N]``.

FOLDER contains ``davosdorf.tif`` (ethz-asl/terrain-navigation) and ``delft.city.json`` (cityjson/cjio). The third
scene, a city of N footprints on 5 m terrain, 10 km by 10 km, is made here. Imports are `skyverse scenario build` in a
separate process, start-up and writing included; plans are `plan_mission` with Taut, with kernels compiled before. It
needs the ``maps`` extra.
"""

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from machine import describe, table

import skyverse as sky

DAVOS = ((46.8090, 9.8480), (46.8100, 9.8490), (46.8110, 9.8500), (46.8120, 9.8510), (46.8130, 9.8520))
DAVOS_TARGETS = ((46.8330, 9.8050), (46.8250, 9.7990), (46.8160, 9.8010), (46.8300, 9.8250), (46.8060, 9.8050))


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--buildings", type=int, default=20_000)
    options = parser.parse_args()
    print(describe("scipy", "pyproj", "rasterio", "pyogrio", "shapely"), end="\n\n")
    rows = []
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        davos = ["--terrain", str(options.folder / "davosdorf.tif"), "--clearance", "10", "--ground-clearance", "30"]
        davos += [word for place in DAVOS for word in ("--uav", f"{place[0]},{place[1]},60 m agl")]
        davos += [word for place in DAVOS_TARGETS for word in ("--target", f"{place[0]},{place[1]},60 m agl")]
        delft = ["--buildings", str(options.folder / "delft.city.json"), "--ground", "0 m amsl"]
        for name, words in (("Davos", davos), ("Delft", delft), (f"city of {options.buildings:,}", None)):
            words = city(folder, options.buildings) if words is None else words
            seconds, memory = built(words, folder / f"{name.split()[0]}.json")
            scenario = sky.read_scenario(folder / f"{name.split()[0]}.json")
            if not scenario.uavs:
                scenario = peopled(scenario)
            rows.append([name, shapes(scenario), f"{seconds:.1f} s", f"{memory:.2f} GB", *planned(scenario)])
    head = ["scene", "holds", "import", "memory", "world and lattice", "one path", "five UAVs, proven", "verdict"]
    table(head, rows)
    return 0


def built(words: list[str], path: Path) -> tuple[float, float]:
    """Import in a process of its own; return its seconds, and the most memory of any so far, GB."""
    command = [sys.executable, "-m", "skyverse", "scenario", "build", *words, "-o", str(path)]
    began = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(done.stderr)
    return time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e6


def shapes(scenario: sky.Scenario) -> str:
    """Say what is in a scenario."""
    ground = "" if scenario.terrain is None else " x ".join(map(str, scenario.terrain.heights.shape)) + " heights"
    prisms = f"{len(scenario.obstacles):,} prisms" if scenario.obstacles else ""
    return ", ".join(part for part in (ground, prisms) if part)


def peopled(scenario: sky.Scenario, seed: int = 0) -> sky.Scenario:
    """Put five UAVs and five targets where there is room, far from each other."""
    rng = np.random.default_rng(seed)
    world = sky.World(scenario)
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    places: list[np.ndarray] = []
    while len(places) < 10:
        place = low + (high - low) * rng.uniform(0.05, 0.95, 3)
        place[2] = low[2] + (high[2] - low[2]) * rng.uniform(0.05, 0.5)
        side = 0 if len(places) < 5 else 1
        place[0] = low[0] + (high[0] - low[0]) * (0.04 + 0.06 * rng.random() + 0.84 * side)
        if world.distance(place)[0] > 3 * scenario.clearance + 1 and world.free(place)[0]:
            places.append(place.round(2))
    uavs = tuple(sky.UAV(name=f"uav-{i}", start=tuple(p.tolist()), max_speed=10.0) for i, p in enumerate(places[:5], 1))
    targets = tuple(sky.Target(name=f"target-{i}", position=tuple(p.tolist())) for i, p in enumerate(places[5:], 1))
    return scenario.model_copy(update={"uavs": uavs, "targets": targets})


def planned(scenario: sky.Scenario) -> list[str]:
    """Plan twice, the first time to compile; return the second's times and the verdict."""
    sky.plan_mission(scenario, sky.Taut(), rng=1)
    began = time.perf_counter()
    airspace = sky.Airspace(scenario)
    airspace.world, airspace.grid  # noqa: B018
    compiled = time.perf_counter() - began
    singles = []
    for uav in range(5):
        began = time.perf_counter()
        sky.Taut().plan(sky.Problem(airspace, uav=uav, target=uav))
        singles.append(time.perf_counter() - began)
    fleets = []
    for _ in range(3):
        began = time.perf_counter()
        mission = sky.plan_mission(scenario, sky.Taut(), rng=1)
        fleets.append(time.perf_counter() - began)
    proven = [c is not None and c.verdict is sky.Verdict.PROVEN for c in mission.certificates]
    verdict = f"{sum(proven)} of 5 proven, {len(mission.violations)} violations"
    return [
        f"{compiled:.2f} s",
        f"{np.median(singles):.3f} s, worst {max(singles):.3f}",
        f"{np.median(fleets):.2f} s",
        verdict,
    ]


def city(folder: Path, count: int, side: float = 10_000.0) -> list[str]:
    """Write turned rectangles and L-shapes on hills, UTM zone 31; return what to build of them."""
    import rasterio
    from pyproj import Transformer
    from rasterio.transform import from_origin

    rng = np.random.default_rng(0)
    x0, y0 = 600_000.0, 5_760_000.0
    n = int(side / 5) + 120
    y, x = np.mgrid[0:n, 0:n] * 5.0
    ground = 40 + 30 * np.sin(x / 900) * np.cos(y / 700) + 5 * np.sin(x / 130 + y / 170)
    with rasterio.open(
        folder / "hills.tif", "w", driver="GTiff", height=n, width=n, count=1, dtype="float32", crs="EPSG:32631",
        transform=from_origin(x0 - 300, y0 + side + 300, 5, 5), tiled=True,
    ) as file:  # fmt: skip
        file.write(ground.astype("float32"), 1)
    to_globe = Transformer.from_crs("EPSG:32631", "EPSG:4326", always_xy=True)
    features = []
    cells = int(np.ceil(np.sqrt(count)))
    for k in range(count):
        middle = (np.array([k % cells, k // cells]) + 0.3 + 0.4 * rng.random(2)) * side / cells
        half, angle = rng.uniform(6, 18, 2), rng.uniform(0, np.pi)
        ring = np.array([[-1, -1], [1, -1], [1, 0.2], [0.1, 0.2], [0.1, 1], [-1, 1]]) * half
        if k % 2:
            ring = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
        ring = ring @ [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]] + middle + [x0, y0]
        corners = np.column_stack(to_globe.transform(*np.vstack([ring, ring[:1]]).T)).round(8).tolist()
        features.append(
            {
                "type": "Feature",
                "properties": {"height": round(float(rng.lognormal(2.6, 0.5)), 1)},
                "geometry": {"type": "Polygon", "coordinates": [corners]},
            }
        )
    (folder / "city.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    west, south = to_globe.transform(x0 + 100, y0 + 100)
    east, north = to_globe.transform(x0 + side - 100, y0 + side - 100)
    area = f"{west},{south},{east},{north}"
    return ["--terrain", str(folder / "hills.tif"), "--buildings", str(folder / "city.geojson"), "--area", area]


if __name__ == "__main__":
    sys.exit(main())
