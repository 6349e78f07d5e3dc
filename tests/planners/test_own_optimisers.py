"""Optimisers of one's own that do what no optimiser should: each ends in one sentence, and never in a crash."""

from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest

import skyverse as sky
from worlds import ROOM

STOP = sky.MaxEvaluations(100)


@dataclass(frozen=True, kw_only=True)
class Odd(sky.WaypointSearch):
    """Evaluates the first population, and then whatever `then` makes of it."""

    then: object = None

    def optimise(self, evaluate, first, rng):
        evaluate(first)
        while True:
            yield
            evaluate(self.then(first))


@dataclass(frozen=True)
class Length(sky.PathObjective):
    """Length alone."""

    def prices(self, problem, paths):
        return np.linalg.norm(np.diff(paths, axis=1), axis=2).sum(axis=1)


KINDS = {"lattice": {}, "straight": {"legs": "straight"}, "objective": {"objective": Length()}}
every_kind = pytest.mark.parametrize("settings", KINDS.values(), ids=KINDS)
CANDIDATES = {
    "nan": lambda first: np.full(first.shape, np.nan),
    "infinite": lambda first: np.full(first.shape, -np.inf),
    "narrow": lambda first: first[:, :5],
    "narrower by a waypoint": lambda first: first[:, 3:],
    "wide": lambda first: np.tile(first, 700),
    "one": lambda first: first[0],
    "deep": lambda first: first[None],
    "words": lambda first: [["x"] * first.shape[1]],
    "nothing": lambda first: None,
}


@every_kind
@pytest.mark.parametrize("then", CANDIDATES.values(), ids=CANDIDATES)
def test_candidates_of_another_shape_or_without_numbers_are_refused(settings, then, refuses):
    with refuses():
        Odd(then=then, **settings).plan(sky.Problem(ROOM), stop=STOP, rng=0)


@every_kind
def test_candidates_may_lie_far_outside_and_come_in_any_kind_of_array(settings):
    ways = (lambda X: X * 1e300 - 1e299, lambda X: X.astype(np.float32), lambda X: X[::2].tolist(), np.asfortranarray)
    for then in ways:
        result = Odd(then=then, **settings).plan(sky.Problem(ROOM), stop=STOP, rng=0)
        assert result.effort.evaluations == 100


def never(evaluate, first):
    while True:
        yield


def never_again(evaluate, first, rows=0):
    evaluate(first)
    while True:
        yield
        evaluate(first[:rows])


def ends(evaluate, first):
    evaluate(first)
    yield


def ends_at_once(evaluate, first):
    evaluate(first)
    return iter(())


IDLE = {"never": never, "never again": never_again, "ends": ends, "no generator": ends_at_once}


@every_kind
@pytest.mark.parametrize("way", IDLE.values(), ids=IDLE)
def test_an_optimiser_that_evaluates_nothing_or_ends_is_refused(settings, way, refuses):
    class Idle(sky.WaypointSearch):
        def optimise(self, evaluate, first, rng):
            return way(evaluate, first)

    with refuses():
        Idle(**settings).plan(sky.Problem(ROOM), stop=STOP, rng=0)


@every_kind
def test_one_candidate_an_iteration_is_enough(settings):
    class Slow(sky.WaypointSearch):
        def optimise(self, evaluate, first, rng):
            return partial(never_again, rows=1)(evaluate, first)

    assert Slow(**settings).plan(sky.Problem(ROOM), stop=STOP, rng=0).effort.evaluations == 100


@pytest.mark.parametrize("first", [np.full((25, 6), np.nan), np.zeros(6), [["x"]]], ids=["nan", "flat", "words"])
def test_a_first_population_of_an_objective_is_held_to_the_same(first, refuses):
    class Begins(Length):
        def first(self, problem, rng, candidates, waypoints):
            return first

    with refuses():
        sky.WOA(objective=Begins()).plan(sky.Problem(ROOM), stop=STOP, rng=0)


@pytest.mark.parametrize("paths", [np.zeros((25, 6)), np.full((25, 3, 3), np.nan), np.zeros((3, 3, 3))])
def test_what_an_objective_makes_of_vectors_are_paths(paths, refuses):
    class Bends(Length):
        def paths(self, problem, X):
            return paths

    with refuses():
        sky.WOA(objective=Bends()).plan(sky.Problem(ROOM), stop=STOP, rng=0)


@dataclass(frozen=True, kw_only=True)
class Raises(sky.WaypointSearch):
    """Has a mistake in its second iteration."""

    def optimise(self, evaluate, first, rng):
        evaluate(first)
        yield
        raise KeyError("mistake")


def test_a_run_whose_optimiser_raises_is_named(tmp_path):
    study = sky.Study(scenarios=["map1"], planners=[f"{__name__}:Raises"], seeds=[7], budget={"evaluations": 60})
    with pytest.raises(KeyError) as caught:
        sky.run_study(study, tmp_path / "rows.sqlite")
    assert caught.value.__notes__ == ["in the run map1, Raises, 60 evaluations, seed 7"]
