"""What threads make side by side: in order, and without a gap wherever it is stopped, whichever thread comes first."""

import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from patience import PATIENCE_S
from skyverse.interrupt import interruptible
from skyverse.numerics.side_by_side import side_by_side
from turns import in_turns

COUNT = 7


def made_until(asked, *how):
    with interruptible(asked):
        return list(side_by_side(*how))


@given(turns=st.permutations(range(1, COUNT)), last=st.integers(0, COUNT))
def test_what_is_made_is_all_that_was_begun_and_has_no_gap_whatever_the_order(turns, last):
    stopped, begun = threading.Event(), []

    def make(number):
        begun.append(number)
        if number == last:
            stopped.set()
        return number

    with pytest.MonkeyPatch.context() as patch:
        in_turns(patch, turns.index)
        made = made_until(stopped.is_set, make, COUNT, 3)
    order = [0, *turns, COUNT]
    assert made == sorted(begun) == list(range(max(order[:-1][: order.index(last) + 1]) + 1))


def test_what_other_threads_have_begun_is_finished():
    stopped = threading.Event()

    def make(number):
        stopped.set() if number == 3 else number and stopped.wait(PATIENCE_S)  # so that all three are under way
        return number

    assert made_until(stopped.is_set, make, COUNT, 3) == [0, 1, 2, 3]


@pytest.mark.parametrize("workers", [1, 3])
@pytest.mark.parametrize("count", [0, 1, COUNT])
def test_nothing_is_begun_after_an_interruption(workers, count):
    assert made_until(lambda: True, int, count, workers) == []
    assert made_until(lambda: False, int, count, workers) == list(range(count))
