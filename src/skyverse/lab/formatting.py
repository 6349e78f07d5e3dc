"""How reports write text in Markdown, counts, lists and p-values."""

import re
from collections.abc import Iterable, Sequence

from skyverse.model.short_lines import listed


def literal(text: str) -> str:
    """Return Markdown that shows `text` as it is, on one line."""
    return re.sub(r"([\\`*_\[\]<>|~&#!$])", r"\\\1", one_line(text))


def one_line(text: str) -> str:
    """Return `text` on one line; control characters, which would break pages and figures, are replaced."""
    return re.sub(r"[\x00-\x1f\x7f-\x9f\ud800-\udfff]", "\ufffd", " ".join(text.split()))


def p_value(p: float | None) -> str:
    """Return p with its name; ``None`` stands for too few runs to compute p."""
    if p is None:
        return "too few runs for p"
    return "p < 0.001" if p < 0.001 else f"p = {p:.3f}" if p < 0.1 else f"p = {p:.2f}"


def whole_numbers(numbers: Iterable[int]) -> str:
    """Return the distinct whole numbers as a range or a list, or how many there are where a list would be long."""
    found = sorted(set(numbers))
    if len(found) > 2 and found[-1] - found[0] == len(found) - 1:
        return f"{found[0]} to {found[-1]}"
    return listed([str(number) for number in found]) if len(found) <= 12 else f"{len(found)} of them"


def named(labels: Sequence[str], indices: Iterable[int]) -> str:
    """Return the labels at `indices`, in Markdown, separated by commas."""
    return ", ".join(literal(labels[index]) for index in indices)
