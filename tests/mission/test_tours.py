"""Tours beside brute force, and what must hold of every mission of tours, whatever is asked for."""

import itertools
import math
import threading
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from handmade import hall
from skyverse.samples.room import random_room
from skyverse.space.world import point_free

APART = sky.MissionOptions(keep_apart=False)


def free_places(scenario, count, seed):
    """Return places (count, 3) where a UAV is clear of all obstacles."""
    rng, space = np.random.default_rng(seed), sky.Airspace(scenario).world.space
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    found = []
    for _ in range(10_000):
        place = np.round(low + (high - low) * rng.uniform(0.02, 0.98, 3), 2)
        if point_free(space, place):
            found.append(tuple(place.tolist()))
        if len(found) == count:
            return found
    pytest.skip("there is hardly a free place")


def with_one_uav(scenario, targets, seed, end):
    start, *places = free_places(scenario, targets + 1, seed)
    uav = scenario.uavs[0].model_copy(update={"start": start, "end": end})
    named = tuple(sky.Target(name=f"t{i}", position=place) for i, place in enumerate(places))
    return scenario.model_copy(update={"uavs": (uav,), "targets": named})


def least_cost(scenario, planner):
    """Return how many targets one tour visits at most, and what it costs at least, by all orders of all subsets."""
    airspace, n = sky.Airspace(scenario), len(scenario.targets)
    home, nodes = scenario.uavs[0].end == "home", scenario.objective.unit == "nodes"

    def cost(begin, end):
        result = planner.plan(sky.Problem(airspace, 0, end, begins=begin))
        return result.cost if result.status.reached else math.inf

    costs = {
        ends: cost(*ends) for ends in itertools.product([None, *range(n)], repeat=2) if ends[0] != ends[1] or not n
    }
    for count in range(n, 0, -1):
        sums = []
        for order in itertools.permutations(range(n), count):
            places = [None, *order, *([None] if home else [])]
            legs = [*itertools.pairwise(places)]
            shared = scenario.objective.fuel * (len(legs) - 1) if nodes and isinstance(planner, sky.AStar) else 0.0
            sums.append(sum(costs[leg] for leg in legs) - shared)
        if min(sums) < math.inf:
            return count, min(sums)
    return 0, 0.0


@pytest.mark.parametrize("end", ["home", "target"])
@pytest.mark.parametrize("planner", [sky.AStar(), sky.Taut()], ids=["astar", "taut"])
@pytest.mark.parametrize("seed", [0, 1, 3, 5, 8])
def test_no_order_costs_less_in_random_rooms(seed, planner, end):
    scenario = with_one_uav(random_room(seed=seed), 4, seed, end)
    mission = sky.plan_mission(scenario, planner)
    assert mission.violations == ()
    visited, least = least_cost(scenario, planner)
    assert len(scenario.targets) - len(mission.unvisited) == visited
    if visited:
        assert mission.results[0].cost == pytest.approx(least, rel=1e-9)


@pytest.mark.parametrize("end", ["home", "target"])
@pytest.mark.parametrize("planner", [sky.AStar(), sky.Taut()], ids=["astar", "taut"])
@pytest.mark.parametrize("name", ["map1", "map2", "map3"])
def test_no_order_costs_less_on_the_maps_of_the_thesis(name, planner, end):
    scenario = with_one_uav(sky.read(name), 5, 1, end)
    mission = sky.plan_mission(scenario, planner)
    assert mission.violations == ()
    assert mission.unvisited == ()
    assert mission.results[0].cost == pytest.approx(least_cost(scenario, planner)[1], rel=1e-9)


BOXES = (
    sky.Box(min=(18, 0, 0), max=(20, 22, 14)),
    sky.Box(min=(30, 18, 0), max=(33, 40, 9)),
    sky.Box(min=(8, 24, 0), max=(14, 30, 15)),
)
"""In the last of them a target may lie."""


@st.composite
def asked(draw):
    """Draw a fleet in a hall with walls, and targets that ask for all that targets may ask for."""
    coordinates = st.tuples(st.integers(2, 38), st.integers(2, 38), st.integers(2, 13))
    count = draw(st.integers(1, 3))
    names = [f"u{i}" for i in range(count)]
    on_battery, windy = draw(st.booleans()), draw(st.booleans())
    uavs = []
    for name in names:
        one = {"name": name, "start": draw(coordinates), "end": draw(st.sampled_from(["home", "target"]))}
        one |= {"max_speed": draw(st.sampled_from([3.0, 8.0])), "capacity": draw(st.sampled_from([None, 2.0]))}
        if on_battery:
            one |= {
                "capacity": 2.0,
                "battery": draw(st.sampled_from([0.05, 2.0, 4.0, 30.0])),
                "hover_power": 200.0,
                "mass": 1.5,
            }
            one |= {"swap": draw(st.sampled_from([0.0, 7.0])), "batteries": draw(st.sampled_from([None, 1, 2]))}
        uavs.append(one)
    targets = []
    for _ in range(draw(st.integers(0, 5))):
        one = {"position": draw(coordinates), "stay": draw(st.sampled_from([0.0, 0.0, 2.5]))}
        one |= {"demand": draw(st.sampled_from([0.0, 1.0, 3.0]))}
        if draw(st.integers(0, 3)) == 0:
            opens = draw(st.sampled_from([0.0, 15.0]))
            one["window"] = opens, opens + draw(st.sampled_from([0.0, 12.0, 40.0]))
        if draw(st.integers(0, 4)) == 0:
            one["uavs"] = (draw(st.sampled_from(names)),)
        pointed = draw(st.integers(0, 5))
        one |= {"heading": 200.0} if pointed == 0 else {"look_at": (10.0, 10.0, 0.0)} if pointed == 1 else {}
        targets.append(one)
    if len(targets) > 1 and draw(st.booleans()):
        targets[0] = targets[0] | {"position": targets[1]["position"]}
    wind = {"velocity": draw(st.sampled_from([(1.0, -1.0, 0.0), (0.0, 2.0, 0.3)])), "gust": 0.4} if windy else None
    return hall((40, 40, 16), uavs, targets, step=2.0, obstacles=BOXES, clearance=0.5, wind=wind)


def visits_of(mission):
    return sorted(visit.target for own in mission.sorties for one in own for visit in one.visits)


def require_sound(mission):
    """Require what must hold of every mission of tours."""
    scenario = mission.scenario
    given = {one.fault for one in mission.violations} <= {sky.Fault.GIVEN, sky.Fault.SEPARATION}
    left = () if mission.deconfliction is None else mission.deconfliction.left
    assert given, [one.message for one in mission.violations]
    assert mission.violations == () or left  # conflicts that waits do not resolve are told
    named = [one.target for one in mission.unvisited]
    assert sorted([*visits_of(mission), *named]) == [*range(len(scenario.targets))]
    assert all(one.why for one in mission.unvisited)
    flying = all(result is None or result.status.reached for result in mission.results)
    assert mission.complete == (not named and flying)


@settings(deadline=None, max_examples=60)
@given(
    scenario=asked(),
    planner=st.sampled_from([sky.Taut(), sky.AStar()]),
    criterion=st.sampled_from(["min-sum", "min-max"]),
    order=st.sampled_from(["best", "given"]),
)
def test_the_referee_finds_nothing_wrong_and_each_target_is_visited_once_or_named(scenario, planner, criterion, order):
    options = sky.MissionOptions(criterion=criterion, order=order)
    mission = sky.plan_mission(scenario, planner, assignment="tours", options=options)
    require_sound(mission)
    if order == "given":
        for own in mission.sorties:
            visited = [visit.target for one in own for visit in one.visits]
            assert visited == sorted(visited)


@settings(deadline=None, max_examples=20)
@given(scenario=asked())
def test_tours_of_other_planners_keep_windows_and_batteries_too(scenario):
    planner, stop = sky.MVO(universes=4), sky.MaxIterations(3)
    mission = sky.plan_mission(scenario, planner, stop=stop, rng=1, assignment="tours")
    require_sound(mission)


HOME = {"end": "home"}
POWER = {"hover_power": 200.0, "mass": 1.5}


def lone(targets, **changes):
    uav = {"start": (2, 2, 2), "end": "home"} | changes.pop("uav", {})
    return hall(changes.pop("size", (20, 20, 10)), [uav], targets, **changes)


SHUT = tuple(
    sky.Box(min=low, max=high)
    for low, high in (
        ((10, 10, 0), (16, 10.5, 10)),
        ((10, 15.5, 0), (16, 16, 10)),
        ((10, 10, 0), (10.5, 16, 10)),
        ((15.5, 10, 0), (16, 16, 10)),
    )
)
WITHSTOOD = {
    "no targets": (lone([]), []),
    "targets that coincide": (lone([(5, 5, 5)] * 4), []),
    "targets at the start": (lone([(2, 2, 2)] * 2), []),
    "targets at the start, and no way home": (lone([(2, 2, 2)] * 2, uav={"end": "target"}), []),
    "windows that exclude each other": (
        lone([{"position": (18, 2, 2), "window": (10, 11)}, {"position": (2, 18, 2), "window": (10, 11)}]),
        ["no UAV has time, battery or capacity left for it beside the others"],
    ),
    "a window that nobody meets": (
        lone([{"position": (18, 2, 2), "window": (0, 1)}, (2, 18, 2)]),
        ["no UAV can be there before its window closes"],
    ),
    "a battery that reaches nothing": (
        lone([(400, 2, 2), (2, 400, 2)], uav=POWER | {"battery": 0.01}, size=(500, 500, 10)),
        ["no battery gives what it takes to go there and back"] * 2,
    ),
    "one battery where two are needed": (
        lone([(18, 2, 2), (2, 18, 2)], uav=POWER | {"battery": 0.9, "batteries": 1}),
        ["no UAV has time, battery or capacity left for it beside the others"],
    ),
    "a load too heavy": (
        lone([{"position": (18, 2, 2), "demand": 2.0}, (2, 18, 2)], uav={"capacity": 1.0}),
        ["its demand is above what any UAV that may go there can carry"],
    ),
    "a target shut in": (lone([(13, 13, 5), (18, 18, 5)], obstacles=SHUT), ["no UAV has a way there and back"]),
    "a target in an obstacle": (
        lone([(10.2, 13, 5), (18, 18, 5)], obstacles=SHUT),
        ["no UAV has a way there and back"],
    ),
    "a target out of bounds": (lone([(30, 13, 5), (18, 18, 5)]), ["no UAV has a way there and back"]),
    "a start shut in": (
        lone([(1, 13, 5), (18, 18, 5)], uav={"start": (13, 13, 2)}, obstacles=SHUT),
        ["no UAV has a way there and back"] * 2,
    ),
    "nobody who could fly": (hall((20, 20, 10), [], [{"position": (2, 2, 2), "stay": 1.0}]), ["no UAV may go there"]),
}


@pytest.mark.parametrize("name", WITHSTOOD)
@pytest.mark.parametrize("planner", [None, sky.AStar()], ids=["auto", "astar"])
def test_what_cannot_be_visited_is_named_with_why_and_the_rest_is_flown(name, planner):
    scenario, why = WITHSTOOD[name]
    mission = sky.plan_mission(scenario, planner, assignment="tours")
    require_sound(mission)
    assert [one.why for one in mission.unvisited] == why


def test_a_wind_above_the_airspeed_is_refused():
    with pytest.raises(sky.InputError, match="cannot hold its place"):
        sky.plan_mission(lone([(18, 2, 2)] * 2, uav={"max_airspeed": 5}, wind={"velocity": (6, 0, 0)}))


def test_aeroplanes_make_no_tours():
    wing = {"fixed_wing": {"speed": 15, "turn_radius": 90, "climb": 5}, "max_speed": 25, "start": (200, 200, 50)}
    with pytest.raises(sky.InputError, match="is an aeroplane, which cannot stop at targets"):
        sky.plan_mission(lone([(1300, 300, 50), (1800, 900, 50)], uav=wing, size=(2000, 2000, 100)))


def test_uavs_that_do_not_exist_are_refused():
    with pytest.raises(ValueError, match="there is no UAV of the name 'zulu'"):
        lone([{"position": (18, 2, 2), "uavs": ("zulu",)}])


def test_the_given_order_is_kept():
    scenario = lone([(10, 2, 2), (18, 2, 2), (14, 2, 2), (5, 2, 2)])
    mission = sky.plan_mission(scenario, options=sky.MissionOptions(order="given"))
    require_sound(mission)
    assert [visit.target for visit in mission.sorties[0][0].visits] == [0, 1, 2, 3]


@pytest.mark.parametrize("targets", [3, 12])
def test_a_cancelled_run_is_marked(targets):
    event = threading.Event()
    event.set()
    scenario = lone([(2 + k, 5 + k % 3, 5) for k in range(targets)])
    mission = sky.plan_mission(scenario, stop=sky.Cancelled(event))
    assert mission.interrupted
    assert not mission.complete
    assert mission.violations == ()


class CancelsInTheMidst(sky.Stop):
    """Cancels a run once a path has been sought for some iterations."""

    def __init__(self):
        self.seen = False

    def met(self, progress):
        self.seen = True
        return "Cancelled"

    @property
    def cancelled(self):
        return self.seen


def test_a_run_that_is_cancelled_while_the_legs_are_planned_is_marked():
    stop = sky.MaxIterations(50) | CancelsInTheMidst()
    mission = sky.plan_mission(lone([(13, 3, 5), (18, 18, 5)], obstacles=SHUT), sky.MVO(universes=4), stop=stop, rng=1)
    assert mission.interrupted
    assert not mission.complete


def test_scenarios_that_ask_for_nothing_new_make_no_tours(monkeypatch):
    monkeypatch.setattr("skyverse.mission.plan_mission.plan_tours", lambda *_: pytest.fail("tours were planned"))
    for scenario in (sky.read("table-4.8"), hall((20, 20, 10), [(2, 2, 2)], [(5, 5, 5)])):
        assert sky.plan_mission(scenario, sky.AStar(), options=APART).sorties == ()


def test_one_target_for_each_uav_is_flown_as_without_tours_to_the_last_digit():
    starts, places = [(2, 2, 2), (2, 30, 3), (30, 3, 5)], [(36, 36, 12), (5, 5, 5), (30, 10, 2)]
    plain = hall((40, 40, 16), starts, places, obstacles=BOXES, clearance=0.5)
    today = sky.plan_mission(plain, options=APART)
    may = {j: plain.uavs[i].name for i, j in enumerate(today.assignment)}
    alone = [one.model_copy(update={"uavs": (may[j],)}) for j, one in enumerate(plain.targets)]
    tours = sky.plan_mission(plain.model_copy(update={"targets": tuple(alone)}), options=APART)
    assert tours.sorties
    assert tours.assignment == today.assignment
    for now, then in zip(tours.trajectories, today.trajectories, strict=True):
        np.testing.assert_array_equal(now.knots, then.knots)
        np.testing.assert_array_equal(now.coefficients, then.coefficients)
    assert [one.cost for one in tours.results] == [one.cost for one in today.results]


def crossing(**changes):
    """Two tours that would meet in the middle, each over and back."""
    uavs = [{"name": "a", "start": (2, 20, 5)} | HOME | changes, {"name": "b", "start": (20, 2, 5)} | HOME | changes]
    targets = [
        {"position": (38, 20, 5), "stay": 1.0, "uavs": ("a",)},
        {"position": (20, 38, 5), "stay": 1.0, "uavs": ("b",)},
    ]
    return hall((40, 40, 10), uavs, targets)


def test_tours_that_would_meet_wait_for_each_other_and_are_proven_apart():
    scenario = crossing()
    together = sky.plan_mission(scenario, options=APART)
    assert {one.fault for one in together.violations} == {sky.Fault.SEPARATION}
    mission = sky.plan_mission(scenario)
    require_sound(mission)
    assert mission.violations == ()
    assert mission.deconfliction.found
    assert not mission.deconfliction.left
    assert mission.apart.verdict is sky.Verdict.PROVEN
    assert mission.actions[0].kind == "wait"
    assert mission.makespan > together.makespan


def test_a_uav_in_two_sorties_never_conflicts_with_itself():
    targets = [{"position": place, "demand": 1.0} for place in ((10, 2, 2), (18, 2, 2))]
    mission = sky.plan_mission(lone(targets, uav={"capacity": 1.0, "swap": 5.0}))
    require_sound(mission)
    assert len(mission.sorties[0]) == 2
    assert mission.deconfliction is None or not mission.deconfliction.found
    (first, second) = mission.sorties[0]
    assert second.begin == pytest.approx(first.end + 5.0)


def test_flying_in_the_order_of_the_wind_is_not_dearer_than_any_other_order():
    scenario = lone([(18, 2, 2), (18, 18, 2), (2, 18, 2)], uav={"max_airspeed": 6.0}, wind={"velocity": (3.0, 0, 0)})
    best = sky.plan_mission(scenario)
    require_sound(best)
    for order in itertools.permutations(scenario.targets):
        given = sky.plan_mission(
            scenario.model_copy(update={"targets": order}), options=sky.MissionOptions(order="given")
        )
        assert best.makespan <= given.makespan + 1e-9


def test_on_target_pads_the_tracking_error_does_not_count_for_what_is_below():
    error = sky.TrackingError(horizontal=1.0, vertical=1.5)
    roofs = (sky.Box(min=(12, 2, 0), max=(18, 8, 4)), sky.Box(min=(12, 22, 0), max=(18, 28, 6)))
    scenario = hall(
        (40, 30, 20),
        [{"start": (4, 15, 0.5), "end": "home", "tracking_error": error}],
        [{"position": (15, 5, 4.5), "stay": 2.0}, {"position": (15, 25, 6.5)}, (30, 15, 0.5)],
        obstacles=roofs,
        clearance=0.5,
    )
    mission = sky.plan_mission(scenario, sky.Taut())
    require_sound(mission)
    assert visits_of(mission) == [0, 1, 2]
    assert mission.certificates[0].verdict is sky.Verdict.PROVEN
    beside = replace(
        mission, scenario=scenario.model_copy(update={"obstacles": (*roofs, sky.Box(min=(15.8, 4, 0), max=(18, 6, 5)))})
    )
    assert {one.fault for one in sky.check(beside.scenario, beside)} >= {sky.Fault.TRAJECTORY_CLEARANCE}
