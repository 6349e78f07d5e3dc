"""Judges where a trajectory starts and ends, and whether it jumps at its knots."""

from collections.abc import Iterator

import numpy as np

from skyverse.model.verdict import Fault, Violation
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.positions import position_text, position_tuple
from skyverse.referee.tolerances import JUMP_ROUNDING, LET_PASS
from skyverse.referee.world import RefereeWorld

SMOOTH_FORMS = ("smooth", "slowed", "straightened")
"""The forms of trajectories whose jerk must not jump either."""


def judge_ends(world: RefereeWorld, uav: int, target: int | None, curve: PolynomialCurve) -> Iterator[Violation]:
    """Yield the first end of a trajectory at which the UAV is not where it must be, or not at rest."""
    scenario, (knots, pieces) = world.scenario, curve
    vehicle = scenario.uavs[uav]
    ends = [("starts", knots[0], curve.motion(0, 0.0), vehicle.start)]
    if target is not None:
        last = curve.motion(len(pieces) - 1, curve.durations[-1])
        ends.append(("ends", knots[-1], last, scenario.targets[target].position))
    for verb, time, motion, due in ends:
        miss, speed, acceleration = np.linalg.norm(motion[:3] - [due, np.zeros(3), np.zeros(3)], axis=1)
        rests = vehicle.fixed_wing is not None or (speed <= LET_PASS and acceleration <= LET_PASS)
        if not (miss <= LET_PASS and rests):
            must = "there" if vehicle.fixed_wing is not None else "there at rest"
            message = (
                f"{vehicle.name}'s trajectory {verb} at t = {time:.6g} s, position {position_text(motion[0])}, "
                f"with {speed:.6g} m/s and {acceleration:.6g} m/s^2, {miss:.6g} m from {position_text(np.array(due))}; "
                f"it must be {must}."
            )
            yield Violation(Fault.TRAJECTORY_ENDS, (uav,), message, float(time), position_tuple(motion[0]))
            return


def judge_continuity(world: RefereeWorld, uav: int, curve: PolynomialCurve, form: object) -> Iterator[Violation]:
    """Yield the worst jump of position or velocity, of a multirotor's acceleration, or of the jerk of a smooth form."""
    vehicle, (knots, pieces) = world.scenario.uavs[uav], curve
    if len(pieces) < 2:
        return
    kinds = 2 if vehicle.fixed_wing is not None else 4 if isinstance(form, str) and form in SMOOTH_FORMS else 3
    each = np.arange(len(pieces))
    before, after = curve.motions(each[:-1], curve.durations[:-1]), curve.motions(each[1:], np.zeros(len(each) - 1))
    jumps = np.linalg.norm(before - after, axis=2)[:, :kinds]
    sizes = np.linalg.norm(after, axis=2)[:, :kinds]
    let_pass = LET_PASS * np.maximum(1.0, sizes)
    # a jump in position may go through a wall, so that far from the origin only rounding is let pass on top
    let_pass[:, 0] = LET_PASS + JUMP_ROUNDING * sizes[:, 0]
    k = int(np.argmax((jumps / let_pass).max(axis=1)))
    if not (jumps[k] <= let_pass[k]).all():
        numbers = [f"{jump:.6g} {unit}" for jump, unit in zip(jumps[k], ("m", "m/s", "m/s^2", "m/s^3"), strict=False)]
        message = (
            f"{vehicle.name}'s trajectory jumps by {', '.join(numbers[:-1])} and {numbers[-1]} "
            f"at t = {knots[k + 1]:.6g} s, position {position_text(after[k, 0])}."
        )
        yield Violation(Fault.CONTINUITY, (uav,), message, float(knots[k + 1]), position_tuple(after[k, 0]))
