import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skyverse.model.geodesy import to_local, to_wgs84
from skyverse.model.scenario import Origin

latitudes = st.one_of(st.floats(-90, 90), st.sampled_from([-90.0, -89.9999, 0.0, 89.9999, 90.0]))
longitudes = st.one_of(st.floats(-180, 180), st.sampled_from([-180.0, -179.9999, 0.0, 179.9999, 180.0]))
origins = st.builds(
    Origin,
    latitude=latitudes,
    longitude=longitudes,
    altitude=st.floats(-400, 6000),
    geoid=st.floats(-110, 90),
)
offsets = st.lists(
    st.tuples(st.floats(-35_000, 35_000), st.floats(-35_000, 35_000), st.floats(-1000, 9000)), min_size=1, max_size=20
)


def topocentric(origin):
    """Return PROJ's own conversion, from longitude, latitude, ellipsoidal height."""
    pyproj = pytest.importorskip("pyproj", reason="the oracle is PROJ")
    return pyproj.Transformer.from_pipeline(
        "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart +ellps=WGS84 "
        f"+step +proj=topocentric +ellps=WGS84 +lat_0={origin.latitude!r} +lon_0={origin.longitude!r} "
        f"+h_0={origin.altitude + origin.geoid!r}"
    )


@given(origins, offsets)
def test_local_metres_to_places_and_back_are_projs_within_a_millimetre_over_50_km_anywhere(origin, points):
    proj = topocentric(origin)
    points = np.array(points)
    places = to_wgs84(origin, points)
    x, y, z = proj.transform(places[:, 1], places[:, 0], places[:, 2] + origin.geoid)
    assert np.abs(np.column_stack([x, y, z]) - points).max() < 1e-3
    assert np.abs(to_local(origin, places) - points).max() < 1e-3
    assert (np.abs(places[:, 0]) <= 90).all()
    assert (np.abs(places[:, 1]) <= 180).all()


@given(origins, st.lists(st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-400, 9000)), min_size=1))
def test_places_to_local_metres_are_projs_within_a_millimetre_also_beyond_180_degrees(origin, apart):
    apart = np.array(apart)
    places = np.array([origin.latitude, origin.longitude, 0.0]) + apart
    places[:, 0] = np.clip(places[:, 0], -90, 90)
    proj = topocentric(origin)
    x, y, z = proj.transform(places[:, 1], places[:, 0], places[:, 2] + origin.geoid)
    assert np.abs(to_local(origin, places) - np.column_stack([x, y, z])).max() < 1e-3


def test_what_lies_level_far_away_lies_lower():
    origin = Origin(latitude=46.8, longitude=9.85, altitude=1500)
    near, far = to_local(origin, [[46.8 + 1 / 111.2, 9.85, 1500], [46.8 + 5 / 111.2, 9.85, 1500]])[:, 2]
    assert near == pytest.approx(-0.08, abs=0.01)
    assert far == pytest.approx(-1.96, abs=0.02)


def test_the_origin_is_zero_and_one_row_will_do():
    origin = Origin(latitude=-33.9, longitude=18.4, altitude=1000, geoid=30)
    assert to_local(origin, [-33.9, 18.4, 1000]) == pytest.approx(np.zeros((1, 3)), abs=1e-8)
    assert to_wgs84(origin, [0, 0, 0]) == pytest.approx(np.array([[-33.9, 18.4, 1000]]), abs=1e-8)


def test_rows_of_two_numbers_are_refused():
    with pytest.raises(ValueError, match="places: expected rows of three finite numbers"):
        to_local(Origin(latitude=0, longitude=0, altitude=0), [[1.0, 2.0]])
