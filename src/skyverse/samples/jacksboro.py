"""A mountain mission: five UAVs from a valley over the ridges beside the Jacksboro fault, Tennessee.

The terrain is the digital elevation model of the U.S. Geological Survey, in the public domain, that matplotlib ships.
"""

from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.model.frame import Frame, Origin
from skyverse.model.geodesy import to_local, to_wgs84
from skyverse.model.scenario import AltitudeBand, Bounds, ClimbLimit, Lattice, Objective, Scenario, Source, Target
from skyverse.model.shapes import Terrain
from skyverse.model.uav import UAV

ELEVATION_FILE = "jacksboro_fault_dem.npz"
JACKSBORO_ORIGIN = Origin(latitude=36.5145, longitude=-84.2275, altitude=300.0)
TERRAIN_SIDES = (11000.0, 7000.0)
TERRAIN_STEP = 75.0
"""Metres."""
END_HEIGHT = 40.0
"""Metres above ground of starts and targets."""

_STARTS = (
    (36.51020, -84.17420),
    (36.51130, -84.17250),
    (36.50910, -84.17590),
    (36.51240, -84.17080),
    (36.50800, -84.17760),
)
_TARGETS = ((36.5270, -84.2790), (36.5140, -84.2830), (36.5020, -84.2740), (36.4905, -84.2760), (36.5375, -84.2620))


def jacksboro() -> Scenario:
    """Make the scenario: flights of 10 km over ridges, at least 30 m above ground, preferably 40 to 120 m.

    Returns
    -------
    Scenario
        It has a 26-connected lattice with steps of 100 m, 25 m vertically, for planners that need one.
    """
    terrain = _terrain()
    heights = terrain.heights
    low, high = (np.array(corner) for corner in terrain.extent)
    ceiling = float(np.ceil(heights.max() / 10) * 10) + 150.0
    starts, targets = (_above(terrain, places) for places in (_STARTS, _TARGETS))
    return Scenario(
        name="jacksboro",
        description="Five UAVs over the ridges beside the Jacksboro fault, Tennessee, on the terrain of the USGS.",
        bounds=Bounds(min=(*low.tolist(), float(np.floor(heights.min() / 10) * 10)), max=(*high.tolist(), ceiling)),
        terrain=terrain,
        clearance=10.0,
        lattice=Lattice(step=(100.0, 100.0, 25.0), connectivity=26),
        objective=Objective(
            unit="metres",
            altitude=AltitudeBand(low=40.0, high=120.0, weight=0.01, above="ground"),
            climb=ClimbLimit(angle=20.0, weight=5.0),
        ),
        uavs=tuple(
            UAV(start=start, max_speed=15.0, max_acceleration=3.5, max_jerk=20.0, separation=10.0) for start in starts
        ),
        targets=tuple(Target(position=position) for position in targets),
        frame=Frame(origin=JACKSBORO_ORIGIN),
        sources=(
            Source(
                file=ELEVATION_FILE,
                gives="terrain",
                licence="USGS, public domain; shipped with matplotlib",
                crs="EPSG:4326",
            ),
        ),
    )


def _terrain() -> Terrain:
    """Return the elevation model in the local frame: bilinear, and raised so that none of its heights lies above it."""
    from matplotlib.cbook import get_sample_data

    file: Any = get_sample_data(ELEVATION_FILE)  # an opened .npz
    with file:
        heights = file["elevation"].astype(np.float64)
        west, north, pitch = float(file["xmin"]), float(file["ymin"]), float(file["dx"])  # its ymin is its first row
    x, y = (np.arange(-side / 2, side / 2 + TERRAIN_STEP, TERRAIN_STEP) for side in TERRAIN_SIDES)
    nodes = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((len(x), len(y)))], axis=-1).reshape(-1, 3)
    places = to_wgs84(JACKSBORO_ORIGIN, nodes)
    sea = _between(heights, (north - places[:, 0]) / pitch - 0.5, (places[:, 1] - west) / pitch - 0.5)
    ground = sea.reshape(len(x), len(y)) - JACKSBORO_ORIGIN.altitude
    rows, columns = np.indices(heights.shape)
    given = np.stack([north - (rows + 0.5) * pitch, west + (columns + 0.5) * pitch, heights], axis=-1).reshape(-1, 3)
    u, v, z = (to_local(JACKSBORO_ORIGIN, given) - [x[0], y[0], 0.0]).T / [[TERRAIN_STEP], [TERRAIN_STEP], [1.0]]
    inside = (u >= 0) & (u <= len(x) - 1) & (v >= 0) & (v <= len(y) - 1)
    short = z[inside] - _between(ground, u[inside], v[inside])
    i, j = u[inside].astype(int), v[inside].astype(int)
    lift = np.zeros((len(x) + 1, len(y) + 1))
    for corner in ((0, 0), (1, 0), (0, 1), (1, 1)):
        np.maximum.at(lift, (i + corner[0], j + corner[1]), short)
    return Terrain(
        origin=(float(x[0]), float(y[0])),
        step=(TERRAIN_STEP, TERRAIN_STEP),
        heights=np.round(ground + lift[:-1, :-1] + 0.005, 2),
        clearance=30.0,
    )


def _between(heights: Floats, row: Floats, column: Floats) -> Floats:
    """Return heights at fractional rows and columns, by bilinear interpolation."""
    return Terrain(origin=(0.0, 0.0), step=(1.0, 1.0), heights=heights).height(np.column_stack([row, column]))


def _above(terrain: Terrain, places: tuple[tuple[float, float], ...]) -> list[tuple[float, float, float]]:
    """Return local positions `END_HEIGHT` above the ground at places given as latitude and longitude."""
    flat = to_local(JACKSBORO_ORIGIN, [(*place, JACKSBORO_ORIGIN.altitude) for place in places])[:, :2].round(1)
    heights = (terrain.height(flat) + END_HEIGHT).round(1)
    return [(float(x), float(y), float(z)) for (x, y), z in zip(flat, heights, strict=True)]
