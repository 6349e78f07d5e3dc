"""Stop rules: when they are met, what they have spent, and how two of them make one."""

import math
import pickle
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.stop import Stop

COUNTED = [
    (sky.MaxIterations, "iterations"),
    (sky.MaxPaths, "generated_paths"),
    (sky.MaxNodes, "generated_nodes"),
    (sky.MaxEvaluations, "evaluations"),
]
COUNTERS = [counter for _, counter in COUNTED]


@pytest.mark.parametrize(("rule", "counter"), COUNTED)
def test_a_counted_rule_is_met_at_its_limit_and_counts_only_its_own(rule, counter):
    stop = rule(10)
    others = dict.fromkeys(COUNTERS, 99) | {counter: 9}
    assert stop.met(sky.Progress(**others)) is None
    assert stop.met(sky.Progress(**{counter: 10})) == rule.__name__
    assert stop.spent(sky.Progress(**others)) == 0.9
    assert stop.spent(sky.Progress(**{counter: 25})) == 1.0
    assert {name: stop.limit(name) for name in COUNTERS} == dict.fromkeys(COUNTERS, math.inf) | {counter: 10}
    assert repr(stop) == f"{rule.__name__}(10)"


@pytest.mark.parametrize("rule", [rule for rule, _ in COUNTED])
@pytest.mark.parametrize("most", [0, -1, 1.5, True, math.nan, math.inf, "10", "ten", None])
def test_a_counted_rule_takes_whole_numbers_from_one_on(rule, most):
    with pytest.raises(ValueError, match=f"{rule.__name__} takes a whole number from 1 on, not {most!r}"):
        rule(most)


def test_a_whole_number_may_come_as_a_float():
    assert sky.MaxIterations(40.0) == sky.MaxIterations(40)
    assert repr(sky.MaxIterations(40.0)) == "MaxIterations(40)"


def test_rules_are_equal_by_kind_and_limit():
    assert sky.MaxIterations(4) != sky.MaxIterations(5)
    assert sky.MaxIterations(4) != sky.MaxPaths(4)
    assert len({sky.MaxIterations(4), sky.MaxIterations(4), sky.MaxPaths(4)}) == 2


def test_a_clock_is_met_but_spends_nothing():
    stop = sky.MaxSeconds(2)
    assert stop.met(sky.Progress(seconds=1.99)) is None
    assert stop.met(sky.Progress(seconds=2.0)) == "MaxSeconds"
    assert stop.spent(sky.Progress(seconds=1.0)) is None
    assert stop.limit("iterations") == math.inf


@pytest.mark.parametrize("seconds", [0, -1, math.nan])
def test_a_clock_takes_seconds_above_zero(seconds, refuses):
    with refuses(ValueError):
        sky.MaxSeconds(seconds)


def test_a_target_cost_is_met_once_reached():
    stop = sky.TargetCost(265)
    assert stop.met(sky.Progress(cost=265.1)) is None
    assert stop.met(sky.Progress(cost=265.0)) == "TargetCost"
    assert stop.spent(sky.Progress(cost=0.0)) is None
    assert stop.met(sky.Progress()) is None


def test_an_event_cancels():
    event = threading.Event()
    stop = sky.Cancelled(event)
    assert stop.met(sky.Progress(iterations=10**9)) is None
    assert not stop.cancelled
    event.set()
    assert stop.met(sky.Progress()) == "Cancelled"
    assert stop.cancelled
    assert stop.spent(sky.Progress()) is None


def test_combined_rules_are_cancelled_when_one_of_them_is_however_far_the_run_is():
    event = threading.Event()
    stop = sky.MaxIterations(3) | (sky.Cancelled(event) | sky.MaxSeconds(1))
    assert not stop.cancelled
    event.set()
    assert stop.cancelled
    assert stop.met(sky.Progress(iterations=3)) == "MaxIterations"


RULES = st.one_of(
    st.builds(lambda rule, most: rule(most), st.sampled_from([rule for rule, _ in COUNTED]), st.integers(1, 50)),
    st.builds(sky.MaxSeconds, st.integers(1, 50)),
    st.builds(sky.TargetCost, st.integers(1, 50)),
)
PROGRESS = st.builds(
    sky.Progress,
    **dict.fromkeys(COUNTERS, st.integers(0, 60)),
    seconds=st.floats(0, 60),
    cost=st.floats(0, 60),
)


@given(st.lists(RULES, min_size=1, max_size=4), PROGRESS)
def test_rules_that_are_combined_end_at_the_first_that_is_met(rules, progress):
    stop: Stop = rules[0]
    for rule in rules[1:]:
        stop = stop | rule
    met = [rule.met(progress) for rule in rules if rule.met(progress)]
    assert stop.met(progress) == (met[0] if met else None)
    shares = [s for s in (rule.spent(progress) for rule in rules) if s is not None]
    assert stop.spent(progress) == (max(shares) if shares else None)
    for counter in COUNTERS:
        assert stop.limit(counter) == min(rule.limit(counter) for rule in rules)
    assert repr(stop) == " | ".join(map(repr, rules))


def test_rules_travel_to_other_processes():
    stop = sky.MaxIterations(3) | sky.MaxSeconds(2.5)
    assert pickle.loads(pickle.dumps(stop)) == stop
    assert repr(stop) == "MaxIterations(3) | MaxSeconds(2.5)"
