"""Judges whether a UAV's nose turns within the limits on its yaw, at every instant; not where it points."""

from collections.abc import Iterator
from math import degrees, isfinite, radians

import numpy as np

from skyverse.model.pointing import Pointing
from skyverse.model.uav import UAV
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.tolerances import LIMIT_LET_PASS, YAW_RATE_ROUNDING


def judge_heading(vehicle: UAV, uav: int, pointing: Pointing | None) -> Iterator[Violation]:
    """Yield what is wrong with the yaw of a multirotor; that of an aeroplane is its course, whose turns are judged.

    Each turn adds a trapezoid to the yaw rate: up in `rise` seconds, level, and down in `rise` seconds. So the yaw
    rate is linear between the corners of all trapezoids, where it is largest, and its slope, the yaw acceleration, is
    constant there.
    """
    if pointing is None or vehicle.fixed_wing is not None:
        return
    if not _well_formed(pointing):
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


def _well_formed(pointing: object) -> bool:
    """Return whether turns can be judged, whatever stands in their place."""
    if not isinstance(pointing, Pointing):
        return False
    try:
        numbers = [float(number) for number in (pointing.yaw, pointing.spread, pointing.rise)]
        instants, turns = (np.asarray(row, dtype=np.float64) for row in (pointing.instants, pointing.turns))
    except (TypeError, ValueError):
        return False
    finite = all(map(isfinite, numbers)) and bool(np.isfinite(instants).all() and np.isfinite(turns).all())
    return finite and instants.ndim == 1 and instants.shape == turns.shape and 0 < numbers[2] <= numbers[1]
