"""The default ceiling is above the zones that UAVs could reach."""

import json

import pytest

import skyverse as sky

pytest.importorskip("pyproj", reason="building scenarios needs pyproj")
pytest.importorskip("shapely", reason="building scenarios needs shapely")

from of_maps import of_maps
from skyverse.maps.assembly.frame import VERY_LOW_LEVEL


def built(folder, lower, ceiling=None):
    """Build a scenario of one UAV at 20 m and of one of ED-318's circles, which begins at `lower` metres."""
    layer = {"upper": lower + 20, "upperReference": "AGL", "lower": lower, "lowerReference": "AGL", "uom": "m"}
    geometry = {"type": "Point", "coordinates": [9.85, 46.8], "layer": layer}
    geometry["extent"] = {"subType": "Circle", "radius": 50}
    zone = {"type": "Feature", "properties": {"type": "PROHIBITED"}, "geometry": geometry}
    (folder / "zones.json").write_text(json.dumps({"type": "FeatureCollection", "features": [zone]}))
    notes = []
    given = {
        "zones": [folder / "zones.json"],
        "ground": sky.AboveSea(500),
        "uavs": [(46.8, 9.851, sky.AboveGround(35))],
    }
    made = of_maps("circle", **given, ceiling=ceiling, on_note=lambda note: notes.append(note.text))
    return made, " ".join(notes)


@pytest.mark.parametrize("lower", [0.5, 60, 100, 150])
def test_a_zone_that_uavs_could_reach_is_kept(tmp_path, lower):
    made, _ = built(tmp_path, lower)
    (zone,) = made.obstacles
    ground = float(made.terrain.heights.max())
    assert zone.low == pytest.approx(ground + lower, abs=0.5)
    assert made.bounds.max[2] >= zone.low + 30 - 1


def test_a_zone_far_above_everything_does_not_raise_the_ceiling(tmp_path):
    made, notes = built(tmp_path, 35 + VERY_LOW_LEVEL + 5)
    assert made.obstacles == ()
    assert "1 above or below the bounds" in notes
    assert made.bounds.max[2] - float(made.terrain.heights.max()) < 70


def test_a_ceiling_that_is_given_is_kept(tmp_path):
    made, notes = built(tmp_path, 100, ceiling=sky.AboveGround(50))
    assert made.bounds.max[2] == pytest.approx(float(made.terrain.heights.max()) + 50)
    assert "1 above or below the bounds" in notes
