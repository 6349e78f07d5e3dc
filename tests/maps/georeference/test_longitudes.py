"""Zones are where they are at every longitude: across the antimeridian as elsewhere, and however wide they are."""

import json

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

import skyverse as sky

pyproj = pytest.importorskip("pyproj")
shapely = pytest.importorskip("shapely")

from of_maps import of_maps  # noqa: E402
from skyverse.maps.assembly.obstacles import local_features, prisms, simplified, within_bounds  # noqa: E402
from zones import read_file  # noqa: E402

GEOD = pyproj.Geod(ellps="WGS84")
LIMITS = {"lower": "0 m amsl", "upper": "250 m amsl"}
longitudes = st.one_of(st.floats(-180, 179.99), st.floats(-0.02, 0.02).map(lambda away: wrapped(180 + away)))
offsets = st.tuples(st.floats(-0.02, 0.02), st.floats(-0.02, 0.02))


def wrapped(longitude):
    return (longitude + 180) % 360 - 180


def features(*geometries):
    return {
        "type": "FeatureCollection",
        "features": [{"type": "Feature", "properties": LIMITS, "geometry": geometry} for geometry in geometries],
    }


@pytest.fixture(scope="module")
def zones(tmp_path_factory):
    """Write geometries as a file of zones."""
    folder = tmp_path_factory.mktemp("zones")

    def written(*geometries, name="z.geojson"):
        path = folder / name
        document = geometries[0] if isinstance(geometries[0], str) else json.dumps(features(*geometries))
        path.write_text(document)
        return path

    return written


def shut(path, latitude, longitude, *, buffer=None, wide=5000.0, tolerance=0.0, told=None):
    """Return a frame's origin, and what is shut in it, so many metres around, as one polygon."""
    origin = sky.Origin(latitude=latitude, longitude=wrapped(longitude), altitude=0.0)
    found = read_file(path, buffer=buffer, tell=([] if told is None else told).append)
    cut = local_features(found, origin, (-wide, -wide, wide, wide), None, 10.0)
    made, _ = prisms(simplified(within_bounds(cut, 0.0, 150.0, 10.0), tolerance))
    return origin, shapely.union_all([shapely.Polygon(one.vertices, one.holes) for one in made])


def metres_away(places, corners):
    """Return how far places are from a line, metres: each the middle of its own map, of geodesics to the line."""
    dense = shapely.get_coordinates(shapely.segmentize(shapely.LineString(corners), 2e-4))
    a, b = np.repeat(places, len(dense), axis=0), np.tile(dense, (len(places), 1))
    azimuth, _, far = GEOD.inv(a[:, 0], a[:, 1], b[:, 0], b[:, 1])
    seen = np.column_stack([far * np.sin(np.radians(azimuth)), far * np.cos(np.radians(azimuth))])
    return shapely.distance(shapely.linestrings(seen.reshape(len(places), -1, 2)), shapely.Point(0, 0))


def agree(origin, solid, places, away, width, most):
    """Compare what is shut with what lies within a width, at the ground and at the ceiling."""
    for altitude in (0.0, 150.0):
        rows = np.column_stack([places[:, 1], places[:, 0], np.full(len(places), altitude)])
        flat = sky.to_local(origin, rows)[:, :2]
        within = (np.abs(flat) <= 5000.0).all(axis=1)
        assert within.any()
        found = shapely.covers(solid, shapely.points(flat))
        assert not (within & ~found & (away <= width)).any()
        assert not (within & found & (away > most)).any()


@example(0.0, 0.0, [(0.015625, 0.015625), (0.0, 0.0), (0.015625, 0.015625)], 2000.0, 0.0, 0)
@given(
    middle=longitudes,
    latitude=st.floats(-75, 75),
    corners=st.lists(offsets, min_size=2, max_size=4),
    width=st.sampled_from([5.0, 80.0, 300.0, 2000.0]),
    tolerance=st.sampled_from([0.0, 0.5]),
    seed=st.integers(0, 99),
)
def test_what_lies_within_the_buffer_of_a_line_is_shut_and_nothing_else(
    zones, middle, latitude, corners, width, tolerance, seed
):
    line = np.array([(middle + x, latitude + y) for x, y in corners])
    assume(np.ptp(line, axis=0).max() > 1e-6)
    path = zones({"type": "LineString", "coordinates": [(wrapped(x), y) for x, y in line.tolist()]})
    origin, solid = shut(path, latitude, middle, buffer=width, tolerance=tolerance)
    rng = np.random.default_rng(seed)
    near = line[rng.integers(len(line), size=80)] + rng.normal(0, 1.5 * width / 111_000, (80, 2))
    places = np.concatenate([near, np.array((middle, latitude)) + rng.uniform(-0.03, 0.03, (20, 2))])
    away = metres_away(places, line)
    agree(origin, solid, places, away, width - 0.002, 1.015 * width + 0.05 + 2 * tolerance)


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("latitude", [-17.0, 62.0])
def test_a_line_of_hundreds_of_kilometres_is_as_wide_all_along(zones, latitude, way):
    corners = [(176.0, latitude - 2), (184.0, latitude + 2)][::way]
    path = zones({"type": "LineString", "coordinates": [(wrapped(x), y) for x, y in corners]})
    rng = np.random.default_rng(3)
    for share in (0.02, 0.5, 0.93):
        x, y = 176 + 8 * share, latitude - 2 + 4 * share
        origin, solid = shut(path, y, x, buffer=300.0)
        places = np.array((x, y)) + rng.uniform(-0.02, 0.02, (100, 2))
        near = [(x - 0.1, y - 0.05), (x + 0.1, y + 0.05)]
        agree(origin, solid, places, metres_away(places, near), 299.99, 305.0)


@given(
    turn=st.floats(-360, 360),
    latitude=st.floats(-80, 80),
    corners=st.lists(offsets, min_size=3, max_size=6, unique=True),
    kind=st.sampled_from(["LineString", "Polygon", "MultiPoint", "MultiLineString", "GeometryCollection"]),
)
def test_zones_moved_to_another_longitude_are_the_same_in_their_frame(zones, turn, latitude, corners, kind):
    assume(shapely.MultiPoint(corners).convex_hull.area > 1e-7)
    solids = []
    for middle in (10.0, 10.0 + turn, 180.0):
        line = [(wrapped(middle + x), latitude + y) for x, y in corners]
        shape = {
            "LineString": line,
            "Polygon": [[*line, line[0]]],
            "MultiPoint": line,
            "MultiLineString": [line[:2], line[1:]],
        }
        geometry = {"type": kind, "coordinates": shape.get(kind)}
        if kind == "GeometryCollection":
            parts = [{"type": name, "coordinates": shape[name]} for name in ("LineString", "MultiPoint")]
            geometry = {"type": kind, "geometries": parts}
        solids.append(shut(zones(geometry), latitude, middle, buffer=200.0)[1])
    first = solids[0]
    for other in solids[1:]:
        assert first.buffer(0.1).covers(other)
        assert other.buffer(0.1).covers(first)


def test_a_buffered_line_across_the_antimeridian_shuts_what_it_crosses(zones, refuses):
    path = zones({"type": "LineString", "coordinates": [[179.995, -17], [-179.995, -17]]})
    with refuses():
        of_maps(
            "z",
            zones=[path],
            uavs=[(-17.001, -179.9998, sky.AboveSea(50))],
            ground=sky.AboveSea(0),
            reading=sky.Reading(buffer=300.0),
        )


def test_a_line_beside_the_antimeridian_shuts_both_its_sides_in_every_format(zones):
    corners = [[179.999, -17.02], [179.999, -16.98]]
    kml = (
        '<kml xmlns="http://www.opengis.net/kml/2.2"><Placemark><ExtendedData><Data name="upper"><value>250 m amsl'
        "</value></Data></ExtendedData><LineString><coordinates>179.999,-17.02 179.999,-16.98</coordinates>"
        "</LineString></Placemark></kml>"
    )
    line = {"type": "LineString", "coordinates": corners}
    for path in (
        zones(line),
        zones({"type": "MultiLineString", "coordinates": [corners]}),
        zones({"type": "GeometryCollection", "geometries": [line]}),
        zones(kml, name="z.kml"),
    ):
        told = []
        origin, solid = shut(path, -17, 180, buffer=300.0, told=told)
        assert not any("repaired" in text for text in told)
        start, free = (shapely.Point(sky.to_local(origin, [-17, lon, 0.0])[0, :2]) for lon in (179.9992, -179.997))
        assert solid.contains(start)
        assert solid.distance(free) == pytest.approx(426 - 300, abs=4)


def ring(west, east, south, north, count):
    """Return an outline of so many edges between west and east."""
    x = np.linspace(west, east, count + 1)
    rows = [*((a, south) for a in x), *((a, north) for a in x[::-1]), (west, south)]
    return {"type": "Polygon", "coordinates": [[[float(a), float(b)] for a, b in rows]]}


@pytest.mark.parametrize(
    ("west", "east", "edges"), [(-100, 100, 2), (-80, 90, 1), (-180, 180, 4), (-100, 359, 6), (-200, 160, 3)]
)
def test_a_zone_wider_than_half_the_globe_is_read_as_it_stands(zones, west, east, edges):
    path = zones(ring(west, east, 30, 60, edges))
    told = []
    _, solid = shut(path, 46.8, 9.8, told=told)
    assert solid.contains(shapely.Point(0, 0))
    assert solid.area == pytest.approx(shut(zones(ring(9, 11, 46, 48, 1)), 46.8, 9.8)[1].area, rel=1e-6)
    assert not any("antimeridian" in text for text in told)


@given(
    longitude=longitudes,
    latitude=st.floats(-70, 70),
    sizes=st.lists(st.floats(0.5, 8.0), min_size=5, max_size=5),
    reverse=st.booleans(),
    seed=st.integers(0, 1000),
)
@example(longitude=179.99, latitude=58.0, sizes=[1.0] * 5, reverse=False, seed=0)
def test_all_but_a_country_is_shut_wherever_that_is(zones, longitude, latitude, sizes, reverse, seed):
    angles = np.arange(5) * 2 * np.pi / 5
    country = (longitude, latitude) + np.column_stack([np.cos(angles), np.sin(angles)]) * np.array(sizes)[:, None]
    globe = [[-180, -90], [180, -90], [180, 90], [-180, 90], [-180, -90]]
    rings = [globe[::-1] if reverse else globe, [[wrapped(x), y] for x, y in [*country.tolist(), country[0].tolist()]]]
    x, y = corner = country[0]
    told = []
    origin, solid = shut(zones({"type": "Polygon", "coordinates": rings}), y, x, told=told)
    assert all("repaired so that" in text for text in told)  # where the country crosses the antimeridian
    places = corner + np.random.default_rng(seed).uniform(-0.03, 0.03, (60, 2))
    inside, hole = shapely.points(places), shapely.Polygon(country)
    clear = shapely.distance(inside, hole.exterior) > 1e-3  # an edge is straight in degrees, to some metres
    flat = sky.to_local(origin, np.column_stack([places[:, 1], places[:, 0], np.zeros(60)]))[:, :2]
    clear &= (np.abs(flat) < 5000.0).all(axis=1)
    assert (shapely.covers(solid, shapely.points(flat)) == ~shapely.covers(hole, inside))[clear].all()


def test_a_band_around_the_globe_is_shut_at_all_longitudes(zones):
    path = zones(ring(-180, 180, 30, 60, 1))
    for longitude in (-180.0, -90.0, 9.8, 179.999):
        assert shut(path, 46.8, longitude)[1].area == pytest.approx(shut(path, 46.8, 0.0)[1].area, rel=1e-6)
        assert shut(path, 65.0, longitude)[1].is_empty


def test_a_wide_zone_ends_where_it_ends(zones):
    for west, east, sides in ((-100, 9.8, (True, False)), (9.8, 150, (False, True))):
        _, solid = shut(zones(ring(west, east, 30, 60, 2)), 46.8, 9.8, wide=25_000.0)
        assert [solid.contains(shapely.Point(x, 20_000)) for x in (-3, 3)] == list(sides)


def test_a_zone_that_begins_in_the_frame_and_ends_far_away_begins_where_its_file_says(zones):
    origin, solid = shut(zones(ring(9.86, 14, 46, 48, 1)), 46.8, 9.8)
    for east, inside in ((1e-7, True), (-4e-6, False)):
        rows = [(latitude, 9.86 + east, up) for latitude in (46.77, 46.8, 46.83) for up in (0.0, 150.0)]
        assert {solid.contains(place) for place in shapely.points(sky.to_local(origin, rows)[:, :2])} == {inside}


def test_a_zone_around_the_pole_cut_at_a_meridian_is_whole(zones):
    _, solid = shut(zones(ring(-180, 180, 80, 90, 8)), 89.5, 30.0, wide=25_000.0)
    assert all(solid.contains(shapely.Point(x, y)) for x, y in ((0, 0), (10_000, 10_000), (-15_000, -10_000)))


def test_a_zone_on_the_other_side_of_the_globe_is_not_here(zones):
    _, solid = shut(zones(ring(-170.3, -170.1, -46.9, -46.7, 1)), 46.8, 9.8)
    assert solid.is_empty


@pytest.mark.parametrize(
    "geometry",
    [
        ring(-100, 100, 30, 60, 1),
        ring(-90, 90, 30, 60, 1),
        ring(-180, 180, 30, 60, 2),
        {"type": "Polygon", "coordinates": [[[-120, 80], [0, 80], [120, 80], [-120, 80]]]},
        {"type": "Polygon", "coordinates": [[[0, 80], [80, 80], [160, 80], [-120, 80], [-60, 80], [0, 80]]]},
        {"type": "LineString", "coordinates": [[-100, 30], [100, 30]]},
        {"type": "LineString", "coordinates": [[-180, 30], [180, 30]]},
        {"type": "Point", "coordinates": [0, 89.9999]},
        {"type": "LineString", "coordinates": [[-1, 89.999], [1, 89.999]]},
    ],
)
def test_what_could_run_either_way_or_goes_around_a_pole_is_refused(zones, geometry, refuses):
    with refuses():
        read_file(zones(geometry), buffer=200.0)


def test_a_buffer_wider_than_a_hundred_kilometres_is_refused(refuses):
    with refuses():
        sky.Reading(buffer=1e7)
    assert sky.Reading(buffer=1e5).buffer == 1e5
