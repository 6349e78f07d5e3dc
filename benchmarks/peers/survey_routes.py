"""Strips of other planners of surveys: run by the Python of a virtual environment that has them, JSON in, JSON out.

Standard input: {"planner", "camera": {...}, "speed", "areas": [{"shell", "holes"}]}, metres. Standard output: a line
for each area, {"seconds", "plans": [{"how", "strips": [[[x, y], [x, y]], ...]}]}: several settings, the judge picks.

What none of them can be told is left out: take-off places, batteries and the time of turns. Each area is also tried
grown by a quarter and half of the spacing outwards, since none of them sees to it that borders are seen as asked.
"""

import contextlib
import io
import json
import math
import os
import sys
import tempfile
import time
import types
from importlib.metadata import version
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
import shapely

GROWN = (0.0, 0.25, 0.5)
ANGLES = range(0, 180, 5)


def parallel(points, way, area):
    """Return the legs of a path that run along a direction, without those from part to part of an area."""
    legs = np.stack([points[:-1], points[1:]], 1)
    along = legs[:, 1] - legs[:, 0]
    length = np.hypot(along[:, 0], along[:, 1])
    off = np.abs(along[:, 0] * way[1] - along[:, 1] * way[0])
    inside = shapely.dwithin(shapely.points(legs.mean(1)), area, 1e-6)
    return legs[(length > 0.01) & (off < 1e-3 * length) & inside]


def unit_lines(angle):
    """Return unit vectors along and across an angle, radians, and along the one that mirrors it."""
    return [np.array([math.cos(a), math.sin(a)]) for a in (angle, angle + math.pi / 2, -angle, math.pi / 2 - angle)]


def spread(strips):
    """Return metres of strips."""
    return float(np.hypot(*(strips[:, 1] - strips[:, 0]).T).sum())


def opencoverage(area, task):
    from opencoverage import UAV, PinholeCamera, plan

    camera = task["camera"]
    sensor = camera["pixels"][0] * camera["pixel"], camera["pixels"][1] * camera["pixel"]
    one = PinholeCamera(camera["pixel"], camera["focal"], *sensor, camera["interval"])
    uav = UAV(0.0, 1e4, 0.1, task["speed"], task["speed"])
    for pattern in ("back_forth", "long_edge", "optimal_sweep"):
        found = plan(
            polygon=area,
            uav=uav,
            camera=one,
            pattern=pattern,
            forward_overlap=camera["overlap"][0],
            lateral_overlap=camera["overlap"][1],
            target="altitude",
            target_value=camera["height"],
        )
        points = np.array(found.path)
        legs = [leg for leg in np.diff(points, axis=0) if np.hypot(*leg) > 0.0]
        way = max(legs, key=lambda leg: np.hypot(*leg))
        yield pattern, parallel(points, way / np.hypot(*way), area)


def uav_coverage_path_planner(area, task):
    import uav_coverage_path_planner as peer

    camera = task["camera"]
    wide = math.hypot(*camera["pixels"]) * camera["pixel"] / camera["focal"]
    problem = peer.PlanningProblem(
        boundary=tuple(area.exterior.coords[:-1]),
        takeoff_point=area.exterior.coords[0],
        task_height_m=camera["height"],
        camera=peer.CameraProfile(math.degrees(2 * math.atan(wide / 2)), *camera["pixels"], camera["interval"]),
        aircraft=peer.AircraftProfile(task["speed"], 1e7, 1e9, 0.0),
        quality=peer.QualityConstraints(
            camera["pixel"] / camera["focal"] * camera["height"] * 100.0 + 1e-9,
            100.0 * camera["overlap"][1],
            100.0 * camera["overlap"][0],
            task["speed"],
            profile="efficient",
        ),
        optimizer=peer.OptimizationConfig(seed=1),
    )
    found = peer.optimize_coverage_route(problem)
    points = np.array(found.route)[1:-1]
    yield "efficient", np.stack([points[::2], points[1::2]], 1)


def covplan(area, task):
    import covplan.field as peer
    import utm

    base = np.array([500000.0, 5000000.0])
    goals = []

    def straight(s_x, s_y, s_yaw, g_x, g_y, g_yaw, curvature, step_size):
        goals.append(((s_x, s_y), (g_x, g_y)))
        return np.array([s_x, g_x]), np.array([s_y, g_y]), np.array([s_yaw, g_yaw]), "", 0.0

    peer.plan_dubins_path = straight  # turns on circles are for cars; the judge counts straight hops
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "field.txt"
        with file.open("w", encoding="utf-8") as out:
            for ring in (area.exterior, *area.interiors):
                for x, y in ring.coords:
                    print(*(repr(float(v)) for v in utm.to_latlon(x + base[0], y + base[1], 31, "T")), file=out)
                print("NaN NaN", file=out)
        for angle in ANGLES[::3]:  # a KMeans each: slow
            field = peer.Field(file, task["spacing"], 0, angle + 1e-3)
            field.headlandGen()
            field.trackGen()
            if len(field.tracks) < 3:
                continue
            field.cluster(3)
            field.tsp_opt()
            goals.clear()
            field.trajGen(2)
            begins = [goal for _, goal in goals]
            ends = [start for start, _ in goals[1:]] + [tuple(field.traj[-1][:2])]
            yield f"{angle} degrees", np.stack([begins, ends], 1) - base


def coverage_path_planner(area, task):
    import coverage_path_planner as peer

    def polygon(ring):
        return peer.Polygon([peer.Point(float(x), float(y)) for x, y in ring.coords[:-1]])

    for angle in ANGLES:
        environment = peer.Environment(polygon(area.exterior))
        for hole in area.interiors:
            environment.addObstacle(polygon(hole))
        settings = peer.PathSettings()
        settings.pattern, settings.offset, settings.angle = "lines", task["spacing"], math.radians(angle)
        settings.distanceToBorder, settings.mowArea = 0.0, True
        settings.mowBorder = settings.mowExclusionsBorder = False
        settings.borderLaps = settings.exclusionsBorderLaps = 0
        first = area.exterior.coords[0]
        found = peer.PathService().computeFullTask(environment, settings, peer.Point(*map(float, first)))
        points = np.array([(p.x, p.y) for p in found.path.getPoints()])
        if len(points) < 2:
            continue
        # which way its angles turn is not told: the direction of the longest strips is taken
        yield f"{angle} degrees", max((parallel(points, way, area) for way in unit_lines(settings.angle)), key=spread)


def drone_flightplan(area, task):
    for name in ("osgeo", "osgeo.gdal", "osgeo.ogr", "osgeo.osr"):
        sys.modules.setdefault(name, types.ModuleType(name))  # only for heights of ground
    folders = [Path(path) / "drone_flightplan" for path in sys.path]
    package = types.ModuleType("drone_flightplan")
    package.__path__ = [str(path) for path in folders if path.is_dir()]
    sys.modules.setdefault("drone_flightplan", package)
    from drone_flightplan.waypoints import calculate_optimal_rotation_angle, create_path, generate_grid_in_aoi

    for angle in [calculate_optimal_rotation_angle(area), *range(0, 180, 15)]:
        grid = generate_grid_in_aoi(area, task["step"], task["spacing"], angle, 100.0 * task["camera"]["overlap"][1])
        path = create_path(grid, task["step"], angle, polygon=area)
        strips, row = [], []
        for point in [*path, {"take_photo": False}]:
            if point["take_photo"]:
                row.append((point["coordinates"].x, point["coordinates"].y))
            elif row:
                strips.append([row[0], row[-1]])
                row = []
        yield f"{angle:.1f} degrees", np.array(strips)


PLANNERS = {
    "opencoverage": opencoverage,
    "uav-coverage-path-planner": uav_coverage_path_planner,
    "covplan": covplan,
    "coverage-path-planner": coverage_path_planner,
    "drone-flightplan": drone_flightplan,
}


def grown(area, by):
    """Return an area grown outwards, its holes as they are."""
    shell = shapely.buffer(shapely.Polygon(area.exterior), by, join_style="mitre", mitre_limit=2.0)
    area = shapely.Polygon(shell.exterior, [hole.coords for hole in area.interiors])
    return shapely.remove_repeated_points(area, 0.01)


def main():
    task = json.load(sys.stdin)
    print(version(task["planner"]), flush=True)
    for given in task["areas"]:
        area = shapely.Polygon(given["shell"], given["holes"])
        plans, fault, begun = [], "", time.perf_counter()
        for share in GROWN:
            try:
                with contextlib.redirect_stdout(io.StringIO()):
                    for how, strips in PLANNERS[task["planner"]](grown(area, share * task["spacing"]), task):
                        if len(strips):
                            how_grown = f"{how}, grown by {share} of the spacing" if share else how
                            plans.append({"how": how_grown, "strips": np.round(strips, 6).tolist()})
            except Exception as error:  # a peer's fault is a result
                fault = f"{type(error).__name__}: {error}"
        print(json.dumps({"seconds": time.perf_counter() - begun, "fault": fault, "plans": plans}), flush=True)


if __name__ == "__main__":
    main()
