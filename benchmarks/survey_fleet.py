"""Three UAVs on AC maps, VM25 and CTU's cases: the longest flight beside what no flights of the same strips go below.

A part of ``python benchmarks/survey.py fleet AC300 COSTS VM25 CTU [EVERY]``: every so manieth AC map from the start of
Agarwal and Akella. On VM25 and on CTU's zones all begin and end at the first corner.
"""

import time
from pathlib import Path

import numpy as np
import shapely
from machine import table
from strip_bounds import routes_bound
from survey_ac import Map, maps
from survey_sorties import routing

from skyverse.mission.strip_routing import route_strips

UAVS = 3
METRES_OF_DEGREE = 111_195.0


def fleet(folder: Path, costs: Path, vm25: Path, ctu: Path, every: int = 4) -> None:
    """Print the longest flight of three UAVs beside its bound."""
    sets = {
        "AC": maps(folder, costs)[::every] if folder.exists() else [],
        "VM25": [_environment(one) for one in sorted(vm25.glob("*")) if (one / "outer_polygon").exists()],
        "CTU": [_zone(ctu, name) for name in ("rectangle", "simple", "complex") if ctu.exists()],
    }
    rows = []
    for name, cases in sets.items():
        if not cases:
            print(f"skipped: no maps of {name}")
            continue
        found = []
        for one in cases:
            vehicle, strips, work, _ = routing(one)
            begun = time.perf_counter()
            routes = route_strips([vehicle] * UAVS, strips, work, "min-max")
            seconds = time.perf_counter() - begun
            bound = routes_bound([vehicle] * UAVS, strips, work, routes, "min-max")
            found.append((routes.finish / bound - 1.0, seconds))
            print(one.name, len(strips), *(f"{value:.4g}" for value in found[-1]), flush=True)
        gap, seconds = np.array(found).T
        within = f"{(gap <= 0.05).sum()} of {len(gap)}"
        rows.append([name, f"{np.median(gap):.2%}", f"{gap.max():.2%}", within, f"{seconds.mean():.1f}"])
    table(["maps", "gap, median", "most", "within 5 %", "s"], rows)


def _environment(folder: Path) -> Map:
    """Return one of VM25; its coordinates are metres."""
    outer, holes = np.loadtxt(folder / "outer_polygon"), folder / "holes"
    blocks = holes.read_text(encoding="utf-8").strip().split("\n\n") if holes.exists() else []
    rings = [np.array(block.split(), float).reshape(-1, 2) for block in blocks if block.strip()]
    return _from_corner(folder.name, outer, rings)


def _zone(folder: Path, name: str) -> Map:
    """Return one of CTU's fly zones about its first corner, scaled by 0.3: its strips 10 m apart are 3 m apart here."""
    read = [
        np.loadtxt(path, delimiter=",")[:, ::-1]
        for path in (folder / f"{name}_fly_zone.csv", *sorted(folder.glob(f"{name}_no_fly_zone_*.csv")))
    ]
    scale = 0.3 * METRES_OF_DEGREE * np.array([np.cos(np.radians(read[0][0, 1])), 1.0])
    outer, *rings = ((ring - read[0][0]) * scale for ring in read)
    return _from_corner(name, outer, rings)


def _from_corner(name: str, outer: np.ndarray, rings: list[np.ndarray]) -> Map:
    area = shapely.make_valid(shapely.Polygon(outer).difference(shapely.union_all([shapely.Polygon(r) for r in rings])))
    area = max(shapely.get_parts(area), key=shapely.area)
    return Map(name, len(rings), area, np.nan, np.nan, np.empty((0, 2, 2)), np.array(area.exterior.coords[0]))
