"""What the referee claims of cells, on the ground and on structures, and what rays find of places in these cells."""

from unittest.mock import patch

import numpy as np

import skyverse as sky
from ray_caster import Cameras, Caster, seen
from skyverse.referee.coverage import judge_coverage
from skyverse.referee.shown import Viewers


def boxes_of(shape):
    """Return an obstacle as what the ray caster knows: of voxels, a box for each that is occupied."""
    if type(shape).__name__ != "Voxels":
        return [shape]
    low, step = np.array(shape.origin), np.array(shape.step)
    cells = np.argwhere(shape.occupied)
    return [sky.Box(min=tuple(low + step * at), max=tuple(low + step * (at + 1))) for at in cells]


def claims_of(scenario, photos, error, rng, most):
    """Return what the referee says, and places in cells that it claims: (n, 3), normals, counts and depths.

    On the ground, normals are nothing.
    """
    found = []

    def told(corners, normal, shown, where):
        at = np.flatnonzero(where)
        at = rng.choice(at, min(len(at), most), replace=False)
        weight = rng.dirichlet(np.full(corners.shape[1], 0.5), len(at))
        places = (weight[:, :, None] * corners[at]).sum(axis=1)
        normals = np.zeros((len(at), 3)) if normal is None else normal[at]
        found.append((places, normals, shown.count.ravel()[at].astype(int), shown.depth.ravel()[at]))

    def show_grid(viewers, grid):
        shown = show_all(viewers, grid)
        nodes = np.dstack([*np.meshgrid(grid.x, grid.y, indexing="ij"), grid.z])
        corners = np.stack([nodes[:-1, :-1], nodes[1:, :-1], nodes[1:, 1:], nodes[:-1, 1:]], axis=2).reshape(-1, 4, 3)
        told(corners, None, shown, (grid.whole & (shown.count > 0)).ravel())
        return shown

    def show_pieces(viewers, pieces, normal=None, hidden=None):
        shown = show_some(viewers, pieces, normal, hidden)
        told(pieces.corners, normal, shown, shown.count > 0)
        return shown

    show_all, show_some = Viewers.show_grid, Viewers.show_pieces
    with patch.object(Viewers, "show_grid", show_grid), patch.object(Viewers, "show_pieces", show_pieces):
        coverage = judge_coverage(scenario, 0, photos, [error])
    return coverage, *(np.concatenate(column) for column in zip(*found, strict=True))


def denied(scenario, photos, error, seed=0, most=40):
    """Return what the referee says, how many places it claims of those looked at, and what rays deny, in words."""
    rng, survey = np.random.default_rng(seed), scenario.surveys[0]
    coverage, places, normals, count, depth = claims_of(scenario, photos, error, rng, most)
    obstacles = tuple(box for shape in scenario.obstacles for box in boxes_of(shape))
    facets = np.array(survey.facets, dtype=float).reshape(-1, 3, 3)
    caster = Caster(scenario.terrain, obstacles, facets, scenario.bounds.min[2])
    if survey.of_ground:
        places[:, 2] = caster.ground(*places[:, :2].T)
    elif survey.structures:  # cells reach a little into the ground
        there = places[:, 2] >= caster.ground(*places[:, :2].T)
        places, normals, count, depth = (column[there] for column in (places, normals, count, depth))
    cameras = Cameras.of(survey, photos, [error])
    sure, deep = seen(caster, cameras, places, None if survey.of_ground else normals, random=6, seed=seed)
    best = np.where(sure, deep, np.inf).min(axis=1, initial=np.inf)
    wrong = [
        f"{count[k]} photos, {depth[k]} m deep, at {places[k].round(3).tolist()}; by rays {sure[k].sum()}, {best[k]}"
        for k in np.flatnonzero((count > sure.sum(axis=1)) | (best > depth + 1e-6))
    ]
    return coverage, len(places), wrong
