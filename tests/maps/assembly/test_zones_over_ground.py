"""Zones whose upper limit is below the ground do not vanish without a word: all, or a part of it, is told."""

import json

import numpy as np
import pytest

rasterio = pytest.importorskip("rasterio", reason="building scenarios needs rasterio")

from rasterio.transform import Affine  # noqa: E402

import skyverse as sky  # noqa: E402

GROUND = 300.0
AREA = (8.699, 50.799, 8.706, 50.801)


def zones(folder, **fields):
    west, south, east, north = AREA
    ring = [[west, south], [east, south], [east, north], [west, north], [west, south]]
    feature = {"type": "Feature", "properties": {"name": "event", **fields}}
    path = folder / "zones.geojson"
    path.write_text(json.dumps({**feature, "geometry": {"type": "Polygon", "coordinates": [ring]}}), encoding="utf-8")
    return path


def built(path, what="zones", **ground):
    """Return the only obstacle of a scenario around the zone, if there is one, with the scenario and what was told."""
    told = []
    asked = {"ground": sky.AboveSea(GROUND)} | ground
    made = sky.build_scenario(
        sky.BuildOptions("s", **{what: [path]}, area=AREA, **asked, on_note=lambda note: told.append(note.text))
    )
    assert len(made.obstacles) <= 1
    return next(iter(made.obstacles), None), made, told


@pytest.mark.parametrize("low", [None, "0 m agl", "SFC", "-20 m agl", "-100 m amsl"])
@pytest.mark.parametrize("high", [-50, 50, 299, 300])
def test_a_zone_that_ends_below_all_ground_is_closed_from_the_ground_up(tmp_path, low, high):
    limits = {"upper": f"{high} m amsl"} | ({} if low is None else {"lower": low})
    zone, made, told = built(zones(tmp_path, **limits))
    assert zone.low <= made.terrain.heights.min()
    assert zone.high > made.bounds.max[2]
    (warning,) = (text for text in told if text.startswith("WARNING"))
    assert warning.startswith(f"WARNING: event: its upper limit, {high} m amsl, is at or below the ground there, 300 m")


def test_a_zone_that_ends_above_the_ground_stays_as_it_is(tmp_path):
    zone, made, told = built(zones(tmp_path, lower="SFC", upper="350 m amsl"))
    assert zone.high + made.frame.origin.altitude == pytest.approx(350.0)
    assert not any("event" in text for text in told)


def test_a_zone_that_ends_below_a_part_of_the_ground_is_told_of(tmp_path):
    path, (west, south, east, north) = tmp_path / "slope.tif", AREA
    slope = np.broadcast_to(np.linspace(280.0, 420.0, 60), (60, 60)).astype("float32")
    pixel = Affine((east - west + 0.02) / 60, 0, west - 0.01, 0, (south - north - 0.02) / 60, north + 0.01)
    with rasterio.open(
        path, "w", driver="GTiff", width=60, height=60, count=1, dtype="float32", crs="EPSG:4326", transform=pixel
    ) as file:
        file.write(slope, 1)
    zone, made, told = built(
        zones(tmp_path, lower="SFC", upper="350 m amsl"), ground=None, terrain=[sky.Raster(path, unit="m")]
    )
    assert zone.high + made.frame.origin.altitude == pytest.approx(350.0)
    (said,) = (text for text in told if text.startswith("event: its upper limit, 350 m amsl, is below a part"))
    highest = made.terrain.heights.max() + made.frame.origin.altitude
    assert abs(float(said.partition("up to ")[2].split(" ")[0]) - highest) < 15


@pytest.mark.parametrize(
    ("what", "fields", "why"),
    [
        ("buildings", {"upper": "200 m amsl"}, "1 buried"),
        ("zones", {"lower": "3000 m amsl", "upper": "4000 m amsl"}, "1 above or below the bounds"),
    ],
)
def test_what_lies_in_the_area_is_not_said_to_lie_elsewhere(tmp_path, what, fields, why):
    found, _, told = built(zones(tmp_path, **fields), what)
    assert found is None
    assert f"WARNING: nothing of it closes anything there: {why}" in told
