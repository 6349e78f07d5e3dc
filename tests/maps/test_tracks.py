"""Recorded tracks become motions: places and instants against other software, and one sentence for each bad file."""

import gzip
import json
from datetime import UTC, datetime, timedelta

import gpxpy.gpx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from proj_map import proj_local

HERE = sky.Origin(latitude=46.8, longitude=9.85, altitude=1500.0, geoid=52.0)


def enu(places, origin=HERE):
    """Local metres of latitudes, longitudes and heights above the ellipsoid, by PROJ."""
    latitude, longitude, height = np.array(places).T
    return proj_local(origin, latitude, longitude, height - origin.geoid)


def written(folder, text, name="track.csv"):
    path = folder / name
    path.write_text(text)
    return path


@given(
    st.lists(st.tuples(st.floats(-500, 500), st.floats(-500, 500), st.floats(0, 300)), min_size=1, max_size=8),
    st.sampled_from([",", ";", "\t"]),
    st.permutations(["t", "x", "y", "z"]),
)
@settings(max_examples=40)
def test_metres_are_read_as_they_stand(tmp_path_factory, places, comma, names):
    rows = [dict(zip("txyz", (3.5 + 2 * k, *place), strict=True)) for k, place in enumerate(places)]
    text = "\n".join([comma.join(names), *(comma.join(repr(row[name]) for name in names) for row in rows)])
    motion = sky.read_track(written(tmp_path_factory.mktemp("csv"), text))
    assert motion.points == tuple(places)
    assert motion.times == tuple(row["t"] for row in rows)


@pytest.mark.parametrize(
    ("column", "said"),
    [
        ("altitude_amsl_m", {}),
        ("altitude_amsl", {"unit": "m"}),
        ("altitude (m)", {"altitude": "amsl"}),
        ("altitude", {"altitude": "amsl", "unit": "m"}),
    ],
)
def test_degrees_are_where_another_library_has_them(tmp_path, column, said):
    places = [(46.801, 9.851, 1700.0), (46.802, 9.849, 1710.5), (46.7985, 9.8475, 1650.25)]
    text = f"time,latitude,longitude,{column}\n" + "".join(
        f"{10 * k},{a},{b},{c}\n" for k, (a, b, c) in enumerate(places)
    )
    motion = sky.read_track(written(tmp_path, text), HERE, **said)
    assert np.allclose(motion.points, enu(np.add(places, (0, 0, 52))), atol=1e-4)
    assert motion.times == (0, 10, 20)


GEOMETRIC = (
    "geoaltitude",
    "geo_altitude",
    "altitude_ellipsoid",
    "altitude_amsl",
    "altitude",
    "alt",
    "ele",
    "elevation",
)
REFERENCE = {"altitude_ellipsoid": None, "altitude_amsl": None, "geoaltitude": None, "geo_altitude": None}


@pytest.mark.parametrize("column", GEOMETRIC)
@pytest.mark.parametrize("spelt", ["{}_{}", "{} ({})", "{} [{}]", "{}"])
def test_a_track_in_feet_is_where_the_same_track_in_metres_is(tmp_path, column, spelt):
    """An aircraft's table in either unit, as receivers and other people's libraries write it."""
    read = []
    for unit, foot in (("m", 1.0), ("ft", 0.3048)):
        name = spelt.format(column, unit)
        text = f"timestamp,icao24,latitude,longitude,{name}\n" + "".join(
            f"{1558732719 + 2 * k},abc123,46.80,{9.85 + k / 1000},{(1500 + 10 * k) / foot:.4f}\n" for k in range(4)
        )
        file = written(tmp_path, text)
        said = {} if column in REFERENCE else {"altitude": "amsl"}
        if spelt.count("{}") == 2:
            read.append(sky.read_track(file, HERE, **said).points)
            other = {"m": "ft", "ft": "m"}[unit]
            with pytest.raises(sky.InputError, match=f"is in {unit}, not in {other}"):
                sky.read_track(file, HERE, **said, unit=other)
        else:
            with pytest.raises(sky.InputError, match=rf"track.csv: {column}: expected word of its unit.*unit: ft"):
                sky.read_track(file, HERE, **said)
            read.append(sky.read_track(file, HERE, **said, unit=unit).points)
    assert np.allclose(*read, atol=1e-3)
    assert np.ptp(read[0], axis=0)[2] == pytest.approx(30, abs=0.1)


def test_only_all_columns_of_the_opensky_network_say_that_altitudes_are_metres(tmp_path, refuses):
    assert sky.read_track(written(tmp_path, STATES), HERE, vehicle="4b1805").points
    for changed in (STATES.replace("geoaltitude", "geo_altitude"), STATES.replace("lat,lon", "latitude,longitude")):
        with refuses():
            sky.read_track(written(tmp_path, changed), HERE, vehicle="4b1805")


@pytest.mark.parametrize("column", ["baroaltitude", "baro_altitude", "alt_baro", "pressure_altitude_ft"])
def test_altitudes_that_follow_the_pressure_are_no_altitudes(tmp_path, column, refuses):
    text = f"t,lat,lon,{column}\n0,46.8,9.85,1600\n5,46.8,9.86,1600\n"
    with refuses():
        sky.read_track(written(tmp_path, text), HERE, altitude="amsl", unit="ft")
    geometric = text.replace(column, f"{column},geoaltitude").replace(",1600", ",1600,1650")
    assert sky.read_track(written(tmp_path, geometric), HERE, unit="m").points[0][2] == pytest.approx(98, abs=1e-3)


STATES = """time,icao24,lat,lon,velocity,heading,vertrate,callsign,onground,baroaltitude,geoaltitude
1700000000,4b1805,46.801,9.851,50,90,0,REGA1,False,1600.2,1750.0
1700000000,3c6444,46.90,9.951,200,90,0,DLH1,False,9000,9100.0
1700000005,3c6444,46.91,9.951,200,90,0,DLH1,False,9000,9100.0
1700000010,4b1805,46.802,9.853,50,90,0,REGA1,False,1600.2,1760.0
1700000013,4b1805,46.803,9.853,50,90,0,REGA1,False,1600.2,1770.0
"""


def test_state_vectors_of_one_aircraft_among_others(tmp_path, refuses):
    file = written(tmp_path, STATES)
    motion = sky.read_track(file, HERE, vehicle="4B1805")
    assert motion.times == (0, 10, 13)
    assert np.allclose(
        motion.points, enu([(46.801, 9.851, 1750), (46.802, 9.853, 1760), (46.803, 9.853, 1770)]), atol=1e-4
    )
    other = sky.read_track(file, HERE, vehicle="3c6444", zero=1700000003)
    assert other.times == (-3, 2)
    assert sky.read_track(file, HERE, vehicle="3c6444", zero="2023-11-14T22:13:20Z").times == (0, 5)
    with refuses():
        sky.read_track(file, HERE)
    with refuses():
        sky.read_track(file, HERE, vehicle="4b1806")
    with refuses():
        sky.read_track(file, HERE, vehicle="4b1805", altitude="amsl")
    with refuses():
        sky.read_track(file, HERE.model_copy(update={"geoid": None}), vehicle="4b1805")


def entry(after, place, flags=0, pressure=5000, extra=None, newer=True):
    """An entry of a trace; newer ones end in the source, the geometric altitude in feet and three more."""
    latitude, longitude, height = place
    feet = None if height is None else height / 0.3048
    row = [after, latitude, longitude, feet if flags & 8 else pressure, 90.0, 45.0, flags, 64, extra]
    return [*row, "adsb_icao", None if flags & 8 else feet, 64, 88, 0.3] if newer else row


def traced(folder, *rows, pack=False, **more):
    text = json.dumps(
        {"icao": "4b1805", "r": "HB-ZRQ", "timestamp": 1700000000.5, "trace": list(rows), **more}
    ).encode()
    path = folder / "trace_full_4b1805.json"
    path.write_bytes(gzip.compress(text) if pack else text)
    return path


FLOWN = [(46.801, 9.851, 1750.0), (46.802, 9.853, 1760.0), (46.803, 9.853, 1770.0)]


@pytest.mark.parametrize("pack", [False, True])
def test_a_trace_of_readsb_is_where_its_geometric_altitudes_are(tmp_path, pack):
    rows = [
        entry(2.0, (46.80, 9.85, None), pressure="ground"),
        entry(10.0, FLOWN[0]),
        entry(14.0, (46.7, 9.7, None)),  # the pressure's altitude alone
        entry(20.0, FLOWN[1], flags=8),
        entry(33.25, FLOWN[2], newer=False, extra={"alt_geom": 1770 / 0.3048, "nac_p": 9, "gva": 2}),
    ]
    motion = sky.read_track(traced(tmp_path, *rows, pack=pack), HERE)
    assert np.allclose(motion.points, enu(FLOWN), atol=1e-4)
    assert motion.times == pytest.approx((0, 10, 23.25))  # after the first that is in the air
    assert sky.read_track(traced(tmp_path, *rows), HERE, vehicle="4B1805", zero=1700000000).times[0] == 10.5


def snapshot(now, *aircraft, **more):
    return json.dumps({"now": now, "messages": 7, "aircraft": list(aircraft), **more})


def heard(place, ago, address="4b1805", **more):
    latitude, longitude, height = place
    return {"hex": address, "lat": latitude, "lon": longitude, "alt_baro": 9000, "alt_geom": height / 0.3048} | {
        "seen_pos": ago, "seen": 0.1, **more
    }  # fmt: skip


SNAPSHOTS = "\n".join(
    (
        snapshot(1700000001.0, heard(FLOWN[0], 1.0), heard(FLOWN[2], 2.5, "3c6444"), {"hex": "aaaaaa", "seen": 0.1}),
        snapshot(1700000002.0, heard(FLOWN[0], 2.1)),  # the same position again, by times that are rounded
        snapshot(1700000011.0, heard(FLOWN[1], 1.0, nac_p=9, gva=2)),
        snapshot(1700000013.5, heard(FLOWN[2], 0.5, nac_p=10), heard(FLOWN[0], 0.0, "3c6444")),
        snapshot(1700000015.5, {"hex": "4b1805", "lat": 46.9, "lon": 9.9, "alt_baro": "ground", "seen_pos": 0.1}),
        "",
    )
)


def test_snapshots_of_a_receiver_one_on_each_line(tmp_path, refuses):
    file = written(tmp_path, SNAPSHOTS, "heard.jsonl")
    motion = sky.read_track(file, HERE, vehicle="4b1805")
    assert np.allclose(motion.points, enu(FLOWN), atol=1e-4)
    assert motion.times == pytest.approx((1.5, 11.5, 14.5))  # after the earliest position of any aircraft
    with refuses():
        sky.read_track(file, HERE)
    with refuses():
        sky.read_track(file, HERE, vehicle="4b1805", gap=9)
    with refuses():
        sky.read_track(file, HERE, vehicle="4b1805", unit="m")
    with refuses():
        sky.read_track(file, HERE.model_copy(update={"geoid": None}), vehicle="4b1805")


@pytest.mark.parametrize("ending", ["gpx", "csv"])
@pytest.mark.parametrize("own", [None, 0.0, 4.0])
@pytest.mark.parametrize("seed", range(4))
def test_a_vehicle_stays_within_its_doubt_where_fixes_share_a_second(tmp_path, ending, own, seed):
    rng = np.random.default_rng(seed)
    times = np.sort(rng.uniform(0, 9, 40))
    steps = rng.uniform(-1, 1, (40, 3)) * [3e-5, 3e-5, 2.0]
    places = np.add([46.8, 9.85, 1600.0], np.cumsum(steps, axis=0))
    stamps = [(datetime(2026, 10, 1, 10, tzinfo=UTC) + timedelta(seconds=int(t))).isoformat() for t in times]
    rows = list(zip(stamps, places.tolist(), strict=True))
    if ending == "gpx":
        marks = "".join(
            f'<trkpt lat="{y!r}" lon="{x!r}"><ele>{z!r}</ele><time>{t}</time></trkpt>' for t, (y, x, z) in rows
        )
        written(tmp_path, f"<gpx><trk><trkseg>{marks}</trkseg></trk></gpx>", "t.gpx")
    else:
        lines = [f"{t},{y!r},{x!r},{z!r}" for t, (y, x, z) in rows]
        written(tmp_path, "\n".join(["time,latitude,longitude,altitude_m", *lines]), "t.csv")
    data = {
        "name": "x",
        "bounds": {"min": [-500, -500, 0], "max": [500, 500, 200]},
        "clearance": 1.0,
        "frame": {"axes": "map", "origin": HERE.model_dump()},
        "uavs": [{"start": [0, 0, 50]}],
        "movers": [
            {"shape": {"shape": "sphere", "centre": [0, 0, 0], "radius": 1}}
            | {"motion": {"track": f"t.{ending}", "altitude": "amsl"}}
            | ({} if own is None else {"doubt": {"radius": own}})
        ],
    }
    (mover,) = sky.read(written(tmp_path, json.dumps(data), "s.json")).movers
    true, when = enu(np.add(places, (0, 0, HERE.geoid))), np.linspace(times[0], times[-1], 500)
    at = np.column_stack([np.interp(when, times, axis) for axis in true.T])
    told = np.column_stack(
        [np.interp(when - int(times[0]), mover.motion.times, axis) for axis in np.array(mover.motion.points).T]
    )
    off = np.linalg.norm(at - told, axis=1).max()
    assert (own or 0.0) + off <= mover.doubt.radius < 40 * off


def test_how_far_positions_of_ads_b_may_be_off_is_their_mover_s_doubt(tmp_path):
    written(tmp_path, SNAPSHOTS, "heard.jsonl")
    scenario = sky.read("map1").model_copy(update={"frame": sky.Frame(origin=HERE)})
    sky.write(scenario, tmp_path / "s.json")
    data = json.loads((tmp_path / "s.json").read_text())
    ball = {"shape": "sphere", "centre": [0, 0, 0], "radius": 5}
    data["movers"] = [{"shape": ball, "motion": {"track": "heard.jsonl", "vehicle": "4b1805"}}]
    (tmp_path / "s.json").write_text(json.dumps(data))
    (mover,) = sky.read(tmp_path / "s.json").movers
    assert mover.doubt.radius == pytest.approx(np.hypot(30, 45))


@pytest.mark.parametrize(
    "text",
    [
        snapshot(1700000001.0, heard(FLOWN[0], 1.0)),
        snapshot(1700000001000.0, heard(FLOWN[0], 1.0)),
        SNAPSHOTS.replace('"alt_geom"', '"alt_g"'),
        SNAPSHOTS.replace('"lon"', '"lng"'),
        SNAPSHOTS.replace('"seen_pos"', '"seen_position"'),
        SNAPSHOTS.replace("46.803", "NaN"),
        SNAPSHOTS.replace("46.803", "1e999"),
        SNAPSHOTS.replace("46.803", "146.803"),
        SNAPSHOTS.replace('"now"', '"then"'),
        SNAPSHOTS[:-300],
        "[1, 2]",
        "{}",
        "",
        "[" * 5000,
        json.dumps({"icao": "4b1805", "timestamp": 1.7e9, "trace": [[1, 2, 3]]}),
        json.dumps({"icao": "4b1805", "timestamp": "yesterday", "trace": [entry(1, FLOWN[0]), entry(2, FLOWN[1])]}),
        json.dumps({"icao": ["4b1805"], "timestamp": 1.7e9, "trace": [entry(1, FLOWN[0]), entry(2, FLOWN[1])]}),
        json.dumps({"icao": "4b1805", "timestamp": 1.7e9, "trace": [entry(3, FLOWN[0]), entry(2, FLOWN[1])]}),
    ],
    ids=map(str, range(18)),
)
def test_bad_json_of_ads_b_gets_one_sentence(tmp_path, text, refuses):
    with refuses():
        sky.read_track(written(tmp_path, text, "heard.jsonl"), HERE, vehicle="4b1805")


def test_a_packed_trace_that_is_cut_off_or_too_large_gets_one_sentence(tmp_path, refuses, monkeypatch):
    whole = traced(tmp_path, entry(1, FLOWN[0]), entry(2, FLOWN[1]), pack=True)
    packed = whole.read_bytes()
    for part in (packed[:-20], packed[:40] + b"?" + packed[41:]):
        whole.write_bytes(part)
        with refuses():
            sky.read_track(whole, HERE)
    monkeypatch.setattr("skyverse.maps.readers.adsb_json.MAX_BYTES", 10_000)
    whole.write_bytes(gzip.compress(b" " * 10_000_000))
    with refuses():
        sky.read_track(whole, HERE)


def gpx(*tracks):
    """A GPX text by another library."""
    whole = gpxpy.gpx.GPX()
    for name, points in tracks:
        track, segment = gpxpy.gpx.GPXTrack(name=name), gpxpy.gpx.GPXTrackSegment()
        whole.tracks.append(track)
        track.segments.append(segment)
        segment.points += [gpxpy.gpx.GPXTrackPoint(*place, time=moment) for moment, place in points]
    return whole.to_xml()


START = datetime(2026, 5, 1, 10, 0, tzinfo=UTC)


def test_gpx_of_another_library(tmp_path, refuses):
    places = [(46.801, 9.851, 1700.0), (46.802, 9.849, 1710.5)]
    glider = [(START + timedelta(seconds=7 + 4.5 * k), place) for k, place in enumerate(places)]
    tug = [(START + timedelta(seconds=k), place) for k, place in enumerate(places)]
    file = written(tmp_path, gpx(("glider", glider), ("tug", tug)), "club.gpx")
    motion = sky.read_track(file, HERE, vehicle="glider", altitude="amsl")
    assert np.allclose(motion.points, enu(np.add(places, (0, 0, 52))), atol=1e-4)
    assert motion.times == (7, 11.5)  # after the first instant in the file
    assert sky.read_track(file, HERE, vehicle="tug", altitude="ellipsoid", zero="2026-05-01T12:00:01+02:00").times == (
        -1,
        0,
    )
    with refuses():
        sky.read_track(file, HERE, altitude="amsl")
    with refuses():
        sky.read_track(file, HERE, vehicle="tug")


@pytest.mark.parametrize("name", ["flown.gpx", "flown.geo.csv", "flown.csv"])
def test_what_skyverse_exports_is_read_as_it_was_flown(tmp_path, name):
    scenario = sky.read("map1").model_copy(update={"frame": sky.Frame(origin=HERE)})
    mission = sky.plan_mission(scenario)
    sky.export(mission, tmp_path / name)
    motion = sky.read_track(tmp_path / name, HERE, altitude="amsl")
    flown = mission.trajectories[0]
    assert np.allclose(motion.at(motion.times), flown.at(np.array(motion.times)).position, atol=2e-3)
    assert motion.times[0] == 0
    assert motion.times[-1] == pytest.approx(flown.end, abs=1e-3)


TABLE = "t,x,y,z\n0,1,2,3\n5,2,2,3\n9,3,2,3\n"
GLOBE = "t,lat,lon,altitude\n0,46.8,9.85,1600\n5,46.8,9.86,1600\n"


@pytest.mark.parametrize(
    "text",
    [
        TABLE.replace("9,3", "5,3"),
        TABLE.replace("9,3", "4,3"),
        TABLE.replace("9,3", "99,3"),
        TABLE.replace("5,2,2", "5,nan,2"),
        TABLE.replace("5,2,2", "5,2,"),
        TABLE.replace("5,2,2", "five,2,2"),
        TABLE.replace("5,2,2", "5,2"),
        TABLE.replace("5,2", "1700000000,2"),
        TABLE.replace("5,2", "1700000000000,2"),
        "t,x,y\n0,1,2\n",
        "",
        "t,x,y,z\n",
        "t,x,y,z,error\n0,1,2,3,-1\n",
        GLOBE,
        GLOBE.replace("46.8,9.86", "96.8,9.86"),
        GLOBE.replace("46.8,9.86", "46.8,190"),
    ],
)
def test_bad_tables_get_one_sentence(tmp_path, text, refuses):
    with refuses():
        sky.read_track(written(tmp_path, text), HERE)


@pytest.mark.parametrize(
    "text",
    [
        "<gpx><trk><trkseg/></trk></gpx>",
        "<gpx/>",
        "<kml/>",
        "<gpx><trk><trkseg><trkpt lat='1' lon='2'/></trkseg></trk></gpx>",
        "<gpx><trk><trkseg><trkpt lat='1' lon='2'><ele>3</ele></trkpt></trkseg></trk></gpx>",
        "<gpx><trk><trkseg><trkpt lat='x' lon='2'/></trkseg></trk></gpx>",
        "<gpx><trk>",
        "<!DOCTYPE gpx><gpx/>",
    ],
)
def test_bad_gpx_gets_one_sentence(tmp_path, text, refuses):
    with refuses():
        sky.read_track(written(tmp_path, text, "track.gpx"), HERE, altitude="amsl")


def test_other_bad_input_gets_one_sentence(tmp_path, refuses):
    file = written(tmp_path, GLOBE)
    with refuses():
        sky.read_track(file, altitude="amsl")
    with refuses():
        sky.read_track(file, HERE, altitude="sea")
    with refuses():
        sky.read_track(file, HERE, altitude="amsl", unit="km")
    with refuses():
        sky.read_track(file, HERE, altitude="amsl", gap=-1)
    with refuses():
        sky.read_track(file, HERE, altitude="amsl", vehicle="a")
    with refuses():
        sky.read_track(file, HERE, altitude="amsl", unit="m", zero="2026-05-01T12:00:01Z")
    with refuses():
        sky.read_track(tmp_path / "track.kml")
    with refuses():
        sky.read_track(tmp_path / "track2.csv")
    (tmp_path / "bytes.csv").write_bytes(b"t,x,y,z\n\xff\xfe")
    with refuses():
        sky.read_track(tmp_path / "bytes.csv")


def test_a_longer_gap_is_a_straight_line_where_the_caller_says_so(tmp_path):
    motion = sky.read_track(written(tmp_path, TABLE.replace("9,3", "105,12")), gap=200)
    assert motion.at(55.0) == pytest.approx(np.array([[7, 2, 3]]))


SAMPLES = {
    "csv": [TABLE, GLOBE, STATES],
    "jsonl": [snapshot(1700000001.0, heard(FLOWN[0], 1.0)) + "\n" + snapshot(1700000006.0, heard(FLOWN[1], 1.0))],
    "gpx": [gpx(("tug", [(START, (46.8, 9.85, 1600.0)), (START + timedelta(seconds=4), (46.8, 9.86, 1600.0))]))],
}


SAID = {"csv": {"altitude": "amsl", "unit": "m"}, "gpx": {"altitude": "amsl"}, "jsonl": {}}


JUNK = [b"", b"nan", b"1e999", b"-", b'"', b",", b"\n", b"\0", b"\xff", b"<a>", b"99999-01-01T:"]


@pytest.mark.parametrize("suffix", SAMPLES)
@given(data=st.data())
@settings(max_examples=150, deadline=None)
def test_damaged_files_end_in_one_sentence(suffix, data, tmp_path_factory):
    whole = bytearray(data.draw(st.sampled_from(SAMPLES[suffix])).encode())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(whole)))
        cut = data.draw(st.sampled_from([0, 0, 1, 30]))
        junk = data.draw(
            st.sampled_from([b"", b"nan", b"1e999", b"-", b'"', b",", b"\n", b"\0", b"\xff", b"<a>", b"99999-01-01T:"])
        )
        whole[at : at + cut] = junk
    path = tmp_path_factory.mktemp("damaged") / f"track.{suffix}"
    path.write_bytes(bytes(whole))
    try:
        motion, said = sky.read_track(path, HERE, **SAID[suffix]), ""
    except sky.InputError as error:
        motion, said = None, str(error)
    assert "\n" not in said
    if motion is None:
        assert "track." in said
    else:
        assert np.isfinite(motion.points).all()
        assert (np.diff(motion.times) > 0).all()
