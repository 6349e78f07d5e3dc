"""The limits of a UAV as polynomials of its trajectory, which keeps a limit where the polynomial is not above zero."""

import math
from collections.abc import Callable, Iterator
from math import atan2, cos, degrees, hypot, inf, isfinite, pi, radians, sin
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.trajectory import Pointing
from skyverse.model.uav import GRAVITY, UAV, FixedWing
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.curve import PolynomialCurve, derivative
from skyverse.referee.polynomial import Polynomials, bernstein, squared, stack
from skyverse.referee.tolerances import AIRSPEED_BAND, LIMIT_LET_PASS, YAW_RATE_ROUNDING


class FlightLimit(NamedTuple):
    """One limit: the polynomials that may not be above zero, and a measure of one instant.

    Attributes
    ----------
    fault, noun
        What is wrong where the limit is broken, and what messages call the limited quantity.
    excess
        At or below zero wherever the limit is kept, except for what is let pass; one row for each piece, or several
        blocks of such rows.
    measure
        Takes position, velocity, acceleration and jerk, (4, 3), and returns the share of the limit that is used, and
        what the UAV does, in words.
    most
        What the measure may be at most, with what is let pass.
    """

    fault: Fault
    noun: str
    excess: Polynomials
    measure: Callable[[Floats], tuple[float, str]]
    most: float = 1 + LIMIT_LET_PASS


def flight_limits(vehicle: UAV, curve: PolynomialCurve) -> Iterator[FlightLimit]:
    """Yield the limits of a UAV as polynomials on the pieces of its trajectory."""
    durations = curve.durations
    rows = [curve.pieces]
    for _ in range(3):
        rows.append(derivative(rows[-1]))
    _, velocity, acceleration, jerk = (bernstein(row, durations) for row in rows)
    norms = [
        (Fault.SPEED, "speed", velocity, vehicle.max_speed, "flies {:.7g} m/s"),
        (Fault.ACCELERATION, "acceleration", acceleration, vehicle.max_acceleration, "accelerates by {:.7g} m/s^2"),
        (Fault.JERK, "jerk", jerk, vehicle.max_jerk, "jerks by {:.7g} m/s^3"),
    ]
    for order, (fault, noun, parts, top, deed) in enumerate(norms[: 3 if vehicle.fixed_wing is None else 2], 1):
        yield FlightLimit(fault, noun, _below(squared(parts), top), _norm(order, top, deed))
    yield from _vertical_speeds(vehicle, velocity[2])
    if vehicle.fixed_wing is None:
        yield from _hovering(vehicle, acceleration)
    else:
        yield from _flying_on(vehicle.fixed_wing, velocity, acceleration)


def _below(square: Polynomials, top: float) -> Polynomials:
    """Return how far the square of a norm is above the square of its limit `top`, as a share of the latter."""
    return square * (1 / (top * (1 + LIMIT_LET_PASS)) ** 2) + -1.0


def _norm(order: int, top: float, deed: str) -> Callable[[Floats], tuple[float, str]]:
    """Return the measure of the norm of the derivative of some order."""

    def measure(motion: Floats) -> tuple[float, str]:
        norm = math.hypot(*motion[order])
        return norm / top, f"{deed.format(norm)} (of {top:.7g})"

    return measure


def _vertical_speeds(vehicle: UAV, upwards: Polynomials) -> Iterator[FlightLimit]:
    """Yield the limits on climbing and descending: vz <= max_climb and -vz <= max_descent."""
    for fault, noun, sign, top, deed in (
        (Fault.CLIMB_RATE, "climb rate", 1.0, vehicle.max_climb, "climbs at {:.7g} m/s (of {:.7g})"),
        (Fault.DESCENT_RATE, "descent rate", -1.0, vehicle.max_descent, "descends at {:.7g} m/s (of {:.7g})"),
    ):
        if top is not None:
            excess = upwards * (sign / (top * (1 + LIMIT_LET_PASS))) + -1.0
            yield FlightLimit(fault, noun, excess, _upwards(sign, top, deed))


def _upwards(sign: float, top: float, deed: str) -> Callable[[Floats], tuple[float, str]]:
    """Return the measure of the vertical speed, upwards where `sign` is 1, and downwards where it is -1."""

    def measure(motion: Floats) -> tuple[float, str]:
        rate = sign * float(motion[1, 2])
        return rate / top, deed.format(rate, top)

    return measure


def _hovering(vehicle: UAV, acceleration: list[Polynomials]) -> Iterator[FlightLimit]:
    """Yield a multirotor's limits on thrust and tilt.

    The specific thrust is f = a + (0, 0, g): it accelerates the UAV and carries its weight.

    - thrust: f . f <= (thrust_to_weight g)^2;
    - tilt: (fx^2 + fy^2) cos^2(max_tilt) <= fz^2 sin^2(max_tilt) and fz >= 0, a cone about the vertical.
    """
    x, y, z = acceleration
    up = z + GRAVITY
    top = vehicle.thrust_to_weight * GRAVITY

    def thrust(motion: Floats) -> tuple[float, str]:
        size = math.hypot(*(motion[2] + [0, 0, GRAVITY]))
        deed = f"needs a thrust of {size / GRAVITY:.7g} times its weight (of {vehicle.thrust_to_weight:.7g})"
        return size / top, deed

    def tilt(motion: Floats) -> tuple[float, str]:
        degrees = float(np.degrees(atan2(hypot(*motion[2, :2]), motion[2, 2] + GRAVITY)))
        return degrees / vehicle.max_tilt, f"tilts by {degrees:.7g} degrees (of {vehicle.max_tilt:.7g})"

    yield FlightLimit(Fault.THRUST, "thrust", _below(squared([x, y, up]), top), thrust)
    angle = min(radians(vehicle.max_tilt * (1 + LIMIT_LET_PASS)), pi / 2)
    leaning = squared([x, y]) * cos(angle) ** 2 - up * up * sin(angle) ** 2
    falling = (up * -GRAVITY).raised(leaning.degree)
    yield FlightLimit(Fault.TILT, "tilt", stack([leaning, falling]) * (1 / GRAVITY**2), tilt)


def _flying_on(wing: FixedWing, velocity: list[Polynomials], acceleration: list[Polynomials]) -> Iterator[FlightLimit]:
    """Yield an aeroplane's limits on airspeed, turn and climb.

    With velocity v in units of its speed, and acceleration a in units of speed^2 / turn_radius:

    - airspeed: slow^2 <= vx^2 + vy^2 <= fast^2;
    - turn: (vx ay - vy ax)^2 <= (vx^2 + vy^2)^3, the square of the curvature seen from above times the radius;
    - climb: vz^2 cos^2(climb) <= (vx^2 + vy^2) sin^2(climb).
    """
    vx, vy, vz = (part * (1 / wing.speed) for part in velocity)
    ax, ay, _ = (part * (wing.turn_radius / wing.speed**2) for part in acceleration)
    level = squared([vx, vy])
    fast, slow = (1 + AIRSPEED_BAND) * (1 + LIMIT_LET_PASS), (1 - AIRSPEED_BAND) * (1 - LIMIT_LET_PASS)

    def airspeed(motion: Floats) -> tuple[float, str]:
        share = hypot(*motion[1, :2]) / wing.speed
        deed = f"flies {share * wing.speed:.7g} m/s over ground (of {wing.speed:.7g}, 1 % off at most)"
        return max(share / (1 + AIRSPEED_BAND), (1 - AIRSPEED_BAND) / share if share > 0 else inf), deed

    def turn(motion: Floats) -> tuple[float, str]:
        (_, (x, y, _), (ddx, ddy, _), _), cube = motion, hypot(*motion[1, :2]) ** 3
        curvature = abs(x * ddy - y * ddx) / cube if cube > 0 else inf
        radius = 1 / curvature if curvature > 0 else inf
        return curvature * wing.turn_radius, f"turns at a radius of {radius:.7g} m (of {wing.turn_radius:.7g})"

    def climb(motion: Floats) -> tuple[float, str]:
        degrees = float(np.degrees(atan2(abs(motion[1, 2]), hypot(*motion[1, :2]))))
        return degrees / wing.climb, f"climbs or descends by {degrees:.7g} degrees (of {wing.climb:.7g})"

    yield FlightLimit(Fault.AIRSPEED, "airspeed", stack([level + -(fast**2), level * -1.0 + slow**2]), airspeed)
    across = vx * ay - vy * ax
    yield FlightLimit(Fault.TURN, "turn", across * across - level * level * level * (1 + LIMIT_LET_PASS) ** 2, turn)
    angle = min(radians(wing.climb * (1 + LIMIT_LET_PASS)), pi / 2)
    yield FlightLimit(Fault.CLIMB, "climb", vz * vz * cos(angle) ** 2 - level * sin(angle) ** 2, climb)


def judge_heading(vehicle: UAV, uav: int, pointing: Pointing | None) -> Iterator[Violation]:
    """Yield what is wrong with the yaw of a multirotor; that of an aeroplane is its course, whose turns are judged.

    Each turn adds a trapezoid to the yaw rate: up in `rise` seconds, level, and down in `rise` seconds. So the yaw
    rate is linear between the corners of all trapezoids, where it is largest, and its slope, the yaw acceleration, is
    constant there.
    """
    if pointing is None or vehicle.fixed_wing is not None:
        return
    if not well_formed(pointing):
        message = (
            f"{vehicle.name}'s pointing is malformed: expected a finite yaw, as many finite instants as turns, "
            "and 0 < rise <= spread."
        )
        yield Violation(Fault.TRAJECTORY_SHAPE, (uav,), message)
        return
    if not len(pointing.turns):
        return
    half, flat = (pointing.spread + pointing.rise) / 2, (pointing.spread - pointing.rise) / 2
    with np.errstate(all="ignore"):  # what overflows is above the limits, or no number, and so refuted
        corners = (pointing.instants[:, None] + [-half, -flat, flat, half]).ravel()
        bends = ((pointing.turns / pointing.spread / pointing.rise)[:, None] * [1.0, -1.0, -1.0, 1.0]).ravel()
        order = np.argsort(corners, kind="stable")
        times, accelerations = corners[order], np.cumsum(bends[order])[:-1]
        changes = accelerations * np.diff(times)
        rates = np.r_[0.0, np.cumsum(changes)]
        accelerations[np.abs(changes) <= YAW_RATE_ROUNDING] = 0.0  # between corners that are one but for rounding
    for noun, unit, values, top in (
        ("yaw rate", "degrees/s", rates, vehicle.max_yaw_rate),
        ("yaw acceleration", "degrees/s^2", accelerations, vehicle.max_yaw_acceleration),
    ):
        if not (np.abs(values) <= radians(top) * (1 + LIMIT_LET_PASS)).all():
            k = int(np.argmax(np.nan_to_num(np.abs(values), nan=np.inf)))
            size, time = degrees(abs(values[k])), float(times[k])
            message = f"{vehicle.name}'s {noun} is {size:.7g} {unit} (of {top:.7g}) at t = {time:.6g} s."
            yield Violation(Fault.YAW, (uav,), message, time)
            return


def well_formed(pointing: object) -> bool:
    """Return whether turns can be judged, whatever stands in their place."""
    if not isinstance(pointing, Pointing):
        return False
    try:
        numbers = [float(number) for number in (pointing.yaw, pointing.spread, pointing.rise)]
        instants, turns = (np.asarray(row, dtype=np.float64) for row in (pointing.instants, pointing.turns))
    except (TypeError, ValueError, OverflowError):
        return False
    finite = all(map(isfinite, numbers)) and bool(np.isfinite(instants).all() and np.isfinite(turns).all())
    return finite and instants.ndim == 1 and instants.shape == turns.shape and 0 < numbers[2] <= numbers[1]
