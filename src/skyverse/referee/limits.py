"""What a UAV can do, as polynomials of its trajectory that may nowhere be above zero."""

from collections.abc import Callable, Iterator
from math import atan2, cos, hypot, inf, pi, radians, sin
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.uav import UAV, FixedWing
from skyverse.model.verdict import Fault
from skyverse.referee.curve import Curve, derivative
from skyverse.referee.polynomial import Polynomials, bernstein, squared, stack

GRAVITY = 9.81  # m/s^2
FORGIVEN = 1e-6  # of each limit
AIRSPEED = 0.01  # of the speed, that a fixed wing may be off


class Limit(NamedTuple):
    """One limit: what may not be above zero, and how far an instant goes.

    Attributes
    ----------
    excess
        At or below zero wherever the limit is kept but for what is forgiven; rows of piece 0, 1, ..., again from 0.
    measure
        Of velocity, acceleration and jerk, (4, 3) with the position first: as a share of the limit, and in words.
    """

    fault: Fault
    noun: str
    excess: Polynomials
    measure: Callable[[Floats], tuple[float, str]]


def limits(vehicle: UAV, curve: Curve) -> Iterator[Limit]:
    """Yield the limits of a UAV, for each piece of its trajectory."""
    durations = curve.durations
    rows = [curve.pieces]
    for _ in range(3):
        rows.append(derivative(rows[-1]))
    _, velocity, acceleration, jerk = (bernstein(row, durations) for row in rows)
    norms = [
        (Fault.SPEED, "speed", velocity, 1, vehicle.max_speed, "flies {:.7g} m/s (of {:.7g})"),
        (
            Fault.ACCELERATION,
            "acceleration",
            acceleration,
            2,
            vehicle.max_acceleration,
            "accelerates by {:.7g} m/s^2 (of {:.7g})",
        ),
    ]
    if vehicle.fixed_wing is None:
        norms.append((Fault.JERK, "jerk", jerk, 3, vehicle.max_jerk, "jerks by {:.7g} m/s^3 (of {:.7g})"))
    for fault, noun, parts, order, top, deed in norms:
        yield Limit(fault, noun, _below(squared(parts), top), _norm(order, top, deed))
    if vehicle.fixed_wing is None:
        yield from _hovering(vehicle, acceleration)
    else:
        yield from _flying_on(vehicle.fixed_wing, velocity, acceleration)


def _below(square: Polynomials, top: float) -> Polynomials:
    """Return how far a square is above that of a limit, as a share of it."""
    return square * (1 / (top * (1 + FORGIVEN)) ** 2) + -1.0


def _norm(order: int, top: float, deed: str) -> Callable[[Floats], tuple[float, str]]:
    def measure(motion: Floats) -> tuple[float, str]:
        norm = float(np.linalg.norm(motion[order]))
        return norm / top, deed.format(norm, top)

    return measure


def _hovering(vehicle: UAV, acceleration: list[Polynomials]) -> Iterator[Limit]:
    """Yield a multirotor's limits on thrust and tilt; its thrust carries its weight too."""
    x, y, z = acceleration
    up = z + GRAVITY
    most = vehicle.thrust_to_weight * GRAVITY

    def thrust(motion: Floats) -> tuple[float, str]:
        newtons = float(np.linalg.norm(motion[2] + [0, 0, GRAVITY]))
        deed = f"needs a thrust of {newtons / GRAVITY:.7g} times its weight (of {vehicle.thrust_to_weight:.7g})"
        return newtons / most, deed

    def tilt(motion: Floats) -> tuple[float, str]:
        degrees = float(np.degrees(atan2(hypot(*motion[2, :2]), motion[2, 2] + GRAVITY)))
        return degrees / vehicle.max_tilt, f"tilts by {degrees:.7g} degrees (of {vehicle.max_tilt:.7g})"

    yield Limit(Fault.THRUST, "thrust", _below(squared([x, y, up]), most), thrust)
    # the thrust in a cone about the vertical: not below it, and not beside it
    angle = min(radians(vehicle.max_tilt * (1 + FORGIVEN)), pi / 2)
    leaning = squared([x, y]) * cos(angle) ** 2 - up * up * sin(angle) ** 2
    falling = (up * -GRAVITY).raised(leaning.degree)
    yield Limit(Fault.TILT, "tilt", stack([leaning, falling]) * (1 / GRAVITY**2), tilt)


def _flying_on(wing: FixedWing, velocity: list[Polynomials], acceleration: list[Polynomials]) -> Iterator[Limit]:
    """Yield an aeroplane's limits on airspeed, turn and climb; in units of its speed."""
    vx, vy, vz = (part * (1 / wing.speed) for part in velocity)
    ax, ay, _ = (part * (wing.turn_radius / wing.speed**2) for part in acceleration)
    level = squared([vx, vy])
    fast, slow = (1 + AIRSPEED) * (1 + FORGIVEN), (1 - AIRSPEED) * (1 - FORGIVEN)

    def airspeed(motion: Floats) -> tuple[float, str]:
        share = hypot(*motion[1, :2]) / wing.speed
        deed = f"flies {share * wing.speed:.7g} m/s over ground (of {wing.speed:.7g}, 1 % off at most)"
        return max(share / (1 + AIRSPEED), (1 - AIRSPEED) / share if share > 0 else inf), deed

    def turn(motion: Floats) -> tuple[float, str]:
        (_, (x, y, _), (ddx, ddy, _), _), cube = motion, hypot(*motion[1, :2]) ** 3
        curvature = abs(x * ddy - y * ddx) / cube if cube > 0 else inf
        radius = 1 / curvature if curvature > 0 else inf
        return curvature * wing.turn_radius, f"turns at a radius of {radius:.7g} m (of {wing.turn_radius:.7g})"

    def climb(motion: Floats) -> tuple[float, str]:
        degrees = float(np.degrees(atan2(abs(motion[1, 2]), hypot(*motion[1, :2]))))
        return degrees / wing.climb, f"climbs or descends by {degrees:.7g} degrees (of {wing.climb:.7g})"

    yield Limit(Fault.AIRSPEED, "airspeed", stack([level + -(fast**2), level * -1.0 + slow**2]), airspeed)
    across = vx * ay - vy * ax
    yield Limit(Fault.TURN, "turn", across * across - level * level * level * (1 + FORGIVEN) ** 2, turn)
    angle = min(radians(wing.climb * (1 + FORGIVEN)), pi / 2)
    yield Limit(Fault.CLIMB, "climb", vz * vz * cos(angle) ** 2 - level * sin(angle) ** 2, climb)
