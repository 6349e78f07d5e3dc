"""Waiting on the way: the search against a brute-force one over ticks of time, its parts against sampling, missions."""

import numpy as np
import pytest
from hypothesis import given as drawn
from hypothesis import settings
from hypothesis import strategies as st

import skyverse as sky
from handmade import hall
from skyverse.deconfliction import CurveStore, Schedule, prioritized_planning
from skyverse.deconfliction.space_time import waiting_flights
from skyverse.deconfliction.space_time.leg_profiles import SECONDS, leg_profiles
from skyverse.deconfliction.space_time.others import make_others
from skyverse.deconfliction.space_time.roadmap import make_roadmap
from skyverse.deconfliction.space_time.search import ArrivalQuery, RoadmapGraph, earliest_arrival, seconds_to
from skyverse.model.timed_shapes import TimedShape
from skyverse.model.trajectory import joined
from skyverse.model.wind import STILL_AIR
from skyverse.numerics.tolerances import LIMIT_MARGIN
from skyverse.space.timed_shapes import moving_shapes
from skyverse.trajectory import rest_to_rest
from skyverse.trajectory.limits import limits_of

UAV = sky.UAV(start=(0, 0, 0), max_speed=1.5, max_acceleration=3.0)
LIMITS = limits_of(UAV, -LIMIT_MARGIN, STILL_AIR)
SEPARATION = 0.4
PARTS = 50  # ticks of a leg


def lattice(cells):
    """A roadmap of unit legs between cells of a level lattice."""
    points = np.array([(x, y, 0.0) for x, y in cells], dtype=np.float64)
    ways = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)], dtype=np.float64)
    legs = [
        (a, b, k)
        for a in range(len(points))
        for k, way in enumerate(ways)
        for b in np.flatnonzero((points == points[a] + way).all(axis=1)).tolist()
    ]
    starts, ends, kinds = np.array(legs).T
    first = np.searchsorted(starts, np.arange(len(points) + 1))
    return RoadmapGraph(points, first, np.ascontiguousarray(ends), np.ascontiguousarray(kinds), ways)


def ticked(graph, profiles, flights, source, target, separation):
    """The earliest arrival if UAVs depart at ticks and keep a separation at the ticks; infinite if there is none."""
    tick = profiles[0, SECONDS] / PARTS
    end = max(flight.end for flight in flights) + 30.0
    now = np.arange(int(end / tick)) * tick
    theirs = np.array([flight.at(now).position for flight in flights])

    def apart(places, ticks):
        return (np.linalg.norm(theirs[:, ticks] - places, axis=-1) >= separation).all(axis=0)

    count = len(now)
    hovers = np.array([apart(point, slice(None)) for point in graph.points])
    steps = np.arange(PARTS + 1)
    legs = []
    for a in range(len(graph.points)):
        for leg in range(graph.first[a], graph.first[a + 1]):
            b = graph.end[leg]
            places = rest_to_rest(graph.points[[a, b]], UAV).at(steps * tick).position
            window = np.arange(count - PARTS)[:, None] + steps
            legs.append((a, b, apart(places, window).all(axis=1)))
    reached = np.zeros((len(graph.points), count), np.bool_)
    reached[source, 0] = hovers[source, 0]
    for k in range(1, count):
        reached[:, k] |= reached[:, k - 1] & hovers[:, k]
        for a, b, free in legs:
            if k >= PARTS and reached[a, k - PARTS] and free[k - PARTS]:
                reached[b, k] = True
    for_ever = np.flip(np.logical_and.accumulate(np.flip(hovers[target])))
    arrivals = np.flatnonzero(reached[target] & for_ever)
    return now[arrivals[0]] if len(arrivals) else np.inf


CELLS = st.sets(st.tuples(st.integers(0, 4), st.integers(0, 2)), min_size=5, max_size=11).map(sorted)


@settings(max_examples=20)
@drawn(CELLS, st.integers(1, 3), st.integers(0, 2**32 - 1), st.booleans())
def test_the_search_arrives_when_a_brute_force_search_over_ticks_does(cells, others, seed, as_movers):
    rng = np.random.default_rng(seed)
    graph = lattice_or_none(cells)
    if graph is None:
        return
    profiles = leg_profiles(graph.ways, LIMITS)
    flights, store, departures = [], CurveStore(), []
    for _ in range(others):
        way = [int(rng.integers(len(graph.points)))]
        for _ in range(int(rng.integers(1, 7))):
            first, last = graph.first[way[-1]], graph.first[way[-1] + 1]
            if first < last:
                way.append(int(graph.end[rng.integers(first, last)]))
        if len(way) == 1:
            return
        departures.append(float(rng.integers(0, 4)))
        flights.append(rest_to_rest(graph.points[way], UAV, start=departures[-1]))
        store.add(flights[-1])
    n = 0 if as_movers else len(flights)
    schedule = Schedule(np.arange(n), np.array(departures[:n]), np.ones(n))
    movers = moving_shapes([mover_along(flight) for flight in flights[n:]], sky.TrackingError())
    horizon = max(flight.end for flight in flights) + 60.0 if as_movers else 0.0
    known = make_others(store.arrays, schedule, np.full((n, 2), SEPARATION), movers, horizon)
    source, target = rng.integers(len(graph.points), size=2).tolist()
    left = seconds_to(graph, profiles, target)
    query = ArrivalQuery(graph, profiles, known, left, source, target, 0.0, 1.0, 100_000, np.inf)
    found = earliest_arrival(query)
    arrival = found.arrivals[-1] if len(found.vertices) else np.inf
    for latest, there in ((arrival + 1e-6, True), (arrival - 1e-3, False)):
        bounded = earliest_arrival(query._replace(latest=latest))
        if source != target and arrival < np.inf:
            assert (len(bounded.vertices) > 0) == there
            assert not there or bounded.arrivals[-1] == pytest.approx(arrival, abs=1e-9)
    if as_movers and arrival >= horizon:
        arrival = np.inf  # movers do not count any more
    tick = profiles[0, SECONDS] / PARTS
    assert arrival <= ticked(graph, profiles, flights, source, target, 1.25 * SEPARATION) + tick
    assert arrival >= ticked(graph, profiles, flights, source, target, 0.8 * SEPARATION) - tick
    if len(found.vertices) >= 2:  # the flight itself, sampled closely
        parts = [rest_to_rest(graph.points[found.vertices[k : k + 2]], UAV) for k in range(len(found.vertices) - 1)]
        for part, departure in zip(parts, found.departures, strict=False):
            instants = np.linspace(0.0, part.end, 200)
            places = part.at(instants).position
            for flight in flights:
                gaps = np.linalg.norm(flight.at(departure + instants).position - places, axis=1)
                assert gaps.min() >= SEPARATION


def mover_along(flight):
    """A sphere that moves as a flight does, from which others keep the separation."""
    motion = sky.PolynomialMotion(knots=flight.knots.tolist(), coefficients=flight.coefficients.tolist())
    return TimedShape(sky.Sphere(centre=(0, 0, 0), radius=SEPARATION), motion, sky.Doubt(), 0.0)


def lattice_or_none(cells):
    """The roadmap of cells of which at least two are neighbours."""
    near = any(abs(a - c) + abs(b - d) == 1 for a, b in cells for c, d in cells)
    return lattice(cells) if near else None


def test_a_roadmap_leads_through_a_gap_that_is_narrower_than_its_lattice():
    walls = [sky.Box(min=(4, 0, 0), max=(5, 4.97, 4)), sky.Box(min=(4, 5.03, 0), max=(5, 10, 4))]
    room = room_of(walls, [sky.UAV(start=(1, 5, 2))], [(9, 5, 2)], width=10.0, high=4.0)
    graph = make_roadmap(sky.World(room), [np.array([(1.0, 5, 2), (9.0, 5, 2)])], [], np.array([0.5, 1.0]))
    profiles = leg_profiles(graph.ways, LIMITS)
    source, target = (int(np.argmin(np.linalg.norm(graph.points - end, axis=1))) for end in ((1, 5, 2), (9, 5, 2)))
    assert np.isfinite(seconds_to(graph, profiles, target)[source])
    begins = np.repeat(np.arange(len(graph.points)), np.diff(graph.first))
    np.testing.assert_allclose(graph.points[begins] + graph.ways[graph.kind], graph.points[graph.end], atol=1e-9)
    legs = np.random.default_rng(1).integers(len(graph.end), size=2_000)
    assert sky.World(room).segments_free(graph.points[begins[legs]], graph.points[graph.end[legs]]).all()


def room_of(walls, uavs, targets, width, high, error=None):
    if error is not None:
        uavs = [uav.model_copy(update={"tracking_error": error}) for uav in uavs]
    return hall((20, width, high), uavs, targets, step=0.5, obstacles=walls, clearance=0.1)


BAY = [
    sky.Box(min=low, max=high)
    for low, high in (
        ((0, 0, 0), (20, 4.6, 2)),
        ((0, 5.4, 0), (9, 8, 2)),
        ((11, 5.4, 0), (20, 8, 2)),
        ((9, 7, 0), (11, 8, 2)),
    )
]
HEAD_ON = [sky.UAV(start=(1, 5, 1)), sky.UAV(start=(19, 5, 1))]
BEYOND = [(18, 5, 1), (2, 5, 1)]


@pytest.mark.parametrize("error", [None, sky.TrackingError(horizontal=0.05, vertical=0.05)])
def test_head_on_in_a_corridor_one_waits_in_a_bay(error):
    given = room_of(BAY, HEAD_ON, BEYOND, width=8.0, high=2.0, error=error)
    mission = sky.plan_mission(given, sky.Taut(), assignment="identity")
    assert mission.deconfliction.left == mission.violations == ()
    assert mission.apart.verdict is sky.Verdict.PROVEN
    assert all(certificate.verdict is sky.Verdict.PROVEN for certificate in mission.certificates)
    (wait,) = (action for action in mission.deconfliction.actions if action.kind == "wait")
    assert wait.sentence.startswith(f"{given.uavs[wait.uav].name} waits ")
    instants = np.linspace(0.0, mission.makespan, 4_000)
    motion = mission.trajectories[wait.uav].at(instants)
    hovering = (np.linalg.norm(motion.velocity, axis=1) < 1e-9) & (instants < mission.trajectories[wait.uav].end - 0.1)
    inside = (motion.position[:, 0] > 9) & (motion.position[:, 0] < 11)
    assert (hovering & inside).any()


def test_without_a_bay_the_conflict_stays():
    walls = [sky.Box(min=(0, 0, 0), max=(20, 4.8, 1)), sky.Box(min=(0, 5.2, 0), max=(20, 8, 1))]
    uavs = [sky.UAV(start=(x, 5, 0.5)) for x in (1, 19)]
    given = room_of(walls, uavs, [(18, 5, 0.5), (2, 5, 0.5)], width=8.0, high=1.0)
    mission = sky.plan_mission(given, sky.Taut(), assignment="identity")
    assert [conflict.uavs for conflict in mission.deconfliction.left] == [(0, 1)]


@pytest.mark.parametrize("make", [lambda: sky.tunnel_swap(10, width=1.0), lambda: sky.random_maze(8, cells=4)])
def test_fleets_exchange_sides_and_the_referee_proves_it(make):
    mission = sky.plan_mission(make(), assignment="identity")
    assert mission.deconfliction.left == mission.violations == ()
    assert mission.apart.verdict is sky.Verdict.PROVEN


def test_a_curve_that_is_dropped_leaves_the_others_as_they_were():
    store, again = CurveStore(), CurveStore()
    ways = [rest_to_rest(np.array([(0, 0, 0), (k + 1.0, 0, 0), (k + 1.0, 2, 1)]), UAV) for k in range(3)]
    for way in (ways[0], joined([ways[1], ways[1]]), ways[2]):
        store.add(way)
        if way is not ways[0] and way is not ways[2]:
            store.drop_last()
    again.add(ways[0])
    again.add(ways[2])
    assert store.seconds == again.seconds
    ours, theirs = store.arrays, again.arrays
    np.testing.assert_array_equal(ours.curves.first[:3], theirs.curves.first[:3])
    rows = int(theirs.curves.first[2])
    np.testing.assert_array_equal(ours.curves.rows[:rows], theirs.curves.rows[:rows])
    used = int(theirs.base[1] + 2 * theirs.leaves[1] + 1)
    np.testing.assert_array_equal(ours.boxes[:used], theirs.boxes[:used])


def test_a_uav_lets_a_mover_pass_in_a_bay():
    train = sky.Mover(
        shape=sky.Sphere(centre=(0, 0, 0), radius=0.9),
        motion=sky.WaypointMotion(points=[(21, 5, 1), (-9, 5, 1)], times=[0, 15]),
    )
    given = room_of(BAY, HEAD_ON[:1], [(18, 5, 1)], width=8.0, high=2.0)
    mission = sky.plan_mission(sky.Scenario.model_validate({**dict(given), "movers": [train]}), sky.Taut())
    assert mission.violations == ()
    assert mission.certificates[0].verdict is sky.Verdict.PROVEN
    assert {action.kind for action in mission.deconfliction.actions} == {"wait"}
    assert 6.0 < mission.makespan < 15.0


def test_a_detour_and_a_wait_together_are_found_where_they_arrive_first():
    shut = {"min": (10, 0, 0), "max": (10.5, 1.2, 2), "name": "near door", "active": [[0, 600]]}
    slow = {"min": (10, 18.8, 0), "max": (10.5, 20, 2), "name": "far door", "active": [[0, 40]]}
    walls = [sky.Box(min=(10, 1.2, 0), max=(10.5, 18.8, 2))]
    given = room_of(walls, [sky.UAV(start=(1, 0.6, 1))], [(19, 0.6, 1)], width=20.0, high=2.0)
    given = sky.Scenario.model_validate({**dict(given), "zones": [sky.Box(**shut), sky.Box(**slow)]})
    mission = sky.plan_mission(given, sky.Taut())
    assert mission.violations == ()
    assert mission.certificates[0].verdict is sky.Verdict.PROVEN
    open_door = room_of([*walls, sky.Box(min=shut["min"], max=shut["max"])], given.uavs, [(19, 0.6, 1)], 20.0, 2.0)
    around = sky.plan_mission(open_door, sky.Taut()).makespan
    assert mission.makespan < 40.0 + around
    whole = " ".join(action.sentence for action in mission.deconfliction.actions)
    assert whole.count("instead of") == 1  # the figures are told once


def test_a_detour_is_flown_where_it_arrives_before_a_flight_that_waits():
    mission = sky.plan_mission(sky.read("table-4.11"), sky.Taut())  # one that waits is found, and takes 7.5 s
    assert [action.kind for action in mission.deconfliction.actions] == ["detour"]
    assert mission.makespan < 7.2


def counted_searches(monkeypatch):
    """What each search in space and time is asked, as a list that grows: ends, flights, weight, and latest arrival."""
    asked, search = [], waiting_flights.earliest_arrival

    def counted(query):
        others = query.others
        among = frozenset(zip(others.base, others.departure, others.seconds, strict=True))
        asked.append((query.source, query.target, among, others.horizon, query.weight, query.latest))
        return search(query)

    monkeypatch.setattr(waiting_flights, "earliest_arrival", counted)
    return asked


def forest_with_spinners():
    return sky.random_movers(sky.forest_swap(uavs=2, seed=3), 4, kind="spinners", speed=3.0, seed=3)


@pytest.mark.parametrize("make", [lambda: sky.tunnel_swap(uavs=4, seed=1), forest_with_spinners])
def test_no_search_is_made_twice(monkeypatch, make):
    asked = counted_searches(monkeypatch)
    assert not sky.plan_mission(make(), assignment="identity").violations
    assert len(asked) > 2
    assert len(set(asked)) == len(asked)


def test_the_less_effort_the_fewer_searches_and_a_fleet_is_kept_apart_all_the_same(monkeypatch):
    asked, counts = counted_searches(monkeypatch), []
    made = sky.tunnel_swap(uavs=10, seed=3)
    for most in (0, 2_000, prioritized_planning.MOST_EFFORT):
        monkeypatch.setattr(prioritized_planning, "MOST_EFFORT", most)
        asked.clear()
        assert not sky.plan_mission(made, assignment="identity").violations
        counts.append(len(asked))
    assert 0 < counts[0] < counts[1] < counts[2]
