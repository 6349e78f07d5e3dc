"""Sentences that hold for several UAVs alike, said once with the names of all of them."""

from collections.abc import Iterator, Sequence


def few(words: Sequence[str], most: int) -> str:
    """Return at most so many words, and how many more there are."""
    more = f" and {len(words) - most} more" if len(words) > most else ""
    return ", ".join(words[:most]) + more


def grouped(said: Sequence[tuple[str, str]], fleet: int) -> Iterator[str]:
    """Yield sentences, those that are the same of several UAVs once, in the order in which they first occur.

    Parameters
    ----------
    said
        The name of a UAV, and what is said of it, for some or all of the fleet.
    fleet
        How many UAVs there are in all.
    """
    holders: dict[str, list[str]] = {}
    for name, text in said:
        holders.setdefault(text, []).append(name)
    for text, names in holders.items():
        if len(names) == 1:
            yield f"{names[0]}: {text}"
        else:
            yield f"Each of {f'the {fleet} UAVs' if len(names) == fleet else ', '.join(names)}: {text}"
