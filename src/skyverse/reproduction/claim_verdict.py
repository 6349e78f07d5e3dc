"""The verdict on a claim of the thesis, with the evidence for it."""

from dataclasses import dataclass
from enum import Enum


class ClaimVerdict(Enum):
    """Whether a claim holds."""

    HOLDS = "holds"
    UNEQUAL = "holds only at unequal effort"
    FAILS = "does not hold"
    OPEN = "cannot be told"


@dataclass(frozen=True)
class Finding:
    """The verdict on a claim for one form of the methods, and the numbers behind it."""

    verdict: ClaimVerdict
    evidence: str


def at_both_efforts(published: bool, equal: bool) -> ClaimVerdict:
    """Return the verdict on a claim that holds, or not, at the published iterations and at equal effort."""
    if not published:
        return ClaimVerdict.FAILS
    return ClaimVerdict.HOLDS if equal else ClaimVerdict.UNEQUAL
