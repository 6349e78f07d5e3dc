"""Instants and durations as sentences tell them."""


def told_seconds(seconds: float) -> str:
    """Return seconds in four digits or more, never in powers of ten: ``3.25 s``, ``48.5 s``, ``2,010 s``."""
    decimals = 0 if abs(seconds) >= 1000 else 1 if abs(seconds) >= 100 else 2
    number = f"{seconds + 0.0:,.{decimals}f}"
    return f"{number.rstrip('0').rstrip('.') if decimals else number} s"


def told_instant(seconds: float) -> str:
    """Return an instant of a simulated flight, ``at 3.25 s``; before the mission begins UAVs hover at their starts."""
    if seconds < 0:
        return f"{-seconds:.2f} s before the mission begins, in the hover at the start"
    return f"at {seconds:.2f} s"
