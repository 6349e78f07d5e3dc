"""Objectives of one's own: what is minimised, kept, told and judged."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

import skyverse as sky
from skyverse.cost import wrong_figures
from skyverse.lab import plan_job, read_study, write_study
from skyverse.planners.objective import priced_result, rescored
from studies import job
from worlds import ROOM

STOP = sky.MaxEvaluations(300)


@dataclass(frozen=True)
class Danger(sky.PathObjective):
    """Length, and danger near a threat; paths through the threat are forbidden."""

    reach: float = 2.0

    def prices(self, problem, paths):
        length = np.linalg.norm(np.diff(paths, axis=1), axis=2).sum(axis=1)
        far = np.linalg.norm(paths - (3.0, 2.0, 2.0), axis=2).min(axis=1)
        return np.where(far < 0.2, np.inf, length + np.maximum(0, self.reach - far))

    def bound(self, problem):
        return math.dist(problem.start, problem.end)


EMPTY = ROOM.model_copy(update={"obstacles": ()})
METHODS = [sky.WaypointMVO, sky.WaypointBBO, sky.WaypointGSO, sky.WOA, sky.MFO, sky.DA]


@pytest.mark.parametrize("kind", METHODS)
def test_the_best_of_all_paths_that_were_priced_is_told_with_its_price(kind):
    seen = []

    class Watched(Danger):
        def prices(self, problem, paths):
            found = super().prices(problem, paths)
            seen.extend(zip(found.tolist(), paths, strict=True))
            return found

    problem, objective = sky.Problem(EMPTY), Watched()
    result = kind(waypoints=2, objective=objective).plan(problem, stop=STOP, rng=1)
    price, path = min(seen[:300], key=lambda one: one[0])
    assert result.cost == price
    np.testing.assert_array_equal(result.path, path)
    assert (result.bound, result.objective) == (objective.bound(problem), repr(objective))
    assert result.effort.evaluations == result.effort.generated_paths == 300
    history = result.history
    best = np.minimum.accumulate([price for price, _ in seen[:300]])
    np.testing.assert_array_equal(
        history.cost[history.evaluations > 0], best[history.evaluations[history.evaluations > 0] - 1]
    )
    assert sky.check_result(EMPTY, 0, 0, result) == []


def test_the_referee_judges_the_path_all_the_same():
    problem = sky.Problem(ROOM)
    through = np.vstack([problem.start, problem.end])[None]
    result = sky.WOA(waypoints=1, objective=Danger(reach=0.0)).plan(problem, stop=STOP, rng=0)
    straight = priced_result(problem, Danger(), through[0], result.cost, result_record(result))
    assert sky.check_result(ROOM, 0, 0, straight)  # the wall
    assert wrong_figures(ROOM, problem.airspace.rates, straight) == ""


def result_record(result):
    from skyverse.planners.results import SearchRecord

    return SearchRecord(result.provenance, result.effort, result.seconds, result.history, result.stopped_by)


def test_a_path_that_was_sought_for_something_else_is_priced_where_it_ended():
    problem, objective = sky.Problem(ROOM), Danger()
    found = sky.MVO().plan(problem, stop=sky.MaxPaths(50), rng=0)
    priced = rescored(problem, objective, found)
    assert priced.cost == objective.prices(problem, found.path[None])[0]
    assert priced.effort == found.effort
    end = {"cost": [priced.cost], "iteration": found.history.iteration[-1:].tolist()} | {
        name: [count] for name, count in vars(found.effort).items()
    }
    assert {name: column.tolist() for name, column in vars(priced.history).items()} == end
    assert rescored(problem, objective, priced) is priced


def test_what_is_priced_lies_between_the_pads_and_what_is_told_begins_at_the_uav():
    uav = sky.UAV(start=(0.6, 0.7, 0.02), tracking_error=sky.TrackingError(vertical=0.05))
    low = EMPTY.model_copy(update={"uavs": (uav,)})
    problem, objective = sky.Problem(low), Danger()
    assert len(problem.lifts[0]) == 1
    for found in (
        sky.WOA(waypoints=1, objective=objective).plan(problem, stop=STOP, rng=0),
        rescored(problem, objective, sky.Taut().plan(problem)),
    ):
        assert found.cost == objective.prices(problem, problem.without_lifts(found.path)[None])[0]
        assert sky.check_result(low, 0, 0, found) == []


def test_a_path_that_ends_short_has_no_price_of_the_objective_and_keeps_none_of_the_scenario():
    problem, objective = sky.Problem(sky.read("map1")), Danger()
    short = sky.MVO(universes=2, generator="uniform").plan(problem, stop=sky.MaxPaths(2), rng=0)
    assert short.status is sky.Status.INCOMPLETE
    priced = rescored(problem, objective, short)
    assert (priced.cost, priced.status, priced.effort) == (math.inf, sky.Status.NO_PATH, short.effort)
    assert priced.history.cost.tolist() == [math.inf]


def test_what_forbids_every_path_leaves_none():
    class Never(Danger):
        def prices(self, problem, paths):
            return np.full(len(paths), np.inf)

    for kind in METHODS:
        result = kind(objective=Never()).plan(sky.Problem(EMPTY), stop=STOP, rng=0)
        assert (result.status, result.cost, len(result.path)) == (sky.Status.NO_PATH, np.inf, 0)
        assert result.effort.evaluations == 300


WRONG = {
    "short": lambda price: price[:-1],
    "nested": lambda price: price[:, None],
    "nan": lambda price: price * np.nan,
    "unbounded": lambda price: price * -np.inf,
    "words": lambda price: ["much"] * len(price),
    "nothing": lambda price: None,
    "single": lambda price: 3.0 if len(price) > 1 else np.zeros(3),
}


@dataclass(frozen=True)
class Told(Danger):
    """Prices as somebody's code may return them."""

    way: str = "short"

    def prices(self, problem, paths):
        return WRONG[self.way](super().prices(problem, paths))


@pytest.mark.parametrize("way", WRONG)
def test_what_is_no_price_for_each_path_is_refused_however_the_path_was_found(way, refuses):
    problem = sky.Problem(EMPTY)
    with refuses():
        sky.WOA(objective=Told(way=way)).plan(problem, stop=STOP, rng=0)
    with refuses():
        rescored(problem, Told(way=way), sky.Taut().plan(problem))


def test_a_list_of_prices_counts_as_an_array():
    class Listed(Danger):
        def prices(self, problem, paths):
            return super().prices(problem, paths).tolist()

    problem = sky.Problem(EMPTY)
    found, listed = (sky.WOA(objective=kind()).plan(problem, stop=STOP, rng=0) for kind in (Danger, Listed))
    assert listed.cost == found.cost


@pytest.mark.parametrize("bound", [1e9, math.nan, "3"])
def test_a_bound_that_a_path_undercuts_proves_nothing_and_is_refused(bound, refuses):
    class Bounded(Danger):
        def bound(self, problem):
            return bound

    problem = sky.Problem(EMPTY)
    with refuses():
        rescored(problem, Bounded(), sky.Taut().plan(problem))
    with refuses():
        sky.WOA(objective=Bounded()).plan(problem, stop=STOP, rng=0)


def test_a_bound_below_zero_is_reached_like_any_other():
    class Gain(Danger):
        def prices(self, problem, paths):
            return super().prices(problem, paths) - 1000.0

        def bound(self, problem):
            return rescored(problem, Plain(), sky.Taut().plan(problem)).cost

    class Plain(Gain):
        def bound(self, problem):
            return None

    problem = sky.Problem(EMPTY)
    assert rescored(problem, Gain(), sky.Taut().plan(problem)).status is sky.Status.OPTIMAL


@pytest.mark.parametrize(("less", "gap"), [(0.0, 0.0), (1.0, None)])
def test_a_share_above_a_bound_that_is_not_positive_means_nothing(less, gap):
    class Offset(sky.PathObjective):
        def prices(self, problem, paths):
            return np.full(len(paths), -1.0)

        def bound(self, problem):
            return -1.0 - less

    row = plan_job(replace(job(sky.Taut(), scenario=EMPTY, seed=0), objective=Offset()))
    assert row.success
    assert (row.bound, row.gap) == (-1.0 - less, gap)


@pytest.mark.parametrize("budget", [1, 10, 26, 75])
def test_no_path_is_priced_beyond_the_budget(budget):
    seen = []

    class Counted(Danger):
        def prices(self, problem, paths):
            seen.extend(paths)
            return super().prices(problem, paths)

    for stop in (sky.MaxEvaluations(budget), sky.MaxPaths(budget), sky.MaxNodes(7 * budget - 1)):
        seen.clear()
        result = sky.WOA(waypoints=6, objective=Counted()).plan(sky.Problem(EMPTY), stop=stop, rng=0)
        assert len(seen) == result.effort.evaluations == budget


def test_a_study_compares_all_planners_by_the_objective(tmp_path):
    study = sky.Study(
        scenarios=["map1"],
        planners=["woa", "waypoint-mvo", "astar"],
        seeds=2,
        budget={"evaluations": 200},
        objective=Length(metres=2.0),
    )
    with sky.run_study(study, tmp_path / "rows.db") as rows:
        found = list(rows)
    problem = sky.Problem(sky.read("map1"))
    for row in found:
        assert row.bound == 2.0 * math.dist(problem.start, problem.end)
        assert row.gap == pytest.approx(row.cost / row.bound - 1)
    exact = sky.AStar().plan(problem).path
    costs = [row.cost for row in found if row.planner == "astar"]
    assert costs == pytest.approx([2.0 * sum(map(math.dist, exact, exact[1:]))] * 2)
    write_study(study, tmp_path / "study.yaml")
    assert read_study(tmp_path / "study.yaml").objective.make() == Length(metres=2.0)
    by_name = sky.Study(scenarios=["map1"], planners=["woa"], objective=f"{__name__}:Length")
    assert by_name.objective.make() == Length()


def test_a_planner_with_an_objective_of_its_own_is_not_compared_with_others(refuses):
    study = sky.Study(scenarios=["map1"], planners=[sky.WOA(objective=Length()), sky.DA(legs="straight")])
    with refuses():
        list(study.jobs())


@dataclass(frozen=True)
class Length(sky.PathObjective):
    """Length alone."""

    metres: float = 1.0

    def prices(self, problem, paths):
        return self.metres * np.linalg.norm(np.diff(paths, axis=1), axis=2).sum(axis=1)

    def bound(self, problem):
        return self.metres * math.dist(problem.start, problem.end)
