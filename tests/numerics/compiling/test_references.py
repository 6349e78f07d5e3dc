"""NamedTuples that kernels take by reference: no reference outlives the memory that it points to."""

import pytest
from numba.core import types

from skyverse.numerics.compiling.listing import read_listing
from skyverse.numerics.compiling.references import StructReference
from skyverse.numerics.kernel import PLAIN_NUMBA, PLAIN_PYTHON

pytestmark = pytest.mark.skipif(PLAIN_PYTHON or PLAIN_NUMBA, reason="nothing is taken by reference")

RETURN_REFERENCES = {
    "skyverse.search.taut.shorten_window:_local_space": "to parts of its argument, which its caller does not return",
    "skyverse.space.world:with_margin": "to parts of its argument, which no caller returns",
}
"""Kernels whose result points to memory of whoever called them, and why that memory is still there."""


def holds_references(kind):
    return isinstance(kind, StructReference) or (
        isinstance(kind, types.BaseTuple) and any(holds_references(item) for item in kind.types)
    )


def test_results_that_hold_references_are_those_that_were_looked_at():
    found = set()
    for listed in read_listing().kernels:
        kernel, arguments = listed.load()
        kernel.compile(arguments)
        if holds_references(kernel.overloads[arguments].signature.return_type):
            found.add(listed.name)
    assert found == {*RETURN_REFERENCES}
