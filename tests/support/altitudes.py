"""Altitudes that are compared but for rounding."""

import pytest


class About:
    """Equals altitudes of a kind that are about so many metres."""

    def __init__(self, kind, metres):
        self.kind, self.metres = kind, metres

    def __eq__(self, other):
        return type(other) is self.kind and other.metres == pytest.approx(self.metres)

    __hash__ = None
