"""Blocks hold every item once, in order, and no more than fits."""

import pytest

from skyverse.referee.overlaps import blocks


@pytest.mark.parametrize(
    ("count", "most", "size", "lengths"),
    [
        (0, 5, 1, []),
        (7, 3, 1, [3, 3, 1]),
        (6, 3, 1, [3, 3]),
        (7, 8, 3, [2, 2, 2, 1]),
        (3, 4, 5, [1, 1, 1]),
        (2, 9, 4, [2]),
        (5, 3, 0, [3, 2]),
    ],
)
def test_all_items_are_in_blocks_of_bounded_size(count, most, size, lengths):
    held = [range(count)[block] for block in blocks(count, most, size)]
    assert [len(items) for items in held] == lengths
    assert [k for items in held for k in items] == list(range(count))


def test_items_take_one_number_unless_more_is_said():
    assert list(blocks(4, 2)) == [slice(0, 2), slice(2, 4)]
