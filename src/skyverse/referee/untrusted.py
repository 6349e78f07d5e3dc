"""Entries of a mission that may be malformed, read as what they should be; ``None`` where they are not."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.model.scenario import Scenario


def float_array(value: object) -> Floats | None:
    """Return a value as an array of floats, or ``None`` if it holds anything but numbers."""
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        return None


def finite_point(value: object) -> Floats | None:
    """Return a value as x, y, z, or ``None`` if it is not three finite numbers."""
    point = float_array(value)
    return point if point is not None and point.shape == (3,) and np.isfinite(point).all() else None


def entry(values: Sequence[Any], index: int) -> Any:
    """Return one UAV's entry in a column of a mission, or ``None`` if the column is too short."""
    return values[index] if index < len(values) else None


def target_index(scenario: Scenario, value: object) -> int | None:
    """Return a value as the index of one of the scenario's targets, or ``None`` if it is not one."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        return None
    return int(value) if 0 <= value < len(scenario.targets) else None
