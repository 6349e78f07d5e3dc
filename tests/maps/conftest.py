"""What tests of maps share."""

import json

import pytest


@pytest.fixture
def read(tmp_path):
    """Write a document to a file, and return the features that are read from it."""
    pytest.importorskip("shapely")
    from skyverse.maps.georeference.reading import Choices
    from skyverse.maps.readers import read_features

    def written(document, name="zones.geojson", **choices):
        path = tmp_path / name
        path.write_text(document if isinstance(document, str) else json.dumps(document), encoding="utf-8")
        return read_features(path, Choices(**choices))

    return written
