"""Each way to resolve a conflict where it is the only one, or the cheapest; priorities; what cannot be resolved."""

import threading
from functools import partial

import numpy as np
import pytest
from hypothesis import assume, settings
from hypothesis import given as drawn
from hypothesis import strategies as st

import skyverse as sky
from handmade import hall
from skyverse.deconfliction import PlacedFlight, resolve_conflicts
from skyverse.deconfliction.candidate_pool import CandidatePool
from skyverse.deconfliction.resolve_conflicts import Resolution, _actions
from turns import in_turns

LEFT = sky.MissionOptions(keep_apart=False)


def scenario(uavs, targets, obstacles=(), height=(0, 2), width=10.0):
    bounds = {"min": (0, 0, height[0]), "max": (20, width, height[1])}
    boxes = [sky.Box(min=a, max=b) for a, b in obstacles]
    return hall(None, uavs, targets, step=0.5, bounds=bounds, obstacles=boxes)


def plan(given, assignment="identity", faults=frozenset(), **more):
    mission = sky.plan_mission(given, sky.Taut(), rng=1, assignment=assignment, **more)
    if faults is not None:
        assert {v.fault for v in mission.violations} == faults
    for uav, (target, result) in enumerate(zip(mission.assignment, mission.results, strict=True)):
        if result is not None:
            assert sky.check_result(given, uav, target, result) == []
    return mission


def kinds(mission):
    return {action.kind for action in mission.deconfliction.actions}


def apart(mission):
    done = mission.deconfliction
    assert done.left == ()
    assert mission.violations == ()
    assert mission.apart.verdict is sky.Verdict.PROVEN
    assert done.total_after == pytest.approx(mission.total_time)
    assert done.makespan_after == pytest.approx(mission.makespan)
    return mission


def badness(mission):
    return len(mission.deconfliction.left), round(mission.makespan, 5)


CROSSING = [sky.UAV(start=(1, 5, 1)), sky.UAV(start=(5.2, 0.8, 1))]
ACROSS = [(9, 5, 1), (5.2, 9.2, 1)]


def test_nothing_is_done_where_nobody_is_too_close():
    mission = apart(plan(scenario([sky.UAV(start=(1, 1, 1)), sky.UAV(start=(1, 9, 1))], [(9, 1, 1), (9, 9, 1)])))
    assert mission.deconfliction.actions == mission.deconfliction.found == ()
    assert mission.deconfliction.total_before == mission.deconfliction.total_after


def test_a_short_delay_is_the_cheapest_where_two_ways_cross():
    mission = plan(scenario(CROSSING, ACROSS))
    assert len(mission.deconfliction.found) == 1
    assert kinds(apart(mission)) == {"delay"}
    assert mission.makespan < 1.2 * mission.deconfliction.makespan_before


@pytest.mark.parametrize("first", [0, 1])
def test_the_lower_priority_gives_way(first):
    uavs = [sky.UAV(start=(1, 5, 1), priority=first), sky.UAV(start=(5.2, 0.8, 1), priority=1 - first)]
    mission = apart(plan(scenario(uavs, [(9, 5, 1), (5.2, 9.2, 1)])))
    assert {action.uav for action in mission.deconfliction.actions} == {first}


def test_head_on_they_pass_beside_each_other():
    uavs = [sky.UAV(start=(1, 5, 1)), sky.UAV(start=(19, 5, 1))]
    mission = apart(plan(scenario(uavs, [(19, 5, 1), (1, 5, 1)])))
    assert "detour" in kinds(mission)
    assert mission.makespan < 1.3 * mission.deconfliction.makespan_before


def test_a_parked_uav_is_flown_around():
    uavs = [sky.UAV(start=(1, 5, 1)), sky.UAV(start=(10, 5, 1))]
    mission = apart(plan(scenario(uavs, [(19, 5, 1)])))
    assert kinds(mission) == {"detour"}
    assert mission.trajectories[1] is None
    (action,) = mission.deconfliction.actions
    assert action.sentence.startswith("uav-1 leaves its path to avoid uav-2: ")


CORRIDOR = [((0, 0, 0), (20, 4.6, 2)), ((0, 5.4, 0), (20, 10, 2))]


def test_head_on_in_a_corridor_without_room_to_pass_they_exchange_targets():
    uavs = [sky.UAV(start=(1, 5, 1)), sky.UAV(start=(19, 5, 1))]
    given = scenario(uavs, [(14, 5, 1), (6, 5, 1)], CORRIDOR, height=(0.6, 1.4))
    sent = partial(sky.plan_mission, given, sky.Taut(), rng=1)
    stuck = sent(assignment="identity")
    (left,) = stuck.deconfliction.left
    assert left.uavs == (0, 1)
    assert left.begin <= left.time <= left.end
    assert not left.given
    assert stuck.apart.verdict is sky.Verdict.REFUTED
    assert [v.fault for v in stuck.violations] == [sky.Fault.SEPARATION]
    exchanged = _crossed(given)
    assert kinds(exchanged) == {"exchange"}
    assert exchanged.assignment == (1, 0)
    assert exchanged.deconfliction.left == ()


def _crossed(given, *, exchange=True):
    """Resolve the conflicts of a fleet in which UAV i flies to target i, as nobody would have assigned them."""
    airspace = sky.Airspace(given)
    problems = [sky.Problem(airspace, k, k) for k in range(len(given.uavs))]
    results = tuple(sky.Taut().plan(problem) for problem in problems)
    flown = tuple(sky.fly_along(p, r) for p, r in zip(problems, results, strict=True))
    assignment, replan = tuple(range(len(problems))), sky.Taut().plan if exchange else None
    planned = sky.Mission(given, assignment, results, flown, (), results[0].provenance)
    return resolve_conflicts(airspace, planned, make_trajectory=sky.fly_along, replan=replan)


def test_one_that_would_be_overtaken_in_a_corridor_is_followed():
    uavs = [sky.UAV(start=(3, 5, 1), max_speed=2), sky.UAV(start=(1, 5, 1))]
    mission = apart(plan(scenario(uavs, [(19, 5, 1), (17, 5, 1)], CORRIDOR)))
    assert {action.uav for action in mission.deconfliction.actions} == {1}
    assert kinds(mission) <= {"delay", "slow down"}


def test_one_that_starts_too_close_behind_a_slower_one_is_delayed():
    uavs = [sky.UAV(start=(1, 5, 1)), sky.UAV(start=(1.4, 5, 1), max_speed=2)]
    mission = plan(scenario(uavs, [(17, 5, 1), (19, 5, 1)], CORRIDOR), faults={sky.Fault.GIVEN})
    assert [conflict.given for conflict in mission.deconfliction.found] == [False, False]  # and where it passes again
    assert [conflict.given for conflict in mission.deconfliction.left] == [True]
    assert "delay" in kinds(mission)


def test_who_starts_too_close_to_another_still_gives_way_to_a_higher_priority():
    uavs = [sky.UAV(start=(1, 5, 1)), sky.UAV(start=(1, 5.2, 1)), sky.UAV(start=(5.2, 0.8, 1), priority=1)]
    mission = plan(scenario(uavs, [(9, 5, 1), (9, 9, 1), (5.2, 9.2, 1)]), faults={sky.Fault.GIVEN})
    assert mission.deconfliction.actions
    assert 2 not in {action.uav for action in mission.deconfliction.actions}


@pytest.mark.parametrize("order", [int, lambda uav: -uav], ids=["in order", "backwards"])
def test_an_interruption_keeps_the_best_found_so_far(monkeypatch, order):
    event = threading.Event()
    in_turns(monkeypatch, order)

    class Interrupting(sky.Taut):  # while the last path is planned, which an exact planner does not look at
        def plan(self, problem, **more):
            if problem.uav == 3:
                event.set()
            return super().plan(problem, **more)

    given = sky.circle_swap(4)
    mission = sky.plan_mission(given, Interrupting(), stop=sky.Cancelled(event), assignment="identity", workers=2)
    assert mission.interrupted
    assert all(result.status.reached for result in mission.results)
    assert mission.deconfliction.actions == ()
    assert mission.deconfliction.left == mission.deconfliction.found != ()


def test_an_exchange_is_told_of_even_where_it_does_not_resolve_all_and_compared_with_the_flight_before():
    uavs = [sky.UAV(name="a", start=(1, 5, 1)), sky.UAV(name="b", start=(19, 5, 1))]
    given = scenario(uavs, [(14, 5, 1), (8, 5, 1)])
    airspace = sky.Airspace(given)
    pool = CandidatePool(airspace, sky.fly_along)

    def towards(*targets):
        found = []
        for uav, target in enumerate(targets):
            problem = sky.Problem(airspace, uav, target)
            result = sky.Taut().plan(problem)
            found.append(pool.add_planned(uav, target, result, sky.fly_along(problem, result)))
        return found

    before, own = towards(0, 1), towards(1, 0)
    places = [PlacedFlight(option, 0.0, in_conflict=True) for option in own]
    flown, results = tuple(option.trajectory for option in before), tuple(option.result for option in before)
    planned = sky.Mission(given, (0, 1), results, flown, (), results[0].provenance)
    told = list(_actions(planned, Resolution(own, (), places), pool))
    assert [(action.uav, action.kind) for action in told] == [(0, "exchange"), (1, "exchange")]
    first, second = (action.sentence for action in told)
    assert first.startswith("a flies to target-2, not to target-1: 7 m in ")
    assert " s instead of 13 m in " in first
    assert second.startswith("b flies to target-1, not to target-2: 5 m in ")
    assert " s instead of 11 m in " in second


def test_the_conflicts_of_the_same_fleet_are_resolved_in_the_same_way():
    first, again = (sky.plan_mission(sky.circle_swap(4), sky.Taut(), assignment="identity") for _ in range(2))
    assert first.deconfliction == again.deconfliction
    assert first.trajectories == again.trajectories
    assert first.makespan < 1.2 * first.deconfliction.makespan_before
    apart(first)


def test_a_window_is_passed_both_ways():
    given = sky.window_swap(sky.read("map1"), 6)
    mission = apart(sky.plan_mission(given, sky.Taut(), assignment="identity"))
    assert mission.complete
    ends = np.array([t.at(t.end).position[0] for t in mission.trajectories])
    np.testing.assert_allclose(ends, [t.position for t in given.targets], atol=1e-6)


def crossing(seed, count, *, well_formed=True):
    """A fleet whose UAVs cross an empty hall; no start or target is near another's path if it is well-formed."""
    rng = np.random.default_rng(seed)
    for _ in range(200):
        angles = rng.uniform(0, 2 * np.pi, count)
        heights = rng.uniform(1, 4, (2, count))
        starts = np.column_stack([10 + 8 * np.cos(angles), 10 + 8 * np.sin(angles), heights[0]])
        turned = angles + np.pi + rng.uniform(-0.8, 0.8, count)
        targets = np.column_stack([10 + 8 * np.cos(turned), 10 + 8 * np.sin(turned), heights[1]])
        if not well_formed or all(
            clear_of(ends, starts[other], targets[other])
            for other in range(count)
            for ends in (np.delete(starts, other, 0), np.delete(targets, other, 0))
        ):
            break
    else:
        assume(False)
    priorities = rng.permutation(count)
    uavs = [sky.UAV(start=tuple(p), priority=int(k)) for p, k in zip(starts, priorities, strict=True)]
    return scenario(uavs, [tuple(p) for p in targets], height=(0, 5), width=20.0)


def clear_of(points, start, end):
    """Whether points are farther from a segment than any separation, and than a smooth flight strays from it."""
    share = np.clip((points - start) @ (end - start) / np.sum((end - start) ** 2), 0, 1)[:, None]
    return bool((np.linalg.norm(points - start - share * (end - start), axis=1) > 1.5).all())


def assert_actions_are_what_was_done(given, planned, mission):
    """Whoever is in no action flies as planned; whoever is in one does what it says."""
    done = {}
    for action in mission.deconfliction.actions:
        done.setdefault(action.uav, set()).add(action.kind)
    for uav, (before, after) in enumerate(zip(planned.trajectories, mission.trajectories, strict=True)):
        kinds_of_it = done.get(uav, set())
        assert (mission.assignment[uav] != planned.assignment[uav]) == ("exchange" in kinds_of_it)
        if not kinds_of_it:
            assert after == before
        if kinds_of_it <= {"delay", "slow down"} and before is not None:
            scale = (after.end - after.start) / (before.end - before.start)
            assert (after.start > before.start) == ("delay" in kinds_of_it)
            assert (scale > 1.001) == ("slow down" in kinds_of_it)
            np.testing.assert_allclose(after.knots, after.start + scale * (before.knots - before.start), atol=1e-9)
            at = np.linspace(before.start, before.end, 50)
            moved = after.at(after.start + scale * (at - before.start)).position
            np.testing.assert_allclose(moved, before.at(at).position, atol=1e-6)


@drawn(st.integers(0, 2**32), st.integers(2, 6))
def test_where_no_start_or_target_is_in_the_way_all_is_resolved_proven_and_the_first_priority_flies_as_planned(
    seed, count
):
    given = crossing(seed, count)
    planned, mission = plan(given, faults=None, options=LEFT), plan(given)
    apart(mission)
    assert mission.deconfliction.found == sky.find_conflicts(given, planned.trajectories)
    assert_actions_are_what_was_done(given, planned, mission)
    first = max(range(count), key=lambda uav: given.uavs[uav].priority)
    assert mission.trajectories[first] == planned.trajectories[first]
    if count == 2:
        assert {action.uav for action in mission.deconfliction.actions} <= {1 - first}


@drawn(st.integers(0, 2**32), st.integers(2, 6))
def test_what_is_said_to_be_left_is_what_the_referee_refutes_and_nothing_is_invented(seed, count):
    given = crossing(seed, count, well_formed=False)
    planned, mission = plan(given, faults=None, options=LEFT), plan(given, faults=None)
    left = mission.deconfliction.left
    assert left == sky.find_conflicts(given, mission.trajectories)
    assert {v.uavs for v in mission.violations} == {conflict.uavs for conflict in left}
    assert (mission.apart.verdict is sky.Verdict.PROVEN) == (not left)
    assert_actions_are_what_was_done(given, planned, mission)


@settings(max_examples=20)
@drawn(st.integers(0, 2**32), st.integers(2, 4))
def test_an_exchange_gives_the_same_targets_to_others_and_never_makes_it_worse(seed, count):
    rng = np.random.default_rng(seed)
    xs = np.linspace(1, 19, 2 * count)
    uavs = [sky.UAV(start=(x, 5, 1)) for x in xs[::2]]
    given = scenario(uavs, [(x, 5, 1) for x in rng.permutation(xs[1::2])], CORRIDOR)
    stay = _crossed(given, exchange=False)
    swapped = _crossed(given)
    assert sorted(swapped.assignment) == sorted(stay.assignment) == list(range(count))
    assert badness(swapped) <= badness(stay)
    for uav, (target, trajectory) in enumerate(zip(swapped.assignment, swapped.trajectories, strict=True)):
        ends = trajectory.at([trajectory.start, trajectory.end]).position
        np.testing.assert_allclose(ends, [given.uavs[uav].start, given.targets[target].position], atol=1e-6)


@pytest.mark.parametrize("wrong", [{"uavs": 3}, {"uavs": 128, "radius": 5.0}, {"radius": "a"}])
def test_circles_that_cannot_be_are_refused(refuses, wrong):
    with refuses():
        sky.circle_swap(**wrong)


@pytest.mark.parametrize(("room", "uavs"), [("map1", 102), ("map2", 100)])
def test_windows_that_cannot_be_are_refused(refuses, room, uavs):
    with refuses():
        sky.window_swap(sky.read(room), uavs)


@pytest.mark.parametrize("name", ["table-4.8", "table-4.13"])
def test_a_fleet_priced_in_nodes_has_results_in_nodes_only_after_detours_too(name):
    given = sky.read(name)
    mission = apart(sky.plan_mission(given, sky.AStar(), rng=1, assignment="euclidean"))
    assert not any(result.any_angle for result in mission.results)
    assert all(result.cost >= result.bound for result in mission.results)
    assert mission.cost == sum(round(result.cost) for result in mission.results)
