"""Words of a report: counts, lists, p."""

from collections.abc import Iterable, Sequence

from skyverse.lab.report import literal


def p_value(p: float | None) -> str:
    """Return p with its name, ``None`` where too few runs have none."""
    if p is None:
        return "too few runs for p"
    return "p < 0.001" if p < 0.001 else f"p = {p:.3f}" if p < 0.1 else f"p = {p:.2f}"


def whole_numbers(numbers: Iterable[int]) -> str:
    """Return which whole numbers there are, or how many where that is shorter."""
    found = sorted(set(numbers))
    if len(found) > 2 and found[-1] - found[0] == len(found) - 1:
        return f"{found[0]} to {found[-1]}"
    return listed([str(number) for number in found]) if len(found) <= 12 else f"{len(found)} of them"


def named(labels: Sequence[str], indices: Iterable[int]) -> str:
    """Return some of the users' labels, in Markdown."""
    return ", ".join(literal(labels[index]) for index in indices)


def listed(words: Sequence[str]) -> str:
    """Return words with an "and" before the last."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def counted(count: int, noun: str) -> str:
    """Return a number and its noun."""
    return f"{count:,} {noun}{'' if count == 1 else 's'}"
