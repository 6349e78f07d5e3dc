"""Viewpoints around structures beside the linear programme of set cover, and their tour beside PyVRP's.

A part of ``python benchmarks/survey.py structure [MESH.stl] [SECONDS]``. The programme (HiGHS) has all views that were
chosen among, and its value is a lower bound of their number. PyVRP (an extra of its own: ``pip install pyvrp``) has so
many seconds for the shortest closed tour through the same places; ours is that of `order_strips`.
"""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from machine import table
from scipy.optimize import linprog
from scipy.sparse import csr_array

import skyverse as sky
from skyverse.survey import viewpoints
from skyverse.survey.strip_order import order_strips
from skyverse.survey.structure_lines import structure_lines

SECONDS = 10
MILLIMETRES = 1e3
ROUNDS = 2_000
YARD = sky.Prism(
    vertices=((0, 0), (40, 0), (40, 40), (20, 55), (0, 40)),
    holes=(((10, 10), (30, 10), (30, 30), (10, 30)),),
    low=0.0,
    high=15.0,
    name="structure",
)
HALL = sky.Box(min=(0, 0, 0), max=(60, 25, 18), name="structure")
BESIDE = sky.Box(min=(60, 5, 0), max=(75, 20, 10), name="beside")
SILO = sky.Cylinder(centre=(0, 0), radius=9.0, low=0.0, high=30.0, name="structure")
BALL = sky.Sphere(centre=(0, 0, 30), radius=10.0, name="structure")


def read_stl(path: Path) -> np.ndarray:
    """Return the triangles (n, 3, 3) of an STL file that is text."""
    rows = [line.split()[1:] for line in path.read_text().splitlines() if line.strip().startswith("vertex")]
    return np.array(rows, dtype=float).reshape(-1, 3, 3)


def scenario(obstacles: tuple[Any, ...], gsd: float, facets: np.ndarray | None = None) -> sky.Scenario:
    """Return a scenario whose survey sees structures as few photos can."""
    corners = np.zeros((0, 3)) if facets is None else facets.reshape(-1, 3)
    low = np.minimum(corners.min(axis=0, initial=-60.0), -60.0)
    high = np.maximum(corners.max(axis=0, initial=0.0), 60.0) + 60.0
    seen: dict[str, Any] = {"structures": ("structure",)} if facets is None else {"facets": facets.tolist()}
    survey = sky.Survey(**seen, camera="mavic-3e", gsd=gsd, pattern="viewpoints")
    uav = sky.UAV(start=(-50, -50, 5), end="home", tracking_error={"horizontal": 0.3, "vertical": 0.3})
    bounds = {"min": (*low[:2], 0.0), "max": tuple(high)}
    return sky.Scenario(
        name="structure", bounds=bounds, clearance=1.0, obstacles=obstacles, uavs=(uav,), surveys=(survey,)
    )


def cases(mesh: Path | None) -> Iterator[tuple[str, sky.Scenario]]:
    """Yield structures by name."""
    for gsd in (0.002, 0.004):
        yield f"hall, {1e3 * gsd:g} mm", scenario((HALL, BESIDE), gsd)
        yield f"yard, {1e3 * gsd:g} mm", scenario((YARD,), gsd)
        yield f"silo and ball, {1e3 * gsd:g} mm", scenario((SILO, BALL), gsd)
        if mesh is not None:
            yield f"{mesh.stem}, {1e3 * gsd:g} mm", scenario((), gsd, read_stl(mesh))


def pyvrp_tour(places: np.ndarray, seconds: float) -> float:
    """Return the metres of PyVRP's closed tour."""
    import pyvrp
    from pyvrp.stop import MaxRuntime

    model = pyvrp.Model()
    x, y = np.zeros((2, len(places)))
    where = [model.add_location(a, b) for a, b in zip(x, y, strict=True)]
    model.add_depot(where[0])
    model.add_vehicle_type(1)
    for one in where[1:]:
        model.add_client(one)
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)
    for i, a in enumerate(where):
        for j, b in enumerate(where):
            if i != j:
                model.add_edge(a, b, distance=round(apart[i, j] * MILLIMETRES))
    return float(model.solve(MaxRuntime(seconds), seed=1, display=False).cost()) / MILLIMETRES


def our_tour(places: np.ndarray) -> float:
    """Return the metres of our closed tour."""
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)
    strips = np.repeat(np.arange(1, len(places))[:, None], 2, axis=1)
    return order_strips(apart, strips, 0, 0, rounds=ROUNDS).cost


def least_photos(sets: np.ndarray, elements: np.ndarray) -> float:
    """Return the value of the linear programme of set cover."""
    elements = np.unique(elements, return_inverse=True)[1]
    used, sets = np.unique(sets, return_inverse=True)
    rows = csr_array((np.full(len(sets), -1.0), (elements, sets)))
    found = linprog(np.ones(len(used)), A_ub=rows, b_ub=-np.ones(rows.shape[0]), method="highs")
    return float(found.fun)


def structure(mesh: Path | None = None, seconds: int = SECONDS) -> None:
    """Print photos and tours of some structures beside their bounds."""
    rows, real = [], viewpoints.few_sets
    for name, given in cases(mesh):
        asked: list[tuple[np.ndarray, np.ndarray]] = []

        def few_sets(sets: np.ndarray, elements: np.ndarray, asked: list[Any] = asked) -> np.ndarray:
            asked.append((sets, elements))
            return real(sets, elements)

        structure_lines(given, 0)
        began = time.perf_counter()
        with patch.object(viewpoints, "few_sets", few_sets):
            lines = structure_lines(given, 0).lines
        took = time.perf_counter() - began
        sets, elements = asked[0]
        least = least_photos(sets, elements)
        places = np.array([line.path[0] for line in lines])
        ours, theirs = our_tour(places), pyvrp_tour(places, seconds)
        counts = [f"{len(np.unique(one)):,}" for one in (elements, sets)]
        photos = [f"{len(lines)}", f"{least:.1f}", f"{len(lines) / least:.3f}"]
        rows.append([name, *counts, *photos, f"{ours:.0f}", f"{theirs:.0f}", f"{ours / theirs:.3f}", f"{took:.1f}"])
    head = ["structure", "facets", "views", "photos", "LP", "ratio", "tour, m", "PyVRP, m", "ratio", "s"]
    table(head, rows)
