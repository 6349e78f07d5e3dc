"""Positions as messages write them and as violations hold them."""

from skyverse._typing import Floats


def position_text(position: Floats) -> str:
    """Write a position (3,) in metres, such as ``(1, 2.5, 0.3)``."""
    return "(" + ", ".join(f"{value:.6g}" for value in position) + ")"


def position_tuple(position: Floats) -> tuple[float, float, float]:
    """Return a position (3,) as the tuple that a violation holds."""
    return float(position[0]), float(position[1]), float(position[2])
