"""Lines, numbers and times as the prompt shows them: at most six short lines that say what matters."""

import math
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


def told_area(area: float) -> str:
    """Return an area, given in square metres, in three digits: ``430 m²``, ``1.98 ha``, ``12.3 km²``."""
    unit, metres = ("km²", 1e6) if area >= 1e7 else ("ha", 1e4) if area >= 1e4 else ("m²", 1.0)
    return f"{float(f'{area / metres:.3g}'):,.6g} {unit}"


def told_gsd(gsd: float) -> str:
    """Return a ground sample distance, given in metres, in centimetres, rounded up; ``none`` where there is none."""
    return f"{math.ceil(round(1e4 * gsd, 6)) / 100:.4g} cm" if math.isfinite(gsd) else "none"


def told_overlap(percent: float) -> str:
    """Return an overlap, rounded down to a tenth of a per cent; ``none`` where there is none."""
    return "none" if math.isnan(percent) else f"{math.floor(10 * percent) / 10:.1f} %"


def told_share(share: float) -> str:
    """Return a share in per cent, rounded down."""
    return f"{math.floor(1e4 * share + 1e-9) / 100:g} %"


def as_lines(first: str, *more: str) -> str:
    """Return a first line and the others indented below it, without empty ones, each cut where it is too long."""
    lines = [first, *(f"  {line}" for line in more if line)]
    return "\n".join(line if len(line) <= MAX_LINE else f"{line[: MAX_LINE - 3]}..." for line in lines)


def told_seconds(seconds: float) -> str:
    """Return seconds in four digits or more, never in powers of ten: ``3.25 s``, ``48.5 s``, ``2,010 s``."""
    decimals = 0 if abs(seconds) >= 1000 else 1 if abs(seconds) >= 100 else 2
    number = f"{seconds + 0.0:,.{decimals}f}"
    return f"{number.rstrip('0').rstrip('.') if decimals else number} s"


def told_clock(seconds: float) -> str:
    """Return seconds in whole minutes and seconds: ``0:48``, ``14:52``."""
    return "{}:{:02}".format(*divmod(round(seconds), 60))


def told_instant(seconds: float) -> str:
    """Return an instant of a simulated flight, ``at 3.25 s``; before the mission begins UAVs hover at their starts."""
    if seconds < 0:
        return f"{-seconds:.2f} s before the mission begins, in the hover at the start"
    return f"at {seconds:.2f} s"


SMALLEST_GAP = 1e-9
"""A gap as small as this, as a share of the bound, is rounding and told as none."""


def told_gap(gap: float | None) -> str:
    """Return a gap, a share of the bound, in per cent rounded up: ``2 %``, ``0.1 %``, ``0 %``; ``-`` where unknown.

    A cost below its bound, which the referee refutes, is told with its sign.
    """
    if gap is None or not math.isfinite(gap):
        return "-"
    if abs(gap) <= SMALLEST_GAP:
        return "0 %"
    scale = 1 if gap >= 0.1 else 10
    percent = math.ceil(100 * scale * gap * (1 - SMALLEST_GAP)) / scale if gap > 0 else 100 * gap
    return f"{percent:,.4g} %" if percent < 1000 else f"{percent:,.0f} %"
