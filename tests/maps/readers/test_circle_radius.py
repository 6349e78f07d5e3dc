"""The radius of a circle, and its unit."""

import numpy as np
import pytest

import skyverse as sky
from altitudes import About

pyproj = pytest.importorskip("pyproj")
shapely = pytest.importorskip("shapely")
pytest.importorskip("pyogrio")

from zones import ZONE, collection, feature  # noqa: E402

GEOD = pyproj.Geod(ellps="WGS84")


RADII = [
    ({"radius": 1.5, "radiusUnit": "km"}, 1500),
    ({"radius": 1.5, "radius_uom": "KM"}, 1500),
    ({"radius": 2, "radius_unit": "NM"}, 3704),
    ({"radius": 2, "uomRadius": "nm"}, 3704),
    ({"radius": 1, "radius-units": "Miles"}, 1609.344),
    ({"radius": 1000, "unitOfRadius": "ft"}, 304.8),
    ({"radius": 500, "radiusUnit": "m"}, 500),
    ({"radius": "1.5 km"}, 1500),
    ({"radius": "1.5", "radiusUnit": "km"}, 1500),
    ({"radius": "1.5 km", "radiusUnit": "km"}, 1500),
    ({"radius": "2 NM"}, 3704),
    ({"radius": "1000ft"}, 304.8),
    ({"radius": {"value": 1.5, "unit": "km"}}, 1500),
    ({"radius_km": 1.5}, 1500),
    ({"radiusInMeters": 250, "radius": "250 m"}, 250),
    ({"radius": 1.5, "unit": "km"}, 1500),
    ({"radius": 500, "unit": "m", **ZONE}, 500),
]


@pytest.mark.parametrize(("fields", "metres"), RADII)
def test_a_radius_is_in_the_unit_that_stands_beside_it(read, fields, metres):
    (disc,) = read(collection(feature([7.0, 47.0], "Point", **fields)), buffer=10)
    middles = (disc.outline + np.roll(disc.outline, -1, axis=0)) / 2
    far = GEOD.inv(np.full(len(middles), 7.0), np.full(len(middles), 47.0), *middles.T)[2]
    assert metres <= far.min() <= far.max() <= metres * 1.001


@pytest.mark.parametrize(
    "fields",
    [
        {"radius": 3, "radiusUnit": "furlong"},
        {"radius": 3, "radius_uom": 7},
        {"radius": "3 furlongs"},
        {"radius": 3, "unit": "deg"},
        {"radius": "wide"},
        {"radius": "3 km", "radiusUnit": "m"},
        {"radius": "3 m", "radius_km": 3},
        {"radius": 300, "radiusUnit": "km"},
        {"radius": -3, "radiusUnit": "m"},
        {"radius": 3},
        {"radius": "3", **ZONE},
        {"radius": 500, "unit": "ft", "upper": 400, "reference": "AGL"},
    ],
)
def test_a_radius_in_no_unit_that_is_known_is_refused(read, fields, refuses):
    with refuses():
        read(collection(feature([7.0, 47.0], "Point", **fields)), buffer=10)


def test_a_radius_without_a_unit_is_in_the_unit_that_is_given_or_that_of_its_format(read):
    for unit, metres in (("m", 300), ("ft", 91.44)):
        (disc,) = read(collection(feature([7.0, 47.0], "Point", radius=300, **ZONE)), unit=unit)
        assert np.ptp(disc.outline[:, 1]) * 111_180 == pytest.approx(2 * metres, rel=0.01)
        limits = {"unit": "ft", "upper": 400, "reference": "AGL"}
        (disc,) = read(collection(feature([7.0, 47.0], "Point", radius=300, **limits)), unit=unit)
        assert np.ptp(disc.outline[:, 1]) * 111_180 == pytest.approx(2 * metres, rel=0.01)
        assert disc.high == About(sky.AboveGround, 121.92)
    part = {"type": "Point", "coordinates": [7.0, 47.0], "extent": {"subType": "Circle", "radius": 300}}
    (disc,) = read(collection({"type": "Feature", "properties": ZONE, "geometry": part}))
    assert np.ptp(disc.outline[:, 1]) * 111_180 == pytest.approx(600, rel=0.01)


def test_the_unit_of_a_circle_is_not_that_of_the_limits_of_its_zone(read):
    layer = {"upper": 400, "upperReference": "AGL", "uom": "ft"}
    extent = {"subType": "Circle", "radius": 1.5, "uom": "km"}
    part = {"type": "Point", "coordinates": [7.0, 47.0], "extent": extent, "layer": layer}
    (disc,) = read(collection({"type": "Feature", "properties": {}, "geometry": part}))
    assert disc.high == About(sky.AboveGround, 121.92)
    assert np.ptp(disc.outline[:, 1]) * 111_180 == pytest.approx(3000, rel=0.01)
    volume = {"uomDimensions": "FT", "upperLimit": 400, "upperVerticalReference": "AGL"}
    flat = {"type": "Circle", "center": [7.0, 47.0], "radius": 500}
    zone = {"identifier": "A1", "geometry": [{**volume, "horizontalProjection": flat}]}
    (disc,) = read({"features": [zone]}, name="zones.json")
    assert np.ptp(disc.outline[:, 1]) * 111_180 == pytest.approx(1000, rel=0.01)
    assert disc.high == About(sky.AboveGround, 121.92)
