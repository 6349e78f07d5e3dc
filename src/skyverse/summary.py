"""What is flown along a path: length, time, energy, and the largest distance from the path."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from skyverse._typing import Floats
from skyverse.model.arrays import arctan2
from skyverse.model.mission import FlightSummary, Mission
from skyverse.model.power import JOULES_OF_WATT_HOUR, TRUSTED_SHARE, Power
from skyverse.model.scenario import Scenario
from skyverse.model.sortie import Sortie
from skyverse.model.take_off import landing, take_off
from skyverse.model.trajectory import Motion, Trajectory
from skyverse.model.uav import GRAVITY, UAV
from skyverse.model.wind import Wind, slow_down
from skyverse.numerics.tolerances import DEVIATION, QUADRATURE
from skyverse.search.path_shortening.shortcut import drop_collinear
from skyverse.space.path_distance import farthest_ends

COURSE_SAMPLES = 1001
"""Instants at which a battery is told."""
MAX_HALVINGS = 40
"""How often intervals are cut in two, each time one of the halves before."""
_INNER = [0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975362]
_OUTWARD = [0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763]
NODES, WEIGHTS = np.array([*(-x for x in _INNER[::-1]), *_INNER]), np.array([*_OUTWARD[::-1], *_OUTWARD])
"""Gauss's quadrature with eight nodes on the interval from -1 to 1 (Abramowitz and Stegun, table 25.4)."""
TURNS_PER_PIECE, SLOWEST = 30, 0.01
"""Instants of a piece at which its course is taken, and metres per second from which a UAV has one."""
MAX_PARTS = 2**16
"""Intervals beyond which none is cut any more, so that no file fills the memory."""


def with_flight_summaries(mission: Mission) -> Mission:
    """Return a mission with a summary of every flight that has a path, whatever summaries it had."""
    flights: list[FlightSummary | None] = []
    for number, (uav, result, trajectory) in enumerate(
        zip(mission.scenario.uavs, mission.results, mission.trajectories, strict=True)
    ):
        if result is None or trajectory is None or not len(result.path):
            flights.append(None)
        else:
            spans = [(one.begin, one.end) for one in mission.sorties_of(number)] or [(trajectory.start, trajectory.end)]
            ground = [_on_and_off(mission.scenario, number, trajectory, span) for span in spans]
            flights.append(flight_summary(uav, result.path, trajectory, mission.scenario.wind, spans, ground))
    return replace(mission, flights=tuple(flights))


def _on_and_off(scenario: Scenario, uav: int, trajectory: Trajectory, span: tuple[float, float]) -> float:
    """Return what take-off and landing before and after a sortie take at most, J."""
    first, last = (tuple(place) for place in trajectory.at(span).position.tolist())
    return take_off(scenario, uav, first).joules + landing(scenario, uav, last).joules


def flight_summary(
    uav: UAV,
    path: Floats,
    trajectory: Trajectory,
    wind: Wind | None = None,
    spans: Sequence[tuple[float, float]] = (),
    ground: Sequence[float] = (0.0,),
) -> FlightSummary:
    """Summarise what a UAV flies along a path (n, 3), metres, in a wind, in spans of time, its sorties, if it has any.

    Between them it takes nothing; `ground` is what take-off and landing of each take at most, J.
    """
    power = uav.power_model
    any_power = power or Power(hover=1.0)  # so that a length has the same bits whether or not a power is known

    def rates(instants: Floats) -> Floats:
        motion = trajectory.at(instants)
        return np.column_stack([np.linalg.norm(motion.velocity, axis=1), *_powers(any_power, motion, wind)])

    within = [_edges(trajectory, span) for span in spans if span[0] < span[1]]
    columns = np.array([_integrals(rates, edges) for edges in within or [trajectory.knots]])
    length, *_ = sums = columns.sum(axis=0)
    energy, bound = (None, None) if power is None else (float(sums[1]), float(sums[-1] + np.sum(ground)))
    most = float((columns[:, -1] + ground[: len(columns)]).max())
    spent = None if bound is None or uav.battery is None else most / uav.battery / JOULES_OF_WATT_HOUR
    return FlightSummary(
        length=float(length),
        time=trajectory.end - trajectory.start,
        energy=energy,
        deviation=largest_distance(trajectory, path),
        energy_bound=bound,
        left=None if spent is None else float(TRUSTED_SHARE - spent),
    )


def _edges(trajectory: Trajectory, span: tuple[float, float]) -> Floats:
    """Return both ends of a span of time, and the knots of a trajectory between them, seconds."""
    knots = trajectory.knots
    return np.r_[span[0], knots[(knots > span[0]) & (knots < span[1])], span[1]]


def _powers(power: Power, motion: Motion, wind: Wind | None, way: Floats | None = None) -> list[Floats]:
    """Return the powers (m,), W, of a motion, `way` (m,) times as fast: as stated, and in worst gusts."""
    load = np.linalg.norm(motion.acceleration + np.array([0.0, 0.0, GRAVITY]), axis=1) / GRAVITY
    flown = motion.velocity if way is None else way[:, None] * motion.velocity
    through = flown - (0.0 if wind is None else wind.at(motion.position[:, 2]))
    level, climb = np.linalg.norm(through[:, :2], axis=1), through[:, 2]
    worst = [power.most(level, level, climb, load, wind.gust)] if wind is not None and wind.gust > 0 else []
    return [power.at(level, climb, load), *worst]


@dataclass(frozen=True, eq=False)
class BatteryCourse:
    """What a battery holds in a sortie, at samples, in gusts that are at their worst; no proof rests on it.

    Attributes
    ----------
    instants
        (m,) seconds into the mission.
    left
        (m,) shares of the battery that are left, of the share that is trusted.
    back
        (m,) shares that it takes to turn about and fly back the way that the UAV came.
    no_return
        The instant up to which that leaves the reserve; ``None`` where it never does.
    """

    instants: Floats
    left: Floats
    back: Floats
    no_return: float | None


def battery_course(scenario: Scenario, number: int, trajectory: Trajectory, sortie: Sortie) -> BatteryCourse | None:
    """Return how the battery of a UAV, by its index, empties in a sortie, for pages; ``None`` without a battery.

    The first sample counts the take-off, the last one the landing.

    To turn about, the UAV brakes at `max_acceleration` and gathers speed the other way; an aeroplane is taken to turn
    at once.
    """
    uav = scenario.uavs[number]
    power, wind = uav.power_model, scenario.wind
    if power is None or uav.battery is None:
        return None
    instants = np.linspace(sortie.begin, sortie.end, COURSE_SAMPLES)
    motion, joules = trajectory.at(instants), uav.battery * JOULES_OF_WATT_HOUR
    slower = slow_down(uav, scenario.winds, -motion.velocity)
    on, home = (_powers(power, motion, wind, way)[-1] for way in (np.ones(len(slower)), -1.0 / slower))
    home = home * slower
    used, back = (np.r_[0.0, np.cumsum((w[1:] + w[:-1]) / 2 * np.diff(instants))] / joules for w in (on, home))
    if uav.fixed_wing is None:
        seconds = 2.0 * np.linalg.norm(motion.velocity, axis=1) / uav.max_acceleration
        back = back + seconds * np.maximum(on, home) * (1.0 + uav.max_acceleration / GRAVITY) ** 1.5 / joules
    first = tuple(motion.position[0].tolist())
    back = back + landing(scenario, number, first).joules / joules
    left = TRUSTED_SHARE - take_off(scenario, number, first).joules / joules - used
    span = sortie.begin, sortie.end
    spent = _integrals(lambda at: _powers(power, trajectory.at(at), wind)[-1][:, None], _edges(trajectory, span))
    left[-1] = TRUSTED_SHARE - (float(spent[0]) + _on_and_off(scenario, number, trajectory, span)) / joules
    fits = left - back >= uav.reserve
    until = len(fits) if fits.all() else int(np.argmin(fits))
    return BatteryCourse(instants, left, back, float(instants[until - 1]) if until else None)


def flown_length(trajectory: Trajectory) -> float:
    """Return the length of a trajectory, metres."""
    speeds = _integrals(
        lambda instants: np.linalg.norm(trajectory.at(instants).velocity, axis=1)[:, None], trajectory.knots
    )
    return float(speeds[0])


def turning(trajectory: Trajectory) -> float:
    """Return the sum of the angles by which the course of a trajectory turns, degrees; where it hovers it has none."""
    shares = np.linspace(0.0, 1.0, TURNS_PER_PIECE, endpoint=False)
    instants = (trajectory.knots[:-1, None] + shares * np.diff(trajectory.knots)[:, None]).ravel()
    velocity = trajectory.at(instants).velocity
    speeds = np.linalg.norm(velocity, axis=1)
    courses = velocity[speeds > SLOWEST] / speeds[speeds > SLOWEST, None]
    chords = np.linalg.norm(np.diff(courses, axis=0), axis=1)
    halves = np.minimum(chords / 2.0, 1.0)
    return math.degrees(float(2.0 * arctan2(halves, np.sqrt(1.0 - halves**2)).sum()))


def _integrals(rates: Callable[[Floats], Floats], edges: Floats) -> Floats:
    """Integrate rates, which (m,) instants give as (m, k), over all intervals between edges (n + 1,), seconds.

    An interval is cut in two until both halves together differ from it by no more than its part of `QUADRATURE`.
    """
    begins, ends = edges[:-1], edges[1:]
    whole = _gauss(rates, begins, ends)
    total: Floats = np.zeros(whole.shape[1])
    allowed = QUADRATURE * np.abs(whole).sum(axis=0) / (edges[-1] - edges[0])
    for _ in range(MAX_HALVINGS):
        middles = (begins + ends) / 2
        left, right = _gauss(rates, begins, middles), _gauss(rates, middles, ends)
        rough = (np.abs(left + right - whole) > allowed * (ends - begins)[:, None]).any(axis=1)
        total += (left + right)[~rough].sum(axis=0)
        begins, ends = np.r_[begins[rough], middles[rough]], np.r_[middles[rough], ends[rough]]
        whole = np.concatenate([left[rough], right[rough]])
        if not 0 < len(begins) <= MAX_PARTS:
            break
    return total + whole.sum(axis=0)


def _gauss(rates: Callable[[Floats], Floats], begins: Floats, ends: Floats) -> Floats:
    """Return the integrals (n, k) of rates over n intervals, by Gauss's quadrature."""
    half, middle = (ends - begins) / 2, (begins + ends) / 2
    values = rates((middle[:, None] + half[:, None] * NODES).ravel())
    return np.einsum("ijk,j->ik", values.reshape(len(begins), len(NODES), -1), WEIGHTS) * half[:, None]


def largest_distance(trajectory: Trajectory, path: Floats) -> float:
    """Return a distance, metres, that no place of a trajectory is farther from a path (n, 3); at most `DEVIATION` more.

    Parts of the trajectory are cut in two until the bounds of their distances are tight.
    """
    corners = drop_collinear(path)
    parts = _bernstein(trajectory)
    reached, bounds = -math.inf, np.full(len(parts), math.inf)
    for _ in range(MAX_HALVINGS):
        ends_reached, bounds = farthest_ends(parts, corners)
        reached = max(reached, ends_reached)
        open_parts = bounds > reached + DEVIATION / 2
        if not open_parts.any():
            return reached + DEVIATION
        if np.count_nonzero(open_parts) > MAX_PARTS:
            break
        parts, bounds = np.concatenate(_halves(parts[open_parts])), bounds[open_parts]
    return float(bounds.max()) + DEVIATION


def _bernstein(trajectory: Trajectory) -> Floats:
    """Return the pieces of a trajectory as coefficients in Bernstein form, (n, degree + 1, 3) metres."""
    degree = trajectory.coefficients.shape[1] - 1
    scaled = trajectory.coefficients * np.vander(np.diff(trajectory.knots), degree + 1, increasing=True)[:, :, None]
    mix = [[math.comb(i, j) / math.comb(degree, j) for j in range(degree + 1)] for i in range(degree + 1)]
    return np.einsum("ij,njk->nik", np.array(mix), scaled)


def _halves(parts: Floats) -> tuple[Floats, Floats]:
    """Return the coefficients of both halves of parts (n, degree + 1, 3), by de Casteljau's algorithm."""
    count = parts.shape[1]
    left, right, row = parts.copy(), parts.copy(), parts
    for k in range(1, count):
        row = (row[:, 1:] + row[:, :-1]) / 2
        left[:, k], right[:, count - 1 - k] = row[:, 0], row[:, -1]
    return left, right
