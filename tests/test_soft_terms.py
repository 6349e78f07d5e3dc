"""Altitude, risk and climb: the kernels against dense sampling, and the referee against the kernels."""

import dataclasses
import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.path import Path as Outline
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

import skyverse as sky
from skyverse import cost
from skyverse.planners.base import provenance
from skyverse.planners.results import SearchRecord, any_angle_result
from skyverse.search.lattice_astar import prices_to, shortest_route
from skyverse.space.lattice import positions
from soft_terms import altitude_term, climb_term, risk_term

STAR = ((1, 1), (9, 2), (5, 4), (8, 9), (2, 8))
COMB = ((0, 0), (10, 0), (10, 8), (8, 8), (8, 2), (6, 2), (6, 8), (4, 8), (4, 2), (2, 2), (2, 8), (0, 8))


def field(*zones, connectivity=26, **weights):
    return sky.Scenario(
        name="field",
        bounds=sky.Bounds(min=(0, 0, 0), max=(10, 10, 10)),
        zones=zones,
        clearance=0.001,
        lattice=sky.Lattice(step=(1, 1, 1), connectivity=connectivity),
        objective=sky.Objective(unit="metres", **weights),
        uavs=(sky.UAV(start=(0, 0, 0)),),
        targets=(sky.Target(position=(10, 10, 10)),),
    )


def terms(scenario, *points):
    path = np.array(points, float)
    return cost.terms_of_legs(scenario, cost.make_rates(scenario), path, path[-1])


def test_a_place_twice_in_a_row_hides_no_turn():
    corner = (0, 0, 0), (5, 0, 0), (5, 5, 0)
    assert terms(field(divergence=3), *corner)["divergence"] == 3
    assert terms(field(divergence=3), corner[0], corner[0], *corner, corner[2]) == terms(field(divergence=3), *corner)
    assert terms(field(divergence=3), corner[0], corner[1], *corner[1:]) == terms(field(divergence=3), *corner)


whole = st.integers(0, 20).map(lambda n: n / 2)
places = st.tuples(whole, whole, whole)
anywhere = st.tuples(*[st.floats(0, 10)] * 3)
heights = st.tuples(st.integers(0, 8), st.integers(1, 9)).map(lambda pair: (pair[0], pair[0] + pair[1]))


@st.composite
def zones(draw):
    low, high = draw(heights)
    risk = draw(st.sampled_from([0.5, 1.0, 3.0]))
    if draw(st.booleans()):
        centre, radius = (draw(st.integers(0, 10)), draw(st.integers(0, 10))), draw(st.integers(1, 5))
        return sky.Cylinder(centre=centre, radius=radius, low=low, high=high, risk=risk)
    if draw(st.booleans()):
        corners = draw(st.sampled_from([STAR, COMB, COMB[::-1], ((0, 0), (4, 0), (4, 4), (0, 4))]))
    else:  # star-shaped about the middle: never crosses itself
        angles = sorted(draw(st.sets(st.integers(0, 23), min_size=3, max_size=9)))
        spokes = [(math.radians(15 * a), draw(st.integers(1, 5))) for a in angles]
        corners = tuple((5 + r * math.cos(a), 5 + r * math.sin(a)) for a, r in spokes)
        if max(np.diff([*angles, angles[0] + 24])) >= 12:
            corners = STAR
    return sky.Prism(vertices=corners, low=low, high=high, risk=risk)


@given(st.integers(0, 2**32 - 1), st.integers(200, 400))
@settings(max_examples=30, deadline=None)
def test_among_zones_of_hundreds_of_corners_the_risk_is_what_shapely_says(seed, corners):
    shapely = pytest.importorskip("shapely")
    rng = np.random.default_rng(seed)
    angles = np.linspace(0, 2 * np.pi, corners, endpoint=False)
    rings = []
    for middle, least, most in (((12, 10), 4, 9), ((30, 12), 2, 6), ((12, 10), 1, 3)):
        rings.append(np.array(middle) + rng.uniform(least, most, (corners, 1)) * np.c_[np.cos(angles), np.sin(angles)])
    outline, other, hole = rings
    scenario = field(
        sky.Prism(vertices=outline.tolist(), holes=[hole.tolist()], low=0, high=9, risk=2.0),
        sky.Prism(vertices=other.tolist(), low=0, high=9, risk=3.0),
        risk=1.0,
    )
    areas = shapely.Polygon(outline, [hole]), shapely.Polygon(other)
    for a, b in rng.uniform(0, [40, 20], (20, 2, 2)):
        line = shapely.LineString([a, b])
        lengths = [line.intersection(area).length for area in areas]
        found = terms(scenario, (*a, 4.0), (*b, 4.0))["risk"]
        assert found == pytest.approx(2 * lengths[0] + 3 * lengths[1], abs=1e-6)


@settings(max_examples=60)
@given(st.lists(zones(), max_size=3), st.lists(anywhere, min_size=2, max_size=4), st.floats(0, 10), st.floats(0, 80))
def test_the_terms_are_what_dense_sampling_says(given_zones, points, low, angle):
    shapely = pytest.importorskip("shapely")
    band, limit = sky.AltitudeBand(low=low, high=low + 2, weight=0.5), sky.ClimbLimit(angle=angle, weight=2)
    scenario = field(*given_zones, altitude=band, risk=3, climb=limit)
    found = terms(scenario, *points)
    altitude = least = most = climb = length = 0.0
    for a, b in itertools.pairwise(np.array(points)):
        size = np.linalg.norm(b - a)
        at = a + ((np.arange(20_000) + 0.5) / 20_000)[:, None] * (b - a)
        altitude += 0.5 * size * np.maximum(0, np.maximum(low - at[:, 2], at[:, 2] - low - 2)).mean()
        for zone in given_zones:
            heights = at[:, 2]
            within, touched = (
                (heights > zone.low) & (heights < zone.high),
                (heights >= zone.low) & (heights <= zone.high),
            )
            if isinstance(zone, sky.Cylinder):
                level = np.hypot(*(at[:, :2] - zone.centre).T)
                within, touched = within & (level < zone.radius), touched & (level <= zone.radius)
            else:
                ring = shapely.LinearRing(zone.vertices)
                inside = Outline(zone.vertices).contains_points(at[:, :2])
                on_ring = shapely.distance(ring, shapely.points(at[:, :2])) < 1e-9
                within, touched = within & inside & ~on_ring, touched & (inside | on_ring)
            least += 3 * zone.risk * size * within.mean()
            most += 3 * zone.risk * size * touched.mean()
        steep = math.degrees(math.atan2(abs(b[2] - a[2]), math.hypot(*(b - a)[:2])))
        climb += 2 * size * math.radians(max(0, steep - angle))
        length += size
    assert found["fuel"] == pytest.approx(length)
    assert found["altitude"] == pytest.approx(altitude, rel=1e-4, abs=1e-4)
    assert found["climb"] == pytest.approx(climb, rel=1e-9, abs=1e-9)
    if given_zones:  # what lies on a surface may count as inside or as outside
        doubt = 0.03 * (1 + length)
        assert least - doubt <= found["risk"] <= most + doubt


@given(st.lists(zones(), min_size=1, max_size=3), st.lists(st.one_of(places, anywhere), min_size=2, max_size=5))
def test_the_referee_agrees_also_along_surfaces(given_zones, points):
    """Points on half metres lie on faces, edges and corners of the zones all the time."""
    scenario = field(*given_zones)
    stands, least, most = risk_term(scenario, np.array(points, float))
    found = terms(scenario, *points)["risk"]
    assert least <= most
    assert least - 1e-9 <= stands <= most + 1e-9
    assert least - 1e-6 <= found <= most + 1e-6


@given(places, places, whole)
def test_the_referee_s_altitude_and_climb_are_those_of_the_kernels(a, b, low):
    band, limit = sky.AltitudeBand(low=low, high=low, weight=1), sky.ClimbLimit(angle=20, weight=1)
    found = terms(field(altitude=band, climb=limit), a, b)
    path = np.array([a, b])
    assert found["altitude"] == pytest.approx(altitude_term(band, path), abs=1e-9)
    assert found["climb"] == pytest.approx(climb_term(limit, path), abs=1e-6)


def test_chords_known_in_closed_form():
    ball = sky.Cylinder(centre=(5, 5), radius=3, low=2, high=8, risk=1)
    comb = sky.Prism(vertices=COMB, low=0, high=10, risk=1)
    through = [
        (ball, (0, 5, 5), (10, 5, 5), 6),
        (ball, (0, 5 + 1.8, 5), (10, 5 + 1.8, 5), 4.8),
        (ball, (0, 8, 5), (10, 8, 5), 0),
        (ball, (5, 5, 0), (5, 5, 10), 6),
        (ball, (5, 9, 0), (5, 9, 10), 0),
        (ball, (4, 5, 5), (6, 5, 5), 2),
        (ball, (5, 5, 9), (6, 5, 9), 0),
        (ball, (2, 5, 0), (8, 5, 10), 0.6 * math.hypot(6, 10)),
        (comb, (0, 5, 5), (10, 5, 5), 6),
        (comb, (10, 5, 5), (0, 5, 5), 6),
        (comb, (-1, 1, 5), (11, 1, 5), 10),
        (comb, (3, 5, 0), (3, 5, 9), 0),
        (comb, (1, 5, 1), (1, 5, 9), 8),
    ]
    for zone, a, b, metres in through:
        scenario = field(zone)
        assert terms(scenario, a, b)["risk"] == pytest.approx(metres), (zone.shape, a, b)
        assert risk_term(scenario, np.array([a, b], float))[0] == pytest.approx(metres), (zone.shape, a, b)


@given(zones(), st.lists(anywhere, min_size=2, max_size=2), st.floats(0.01, 0.99))
def test_a_leg_cut_in_two_costs_the_same_but_for_rounding(zone, ends, share):
    band, limit = sky.AltitudeBand(low=4, high=5, weight=1), sky.ClimbLimit(angle=10, weight=1)
    scenario = field(zone, altitude=band, climb=limit)
    a, b = np.array(ends)
    whole_leg, cut = terms(scenario, a, b), terms(scenario, a, a + share * (b - a), b)
    for name in ("fuel", "altitude", "climb"):
        assert cut[name] == pytest.approx(whole_leg[name], rel=1e-6, abs=1e-6)
    _, least, most = risk_term(scenario, np.array(ends))
    assert least - 1e-6 <= cut["risk"] <= most + 1e-6


ALL = {
    "divergence": 0.5,
    "altitude": sky.AltitudeBand(low=3, high=5, weight=0.2),
    "climb": sky.ClimbLimit(angle=10, weight=2),
}
ZONES = (
    sky.Cylinder(centre=(5, 5), radius=3, low=2, high=7, risk=0.7),
    sky.Prism(vertices=STAR, low=1, high=6, risk=1.3),
)


@pytest.mark.parametrize("connectivity", [6, 26])
def test_lattice_paths_pay_move_by_move_what_their_legs_cost(connectivity):
    scenario = field(*ZONES, connectivity=connectivity, **ALL)
    problem = sky.Problem(scenario)
    for planner in (sky.MVO(universes=6), sky.AStar(), sky.RandomRestart(samples=3)):
        result = planner.plan(problem, stop=sky.MaxIterations(4), rng=1)
        assert sky.check_result(scenario, 0, 0, result) == []
        assert result.history.cost[-1] == pytest.approx(result.cost)
        assert list(result.terms) == ["fuel", "divergence", "end", "altitude", "risk", "climb"]
        legs = terms(scenario, *result.path)
        for name in ("altitude", "risk", "climb"):
            assert result.terms[name] == pytest.approx(legs[name])
        assert result.cost == pytest.approx(sum(result.terms.values()))
        assert result.bound == problem.route.price <= result.cost * (1 + 1e-12)
        optimal = isinstance(planner, sky.AStar)
        assert result.status is (sky.Status.OPTIMAL if optimal else sky.Status.COMPLETE)


def test_terms_that_are_not_priced_are_not_there():
    assert list(terms(field(), (0, 0, 0), (1, 1, 1))) == ["fuel", "divergence", "end"]
    assert list(terms(field(*ZONES, risk=0), (0, 0, 0), (1, 1, 1))) == ["fuel", "divergence", "end"]
    assert list(terms(field(altitude=ALL["altitude"]), (0, 0, 0), (1, 1, 1)))[3:] == ["altitude"]


@pytest.mark.parametrize("name", ["altitude", "risk", "climb"])
def test_a_term_that_is_not_what_the_path_costs_is_told(name):
    scenario = field(*ZONES, **ALL)
    path = np.array([(0, 0, 0), (4, 6, 5), (10, 10, 10)], float)
    record = SearchRecord(provenance("by hand", None, None))
    problem = sky.Problem(scenario)
    right = any_angle_result(problem, path, None, record)
    assert cost.wrong_figures(scenario, problem.airspace.rates, right) == ""
    told = right.terms | {name: right.terms[name] - 0.01}
    wrong = dataclasses.replace(right, terms=told, cost=sum(told.values()))
    assert cost.wrong_figures(scenario, problem.airspace.rates, wrong)
    del told[name]
    silent = dataclasses.replace(right, terms=told, cost=sum(told.values()))
    assert cost.wrong_figures(scenario, problem.airspace.rates, silent)


def test_a_leg_along_a_face_may_count_as_inside_or_as_outside():
    scenario = field(sky.Prism(vertices=((0, 0), (4, 0), (4, 4), (0, 4)), low=0, high=4, risk=2))
    for along in ([(0, 4, 2), (4, 4, 2)], [(1, 1, 4), (3, 1, 4)], [(4, 0, 1), (4, 3, 1)], [(4, 4, 0), (4, 4, 4)]):
        length = math.dist(*along)
        assert risk_term(scenario, np.array(along, float))[1:] == pytest.approx((0, 2 * length), abs=1e-4)
        assert terms(scenario, *along)["risk"] in (pytest.approx(0), pytest.approx(2 * length))


TERRAIN = sky.Terrain(
    origin=(0, 0), step=(3, 5), heights=[[0, 2, 1], [3, 0, 1], [1, 4, 0], [0, 1, 3], [2, 2, 2]], clearance=0.5
)
"""Covers 12 m by 10 m."""


@st.composite
def soft_worlds(draw):
    weights = {"fuel": draw(st.sampled_from([0.1, 1.0])), "divergence": draw(st.sampled_from([0.0, 0.5]))}
    terrain = TERRAIN if draw(st.booleans()) else None
    if draw(st.booleans()):
        low = draw(st.integers(0, 6))
        above = draw(st.sampled_from(["zero", "ground"])) if terrain else None
        weights["altitude"] = sky.AltitudeBand(
            low=low, high=low + 1, weight=draw(st.sampled_from([0.1, 5.0])), above=above
        )
    if draw(st.booleans()):
        weights["climb"] = sky.ClimbLimit(angle=10, weight=2)
    return sky.Scenario(
        name="soft",
        bounds=sky.Bounds(min=(0, 0, 0), max=(10, 10, 10)),
        obstacles=(sky.Sphere(centre=(5, 5, 4), radius=2.2),),
        zones=tuple(draw(st.lists(zones(), max_size=3))),
        terrain=terrain,
        clearance=0.001,
        lattice=sky.Lattice(step=(2.5, 2.5, 2.5), connectivity=draw(st.sampled_from([6, 26]))),
        objective=sky.Objective(unit=draw(st.sampled_from(["nodes", "metres"])), **weights),
    )


@settings(max_examples=25)
@given(soft_worlds(), st.data())
def test_exact_search_pays_soft_terms_as_dijkstra_does_on_the_explicit_graph(scenario, data):
    airspace = sky.Airspace(scenario)
    grid, pricing = airspace.grid, airspace.pricing
    open_nodes = np.flatnonzero(grid.exits)
    source, goal = (int(open_nodes[data.draw(st.integers(0, len(open_nodes) - 1))]) for _ in range(2))
    places = positions(grid, np.arange(len(grid.exits)))
    k, rates = len(grid.moves), airspace.rates
    a, m = np.nonzero(grid.exits[:, None] >> np.arange(k) & 1)
    b = a + grid.offsets[m]
    found = [cost.legs(rates, np.array([places[i], places[j]]), places[j]) for i, j in zip(a, b, strict=True)]
    price = np.sum(found, axis=1)  # of fuel by the metre, and of soft terms
    if scenario.objective.unit == "nodes":
        price += scenario.objective.fuel - np.array(found)[:, 0]
    turn = np.array([[bool(np.any(np.cross(h, g))) for g in grid.moves] for h in grid.moves])
    rows = (a[:, None] * k + np.arange(k)).ravel()
    columns = np.repeat(b * k + m, k)
    weights = (price[:, None] + scenario.objective.divergence * turn[:, m].T).ravel()
    begin = a == source
    size = len(grid.exits) * k + 1
    rows, columns = np.r_[rows, np.full(begin.sum(), size - 1)], np.r_[columns, (b * k + m)[begin]]
    weights = np.r_[weights, price[begin]]
    truth = dijkstra(coo_array((weights, (rows, columns)), shape=(size, size)).tocsr(), indices=size - 1)
    truth = truth[:-1].reshape(-1, k).min(axis=1)
    truth[source] = 0
    route = shortest_route(grid, pricing, source, goal)
    if np.isinf(truth[goal]):
        assert route is None
        return
    assert route.price == pytest.approx(pricing.first + truth[goal], rel=1e-9)
    assert cost.total(grid, pricing, route.nodes, goal) == pytest.approx(route.price, rel=1e-9)
    goals = np.arange(0, len(grid.exits), 7)
    np.testing.assert_allclose(prices_to(grid, pricing, source, goals), pricing.first + truth[goals], rtol=1e-9)
