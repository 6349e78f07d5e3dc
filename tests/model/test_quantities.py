"""Every way to make a model, or another one of it, validates it and says in one sentence what is wrong."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

import skyverse as sky
from every_part import EVERY_PART, models_in
from skyverse.model.arrays import frozen
from skyverse.model.quantities import Model, derived, short

ONE_OF_EACH = list({type(part): part for part in models_in(EVERY_PART)}.values())
FIELDS = [(part, field) for part in ONE_OF_EACH for field in type(part).model_fields]


def named(value):
    return value if isinstance(value, str) else type(value).__name__


def test_every_kind_of_part_is_tried():
    given = {kind for kind in every_kind(Model) if kind.__module__.startswith("skyverse.model")}
    abstract = {"GridModel", "Extent", "Shape", "Upright"}
    assert {kind.__name__ for kind in given} - {type(one).__name__ for one in ONE_OF_EACH} <= abstract | {"Sensor"}


def every_kind(kind):
    for below in kind.__subclasses__():
        yield from (below, *every_kind(below))


@pytest.mark.parametrize(("part", "field"), FIELDS, ids=named)
def test_a_copy_with_a_wrong_value_or_a_misspelt_name_is_refused_whatever_the_field(part, field):
    with pytest.raises(sky.InputError) as refused:
        part.model_copy(update={field: object()})
    assert (refused.value.sentence.field or field).startswith(field)
    misspelt = f"{field}x"
    with pytest.raises(sky.InputError, match=f"did you mean .*'{field}'"):
        part.model_copy(update={misspelt: getattr(part, field)})
    with pytest.raises(sky.InputError, match=misspelt):
        part.copy(update={misspelt: getattr(part, field)})
    with pytest.raises(sky.InputError, match=misspelt):
        type(part)(**{misspelt: 1})
    with pytest.raises(TypeError, match=misspelt):
        derived(part, **{misspelt: 1})


@pytest.mark.parametrize("part", ONE_OF_EACH, ids=named)
def test_a_copy_is_equal_but_for_what_is_changed(part):
    fields = dict(part)
    for same in (part.model_copy(), part.model_copy(update=fields), part.model_copy(deep=True), copy.deepcopy(part)):
        assert same == part
        assert type(same) is type(part)
    assert pickle.loads(pickle.dumps(part.model_copy(update=fields))) == part


def test_a_copy_is_validated_as_a_whole():
    with pytest.raises(sky.InputError, match=r"max_height, 0\.1 m, must be above the clearance"):
        EVERY_PART.model_copy(update={"max_height": 0.1})
    with pytest.raises(sky.InputError, match="home"):
        EVERY_PART.uavs[0].model_copy(update={"start": (0, 0, 0.2)})
    named_twice = (*EVERY_PART.uavs, EVERY_PART.uavs[0])
    with pytest.raises(sky.InputError, match="names must differ") as refused:
        EVERY_PART.model_copy(update={"uavs": named_twice})
    assert refused.value.sentence.field == "uavs"


def test_a_copy_keeps_large_arrays_as_they_are():
    terrain = sky.Terrain(origin=(0, 0), step=(1, 1), heights=np.zeros((4, 4)))
    assert terrain.model_copy(update={"clearance": 1.0}).heights is terrain.heights
    voxels = sky.Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=np.ones((2, 2, 2), bool))
    assert voxels.model_copy(update={"name": "block"}).occupied is voxels.occupied


def test_a_constructor_says_in_one_sentence_what_is_wrong_and_pydantic_all_of_it():
    with pytest.raises(sky.InputError) as refused:
        sky.UAV(start=(0, 0, 0), max_speed=-1.0, max_jerk="x")
    assert refused.value.sentence.field == "max_speed"
    assert "\n" not in str(refused.value)
    with pytest.raises(ValidationError) as listed:
        sky.UAV.model_validate({"start": (0, 0, 0), "max_speed": -1.0, "max_jerk": "x"})
    assert listed.value.error_count() == 2


@pytest.fixture
def scenario():
    return sky.read_scenario("table-4.8")


def test_a_scenario_keeps_its_digest_when_it_is_written_and_read(tmp_path, scenario):
    for suffix in (".yaml", ".json"):
        sky.write(scenario, tmp_path / f"same{suffix}")
        assert sky.read_scenario(tmp_path / f"same{suffix}").digest == scenario.digest


def test_defaults_do_not_count(scenario):
    data = scenario.model_dump(mode="json", exclude_defaults=True)
    assert sky.Scenario.model_validate(data | {"zones": [], "sources": []}).digest == scenario.digest


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
    plain = sky.Scenario.model_validate(flat | {"terrain": {"origin": [0, 0], "step": [1, 1], "heights": heights}})
    again = sky.Scenario.model_validate(
        flat | {"terrain": {"origin": [0, 0], "step": [1, 1], "heights": heights + 0.0}}
    )
    assert plain.digest == again.digest
    heights[1, 1] = 1e-9
    hill = sky.Scenario.model_validate(flat | {"terrain": {"origin": [0, 0], "step": [1, 1], "heights": heights}})
    assert hill.digest != plain.digest


def test_a_digest_is_shown_by_its_first_digits(scenario):
    assert len(scenario.digest) == 64
    assert short(scenario.digest) == f"sha256 {scenario.digest[:12]}"


def arrays(mission):
    for thing in (*mission.results, *mission.trajectories, *(r.history for r in mission.results)):
        yield from (value for value in vars(thing).values() if isinstance(value, np.ndarray))


def test_the_arrays_of_an_answer_are_read_only_even_after_a_pickle(mission):
    for answer in (mission, pickle.loads(pickle.dumps(mission))):
        assert answer == mission
        assert len(list(arrays(answer))) == 2 * 3 + 2 * 2 + 2 * 5
        for array in arrays(answer):
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0


def test_an_answer_does_not_change_with_the_array_it_was_made_from():
    knots = np.array([0.0, 1.0])
    trajectory = sky.Trajectory(knots, np.zeros((1, 6, 3)))
    knots[1] = 9.0
    assert trajectory.end == 1.0


def test_answers_differ_where_one_element_differs():
    one = sky.Trajectory(np.array([0.0, 1.0]), np.zeros((1, 6, 3)))
    other = np.zeros((1, 6, 3))
    other[0, 5, 2] = 1e-300
    assert one == replace(one)
    assert one != replace(one, coefficients=other)


def test_a_read_only_array_is_shared_and_a_view_is_copied():
    whole = frozen(np.arange(4.0))
    assert frozen(whole) is whole
    view = whole[1:]
    assert frozen(view) is not view
    assert not frozen(view).flags.writeable
