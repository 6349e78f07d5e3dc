"""Bounds the energy of a trajectory from above, and judges whether a battery gives it.

Pieces are cut until the power on each part is nearly constant. On a part, Bernstein coefficients bound airspeed, climb
and load; the power rises with the last two, and in airspeed it is largest at an end of the range, or at a corner of a
measured curve. So a part takes no more than its largest power times its time.
"""

import math
from typing import NamedTuple, Self

import numpy as np

from skyverse._typing import Floats
from skyverse.model.power import JOULES_OF_WATT_HOUR, Power
from skyverse.model.scenario import Scenario
from skyverse.model.take_off import landing, take_off
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import GRAVITY, UAV
from skyverse.model.verdict import Fault, Violation
from skyverse.model.wind import Wind, slow_down
from skyverse.referee.curve import PolynomialCurve, curve_of, derivative
from skyverse.referee.judgement import position_tuple
from skyverse.referee.polynomial import bernstein, halve
from skyverse.referee.tolerances import ENERGY_ROUNDING, LOOSE_POWER, MACHINE_EPSILON, TWO_ROUNDINGS

SIMPSON = np.array([1.0, 4.0, 1.0]) / 6
"""Weights of begin, middle and end of a part in the mean on it; no bound rests on that."""
MAX_CUTS, MAX_PARTS = 12, 2**17
"""How often a part is cut in two, and parts of one trajectory at most; uncut, they are bounded all the same."""
TURN_ABOUT = 7 * math.pi / 3
"""Radii that an aeroplane flies at least to be where it was with the opposite course, along three arcs."""
ROUNDED_UP = 1 + ENERGY_ROUNDING
"""Factor on bounds, more than the rounding of all their sums."""


class _Powers(NamedTuple):
    """What is taken on parts of a curve at most: powers of flying on, and back, (m,) W, and (m,) J of turning about."""

    watts: Floats
    back: Floats
    turn: Floats


class _TakenOnParts(NamedTuple):
    """Parts of a curve in order of time: the edges between them, (m + 1,) seconds, and what is taken on them."""

    edges: Floats
    taken: _Powers

    def between(self, begin: float, end: float) -> Self:
        """Return the parts between two instants; before and after a trajectory, a UAV stands and takes nothing."""
        inner = (self.edges[1:] > begin) & (self.edges[:-1] < end)
        if not inner.any():
            return type(self)(np.array([begin, end]), _Powers(*np.zeros((3, 1))))
        edges = np.clip(np.r_[self.edges[:-1][inner], self.edges[1:][inner][-1]], begin, end)
        return type(self)(edges, _Powers(*(row[inner] for row in self.taken)))

    def summed(self, watts: Floats) -> Floats:
        """Return the joules (m + 1,) of powers (m,) from the first edge to each."""
        return np.r_[0.0, np.cumsum(watts * np.diff(self.edges))] * ROUNDED_UP


def energy_bounds(
    scenario: Scenario, uav: int, trajectory: Trajectory, begin: float, end: float
) -> tuple[Floats, Floats]:
    """Return instants (m,), seconds, and the joules (m,) that a UAV has taken by then at most, from `begin` to `end`.

    The bound holds for the stated power, at every wind within the scenario's margin of gusts. Between two of the
    instants it is linear. It is at most about half a percent above what the same power takes where there are no gusts.

    Raises
    ------
    ValueError
        If no power is known of the UAV, or the trajectory is malformed.
    """
    parts = _parts_of(scenario, uav, trajectory).between(begin, end)
    return parts.edges, parts.summed(parts.taken.watts)


def turning_back(
    scenario: Scenario, uav: int, trajectory: Trajectory, begin: float, end: float
) -> tuple[Floats, Floats, float | None]:
    """Return what it takes at most to turn about, and to fly back to where the UAV was at `begin` the way that it came.

    It brakes at `max_acceleration`, gathers speed the other way, and flies what it has flown backwards in the same
    time, or as slowly as the wind or its climb rate demands where that is longer. For the point of no return, take-off
    and landing count, too.

    Returns
    -------
    instants, joules
        (m,) seconds and joules; the bound holds at these instants.
    last
        The point of no return: the instant up to which one battery suffices for turning back. ``None`` without a
        battery, or where it does not even suffice at `begin`.

    Raises
    ------
    ValueError
        If no power is known of the UAV, or the trajectory is malformed.
    """
    parts = _parts_of(scenario, uav, trajectory, back=True).between(begin, end)
    turn = parts.taken.turn  # an instant belongs to the parts on both sides
    back = parts.summed(parts.taken.back) + np.maximum(np.r_[0.0, turn], np.r_[turn, 0.0])
    usable = scenario.uavs[uav].usable_energy
    if usable is None:
        return parts.edges, back, None
    place = position_tuple(trajectory.at([begin]).position[0])
    off_and_on = take_off(scenario, uav, place).joules + landing(scenario, uav, place).joules
    return parts.edges, back, _until(parts.edges, parts.summed(parts.taken.watts) + back + off_and_on - usable)


def _until(edges: Floats, lacking: Floats) -> float | None:
    """Return until when what is lacking (m,), linear between edges (m,), is at most 0; ``None`` if it begins above."""
    k = int(np.argmax(lacking > 0))
    if not lacking[k] > 0:
        return float(edges[-1])
    if k == 0:
        return None
    return float(edges[k] - (edges[k] - edges[k - 1]) * lacking[k] / (lacking[k] - lacking[k - 1]))


def judge_battery(scenario: Scenario, uav: int, trajectory: Trajectory, spans: Floats) -> list[Violation]:
    """Return a violation for each sortie that one battery does not give, reserve and what is not trusted apart.

    Where a sortie fits as a whole, going on along the plan fits from each of its instants; how long turning back fits
    too is what `turning_back` tells.

    Parameters
    ----------
    scenario, uav, trajectory
        What is judged.
    spans
        (n, 2) seconds: when each sortie begins and ends. Before it the UAV rises from the ground, after it lands; what
        that takes counts, too. Between sorties it stands there, at no cost.
    """
    vehicle = scenario.uavs[uav]
    if vehicle.battery is None or vehicle.usable_energy is None or isinstance(curve_of(trajectory), str):
        return []
    parts, violations = _parts_of(scenario, uav, trajectory), []
    for number, (begin, end) in enumerate(spans, 1):
        sortie = parts.between(float(begin), float(end))
        first, last = (position_tuple(place) for place in trajectory.at([begin, end]).position)
        joules = take_off(scenario, uav, first).joules + sortie.summed(sortie.taken.watts)
        joules[-1] += landing(scenario, uav, last).joules
        if joules[-1] <= vehicle.usable_energy:
            continue
        until = _until(sortie.edges, joules - vehicle.usable_energy)
        which = "" if len(spans) == 1 else f" in sortie {number}"
        usable, needed = (value / JOULES_OF_WATT_HOUR for value in (vehicle.usable_energy, float(joules[-1])))
        message = (
            f"{vehicle.name} takes up to {needed:.4g} Wh{which}, {needed - usable:.3g} Wh more than the "
            f"{usable:.4g} Wh that its battery gives, {vehicle.battery:.6g} Wh with a reserve of {vehicle.reserve:.3g}."
        )
        violations.append(Violation(Fault.BATTERY, (uav,), message, until))
    return violations


def _parts_of(scenario: Scenario, uav: int, trajectory: Trajectory, *, back: bool = False) -> _TakenOnParts:
    """Return parts of a trajectory on each of which the power is nearly constant, and that of flying back if asked."""
    vehicle, curve = scenario.uavs[uav], curve_of(trajectory)
    if vehicle.power_model is None or isinstance(curve, str):
        raise ValueError(f"{vehicle.name}'s trajectory {curve}" if isinstance(curve, str) else "the power is not known")
    b, error = _motion(curve)
    piece, begin, width = np.arange(len(b)), curve.knots[:-1], curve.durations
    done: list[Floats] = []
    for cut in range(MAX_CUTS + 1):
        left, right = halve(b)
        most = _powers(scenario, vehicle, b, error[piece], back=back)
        samples = np.concatenate([b[:, :1], right[:, :1], b[:, -1:]])
        sampled = _powers(scenario, vehicle, samples, np.zeros((len(samples), 3)), back=back)
        means = [np.einsum("i,ij->j", SIMPSON, one.reshape(3, -1)) for one in (sampled.watts, sampled.back)]
        rough = (most.watts > (1 + LOOSE_POWER) * means[0]) | (most.back > (1 + LOOSE_POWER) * means[1])
        rough &= (cut < MAX_CUTS) & (2 * len(b) < MAX_PARTS)
        done.append(np.stack([begin, *most])[:, ~rough])
        b, piece, width = np.concatenate([left[rough], right[rough]]), np.tile(piece[rough], 2), width[rough] / 2
        begin, width = np.concatenate([begin[rough], begin[rough] + width]), np.tile(width, 2)
        if not rough.any():
            break
    begins, *powers = (parts := np.concatenate(done, axis=1))[:, np.argsort(parts[0])]
    return _TakenOnParts(np.r_[begins, curve.knots[-1]], _Powers(*powers))


def _motion(curve: PolynomialCurve) -> tuple[Floats, Floats]:
    """Return position, velocity and acceleration of pieces in Bernstein form (n, degree + 1, 9), and their errors.

    The errors (n, 3) bound those of an altitude, and of the lengths of velocity and acceleration.
    """
    rows, parts = curve.pieces, []
    for _ in range(3):
        parts += bernstein(rows, curve.durations)
        rows = derivative(rows)
    parts = [part.raised(parts[0].degree) for part in parts]
    # each halving takes as many means one after another as the degree, and each of them rounds
    errors = [part.error + MAX_CUTS * part.b.shape[1] * MACHINE_EPSILON * part.size for part in parts]
    lengths = [np.linalg.norm(np.stack(errors[3 * k : 3 * k + 3]), axis=0) for k in (1, 2)]
    return np.stack([part.b for part in parts], axis=2), np.stack([errors[2], *lengths], axis=1)


def _powers(scenario: Scenario, vehicle: UAV, b: Floats, error: Floats, *, back: bool) -> _Powers:
    """Return bounds on what is taken on parts (m, degree + 1, 9); nothing for the way back if that is not asked."""
    altitude, velocity, up = b[:, :, 2], b[:, :, 3:5], b[:, :, 5]
    load = (np.linalg.norm(b[:, :, 6:] + np.array([0.0, 0.0, GRAVITY]), axis=2).max(axis=1) + error[:, 2]) / GRAVITY
    wind, doubt = _winds(scenario.wind, altitude.min(axis=1) - error[:, 0], altitude.max(axis=1) + error[:, 0])
    gust, power = 0.0 if scenario.wind is None else scenario.wind.gust, vehicle.power_model or Power()
    aside = np.hypot(doubt[:, 0], doubt[:, 1]) + error[:, 1]
    rise = doubt[:, 2] - wind[:, 2] + error[:, 1]  # of the climb through the air
    ways, watts = [np.ones(len(b))], []
    if back:
        ways.append(-1.0 / slow_down(vehicle, scenario.winds, -b[:, :, 3:6]).max(axis=1))
        load = np.maximum(load, 1.0)  # slower it turns more gently
    for way in ways:
        through = way[:, None, None] * velocity - wind[:, None, :2]
        course = through.mean(axis=1)
        course = course / np.maximum(np.linalg.norm(course, axis=1), np.finfo(float).tiny)[:, None]
        low = np.maximum(np.einsum("ijk,ik->ij", through, course).min(axis=1) - aside, 0.0)
        high = np.linalg.norm(through, axis=2).max(axis=1) + aside
        watts.append(power.most(low, high, (way[:, None] * up).max(axis=1) + rise, load, gust) / np.abs(way))
    if not back:
        return _Powers(watts[0], *np.zeros((2, len(b))))
    speed = np.linalg.norm(b[:, :, 3:6], axis=2).max(axis=1) + error[:, 1]
    strongest, climb = np.linalg.norm(wind[:, :2], axis=1) + aside, np.abs(up).max(axis=1) + rise
    slowest, turning = np.zeros(len(b)), vehicle.max_acceleration
    seconds, wing = 2.0 * speed / turning, vehicle.fixed_wing
    if wing is not None:
        slowest, turning = np.maximum(wing.speed - strongest, 0.0), wing.speed**2 / wing.turn_radius
        seconds = np.full(len(b), TURN_ABOUT * wing.turn_radius / wing.speed)
    turn = power.most(slowest, speed + strongest, climb, np.maximum(load, 1.0 + turning / GRAVITY), gust)
    return _Powers(watts[0], watts[1], seconds * turn)


def _winds(wind: Wind | None, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Return winds (m, 3), m/s, at altitudes from `low` to `high` (m,), and how far off they may be there, (m, 3).

    Between its layers a wind changes linearly, so that it is largest and smallest at layers and at the ends.
    """
    if wind is None:
        return np.zeros((len(low), 3)), np.zeros((len(low), 3))
    found = np.stack([wind.at(np.clip(altitude, low, high)) for altitude in (low, high, *wind.table[0])])
    least, most = found.min(axis=0), found.max(axis=0)
    return (least + most) / 2, (most - least) / 2 + TWO_ROUNDINGS * np.abs(found).max(axis=0)
