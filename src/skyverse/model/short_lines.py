"""Lines and numbers as the prompt shows them: at most six short lines that say what matters."""

from collections.abc import Iterable, Sequence

MAX_LINE = 110
"""Characters of a line at most; what is longer is cut."""
TIMES = " \N{MULTIPLICATION SIGN} "


def counted(number: int, thing: str, things: str | None = None) -> str:
    """Return a number of things in words: ``no obstacles``, ``1 target``, ``1,200 UAVs``."""
    many = things or f"{thing}s"
    return f"no {many}" if number == 0 else f"1 {thing}" if number == 1 else f"{number:,} {many}"


def listed(words: Sequence[str]) -> str:
    """Return words separated by commas, with "and" before the last; empty where there are none."""
    return " and ".join(filter(None, (", ".join(words[:-1]), *words[-1:])))


def told_metres(metres: float) -> str:
    """Return metres in about four digits, never in powers of ten below a billion: ``24.78 m``, ``9,986 m``."""
    return f"{metres:,.0f} m" if 1000 <= abs(metres) < 1e9 else f"{metres:.4g} m"


def told_point(point: Iterable[float]) -> str:
    """Return a place in metres, rounded to millimetres: ``(0, -4, 1.25)``."""
    return f"({', '.join(f'{round(float(value), 3) + 0.0:.10g}' for value in point)})"


def as_lines(first: str, *more: str) -> str:
    """Return a first line and the others indented below it, without empty ones, each cut where it is too long."""
    lines = [first, *(f"  {line}" for line in more if line)]
    return "\n".join(line if len(line) <= MAX_LINE else f"{line[: MAX_LINE - 3]}..." for line in lines)
