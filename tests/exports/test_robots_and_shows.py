"""Missions for ROS, for light shows and for DJI, read back by rosbags, or as their own importers read them."""

import csv
import json
import zipfile
from xml.etree import ElementTree as ET

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky

pytestmark = pytest.mark.usefixtures("unjudged")


def load(file):
    if file.suffix == ".json":
        return json.loads(file.read_text())
    from ruamel.yaml import YAML

    return YAML(typ="safe").load(file.read_text())


def message(store, kind, data):
    """Build a message of data, field by field: a missing, surplus or wrong one is an error."""
    definition = dict(store.fielddefs[kind][1])
    assert set(definition) == set(data), kind
    values = {}
    for name, (node, of) in definition.items():
        values[name] = field(store, node, of, data[name])
    return store.types[kind](**values)


def field(store, node, of, value):
    from rosbags.interfaces import Nodetype

    if node == Nodetype.BASE:
        expected = {"float64": float, "int32": int, "uint32": int, "string": str}[of[0]]
        assert isinstance(value, expected), (of, value)
        return value
    if node == Nodetype.NAME:
        return message(store, of, value)
    inner, kind = of[0]
    return [field(store, inner, kind, one) for one in value]


@pytest.mark.parametrize("suffix", [".json", ".yaml"])
def test_ros_messages_have_exactly_the_fields_of_their_types_and_the_same_places(tmp_path, suffix):
    typesys = pytest.importorskip("rosbags.typesys", reason="knows ROS messages")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    for seed in range(10 if suffix == ".json" else 1):
        mission = handmade.random_mission(seed)
        paths = sky.export(mission, tmp_path / f"m{seed}.path{suffix}", sky.ExportOptions(rate=1))
        moves = sky.export(mission, tmp_path / f"m{seed}.trajectory{suffix}", sky.ExportOptions(rate=1))
        for trajectory, path, move in zip(mission.trajectories, paths, moves, strict=True):
            kind = "nav_msgs/msg/Path"
            told = store.deserialize_cdr(store.serialize_cdr(message(store, kind, load(path)), kind), kind)
            times = [p.header.stamp.sec + p.header.stamp.nanosec / 1e9 for p in told.poses]
            places = [(p.pose.position.x, p.pose.position.y, p.pose.position.z) for p in told.poses]
            np.testing.assert_allclose(places, trajectory.at(times).position, atol=1e-6)
            assert {p.header.frame_id for p in told.poses} == {"map"}
            kind = "trajectory_msgs/msg/MultiDOFJointTrajectory"
            told = store.deserialize_cdr(store.serialize_cdr(message(store, kind, load(move)), kind), kind)
            times = [p.time_from_start.sec + p.time_from_start.nanosec / 1e9 for p in told.points]
            assert times[0] == pytest.approx(trajectory.start)
            assert times[-1] == pytest.approx(trajectory.end)
            motion = trajectory.at(times)
            speeds = [(v.x, v.y, v.z) for p in told.points for v in [p.velocities[0].linear]]
            np.testing.assert_allclose(speeds[1:-1], motion.velocity[1:-1], atol=1e-4)
            places = [(v.x, v.y, v.z) for p in told.points for v in [p.transforms[0].translation]]
            np.testing.assert_allclose(places, motion.position, atol=1e-6)


def test_yaml_has_numbers_for_readers_of_the_older_standard(tmp_path):
    mission = handmade.mission([handmade.along([(1e-7, 0, 5), (1e-5, 3e-9, 6)], 3)])
    (file,) = sky.export(mission, tmp_path / "m.path.yaml")
    for word in file.read_text().replace(",", " ").replace("}", " ").split():
        if "e-" in word:
            assert "." in word.split("e-")[0]


def show(file):
    """Read a show as Skybrush Studio's importer does."""
    read = {}
    with zipfile.ZipFile(file) as archive:
        for name in archive.namelist():
            lines = archive.read(name).decode("ascii").splitlines()
            rows = list(csv.reader(lines))
            assert rows[0][0].lower().startswith("time_msec")
            assert name.removesuffix(".csv") not in read
            read[name.removesuffix(".csv")] = np.array([[float(v) for v in row] for row in rows[1:]])
            assert all(int(v) == 255 for row in rows[1:] for v in row[4:7])
    return read


def test_shows_have_a_file_for_each_drone_and_all_last_as_long(tmp_path):
    for seed in range(30):
        mission = handmade.random_mission(seed)
        (file,) = sky.export(mission, tmp_path / f"m{seed}.skybrush.zip")
        drones = show(file)
        assert len(drones) == len(mission.trajectories)
        end = max(t.end for t in mission.trajectories)
        for rows, trajectory in zip(drones.values(), mission.trajectories, strict=True):
            assert rows[0, 0] == 0
            assert rows[-1, 0] == pytest.approx(1000 * end, abs=1)
            assert (np.diff(rows[:, 0]) > 0).all()
            there = trajectory.at(rows[:, 0] / 1000).position
            assert np.linalg.norm(rows[:, 1:4] - there, axis=1).max() < 0.03  # half a millisecond at full speed


WPML = "{http://www.dji.com/wpmz/1.0.2}"
KML = "{http://www.opengis.net/kml/2.2}"
CONFIG = ["flyToWaylineMode", "finishAction", "exitOnRCLost", "executeRCLostAction", "takeOffSecurityHeight"]
CONFIG += ["globalTransitionalSpeed", "droneInfo", "payloadInfo"]
MARK = ["index", "executeHeight", "waypointSpeed", "waypointHeadingParam", "waypointTurnParam", "useStraightLine"]


def words(element):
    return [child.tag.removeprefix(WPML) for child in element if child.tag.startswith(WPML)]


@pytest.mark.parametrize("above", ["amsl", "home", "agl"])
def test_waylines_have_all_that_dji_requires_and_the_same_places(tmp_path, above, refuses):
    pytest.importorskip("pyproj", reason="an independent geodesy")
    modes = {"amsl": "WGS84", "home": "relativeToStartPoint", "agl": "realTimeFollowSurface"}
    for seed in range(12):
        mission = handmade.random_mission(seed, terrain=above == "agl")
        if mission.scenario.uavs[0].fixed_wing is not None:
            with refuses():
                sky.export(mission, tmp_path / "m.wpml.kmz")
            continue
        routes, begins = sky.routes(mission, altitude=above, takeoff=1.2, stops=True), []  # DJI's least rise
        for route, file in zip(
            routes, sky.export(mission, tmp_path / f"m{seed}.wpml.kmz", sky.ExportOptions(altitude=above)), strict=True
        ):
            with zipfile.ZipFile(file) as archive:
                assert archive.namelist() == ["wpmz/template.kml", "wpmz/waylines.wpml"]
                template, lines = (ET.fromstring(archive.read(name)) for name in archive.namelist())
            height = ["globalRTHHeight"]  # DJI's waylines have it, its templates do not
            for document, more in ((template, []), (lines, height)):
                expected = [*CONFIG[:6], *more, *CONFIG[6:]]
                assert words(document.find(f"{KML}Document/{WPML}missionConfig")) == expected
            folder = lines.find(f"{KML}Document/{KML}Folder")
            assert folder.findtext(f"{WPML}executeHeightMode") == modes[above]
            marks = folder.findall(f"{KML}Placemark")
            assert [m.findtext(f"{WPML}index") for m in marks] == [str(k) for k in range(len(route.waypoints))]
            assert all([w for w in words(m) if w != "actionGroup"] == MARK for m in marks)
            assert all(0 < float(m.findtext(f"{WPML}waypointSpeed")) <= 15 for m in marks)
            waits = [float(e.text) for e in lines.iter(f"{WPML}hoverTime")]
            begins.append(sum(waits) + handmade.climb(mission.scenario, route) / 3.0 - route.times[0])
            globe = [m.findtext(f"{KML}Point/{KML}coordinates").split(",") for m in marks]
            longitude, latitude = np.array(globe, dtype=float).T
            height = np.array([float(m.findtext(f"{WPML}executeHeight")) for m in marks])
            if above == "amsl":
                back = handmade.local(mission.scenario.frame.origin, latitude, longitude, height)
                assert np.linalg.norm(back - route.waypoints, axis=1).max() < 0.01
            elif above == "home":
                assert height[0] == pytest.approx(1.2, abs=0.01)
            else:
                assert height == pytest.approx(
                    route.waypoints[:, 2] - handmade.under(mission.scenario, route.waypoints), abs=0.02
                )
