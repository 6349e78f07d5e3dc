"""The digest of a scenario is the same for the same content, and another for every other content."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.model.quantities import short
from skyverse.model.scenario import Scenario


@pytest.fixture
def scenario():
    return sky.read_scenario("table-4.8")


def test_a_scenario_keeps_its_digest_when_it_is_written_and_read(tmp_path, scenario):
    for suffix in (".yaml", ".json"):
        sky.write(scenario, tmp_path / f"same{suffix}")
        assert sky.read_scenario(tmp_path / f"same{suffix}").digest == scenario.digest


def test_defaults_do_not_count(scenario):
    data = scenario.model_dump(mode="json", exclude_defaults=True)
    assert Scenario.model_validate(data | {"zones": [], "sources": []}).digest == scenario.digest


@pytest.mark.parametrize(
    "change", [{"name": "other"}, {"clearance": 0.123456789}, {"uavs": ()}, {"description": "as before"}]
)
def test_every_change_makes_another_digest(scenario, change):
    assert scenario.model_copy(update=change).digest != scenario.digest


@pytest.mark.parametrize("size", [3, 100])
def test_one_height_makes_another_digest(size):
    heights = np.zeros((size, size))
    flat = {
        "name": "flat",
        "bounds": {"min": [0, 0, 0], "max": [2, 2, 9]},
        "clearance": 0.1,
        "lattice": {"step": [1, 1, 1]},
    }
    plain = Scenario.model_validate(flat | {"terrain": {"origin": [0, 0], "step": [1, 1], "heights": heights}})
    again = Scenario.model_validate(flat | {"terrain": {"origin": [0, 0], "step": [1, 1], "heights": heights + 0.0}})
    assert plain.digest == again.digest
    heights[1, 1] = 1e-9
    hill = Scenario.model_validate(flat | {"terrain": {"origin": [0, 0], "step": [1, 1], "heights": heights}})
    assert hill.digest != plain.digest


def test_a_digest_is_shown_by_its_first_digits(scenario):
    assert len(scenario.digest) == 64
    assert short(scenario.digest) == f"sha256 {scenario.digest[:12]}"
