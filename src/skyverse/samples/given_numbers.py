"""Whole numbers that are given to generators of scenarios."""

import numpy as np

from skyverse.errors import InputError


def require_whole(
    generator: str, name: str, number: object, least: int, most: int | None = None, *, even: bool = False
) -> None:
    """Raise `InputError` for what is no whole number from `least` to `most`, or on, or not `even` where it must be."""
    if isinstance(number, int | np.integer) and not isinstance(number, bool):
        in_range = number >= least and (most is None or number <= most)
        if in_range and not (even and number % 2):
            return
    until = "on" if most is None else f"to {most}"
    kind = "an even number" if even else "a whole number"
    raise InputError(f"{generator}'s {name} is {kind} from {least} {until}, not {number!r}")
