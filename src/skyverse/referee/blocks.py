"""Work that is done block by block, so that arrays do not grow with what is judged."""

from collections.abc import Iterator


def blocks(count: int, most: int, size: int = 1) -> Iterator[slice]:
    """Yield the slices of consecutive blocks of `count` items that take `size` numbers each.

    A block takes `most` numbers, or less; one item may take more.
    """
    items = most // max(size, 1) or 1
    return (slice(first, first + items) for first in range(0, count, items))
