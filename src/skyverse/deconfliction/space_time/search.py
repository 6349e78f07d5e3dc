"""Safe-interval path planning: the earliest arrival over a roadmap among flights that are already placed.

M. Phillips, M. Likhachev, SIPP: Safe Interval Path Planning for Dynamic Environments, ICRA 2011. A state is a vertex
and an interval in which it is safe to hover there: to arrive earlier in it is never worse. Time is continuous. When a
leg may depart is found only when the search comes to it (lazily); until then the earliest that may be is taken.
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Bools, Floats, Ints
from skyverse.deconfliction.space_time.leg_profiles import SECONDS, StraightLeg
from skyverse.deconfliction.space_time.others import Others, earliest_leg, safe_intervals
from skyverse.numerics.arrays import doubled, put
from skyverse.numerics.heap import Heap, make_heap, pop, push
from skyverse.numerics.kernel import by_reference, inner, kernel

SHORTEST = 0.02
"""Seconds that a safe interval lasts at least."""


@by_reference
class RoadmapGraph(NamedTuple):
    """A roadmap's n vertices and its m legs, the legs of one vertex after those of another.

    Attributes
    ----------
    points
        (n, 3) metres.
    first
        (n + 1,) the number of the first leg from each vertex.
    end
        (m,) the vertex that each leg leads to.
    kind
        (m,) the row of `ways` and `profiles` of each leg.
    ways
        (k, 3) metres from a leg's beginning to its end.
    """

    points: Floats
    first: Ints
    end: Ints
    kind: Ints
    ways: Floats


class Itinerary(NamedTuple):
    """The vertices (n,) of a way, and when the UAV departs from each of them and arrives there, (n,) seconds each.

    Without a way they are empty. `expanded` says how many states were expanded.
    """

    vertices: Ints
    departures: Floats
    arrivals: Floats
    expanded: int


@kernel
def seconds_to(graph: RoadmapGraph, profiles: Floats, target: int) -> Floats:
    """Return how many seconds it takes from each vertex to the target if nobody is in the way; (n,)."""
    left = np.full(len(graph.points), np.inf)
    left[target] = 0.0
    heap = push(make_heap(1024), 0.0, target)
    while heap.size[0] > 0:
        key, v = pop(heap)
        if key > left[v]:
            continue
        for leg in range(graph.first[v], graph.first[v + 1]):  # each leg leads both ways, and takes about as long
            w, longer = graph.end[leg], key + profiles[graph.kind[leg], SECONDS]
            if longer < left[w]:
                left[w] = longer
                heap = push(heap, longer, w)
    return left


class States(NamedTuple):
    """What is known of the safe intervals that the search has come to; those of one vertex follow each other.

    Attributes
    ----------
    first, last
        (n,) the first interval of each vertex, -1 where it is not known, and the one after the last.
    known
        (1,) how many intervals are known.
    interval
        (capacity, 2) seconds.
    vertex
        (capacity,) where each is.
    arrival
        (capacity,) the earliest that is known, seconds.
    parent, departure
        (capacity,) the interval from which the UAV comes, and when it departs there, seconds.
    done
        (capacity,) whether nothing earlier will be found.
    """

    first: Ints
    last: Ints
    known: Ints
    interval: Floats
    vertex: Ints
    arrival: Floats
    parent: Ints
    departure: Floats
    done: Bools


class Tries(NamedTuple):
    """Legs to be tried, by the earliest that they may bring the UAV to the target.

    Attributes
    ----------
    heap
        Their numbers.
    leg
        (capacity, 3) the interval from which it leads, its number in the roadmap, and the interval to which it leads.
    departure
        (capacity,) seconds; below 0 where it is not known yet.
    made
        (1,) how many there are.
    """

    heap: Heap
    leg: Ints
    departure: Floats
    made: Ints


@by_reference
class ArrivalQuery(NamedTuple):
    """What is asked of `earliest_arrival`.

    Attributes
    ----------
    graph, profiles
        The roadmap, and how its legs are flown.
    others
        The flights to stay clear of.
    left
        (n,) as from `seconds_to`.
    source, target
        The vertices from and to which the UAV flies.
    begin
        The earliest departure, seconds.
    weight
        By how much the time that is left counts more than that which has passed; 1 or more.
    most
        How many states are expanded at most.
    latest
        Seconds: arrivals that are surely later are not sought.
    """

    graph: RoadmapGraph
    profiles: Floats
    others: Others
    left: Floats
    source: int
    target: int
    begin: float
    weight: float
    most: int
    latest: float


@kernel
def earliest_arrival(query: ArrivalQuery) -> Itinerary:
    """Return how a UAV arrives first, or, with a weight above 1, no more than so many times as late; see the module."""
    graph, others, left = query.graph, query.others, query.left
    source, target, begin = query.source, query.target, query.begin
    states = _with_intervals(_no_states(len(graph.points)), graph, others, source)
    tries = Tries(make_heap(1024), np.empty((1024, 3), np.int64), np.empty(1024), np.zeros(1, np.int64))
    expanded, room = 0, np.empty((7, 3))
    for state in range(states.first[source], states.last[source]):
        if states.interval[state, 0] <= begin <= states.interval[state, 1]:
            states.arrival[state], states.done[state] = begin, True
            if source == target and states.interval[state, 1] == np.inf:
                return _itinerary(states, state, expanded)
            states, tries = _expanded(query, states, tries, state)
    while tries.heap.size[0] > 0 and expanded < query.most:
        _, number = pop(tries.heap)
        before, leg, state = tries.leg[number, 0], tries.leg[number, 1], tries.leg[number, 2]
        if states.done[state]:
            continue
        kind = graph.kind[leg]
        seconds = query.profiles[kind, SECONDS]
        departure = tries.departure[number]
        if departure < 0.0:
            since = max(states.arrival[before], states.interval[state, 0] - seconds)
            until = min(states.interval[before, 1], states.interval[state, 1] - seconds)
            way = StraightLeg(graph.points[states.vertex[before]], graph.ways[kind], query.profiles[kind])
            departure = earliest_leg(others, way, since, until, room)
            arrives = departure + seconds + left[states.vertex[state]]
            if departure + seconds >= states.arrival[state] or arrives > query.latest:
                continue
            states.arrival[state] = departure + seconds
            states.parent[state], states.departure[state] = before, departure
            if departure > since:
                tries.departure[number] = departure
                key = departure + seconds + query.weight * left[states.vertex[state]]
                tries = Tries(push(tries.heap, key, number), tries.leg, tries.departure, tries.made)
                continue
        elif departure != states.departure[state] or before != states.parent[state]:
            continue  # the state is reached earlier by another leg
        states.done[state] = True
        expanded += 1
        if states.vertex[state] == target and states.interval[state, 1] == np.inf:
            return _itinerary(states, state, expanded)
        states, tries = _expanded(query, states, tries, state)
    return _itinerary(states, -1, expanded)


@inner
def _no_states(vertices: int) -> States:
    n = 1024
    return States(
        np.full(vertices, -1),
        np.zeros(vertices, np.int64),
        np.zeros(1, np.int64),
        np.empty((n, 2)),
        np.empty(n, np.int64),
        np.empty(n),
        np.empty(n, np.int64),
        np.empty(n),
        np.empty(n, np.bool_),
    )


@inner
def _with_intervals(states: States, graph: RoadmapGraph, others: Others, v: int) -> States:
    """Return the states with the safe intervals of a vertex."""
    own = safe_intervals(others, graph.points[v], SHORTEST)
    count = states.known[0]
    while count + len(own) > len(states.vertex):
        states = States(
            states.first,
            states.last,
            states.known,
            doubled(states.interval),
            doubled(states.vertex),
            doubled(states.arrival),
            doubled(states.parent),
            doubled(states.departure),
            doubled(states.done),
        )
    for k in range(len(own)):
        put(states.interval, count + k, own[k])
        states.vertex[count + k], states.arrival[count + k] = v, np.inf
        states.parent[count + k], states.done[count + k] = -1, False
    states.first[v], states.last[v] = count, count + len(own)
    states.known[0] = count + len(own)
    return states


@inner
def _expanded(query: ArrivalQuery, states: States, tries: Tries, state: int) -> tuple[States, Tries]:
    """Return states and tries with the legs from a state, each to all intervals of its end that it may come to.

    Those that surely bring the UAV to the target after the latest instant are left out.
    """
    graph, left, latest = query.graph, query.left, query.latest
    heap, legs, departures = tries.heap, tries.leg, tries.departure
    v, now = states.vertex[state], states.arrival[state]
    for leg in range(graph.first[v], graph.first[v + 1]):
        w = graph.end[leg]
        seconds = query.profiles[graph.kind[leg], SECONDS]
        if left[w] == np.inf or now + seconds + left[w] > latest:
            continue
        if states.first[w] < 0:
            states = _with_intervals(states, graph, query.others, w)
        for j in range(states.first[w], states.last[w]):
            since = max(now, states.interval[j, 0] - seconds)
            until = min(states.interval[state, 1], states.interval[j, 1] - seconds)
            if states.done[j] or since > until or since + seconds >= states.arrival[j]:
                continue
            if since + seconds + left[w] > latest:
                continue
            number = tries.made[0]
            if number == len(departures):
                legs, departures = doubled(legs), doubled(departures)
            legs[number, 0], legs[number, 1], legs[number, 2], departures[number] = state, leg, j, -1.0
            tries.made[0] = number + 1
            heap = push(heap, since + seconds + query.weight * left[w], number)
    return states, Tries(heap, legs, departures, tries.made)


@inner
def _itinerary(states: States, state: int, expanded: int) -> Itinerary:
    """Return the way to a state, or an empty one for state -1."""
    count, j = 0, state
    while j >= 0:
        count, j = count + 1, states.parent[j]
    vertices, departures, arrivals = np.empty(count, np.int64), np.empty(count), np.empty(count)
    j = state
    for k in range(count - 1, -1, -1):
        vertices[k], arrivals[k] = states.vertex[j], states.arrival[j]
        if k == count - 1:
            departures[k] = np.inf
        if k > 0:
            departures[k - 1] = states.departure[j]
        j = states.parent[j]
    return Itinerary(vertices, departures, arrivals, expanded)
