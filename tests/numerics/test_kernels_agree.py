"""Each kernel, compiled, does what its plain Python does: the same numbers, the same branches, the same random draws.

The calls are those that planning in small random worlds makes. A kernel that only kernels call runs within those that
Python calls; to be called alone, too, it is compiled anew, which takes minutes for all of them.
CI runs this file again with numba's bounds checks on.
"""

import copy
import inspect
import warnings
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numba import config

from kernel_calls import all_kernels, record
from kernel_workloads import WORKLOADS
from plain_python import in_plain_python

pytestmark = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")

KERNELS = all_kernels()
ULPS = 4
MARKS = (77, 0)
"""What memory that is not set holds in two runs in plain Python."""

NEVER_CALLED: dict[str, str] = {}
"""Kernels that no workload calls, and why."""

DIFFERENT = {
    "skyverse.numerics.arrays:order_of": "its sort is not stable: numba and numpy put equal keys in different orders",
    "skyverse.space.tree:build": "boxes whose centres are equal come in the order that the sort puts them in",
    "skyverse.search.taut.shorten_window:local_space": "its boxes come in the order in which `build` puts them",
    "skyverse.space.edges:make_edges": "its edges come in the order in which `build` puts them",
    "skyverse.search.cheapest.bend_points:bend_points": "equally near ones come in the order of the sort",
    "skyverse.search.cheapest.cheapest_path:cheapest_path": "it begins with what `bend_points` returns",
    "skyverse.search.cheapest.cheapest_path:_try_ways": "equally cheap ones come in the order of the sort",
    "skyverse.survey.cells:turned": "edges that begin at the same offset come in the order of the sort",
    "skyverse.live.steered_motion:steered_motion": "bisections and corrections of its aim enlarge the rounding of sums",
    "skyverse.live.aeroplane_course:flown_leg": "a coordinate near 0 is what rounding leaves of a difference of sums",
    "skyverse.deconfliction.curve_store:grow_tree": "parts whose middles are equal come in the order of the sort",
    "skyverse.trajectory.interior_point:objective": "numpy and numba add the terms of long sums in different orders",
    "skyverse.trajectory.interior_point:improve": "many Newton steps enlarge the rounding of sums and products",
}
"""Kernels that are called, but whose outcomes are not compared, and why; other tests judge what they return."""


@st.composite
def ramps(draw):
    """Seconds since the beginning of a ramp that lasts as long at least, its speed, and how long it rises and holds."""
    peak, rise = draw(st.floats(0.01, 20.0)), draw(st.floats(0.01, 5.0))
    hold = draw(st.just(0.0) | st.floats(0.0, 5.0))
    return draw(st.floats(0.0, 1.0)) * (2.0 * rise + hold), peak, rise, hold


DOMAINS = {"skyverse.deconfliction.space_time.leg_profiles:_ramp_way": ramps()}
"""What kernels of numbers are tried with that lose digits outside their domain."""

NUMBERS = [
    name
    for name, kernel in KERNELS.items()
    if all(kind is float for kind in inspect.get_annotations(kernel.py_func, eval_str=True).values())
]
"""The kernels of which all arguments, and the result, are floats: these can be drawn from the signature alone."""


@pytest.fixture(scope="module")
def calls():
    return record(WORKLOADS)


@contextmanager
def memory_holding(mark):
    """Let `np.empty` of plain Python return arrays full of a mark, instead of what memory happens to hold."""
    before = np.empty

    def empty(shape, dtype=float):
        return np.full(shape, mark, dtype=dtype)

    np.empty = empty
    try:
        yield
    finally:
        np.empty = before


def disagreement(plain, again, compiled):
    """Return the first values that differ, by more than 4 ulp where they are floats; None if none do.

    `again` is from another run in plain Python, with other marks in memory that is not set: only those may differ.
    """
    if isinstance(plain, tuple):
        triples = zip(plain, again, compiled, strict=True)
        return next((found for triple in triples if (found := disagreement(*triple)) is not None), None)
    if isinstance(plain, np.random.Generator):
        plain, again, compiled = (str(rng.bit_generator.state) for rng in (plain, again, compiled))
    if plain is None or isinstance(plain, str):
        return None if plain == again == compiled else (plain, again, compiled)
    a, b, c = np.asarray(plain), np.asarray(again), np.asarray(compiled)
    if not a.shape == b.shape == c.shape:
        return plain, again, compiled
    numbers = (a == b) | ((a != a) & (b != b))
    unset = ~numbers & (a == a.dtype.type(MARKS[0])) & (b == a.dtype.type(MARKS[1]))
    same = (a == c) | ((a != a) & (c != c))
    if np.issubdtype(a.dtype, np.floating):
        with np.errstate(invalid="ignore"):
            same |= np.abs(a - c) <= ULPS * np.spacing(np.maximum(np.abs(a), np.abs(c)))
    wrong = ~unset & ~(numbers & same)
    return (a[wrong], b[wrong], c[wrong]) if wrong.any() else None


def outcome(call, arguments):
    """Return what a kernel returns for a copy of these arguments, and the copy, which it may have written to."""
    own = copy.deepcopy(arguments)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return call(*own), own


def outcomes(kernel, arguments):
    """Return the outcomes of a kernel's plain Python, for each of the marks, and of the compiled kernel."""
    for mark in MARKS:
        with in_plain_python(), memory_holding(mark):
            yield outcome(kernel.py_func, arguments)
    yield outcome(kernel.compiled, arguments)


def test_every_kernel_is_called_by_a_workload(calls):
    assert set(KERNELS) - set(calls) == set(NEVER_CALLED)
    assert set(DIFFERENT) <= set(KERNELS)


@pytest.mark.parametrize("name", sorted(KERNELS))
def test_a_compiled_kernel_does_what_its_plain_python_does(name, calls):
    for arguments in calls.get(name, ()):
        found = tuple(outcomes(KERNELS[name], arguments))
        assert name in DIFFERENT or disagreement(*found) is None


@pytest.mark.parametrize("name", NUMBERS)
@given(data=st.data())
def test_a_kernel_of_numbers_does_so_for_any_numbers(name, data):
    some = st.one_of(st.integers(-4, 4).map(float), st.floats(-1e3, 1e3, allow_subnormal=False))
    count = len(inspect.signature(KERNELS[name].py_func).parameters)
    arguments = data.draw(DOMAINS.get(name, st.tuples(*[some] * count)))
    try:
        found = tuple(outcomes(KERNELS[name], arguments))
    except (ArithmeticError, ValueError):  # outside its domain, where only plain Python complains
        assume(False)
    assert disagreement(*found) is None


def test_a_disagreement_is_noticed():
    def found(plain, compiled):
        return disagreement(plain, plain, compiled)

    after = np.nextafter(1.0, 2.0)
    assert found((1.0, 2), (after, 2)) is None
    assert found((1.0, 2), (1.0 + 9 * (after - 1.0), 2)) is not None
    assert found((1, np.zeros(2)), (1, np.array([0.0, 1e-300]))) is not None
    assert found(np.array([1, np.nan]), np.array([1, np.nan])) is None
    assert found(np.array([1, 2]), np.array([1, 3])) is not None
    rng, other = np.random.default_rng(1), np.random.default_rng(1)
    assert found(rng, other) is None
    other.random()
    assert found(rng, other) is not None


def test_memory_that_is_not_set_is_not_compared_but_nothing_may_depend_on_it():
    first, second = (np.array([1.0, mark]) for mark in MARKS)
    assert disagreement(first, second, np.array([1.0, 5.0])) is None
    assert disagreement(first + 1.0, second + 1.0, np.array([2.0, 6.0])) is not None
