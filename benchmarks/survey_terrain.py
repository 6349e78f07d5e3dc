"""Strips over random alps beside rays on a grid: how finely photos show the ground, how they overlap, how many."""

import math
import time
from pathlib import Path

import numpy as np
from machine import table

import skyverse as sky
from skyverse.model.asked_ground import asked_ground
from skyverse.model.photos import Photos
from skyverse.referee.ground_cells import grid_of
from skyverse.referee.photo_overlaps import SHORT, neighbours_of
from skyverse.survey.ground_lines import ground_lines
from skyverse.survey.lines import PhotoLine

GSD = 0.02
AROUND, SIDE = 300.0, 600.0
GRID = 4.0


def alps(cells: int, step: float, steepest: float, seed: int) -> np.ndarray:
    """Return heights (cells, cells) whose 99th percentile of slopes is as steep as said, in degrees."""
    rng = np.random.default_rng(seed)
    k = np.hypot(np.fft.fftfreq(cells, step)[:, None], np.fft.rfftfreq(cells, step)[None])
    sizes = np.where((k > 0) & (k < 1 / 200.0), np.maximum(k, 1e-6) ** -2.0, 0.0)
    h = np.fft.irfft2(sizes * np.exp(2j * math.pi * rng.random(sizes.shape)), s=(cells, cells))
    slope = np.quantile(np.hypot(*np.gradient(h, step)), 0.99)
    return (h - h.min()) * math.tan(math.radians(steepest)) / slope


def scenario(side: float, step: float, steepest: float, seed: int, gsd_of: str = "photo") -> sky.Scenario:
    return over(alps(int((side + 2 * AROUND) / step) + 1, step, steepest, seed), step, side, gsd_of)


def over(heights: np.ndarray, step: float, side: float, gsd_of: str) -> sky.Scenario:
    """Return a survey of a square over heights that reach beyond it."""
    top = float(heights.max())
    uav = sky.UAV(start=(-200.0, -200.0, top + 50.0), end="home", max_speed=12.0, max_climb=6.0, max_descent=6.0)
    corners = ((0.0, 0.0), (side, 0.0), (side, side), (0.0, side))
    low, high = 5.0 - AROUND, side + AROUND - 5.0
    return sky.Scenario(
        name="alps",
        bounds={"min": (low, low, 0.0), "max": (high, high, top + 200.0)},
        clearance=10.0,
        uavs=(uav,),
        terrain={"origin": (-AROUND, -AROUND), "step": (step, step), "heights": heights},
        surveys=(sky.Survey(corners, "mavic-3e", gsd=GSD, gsd_of=gsd_of),),
    )


def photos(line: PhotoLine) -> tuple[np.ndarray, np.ndarray]:
    legs = np.hypot(*np.diff(line.path[:, :2], axis=0).T)
    way = np.r_[0.0, np.cumsum(legs)]
    at = np.linspace(0.0, way[-1], round(way[-1] / line.every) + 1)
    ahead = (line.path[-1] - line.path[0])[:2] / np.hypot(*(line.path[-1] - line.path[0])[:2])
    return np.column_stack([np.interp(at, way, line.path[:, k]) for k in range(3)]), ahead


def judged(given: sky.Scenario, lines: tuple[PhotoLine, ...], side: float) -> tuple[float, float, float, float]:
    """Return the coarsest of any place in a photo, of the best photo of each, the share of pairs as asked, the least.

    Pairs are judged by the referee.
    """
    survey = given.surveys[0]
    across, along = survey.camera.half_widths
    axis = np.arange(0.0, side + GRID / 2, GRID)
    x, y = (one.ravel() for one in np.meshgrid(axis, axis, indexing="ij"))
    z, best, coarsest = given.terrain.height(np.column_stack([x, y])), np.full(len(x), np.inf), 0.0
    taken = [photos(line) for line in lines]
    for where, ahead in taken:
        for px, py, pz in where:
            near = np.flatnonzero(np.hypot(x - px, y - py) < 200.0)
            u, v, depth = x[near] - px, y[near] - py, pz - z[near]
            seen = (np.abs(u * ahead[0] + v * ahead[1]) <= along * depth) & (
                np.abs(u * ahead[1] - v * ahead[0]) <= across * depth
            )
            near, depth = near[seen], depth[seen]
            best[near] = np.minimum(best[near], depth)
            coarsest = max(coarsest, depth.max(initial=0.0))
    counts = [len(where) for where, _ in taken]
    heading = np.repeat([math.degrees(math.atan2(*ahead)) % 360.0 for _, ahead in taken], counts)
    none = np.zeros(len(heading))
    strip, uav = np.repeat(np.arange(len(lines)), counts), np.zeros(len(heading), dtype=np.int64)
    shots = Photos(np.concatenate([where for where, _ in taken]), heading, none - 90.0, none, none, uav, strip)
    shared = neighbours_of(shots, survey.camera, grid_of(given, survey, asked_ground(survey)))
    spare = np.concatenate([pairs.share - asked for pairs, asked in zip(shared, survey.overlap, strict=True)])
    pixel = survey.camera.pixel
    return coarsest * pixel, best.max() * pixel, float((spare >= -SHORT).mean()), float(spare.min()) / 100


def mountain(dem: Path, gsd_of: str) -> tuple[sky.Scenario, float]:
    """Return a survey of the part of an elevation model whose mean slope is nearest to 30 degrees, and its grid."""
    import rasterio

    with rasterio.open(dem) as raster:
        heights, step = raster.read(1).T[:, ::-1].astype(float), float(raster.res[0])
    wide, inner = round((SIDE + 2 * AROUND) / step) + 1, round(AROUND / step)
    slope = np.degrees(np.arctan(np.hypot(*np.gradient(heights, step))))
    best, at = math.inf, (0, 0)
    for i in range(0, heights.shape[0] - wide, 25):
        for j in range(0, heights.shape[1] - wide, 25):
            mean = slope[i + inner : i + wide - inner, j + inner : j + wide - inner].mean()
            if abs(mean - 30.0) < best and np.isfinite(heights[i : i + wide, j : j + wide]).all():
                best, at = abs(mean - 30.0), (i, j)
    part = heights[at[0] : at[0] + wide, at[1] : at[1] + wide]
    return over(part - part.min(), step, SIDE, gsd_of), step


def terrain(runs: int = 3, dem: Path | None = None) -> None:
    """Judge strips over alps, those of 30 degrees among them."""
    ground_lines(scenario(300.0, 2.0, 10.0, 0), 0)  # compiled
    rows = []
    for gsd_of in ("photo", "place"):
        sites = [
            (f"{steepest:g}, {seed}", scenario(SIDE, 2.0, max(steepest, 0.01), seed, gsd_of), 2.0)
            for steepest in (0.0, 10.0, 20.0, 30.0)
            for seed in range(runs if steepest else 1)
        ]
        sites += [(dem.stem, *mountain(dem, gsd_of))] if dem is not None else []
        for name, given, step in sites:
            begun = time.process_time()
            found = ground_lines(given, 0)
            seconds = time.process_time() - begun
            lines = found.lines
            count = sum(len(photos(line)[0]) for line in lines)
            survey, (across, along) = given.surveys[0], given.surveys[0].camera.half_widths
            ideal = SIDE**2 / (0.2 * 2 * along * survey.distance * 0.3 * 2 * across * survey.distance)
            inner = slice(round(AROUND / step), -round(AROUND / step))
            slope = np.hypot(*np.gradient(given.terrain.heights, step))[inner, inner]
            coarsest, best, share, least = judged(given, lines, SIDE)
            points, length = sum(len(line.path) for line in lines), sum(photos_length(line) for line in lines)
            rows.append(
                [
                    *(name, f"{math.degrees(np.arctan(slope).mean()):.0f}", gsd_of),
                    *(f"{100 * coarsest:.3f}", f"{100 * best:.3f}", f"{100 * share:.2f}", f"{100 * least:+.1f}"),
                    *(str(count), f"{count / (ideal * np.sqrt(1 + slope**2).mean()):.2f}", str(points)),
                    *(f"{points / (length / 10.0):.2f}", f"{len(found.unseen)}", f"{seconds:.1f}"),
                ]
            )
    heads = ["steepest, seed", "mean", "gsd_of", "GSD cm any", "best", "pairs as asked %", "least spare", "photos"]
    table([*heads, "x flat / cos", "points", "x every 10 m", "gaps", "s"], rows)
    print("Photos of level ground exceed the flat ideal by what cameras and UAVs are off, and by whole strips.")


def photos_length(line: PhotoLine) -> float:
    return float(np.hypot(*np.diff(line.path[:, :2], axis=0).T).sum())
