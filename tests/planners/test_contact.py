"""The time axis of the cost: against dense samples, every path of a small lattice, and the referee."""

import dataclasses
import itertools

import numpy as np
import pytest

import skyverse as sky
from skyverse.planners.contact import contact_of, without_movers
from skyverse.planners.metaheuristic import make_workspace
from skyverse.planners.moves import LatticeTask, judge
from skyverse.trajectory.path_to_trajectory import needed_waypoints
from timed_flights import seconds_inside
from worlds import ROOM

LATTICE_SEARCHES = (sky.MVO(), sky.MVO(as_run=True), sky.GSO(), sky.BBO(), sky.RandomRestart(), sky.WOA(waypoints=3))
STOP = sky.MaxIterations(6)


def ball(radius, points, times, **more):
    return sky.Mover(
        shape=sky.Sphere(centre=(0, 0, 0), radius=radius),
        motion=sky.WaypointMotion(points=points, times=times, **more),
    )


def among(scenario, movers, **more):
    return sky.Scenario.model_validate({**dict(scenario), "movers": tuple(movers), **more})


def priced(problem, nodes):
    """What a search pays for a path of nodes, and what it pays for it without movers."""
    grid, pricing = problem.airspace.grid, problem.airspace.pricing
    costs = []
    for contact in (contact_of(problem), without_movers(contact_of(problem))):
        task = LatticeTask(grid, pricing, contact, problem.source, problem.goal)
        workspace = make_workspace(STOP, len(grid.exits), len(nodes))
        workspace.draft[: len(nodes)] = nodes
        costs.append(judge(task, workspace, len(nodes)))
    return costs


def nodes_of(problem, path):
    grid = problem.airspace.grid
    indices = np.rint((path - grid.origin) / grid.step).astype(int)
    return np.ravel_multi_index(tuple(indices.T), tuple(grid.shape))


@pytest.mark.parametrize("kind", ["spinners", "patrols", "knots", "traffic"])
@pytest.mark.parametrize("name", ["map1", "map3"])
def test_contact_costs_what_dense_samples_of_the_flight_say(name, kind):
    scenario = sky.random_movers(sky.read(name), 150, kind=kind, speed=1.0, seed=3)
    problem, uav = sky.Problem(scenario, departs=2.5), scenario.uavs[0]
    found = 0
    for seed in range(2):
        result = sky.RandomRestart().plan(sky.Problem(sky.read(name)), stop=sky.MaxPaths(300), rng=seed)
        if not result.status.reached:
            continue
        corners = needed_waypoints(problem, result)
        speed, acceleration = uav.max_speed, uav.max_acceleration
        kept = scenario.clearance
        seconds = seconds_inside(scenario.movers, kept, corners, speed, acceleration, 2.5, 1.0, 8_000)
        contact, still = priced(problem, nodes_of(problem, result.path))
        assert still == result.cost
        assert contact - still == pytest.approx(scenario.objective.end * speed * seconds, rel=0.03, abs=2.0)
        found += seconds > 0
    assert found


@pytest.mark.parametrize("planner", LATTICE_SEARCHES, ids=repr)
def test_movers_that_are_never_near_change_nothing(planner):
    far = ball(0.1, [(0.3, 4.7, 3.7)], [0.0])
    alone = planner.plan(sky.Problem(ROOM), stop=STOP, rng=2)
    along = planner.plan(sky.Problem(among(ROOM, [far])), stop=STOP, rng=2)
    assert dataclasses.replace(alone, seconds=0.0) == dataclasses.replace(along, seconds=0.0)


FLAT = sky.Scenario(
    name="a flat yard with a wall in it",
    bounds=sky.Bounds(min=(0, 0, 0), max=(4, 4, 1)),
    obstacles=(sky.Box(min=(1.8, 1.2, 0), max=(2.2, 2.8, 1)),),
    clearance=0.1,
    lattice=sky.Lattice(step=(1, 1, 1)),
    objective=sky.Objective(),
    uavs=(sky.UAV(start=(0, 2, 0), max_speed=1.0, max_acceleration=1.0),),
    targets=(sky.Target(position=(4, 2, 0)),),
)
LOW = ball(0.5, [(2.0, 0.6, 0), (2.0, 1.0, 0)], [0, 3], then="returns")
"""Swings in the lower of the two ways round the wall."""
HIGH = ball(0.3, [(2.0, 3.0, 0)], [0.0])
"""Stands in the shorter part of the upper one."""


def every_path(problem):
    """Yield every path over nodes of the ground that joins start and goal and visits none twice."""
    grid = problem.airspace.grid
    above = grid.shape[2] - 1

    def on(path):
        node = path[-1]
        if node == problem.goal:
            yield path
            return
        for m, offset in enumerate(grid.offsets.tolist()):
            after = node + offset
            if grid.exits[node] >> m & 1 and after not in path and after % (above + 1) == 0:
                yield from on([*path, after])

    yield from on([problem.source])


def truth(problem, nodes):
    """What a path costs with contact, by samples: it is paid by the second that the flight is inside a mover."""
    scenario, uav = problem.scenario, problem.scenario.uavs[0]
    path = problem.places(nodes)
    result = dataclasses.replace(sky.AStar().plan(problem), path=path)
    corners = needed_waypoints(problem, result)
    seconds = seconds_inside(
        scenario.movers, scenario.clearance, corners, uav.max_speed, uav.max_acceleration, problem.departs, 1.0, 4_000
    )
    return len(nodes) + scenario.objective.end * uav.max_speed * seconds


@pytest.mark.parametrize("departs", [0.0, 2.0])
def test_no_search_pays_less_than_the_cheapest_of_all_paths_and_mvo_finds_it(departs):
    problem = sky.Problem(among(FLAT, [LOW, HIGH]), departs=departs)
    costs = [truth(problem, nodes) for nodes in itertools.islice(every_path(problem), 3_000)]
    assert 20 < len(costs) < 3_000
    assert max(costs) > min(costs) + 50  # contact makes a difference
    assert min(costs) == 9
    for planner in LATTICE_SEARCHES:
        paid = []
        result = planner.plan(
            problem, stop=sky.MaxIterations(30), rng=1, on_iteration=lambda now, paid=paid: paid.append(now.cost)
        )
        assert paid[-1] >= min(costs) - 1e-9
        assert paid[-1] == pytest.approx(truth(problem, nodes_of(problem, result.path)), abs=1.0)
        if isinstance(planner, sky.MVO):
            assert paid[-1] == result.cost == min(costs)


def test_the_other_way_round_is_taken_where_a_mover_is_in_the_shorter_one():
    """The direct flight along it is proven by the referee, without anything that resolves conflicts."""
    shorter = sky.Scenario(**{**dict(FLAT), "targets": (sky.Target(position=(4, 1, 0)),)})
    for movers, side in (([], -1), ([LOW], 1)):
        scenario = among(shorter, movers)
        mission = sky.plan_mission(scenario, sky.MVO(), rng=1, options=sky.MissionOptions(keep_apart=False))
        middle = mission.results[0].path[np.abs(mission.results[0].path[:, 0] - 2) < 1e-9]
        assert (np.sign(middle[:, 1] - 2) == side).all()
        assert not mission.violations


def test_the_price_of_contact_steers_a_search_and_is_no_part_of_its_results_cost():
    wall = [ball(3.0, [(2, 2, 0)], [0.0])]
    scenario = among(FLAT, wall)
    paid = []
    result = sky.MVO().plan(
        sky.Problem(scenario), stop=STOP, rng=1, on_iteration=lambda progress: paid.append(progress.cost)
    )
    assert paid[-1] > result.cost + 100
    assert result.cost == sum(result.terms.values()) == result.history.cost[-1]
    mission = sky.plan_mission(scenario, sky.MVO(), stop=STOP, rng=1, options=sky.MissionOptions(keep_apart=False))
    assert {violation.fault for violation in mission.violations} == {sky.Fault.MOVER}


def test_zones_count_while_they_are_closed_and_those_with_a_speed_limit_do_not():
    box = {"min": (1.5, 0, 0), "max": (2.5, 1.6, 1)}
    for zone, departs, side in (
        (sky.Box(**box, active=[[0, 60]]), 0.0, 1),
        (sky.Box(**box, active=[[0, 60]]), 61.0, -1),
        (sky.Box(**box, active=[[0, 60]], max_speed=0.5), 0.0, -1),
    ):
        scenario = sky.Scenario(**{**dict(FLAT), "targets": (sky.Target(position=(4, 1, 0)),), "zones": (zone,)})
        result = sky.MVO().plan(sky.Problem(scenario, departs=departs), rng=1)
        middle = result.path[np.abs(result.path[:, 0] - 2) < 1e-9]
        assert (np.sign(middle[:, 1] - 2) == side).all()


@pytest.mark.parametrize("departs", [-1.0, float("nan"), float("inf")])
def test_an_instant_before_the_mission_is_refused(departs, refuses):
    with refuses():
        sky.Problem(ROOM, departs=departs)
