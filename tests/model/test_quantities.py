"""Every way to make a model, or another one of it, validates it and says in one sentence what is wrong."""

import copy
import pickle

import numpy as np
import pytest
from pydantic import ValidationError

import skyverse as sky
from every_part import EVERY_PART, models_in
from skyverse.model.quantities import Model, derived

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
