"""Sentences that hold for several UAVs alike, said once with the names of all of them."""

from collections.abc import Iterator, Sequence


def grouped(said: Sequence[tuple[str, str]]) -> Iterator[str]:
    """Yield sentences, those that are the same of several UAVs once, in the order in which they first occur.

    Parameters
    ----------
    said
        The name of each UAV, and what is said of it.
    """
    holders: dict[str, list[str]] = {}
    for name, text in said:
        holders.setdefault(text, []).append(name)
    every = len({name for name, _ in said})
    for text, names in holders.items():
        if len(names) == 1:
            yield f"{names[0]}: {text}"
        else:
            yield f"Each of {f'the {every} UAVs' if len(names) == every else ', '.join(names)}: {text}"
