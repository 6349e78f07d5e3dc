"""Verdicts: all of several comparisons, evidence at equal effort, and how often they are right."""

import math

import numpy as np
import pytest

from skyverse.reproduction.claim_verdict import ClaimVerdict, Comparison, Evidence, judged, verdict

SHOWN, OPEN, AGAINST, WEAKLY_AGAINST = (
    Evidence(0.04, 1.0),
    Evidence(0.3, 1.0),
    Evidence(1.0, 0.001),
    Evidence(1.0, 0.04),
)


@pytest.mark.parametrize(
    ("published", "equal", "expected"),
    [
        ([SHOWN], [], ClaimVerdict.AS_PUBLISHED),
        ([SHOWN] * 12, [SHOWN] * 6, ClaimVerdict.HOLDS),  # each at 5 %: no adjustment where all are needed
        ([SHOWN, OPEN], [SHOWN], ClaimVerdict.OPEN),
        ([SHOWN, AGAINST], [SHOWN], ClaimVerdict.FAILS),
        ([SHOWN, WEAKLY_AGAINST, OPEN], [], ClaimVerdict.OPEN),  # any of three refutes: adjusted
        ([SHOWN], [OPEN], ClaimVerdict.NOT_SHOWN),  # no evidence is no evidence of absence
        ([SHOWN], [SHOWN, AGAINST], ClaimVerdict.UNEQUAL),
        ([SHOWN], [SHOWN, WEAKLY_AGAINST], ClaimVerdict.NOT_SHOWN),
    ],
)
def test_a_verdict_follows_from_the_evidence(published, equal, expected):
    assert verdict(published, equal) is expected


def compared(first, second, asked=(-math.inf, 0.0), runs=200, deviation=8.0, seed=0):
    rng = np.random.default_rng(seed)
    samples = (rng.normal(mean, deviation, runs) for mean in (first, second))
    return Comparison("Map 1", ("a", "b"), *samples, asked)


@pytest.mark.parametrize(
    ("equal", "expected"),
    [
        (compared(270, 280), ClaimVerdict.HOLDS),
        (compared(280, 280), ClaimVerdict.UNEQUAL),  # the same within 3 %
        (compared(290, 280), ClaimVerdict.UNEQUAL),  # the opposite
        (compared(275, 280, deviation=60.0, runs=50, seed=4), ClaimVerdict.NOT_SHOWN),
        (compared(279, 280, deviation=2.0), ClaimVerdict.HOLDS),  # lower, if by less than 3 %
    ],
)
def test_only_evidence_at_equal_effort_makes_a_claim_one_on_unequal_effort(equal, expected):
    assert judged([compared(270, 280)], [equal], same_refutes=True).verdict is expected


@pytest.mark.parametrize(
    ("first", "expected"),
    [
        (50, ClaimVerdict.AS_PUBLISHED),
        (62, ClaimVerdict.AS_PUBLISHED),
        (70, ClaimVerdict.FAILS),
        (30, ClaimVerdict.FAILS),
    ],
)
def test_a_share_may_be_asked_to_lie_in_a_range(first, expected):
    assert judged([compared(first, 100, (-0.6, -0.35), deviation=2.0)]).verdict is expected


def test_a_false_claim_on_two_comparisons_is_accepted_in_at_most_one_of_twenty_studies():
    rng, held = np.random.default_rng(0), 0
    for _ in range(500):
        true, false = (Comparison("", ("a", "b"), rng.normal(a, 8, 30), rng.normal(280, 8, 30)) for a in (260.0, 280.0))
        held += judged([true, false]).verdict is ClaimVerdict.AS_PUBLISHED
    assert held / 500 <= 0.05


def test_a_row_tells_the_means_and_what_could_have_been_seen():
    row = compared(270, 280).record()
    assert row["difference"].startswith("-3.")
    share, units = row["could be seen"].removesuffix(")").split("% (")
    assert float(units) == pytest.approx(2.8 * 8 * math.sqrt(2 / 200), rel=0.1)
    assert float(share) == pytest.approx(100 * float(units) / 280, abs=0.06)
