"""What an observation holds beside movers, checked before anything is changed: states of UAVs, and new obstacles."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike
from pydantic import ValidationError

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.live.course import Course
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Shape
from skyverse.model.uav import TrackingError
from skyverse.model.wrong_values import complaint

OFF_COURSE = 0.01
"""Metres beyond its tracking error from where it should be, at which a UAV counts as off its course."""


def checked_states(given: Mapping[int, tuple[ArrayLike, ArrayLike]], count: int) -> dict[int, Floats]:
    """Return the states (3, 3) of UAVs, without acceleration, or raise `InputError`."""
    states = {}
    for uav, known in given.items():
        if uav not in range(count):
            raise InputError(f"expected the index of one of {count} UAVs, but it is {uav!r}", field="states")
        try:
            state = np.array([*known, np.zeros(3)], dtype=np.float64)
        except (TypeError, ValueError):
            state = np.full(1, np.nan)
        if state.shape != (3, 3) or not np.isfinite(state).all():
            raise InputError("expected a position and a velocity, three finite numbers each", field=f"states[{uav}]")
        states[uav] = state
    return states


def with_obstacles(scenario: Scenario, obstacles: Sequence[Shape]) -> Scenario:
    """Return a scenario with more obstacles, or raise `InputError`."""
    try:
        return Scenario.model_validate({**dict(scenario), "obstacles": (*scenario.obstacles, *obstacles)})
    except ValidationError as error:
        first = error.errors()[0]
        number, place = first["loc"][1:2], ".".join(str(part) for part in ("", *first["loc"][3:]))
        which = f"[{number[0] - len(scenario.obstacles)}]" if number and isinstance(number[0], int) else ""
        raise InputError(complaint(first), field=f"obstacles{which}{place}") from None


def strays(course: Course, t: float, state: Floats, error: TrackingError) -> bool:
    """Tell whether a state is farther from a course at an instant than a tracking error and a centimetre."""
    off = state[0] - course.state(t)[0]
    aside, up = float(np.hypot(off[0], off[1])), abs(float(off[2]))
    return aside > error.horizontal + OFF_COURSE or up > error.vertical + OFF_COURSE
