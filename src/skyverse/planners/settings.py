"""Checks of a planner's settings: each raises a ValueError that names the planner, the setting and what it may be."""

import numpy as np

from skyverse.errors import InputError, is_number


def require_integer(settings: object, name: str, least: float) -> None:
    """Refuse a setting that is no whole number, or below the least."""
    value = getattr(settings, name)
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise InputError(f"{type(settings).__name__}'s {name} is a whole number from {least:g} on, not {value!r}")


def require_number(settings: object, name: str, least: float, most: float) -> None:
    """Refuse a setting that is no number, or not within these limits."""
    value = getattr(settings, name)
    if not (is_number(value) and least <= value <= most):
        raise InputError(f"{type(settings).__name__}'s {name} is a number from {least:g} to {most:g}, not {value!r}")


def require_boolean(settings: object, name: str) -> None:
    """Refuse a setting that is neither true nor false."""
    value = getattr(settings, name)
    if not isinstance(value, bool):
        raise InputError(f"{type(settings).__name__}'s {name} is True or False, not {value!r}")
