"""The map against PROJ, and altitudes as people write them."""

import contextlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from proj_map import proj_local

latitudes = st.one_of(st.floats(-90, 90), st.sampled_from([-90.0, -89.9999, 0.0, 89.9999, 90.0]))
longitudes = st.one_of(st.floats(-180, 180), st.sampled_from([-180.0, -179.9999, 0.0, 179.9999, 180.0]))
origins = st.builds(
    sky.Origin,
    latitude=latitudes,
    longitude=longitudes,
    altitude=st.floats(-400, 6000),
    geoid=st.floats(-110, 90),
)
offsets = st.lists(
    st.tuples(st.floats(-35_000, 35_000), st.floats(-35_000, 35_000), st.floats(-1000, 9000)), min_size=1, max_size=20
)


@given(origins, offsets)
def test_local_metres_to_places_and_back_are_projs_within_a_millimetre_over_50_km_anywhere(origin, points):
    points = np.array(points)
    places = sky.to_wgs84(origin, points)
    assert np.abs(proj_local(origin, *places.T) - points).max() < 1e-3
    assert np.abs(sky.to_local(origin, places) - points).max() < 1e-3
    assert (np.abs(places[:, 0]) <= 90).all()
    assert (np.abs(places[:, 1]) <= 180).all()


@given(origins, st.lists(st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-400, 9000)), min_size=1))
def test_places_to_local_metres_are_projs_within_a_millimetre_also_beyond_180_degrees(origin, apart):
    places = np.array([origin.latitude, origin.longitude, 0.0]) + np.array(apart)
    places[:, 0] = np.clip(places[:, 0], -90, 90)
    assert np.abs(sky.to_local(origin, places) - proj_local(origin, *places.T)).max() < 1e-3


@given(origins, st.floats(-90_000, 90_000), st.floats(-90_000, 90_000), st.floats(0, 360))
def test_lengths_are_too_long_by_the_share_that_is_stated(origin, east, north, course):
    geod = pytest.importorskip("pyproj", reason="the oracle is PROJ").Geod(ellps="WGS84")
    sea = origin.model_copy(update={"altitude": 0.0})
    (latitude, longitude, _), _ = sky.to_wgs84(sea, [(east, north, 0), (east, north, 0)])
    there = geod.fwd(longitude, latitude, course, 100.0)
    a, b = sky.to_local(sea, [(latitude, longitude, 0), (there[1], there[0], 0)])
    stated = east**2 / (2 * 6.37e6**2)
    assert np.linalg.norm(b - a) / 100.0 - 1 == pytest.approx(stated, abs=0.02 * stated + 1e-6)


@given(origins, offsets)
def test_what_is_level_is_level_and_what_is_upright_is_upright(origin, points):
    places = sky.to_wgs84(origin, points)
    assert places[:, 2] == pytest.approx(np.array(points)[:, 2] + origin.altitude, abs=1e-9)
    places[:, 2] += 100.0
    assert np.abs(sky.to_local(origin, places) - points - [0, 0, 100]).max() < 1e-6


def test_the_origin_is_zero_and_one_row_will_do():
    origin = sky.Origin(latitude=-33.9, longitude=18.4, altitude=1000, geoid=30)
    assert sky.to_local(origin, [-33.9, 18.4, 1000]) == pytest.approx(np.zeros((1, 3)), abs=1e-8)
    assert sky.to_wgs84(origin, [0, 0, 0]) == pytest.approx(np.array([[-33.9, 18.4, 1000]]), abs=1e-8)


def test_rows_of_two_numbers_are_refused():
    with pytest.raises(ValueError, match="places: expected rows of three finite numbers"):
        sky.to_local(sky.Origin(latitude=0, longitude=0, altitude=0), [[1.0, 2.0]])


def test_what_is_round_the_earth_is_no_place_and_what_is_far_aside_stays_a_number(refuses):
    origin = sky.Origin(latitude=46.8, longitude=9.8, altitude=0)
    for point in ([1.1e7, 0, 0], [0, -1.1e7, 0]):
        with refuses():
            sky.to_wgs84(origin, point)
    far = sky.to_local(origin, [[0, 99.8, 0], [10, 95, 0], [-46.8, -170.2, 0]])
    assert np.isfinite(far).all()
    assert (np.linalg.norm(far[:, :2], axis=1) > 9e6).all()


@pytest.mark.parametrize(
    ("text", "altitude"),
    [
        ("60 m agl", sky.AboveGround(60)),
        ("60m agl", sky.AboveGround(60)),
        ("1250 m amsl", sky.AboveSea(1250)),
        ("1250M MSL", sky.AboveSea(1250)),
        (" 30 m home ", sky.AboveHome(30)),
        ("-3.5 m amsl", sky.AboveSea(-3.5)),
        ("+1e2 m agl", sky.AboveGround(100)),
        (".5 m agl", sky.AboveGround(0.5)),
    ],
)
def test_an_altitude_says_what_it_is_counted_from(text, altitude):
    assert sky.parse_altitude(text) == altitude


@pytest.mark.parametrize(
    ("text", "number"), [("400 agl", 400), ("60agl", 60), ("1250 MSL", 1250), ("30 home", 30), ("0 amsl", 0)]
)
def test_an_altitude_without_a_unit_is_refused_unless_the_unit_is_known(text, number):
    with pytest.raises(ValueError, match="expected an altitude in m or ft, as in '"):
        sky.parse_altitude(text)
    assert sky.parse_altitude(text, 0.3048).metres == pytest.approx(0.3048 * number)


def test_feet_are_international_feet():
    assert sky.parse_altitude("400 ft agl").metres == pytest.approx(121.92, abs=1e-12)


@pytest.mark.parametrize("text", ["60", "60 m", "100ft", "-4"])
def test_a_bare_number_is_refused(text):
    with pytest.raises(ValueError, match="what it is counted from"):
        sky.parse_altitude(text)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "agl",
        "60 km agl",
        "60 m above",
        "nan agl",
        "inf agl",
        "6 0 agl",
        "60 m agl x",
        "1e agl",
        "1e9 agl",
        "-20000 amsl",
    ],
)
def test_what_is_no_altitude_is_refused(text):
    with pytest.raises(ValueError, match="expected an altitude"):
        sky.parse_altitude(text)


@given(st.floats(-1e4, 5e4), st.sampled_from(["m", "ft"]), st.sampled_from(["amsl", "agl", "home"]))
def test_what_is_written_is_read(number, unit, frame):
    kind = {"amsl": sky.AboveSea, "agl": sky.AboveGround, "home": sky.AboveHome}[frame]
    factor = 0.3048 if unit == "ft" else 1
    assert sky.parse_altitude(f"{number!r} {unit} {frame}") == kind(number * factor)


@given(st.text(max_size=30))
def test_any_text_is_an_altitude_or_refused_in_one_sentence(text):
    with contextlib.suppress(ValueError):
        assert isinstance(sky.parse_altitude(text), sky.AboveGround | sky.AboveHome | sky.AboveSea)
