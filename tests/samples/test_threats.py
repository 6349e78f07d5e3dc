import math

import numpy as np
import pytest

import skyverse as sky


def test_the_same_seed_makes_the_same_field_and_another_one_another():
    assert sky.random_threats(20, seed=3) == sky.random_threats(20, seed=3)
    assert sky.random_threats(20, seed=3) != sky.random_threats(20, seed=4)


@pytest.mark.parametrize("threats", [0, 1, 15, 30])
def test_there_are_as_many_threats_as_asked_for_of_every_kind(threats):
    fields = [sky.random_threats(threats, seed=seed) for seed in range(20)]
    assert all(len(field.obstacles) + len(field.zones) == threats for field in fields)
    if threats >= 15:
        kinds = [type(zone) for field in fields for zone in field.zones]
        for count in (sum(len(field.obstacles) for field in fields), kinds.count(sky.Cylinder), kinds.count(sky.Prism)):
            assert count == pytest.approx(20 * threats / 3, rel=0.4)


@pytest.mark.parametrize("seed", range(20))
def test_the_uav_crosses_the_field_and_both_its_ends_can_be_planned_for(seed):
    for threats in (15, 30):
        problem = sky.Problem(sky.random_threats(threats, seed=seed))
        assert problem.refusal is None
        assert problem.any_angle_refusal is None
        assert math.dist(problem.start, problem.end) > 1100


def test_every_term_of_the_objective_matters():
    names = ("divergence", "altitude", "risk", "climb")
    shares = {name: [] for name in names}
    for seed in range(20):
        result = sky.AStar().plan(sky.Problem(sky.random_threats(30, seed=seed)))
        for name in names:
            shares[name].append(result.terms[name] / result.cost)
    assert all(np.mean(shares[name]) > 0.005 for name in names)


@pytest.mark.parametrize(("threats", "seed"), [(-1, 0), (2.5, 0), (True, 0), (3, -1)])
def test_what_cannot_be_is_refused_in_one_sentence(threats, seed, refuses):
    with refuses():
        sky.random_threats(threats, seed=seed)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_descriptions_count_in_words(count):
    told = sky.random_threats(count).description, sky.forest_swap(2, trees=count).description
    for said, thing in zip(told, ("random threat", "tree"), strict=True):
        assert f"{('no', '1', '2')[count]} {thing}{'' if count == 1 else 's'}" in said
