"""From files of maps to files of ground stations, by the command line alone; opened again by others' software.

What comes out is held against what went in, never against the scenario between: the terrain's pixels, the buildings'
corners, the places as they were typed.
"""

import json
import os
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from skyverse.cli import main

pyproj = pytest.importorskip("pyproj", reason="reading maps needs pyproj")
rasterio = pytest.importorskip("rasterio", reason="reading terrain needs rasterio")
pyogrio = pytest.importorskip("pyogrio", reason="reading GeoJSON as others do needs pyogrio")
shapely = pytest.importorskip("shapely", reason="reading buildings needs shapely")
mavwp = pytest.importorskip("pymavlink.mavwp", reason="reading waypoints as ground stations do needs pymavlink")

DATA = Path(os.environ.get("SKYVERSE_DATA", Path(__file__).parents[3] / "shared" / "data"))
TAKEOFF, WAYPOINT, LOITER = 22, 16, 17
ABOVE_HOME, ABOVE_SEA = 3, 0


def run(*words):
    with pytest.raises(SystemExit) as ended:
        main([*map(str, words)])
    assert not ended.value.code, words


def flights(folder, stem, names, frame):
    """Home, and latitude, longitude and altitude of what each UAV flies, by pymavlink."""
    found = {}
    for name in names:
        loader = mavwp.MAVWPLoader()
        loader.load(str(folder / f"{stem}-{name}.waypoints"))
        home, *items = (loader.wp(k) for k in range(loader.count()))
        flown = [item for item in items if item.command in (TAKEOFF, WAYPOINT, LOITER)]
        assert {item.frame for item in flown} == {frame}
        places = np.array([(item.x, item.y, item.z) for item in flown])
        places[places[:, 0] == 0, :2] = home.x, home.y  # a takeoff is straight up
        found[name] = np.array([home.x, home.y, home.z]), places
    return found


def along(places, steps=400):
    """Straight on the map and in altitude, from place to place."""
    share = np.linspace(0, 1, steps)[:, None]
    return np.concatenate([a + share * (b - a) for a, b in pairwise(places)])


@pytest.mark.skipif(not (DATA / "davosdorf.tif").is_file(), reason="the terrain of Davos is not here")
def test_five_uavs_over_davos_fly_as_high_above_home_and_above_the_files_terrain_as_they_were_told_to(tmp_path):
    from scipy.ndimage import map_coordinates

    with rasterio.open(DATA / "davosdorf.tif") as file:
        heights, to_pixel = file.read(1).astype(float), ~file.transform
        to_metres = pyproj.Transformer.from_crs(4326, file.crs, always_xy=True)

    def terrain(places):
        places = np.atleast_2d(places)
        columns, rows = to_pixel @ np.array(to_metres.transform(places[:, 1], places[:, 0]))
        return map_coordinates(heights, [rows - 0.5, columns - 0.5], order=1)

    names = "abcde"
    starts = {name: (46.812 + 0.0005 * k, 9.845 + 0.001 * k) for k, name in enumerate(names)}
    goals = [(46.82 + 0.001 * k, 9.83 + 0.001 * k) for k in range(5)]
    words = ["--terrain", DATA / "davosdorf.tif", "--ground-clearance", 15]
    for name, (latitude, longitude) in starts.items():
        words += ["--uav", f"{name}={latitude},{longitude},60 m home"]
    for latitude, longitude in goals:
        words += ["--target", f"{latitude},{longitude},80 m agl"]
    run("scenario", "build", *words, "-o", tmp_path / "davos.json")
    run("plan", tmp_path / "davos.json", "--planner", "taut", "--seed", 1, "--no-page", "-o", tmp_path / "m.json")
    run("export", tmp_path / "m.json", tmp_path / "m.waypoints", "--altitude", "home")
    run("export", tmp_path / "m.json", tmp_path / "m.geojson", "--geoid", 52)
    ends = []
    for name, (home, flown) in flights(tmp_path, "m", names, ABOVE_HOME).items():
        assert home[:2] == pytest.approx(starts[name], abs=1e-6)
        assert home[2] == pytest.approx(terrain(starts[name])[0], abs=0.05)
        assert flown[0] == pytest.approx((*starts[name], 60), abs=1e-3)
        ends.append(flown[-1, :2].round(6).tolist())
        at = along(flown)
        above = home[2] + at[:, 2] - terrain(at)
        assert above.min() >= 14.9
        assert 79.9 <= above[-1] <= 102  # the ground is raised by 22 m at most
    assert np.array(sorted(ends)) == pytest.approx(np.array(sorted(map(list, goals))), abs=2e-6)
    _, _, shapes, (kinds, *_) = pyogrio.raw.read(tmp_path / "m.geojson", columns=["kind"])
    lines = [shape for shape in shapely.from_wkb(shapes) if shape.geom_type == "LineString"]
    assert len(kinds) >= 10
    firsts = sorted(line.coords[0] for line in lines)
    for first, (latitude, longitude) in zip(firsts, starts.values(), strict=True):
        assert first[:2] == pytest.approx((longitude, latitude), abs=1e-6)
        assert first[2] == pytest.approx(terrain((latitude, longitude))[0] + 60 + 52, abs=0.05)


@pytest.mark.skipif(not (DATA / "delft.city.json").is_file(), reason="the Delft buildings are not here")
def test_five_uavs_through_delft_keep_away_from_every_corner_of_its_buildings(tmp_path):
    document = json.loads((DATA / "delft.city.json").read_text())
    transform = document["transform"]
    vertices = np.array(document["vertices"]) * transform["scale"] + transform["translate"]

    def surfaces(boundaries):
        if isinstance(boundaries[0][0], int):
            return [vertices[boundaries[0]]]
        return [ring for inner in boundaries for ring in surfaces(inner)]

    shapes, tops = [], []
    for one in document["CityObjects"].values():
        if one["type"] in ("Building", "Bridge", "PlantCover"):
            rings = [ring for geometry in one["geometry"] for ring in surfaces(geometry["boundaries"])]
            polygons = [shapely.make_valid(shapely.Polygon(ring[:, :2])) for ring in rings]
            shapes.append(shapely.union_all(polygons))
            tops.append(max(ring[:, 2].max() for ring in rings))
    assert len(shapes) > 160
    names = [f"u{k}" for k in range(5)]
    words = ["--buildings", DATA / "delft.city.json", "--ground", "-1 m amsl", "--ceiling", "11 m amsl"]
    words += ["--clearance", 2, "--ground-clearance", 2]
    for k, name in enumerate(names):
        words += ["--uav", f"{name}=52.0103,{4.364 + 0.001 * k:.4f},6 m amsl"]
        words += ["--target", f"52.0141,{4.3644 + 0.001 * k:.4f},6 m amsl"]
    run("scenario", "build", *words, "-o", tmp_path / "delft.yaml")
    options = ["--planner", "taut", "--seed", 1, "--assignment", "identity", "--no-page"]
    run("plan", tmp_path / "delft.yaml", *options, "-o", tmp_path / "m.json")
    run("export", tmp_path / "m.json", tmp_path / "m.waypoints")
    to_metres = pyproj.Transformer.from_crs(4326, 28992, always_xy=True)
    around = 0
    for k, (_, flown) in enumerate(flights(tmp_path, "m", names, ABOVE_SEA).values()):
        assert flown[0] == pytest.approx((52.0103, 4.364 + 0.001 * k, 6), abs=1e-6)
        assert flown[-1] == pytest.approx((52.0141, 4.3644 + 0.001 * k, 6), abs=1e-6)
        at = along(flown)
        assert ((at[:, 2] > 0.9) & (at[:, 2] < 11.03)).all()
        places = shapely.points(*to_metres.transform(at[:, 1], at[:, 0]))
        for shape, top in zip(shapes, tops, strict=True):
            beside = at[:, 2] < top + 1.97
            if beside.any():
                assert shapely.distance(shape, places[beside]).min() >= 1.97
        around += len(flown) > 2
    assert around >= 2
