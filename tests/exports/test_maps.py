"""Missions for maps, read back by fastkml, GDAL and gpxpy."""

import csv
import dataclasses
import zipfile
from datetime import datetime

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse import Origin

pytestmark = pytest.mark.usefixtures("unjudged")

pytest.importorskip("pyproj", reason="an independent geodesy")

SECOND_0 = datetime.fromisoformat("2000-01-01T00:00:00+00:00")


def places_of(mission, flight, rows):
    """Longitude, latitude, altitude above the sea of somebody's reader, in local metres."""
    longitude, latitude, altitude = np.array(rows, dtype=float).T
    return handmade.local(mission.scenario.frame.origin, latitude, longitude, altitude)


def same_path(mission, uav, times, back):
    there = mission.trajectories[uav].at(times).position
    assert len(back) == len(times)
    assert np.linalg.norm(back - there, axis=1).max() < 0.01


def seconds(when):
    return (when - SECOND_0).total_seconds()


@pytest.mark.parametrize("suffix", [".kml", ".kmz"])
def test_kml_read_by_fastkml_has_the_same_paths_and_tracks(tmp_path, suffix):
    kml = pytest.importorskip("fastkml", reason="reads KML").KML
    from fastkml import Placemark
    from fastkml.enums import AltitudeMode
    from fastkml.gx import Track
    from fastkml.utils import find_all

    for seed in range(20):
        mission = handmade.random_mission(seed)
        (file,) = sky.export(mission, tmp_path / f"m{seed}{suffix}", sky.ExportOptions(rate=1))
        if suffix == ".kmz":
            with zipfile.ZipFile(file) as archive:
                assert archive.namelist() == ["doc.kml"]
                text = archive.read("doc.kml")
        else:
            text = file.read_bytes()
        read = kml.from_string(text.decode().split("\n", 1)[1])
        marks = list(find_all(read, of_type=Placemark))
        lines = [m for m in marks if type(m.kml_geometry).__name__ == "LineString"]
        assert [m.name for m in lines] == [uav.name.strip() for uav in mission.scenario.uavs]
        for uav, mark in enumerate(lines):
            assert mark.kml_geometry.altitude_mode is AltitudeMode.absolute
            assert mark.kml_geometry.extrude
            back = places_of(mission, uav, mark.kml_geometry.geometry.coords)
            track = list(find_all(read, of_type=Track))[uav]
            times = [seconds(item.when.dt) for item in track.track_items]
            again = places_of(mission, uav, [item.coord.coords[0] for item in track.track_items])
            same_path(mission, uav, times, again)
            kept = np.r_[True, np.any(np.diff(again, axis=0) != 0, axis=1)]  # repeated places are dropped
            np.testing.assert_allclose(again[kept], back, atol=1e-6)


def test_kml_above_ground_has_the_height_above_the_terrain(tmp_path):
    fastkml = pytest.importorskip("fastkml", reason="reads KML")
    from fastkml.enums import AltitudeMode
    from fastkml.utils import find_all

    mission = handmade.random_mission(7, terrain=True)
    (file,) = sky.export(mission, tmp_path / "m.kml", sky.ExportOptions(altitude="agl", rate=1))
    read = fastkml.KML.from_string(file.read_text().split("\n", 1)[1])
    mark = next(m for m in find_all(read, of_type=fastkml.Placemark) if type(m.kml_geometry).__name__ == "LineString")
    assert mark.kml_geometry.altitude_mode is AltitudeMode.relative_to_ground
    rows = np.array(mark.kml_geometry.geometry.coords)
    origin = mission.scenario.frame.origin
    flat = handmade.local(origin, rows[:, 1], rows[:, 0], np.full(len(rows), origin.altitude))
    start = mission.trajectories[0].at([mission.trajectories[0].start]).position
    assert rows[0, 2] == pytest.approx(start[0, 2] - handmade.under(mission.scenario, start)[0], abs=0.01)
    assert len(flat) == len(rows)


def test_geojson_read_by_gdal_has_the_same_paths(tmp_path):
    raw = pytest.importorskip("pyogrio", reason="reads GeoJSON").raw
    shapely = pytest.importorskip("shapely", reason="reads what GDAL hands on")
    for seed in range(30):
        mission = handmade.random_mission(seed)
        (file,) = sky.export(mission, tmp_path / f"m{seed}.geojson", sky.ExportOptions(rate=1))
        meta, _, geometries, columns = raw.read(file)
        assert meta["crs"] == "EPSG:4326"
        fields = dict(zip(meta["fields"], columns, strict=True))
        paths = [k for k, kind in enumerate(fields["kind"]) if kind == "path"]
        assert [fields["name"][k] for k in paths] == [uav.name for uav in mission.scenario.uavs]
        for uav, k in enumerate(paths):
            shape = shapely.from_wkb(geometries[k])
            parts = [shape] if shape.geom_type == "LineString" else list(shape.geoms)
            rows = np.concatenate([shapely.get_coordinates(part, include_z=True) for part in parts])
            if len(parts) > 1:
                rows = rows[np.abs(rows[:, 0]) != 180]
            times = (
                [float(t) for t in str(fields["times"][k]).strip("[] ").split(",")]
                if isinstance(fields["times"][k], str)
                else fields["times"][k]
            )
            same_path(mission, uav, np.asarray(times, dtype=float), places_of(mission, uav, rows))


def test_no_line_in_geojson_spans_the_antimeridian(tmp_path):
    import json

    origin = Origin(latitude=-17, longitude=180, altitude=20, geoid=0)
    mission = handmade.mission([handmade.along([(-200, 0, 50), (200, 30, 60), (-100, 50, 60)], 20)], origin=origin)
    (file,) = sky.export(mission, tmp_path / "m.geojson", sky.ExportOptions(rate=1))
    shape = json.loads(file.read_text())["features"][0]["geometry"]
    assert shape["type"] == "MultiLineString"
    assert len(shape["coordinates"]) == 3
    for part in shape["coordinates"]:
        longitudes = np.array(part)[:, 0]
        assert np.ptp(longitudes) < 1
        assert np.abs(longitudes).max() <= 180


def test_gpx_read_by_gpxpy_has_the_same_tracks(tmp_path):
    gpxpy = pytest.importorskip("gpxpy", reason="reads GPX")
    for seed in range(30):
        mission = handmade.random_mission(seed)
        (file,) = sky.export(mission, tmp_path / f"m{seed}.gpx", sky.ExportOptions(rate=1))
        read = gpxpy.parse(file.read_text())
        assert read.version == "1.1"
        assert [track.name for track in read.tracks] == [uav.name for uav in mission.scenario.uavs]
        for uav, track in enumerate(read.tracks):
            points = track.segments[0].points
            rows = [(p.longitude, p.latitude, p.elevation) for p in points]
            same_path(mission, uav, [seconds(p.time) for p in points], places_of(mission, uav, rows))
        assert len(read.waypoints) == len(mission.scenario.targets)


def test_a_table_has_places_on_the_globe_beside_local_metres(tmp_path):
    for seed in range(10):
        mission = handmade.random_mission(seed)
        (file,) = sky.export(mission, tmp_path / f"m{seed}.geo.csv", sky.ExportOptions(rate=2))
        rows = list(csv.DictReader(file.read_text().splitlines()))
        for uav, vehicle in enumerate(mission.scenario.uavs):
            own = [row for row in rows if row["uav"] == vehicle.name]
            globe = [(float(r["longitude"]), float(r["latitude"]), float(r["altitude_amsl_m"])) for r in own]
            same_path(mission, uav, [float(r["t"]) for r in own], places_of(mission, uav, globe))


def test_heights_above_the_ellipsoid_count_the_geoid(tmp_path):
    import json

    origin = Origin(latitude=46.8, longitude=9.8, altitude=1500, geoid=52.5)
    mission = handmade.mission([handmade.along([(0, 0, 50), (100, 0, 50)], 20)], origin=origin)
    (file,) = sky.export(mission, tmp_path / "m.geojson")
    path = json.loads(file.read_text())["features"][0]
    assert path["geometry"]["coordinates"][0][2] == pytest.approx(1602.5, abs=1e-3)
    assert path["properties"]["altitudes"][0] == pytest.approx(1550, abs=1e-3)


def test_a_known_geoid_is_kept_for_another_origin_nearby_only(tmp_path, refuses):
    flight = [handmade.along([(0, 0, 50), (100, 0, 50)], 20)]
    mission = handmade.mission(flight, origin=Origin(latitude=46.8, longitude=9.8, altitude=1500, geoid=52.5))
    (file,) = sky.export(
        mission, tmp_path / "m.geojson", sky.ExportOptions(origin=Origin(latitude=46.81, longitude=9.8, altitude=1600))
    )
    assert "1702.5" in file.read_text()
    with refuses():
        sky.export(
            mission, tmp_path / "m.geojson", sky.ExportOptions(origin=Origin(latitude=40, longitude=9.8, altitude=1600))
        )


def test_waylines_above_the_sea_are_written_above_the_ellipsoid(tmp_path):
    flight = [handmade.along([(0, 0, 50), (100, 0, 50)], 20)]
    mission = handmade.mission(flight, origin=Origin(latitude=46.8, longitude=9.8, altitude=1500, geoid=52.5))
    (file,) = sky.export(mission, tmp_path / "m.wpml.kmz")
    with zipfile.ZipFile(file) as archive:
        text = archive.read("wpmz/waylines.wpml")
    assert b"<wpml:executeHeight>1603.7" in text  # DJI's aircraft first rise by 1.2 m
    assert b"<wpml:executeHeight>1602.5" in text


def test_the_command_line_takes_an_origin_with_its_frame_and_a_geoid(tmp_path, refuses):
    from skyverse.cli.export import PlaceOptions, export
    from skyverse.cli.places import origin_of

    mission = handmade.mission([handmade.along([(0, 0, 50), (100, 0, 50)], 20)])
    sky.write(mission, tmp_path / "m.json")
    assert origin_of("47.39,8.54,410 m amsl") == Origin(latitude=47.39, longitude=8.54, altitude=410)
    for text in ("47.39,8.54,410", "47.39,8.54,410 m agl", "47.39,8.54", "a,8,4 amsl"):
        with refuses():
            origin_of(text)
    for text in ("470,8,4 m amsl", "47,800,4 m amsl"):
        with refuses():
            origin_of(text)
    out = tmp_path / "m.geojson"
    with refuses():
        export(str(tmp_path / "m.json"), out, place=PlaceOptions(origin="47.39,8.54,410 m amsl"))
    export(str(tmp_path / "m.json"), out, place=PlaceOptions(origin="47.39,8.54,410 m amsl", geoid=48.0))
    assert "508.0" in out.read_text()


def test_what_is_made_of_maps_is_not_moved_and_who_is_left_out_is_told(tmp_path, refuses):
    flights = [handmade.along([(0, y, 50), (100, y, 50)], 20) for y in (0, 30)]
    mission = handmade.mission(flights, origin=Origin(latitude=46.8, longitude=9.8, altitude=1500))
    alone = dataclasses.replace(mission, trajectories=(flights[0], None))
    told = []
    sky.export(alone, tmp_path / "m.kml", on_note=told.append)
    assert told == ["Left out, for want of a trajectory: uav-2."]
    mapped = mission.scenario.model_copy(update={"sources": (sky.Source(file="dem.tif", gives="terrain"),)})
    real = dataclasses.replace(mission, scenario=mapped)
    with refuses():
        sky.export(real, tmp_path / "m.kml", sky.ExportOptions(origin=Origin(latitude=9.8, longitude=46.8, altitude=0)))


def test_a_kmz_says_that_aircraft_of_dji_take_another(tmp_path):
    mission = handmade.random_mission(0)
    for suffix, told in ((".kml", []), (".kmz", ["m.kmz"])):
        notes = []
        sky.export(mission, tmp_path / f"m{suffix}", on_note=notes.append)
        assert [note.split()[0] for note in notes if ".wpml.kmz" in note] == told
