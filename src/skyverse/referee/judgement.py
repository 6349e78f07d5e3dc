"""What every judge of the referee returns."""

from typing import NamedTuple

from skyverse.model.verdict import Violation


class Judgement(NamedTuple):
    """What is wrong or could not be decided, and how often pieces of curves were cut in two to find that out."""

    violations: list[Violation]
    halvings: int = 0
