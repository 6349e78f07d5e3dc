"""NamedTuples that kernels take by reference: no reference outlives the memory that it points to."""

import os
import subprocess
import sys

import pytest
from numba.core import types

from skyverse.numerics.compiling.listing import read_listing
from skyverse.numerics.compiling.references import StructReference
from skyverse.numerics.kernel import PLAIN_NUMBA, PLAIN_PYTHON

pytestmark = pytest.mark.skipif(PLAIN_PYTHON or PLAIN_NUMBA, reason="nothing is taken by reference")

RETURN_REFERENCES = {
    "skyverse.search.taut.shorten_window:local_space": "to parts of its argument, which its caller does not return",
    "skyverse.space.obstacles:with_margin": "to parts of its argument, which no caller returns",
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


WIDEN = """
import numpy as np
import skyverse as sky
from skyverse.space.obstacles import with_margin
from skyverse.space.world import World

scenario = sky.Scenario(
    name="a box and a sphere",
    bounds=sky.Bounds(min=(0, 0, 0), max=(10, 10, 5)),
    obstacles=(sky.Box(min=(4, 0, 0), max=(5, 5, 5)), sky.Sphere(centre=(7, 7, 2), radius=1)),
    clearance=0.1,
    lattice=sky.Lattice(step=(1, 1, 1)),
)
space = World(scenario).space
kept = []
for i in range(20_000):
    widened = with_margin(space, 0.1)
    kept.append(bytes(40 + i % 60))
    if i % 50 == 0:
        kept.append(bytes(3000))
        kept = kept[-2000:]
        others = np.zeros(200_000)
"""


def test_a_space_returned_to_python_leaves_memory_alone_that_is_free():
    # the C library's allocator, which is asked between the calls, ends the process where free memory was written to
    done = subprocess.run(
        [sys.executable, "-c", WIDEN], env={**os.environ, "PYTHONMALLOC": "malloc"}, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
