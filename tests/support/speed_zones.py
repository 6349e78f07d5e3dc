"""Zones with speed limits for tests, and an independent answer to which places they hold."""

import numpy as np
import shapely

import skyverse as sky

BOX = sky.Box(min=(-10, -8, 0), max=(12, 9, 40), max_speed=2.0, name="school")
CYLINDER = sky.Cylinder(centre=(3, -2), radius=11, low=0, high=30, max_speed=3.0)
SPHERE = sky.Sphere(centre=(0, 5, 15), radius=14, max_speed=1.5)
PRISM = sky.Prism(vertices=((-15, -9), (14, -9), (14, 12), (0, 2), (-15, 12)), low=2, high=35, max_speed=2.5)
VOXELS = sky.Voxels(
    origin=(-9, -9, 0), step=(6, 6, 12), occupied=np.arange(27).reshape(3, 3, 3) % 2 == 0, max_speed=2.0
)
ZONES = (BOX, CYLINDER, SPHERE, PRISM, VOXELS)


def holds(zone, points):
    """Whether each of (n, 3) points is inside a zone, by other means than the library's."""
    x, y, z = points.T
    if isinstance(zone, sky.Sphere):
        return np.linalg.norm(points - zone.centre, axis=1) < zone.radius
    if isinstance(zone, sky.Voxels):
        places = (points - zone.origin) / zone.step
        cells = np.floor(places).astype(int)
        within = [all(0 <= k < 3 for k in cell) and bool(zone.occupied[tuple(cell)]) for cell in cells.tolist()]
        return np.array(within) & (places != cells).all(axis=1)
    low, high = (zone.min[2], zone.max[2]) if isinstance(zone, sky.Box) else (zone.low, zone.high)
    if isinstance(zone, sky.Box):
        area = shapely.box(*zone.min[:2], *zone.max[:2])
    elif isinstance(zone, sky.Cylinder):
        return (np.hypot(x - zone.centre[0], y - zone.centre[1]) < zone.radius) & (low < z) & (z < high)
    else:
        area = shapely.Polygon(zone.vertices)
    return shapely.contains_xy(area, x, y) & (low < z) & (z < high)


def world_of(*zones, obstacles=(), uavs=(), targets=(), error=None, **more):
    """Return a scenario of 200 m with zones."""
    return sky.Scenario(
        name="slow",
        bounds=sky.Bounds(min=(-100, -100, 0), max=(100, 100, 80)),
        obstacles=obstacles,
        zones=zones,
        clearance=1.0,
        lattice=sky.Lattice(step=(5, 5, 5)),
        objective=sky.Objective(unit="metres"),
        uavs=uavs,
        targets=targets,
        **more,
    )


def too_fast(zones, trajectory, step=0.01, depth=0.0):
    """The largest speed inside a zone, by some depth, beyond its limit, m/s, at instants `step` seconds apart."""
    motion = trajectory.at(np.arange(trajectory.start, trajectory.end, step))
    speed = np.linalg.norm(motion.velocity, axis=1)
    around = [motion.position + way for way in depth * np.vstack([np.eye(3), -np.eye(3)])]
    inside = [np.all([holds(zone, places) for places in around], axis=0) for zone in zones]
    return max(
        float((speed - zone.max_speed)[held].max(initial=-np.inf)) for zone, held in zip(zones, inside, strict=True)
    )
