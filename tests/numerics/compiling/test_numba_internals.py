"""What skyverse uses of numba's interior: it is there, kernels use it, and nobody else's functions do."""

import os
import subprocess
import sys
from typing import NamedTuple

import numba
import numpy as np
import pytest
from numba.core import codegen
from numba.core.registry import cpu_target

from skyverse.numerics.compiling.references import StructReference
from skyverse.numerics.kernel import PLAIN_NUMBA, PLAIN_PYTHON, VERIFIED, by_reference, inner, kernel, query

pytestmark = pytest.mark.skipif(PLAIN_PYTHON, reason="nothing is compiled")


@by_reference
class Numbers(NamedTuple):
    factor: float
    array: np.ndarray


@by_reference
class Nested(NamedTuple):
    numbers: Numbers
    others: np.ndarray


@inner
def weigh(nested: Nested, i: int) -> float:
    return nested.numbers.factor * nested.numbers.array[i] + nested.others[i]


@kernel
def weigh_all(nested: Nested) -> float:
    total = 0.0
    for i in range(len(nested.others)):
        total += weigh(nested, i)
    return total


@kernel
def make_and_weigh(numbers: Numbers, n: int) -> float:
    return weigh(Nested(numbers, np.full(n, 0.5)), n - 1) + weigh(Nested(Numbers(3.0, np.ones(n)), np.zeros(n)), 0)


@kernel
def exchange(nested: Nested, others: np.ndarray) -> Nested:
    return Nested(nested.numbers, others)


@query
def first(numbers: Numbers) -> float:
    return numbers.array[0]


@kernel
def draw(rng: np.random.Generator) -> float:
    return rng.random() + rng.integers(0, 1000) + rng.standard_normal()


@query
def draw_without_counting(rng: np.random.Generator) -> float:
    return rng.random()


@kernel
def sum_of_ones(n: int) -> float:
    return np.ones(n).sum()


@query
def twice_the_sum_of_ones(n: int) -> float:
    return 2 * sum_of_ones(n)


def test_this_version_of_numba_is_one_that_was_tried():
    assert numba.version_info.short in VERIFIED
    assert not PLAIN_NUMBA


def test_named_tuples_are_taken_by_reference_and_references_are_counted():
    numbers = Numbers(2.0, np.arange(4.0))
    nested = Nested(numbers, np.ones(4))
    counts = [sys.getrefcount(array) for array in (numbers.array, nested.others)]
    for _ in range(50):
        assert weigh_all(nested) == weigh_all.py_func(nested) == 16.0
        assert make_and_weigh(numbers, 4) == make_and_weigh.py_func(numbers, 4) == 9.5
        assert first(numbers) == 0.0
    assert [sys.getrefcount(array) for array in (numbers.array, nested.others)] == counts
    assert len(weigh.signatures) <= 1, "one compilation serves what Python gives and what kernels make"


def test_a_kernel_returns_fields_that_it_was_given_by_reference():
    nested, others = Nested(Numbers(2.0, np.arange(4.0)), np.ones(4)), np.zeros(4)
    counts = [sys.getrefcount(array) for array in (nested.numbers.array, others)]
    for _ in range(50):
        found = exchange(nested, others)
        assert type(found) is Nested
        assert type(found.numbers) is Numbers
        assert found.numbers.factor == 2.0
        np.testing.assert_array_equal(found.numbers.array, nested.numbers.array)
        assert weigh_all(found) == 12.0
    del found
    assert [sys.getrefcount(array) for array in (nested.numbers.array, others)] == counts


@pytest.mark.parametrize("source", [np.random.PCG64, np.random.MT19937, np.random.Philox, np.random.SFC64])
def test_a_random_generator_goes_on_where_it_was_and_is_held_by_nobody_else(source):
    rng, same = (np.random.Generator(source(5)) for _ in range(2))
    counts = sys.getrefcount(rng), sys.getrefcount(rng.bit_generator)
    for _ in range(50):
        assert draw(rng) == draw.py_func(same)
        assert draw_without_counting(rng) == same.random()
        assert rng.random() == same.random()
    assert (sys.getrefcount(rng), sys.getrefcount(rng.bit_generator)) == counts


def test_a_kernel_that_a_query_calls_first_may_make_arrays():
    assert twice_the_sum_of_ones(3) == 6.0


def test_a_field_of_the_wrong_type_is_refused():
    with pytest.raises(numba.errors.TypingError):
        weigh_all(Nested(Numbers(2.0, "text"), np.ones(4)))


def test_a_type_from_before_its_namedtuple_had_a_field_is_an_error_of_numba():
    with pytest.raises(numba.errors.NumbaError):
        first.compile((StructReference(Numbers, (numba.float64,)),))


def test_numba_s_own_target_is_as_it_was():
    @numba.njit
    def twice(x):
        return 2 * x

    assert twice(2) == 4
    library = twice.overloads[twice.signatures[0]].library
    assert type(library) is codegen.JITCodeLibrary
    assert codegen.JITCPUCodegen._library_class is codegen.JITCodeLibrary
    assert type(cpu_target.target_context).__module__ == "numba.core.cpu"
    assert numba.typeof((1, 2)) == numba.types.UniTuple(numba.int64, 2)


def test_plain_numba_compiles_kernels_too(tmp_path):
    code = """
import numpy as np
from skyverse.numerics.arrays import put_box
from skyverse.numerics.compiling.references import StructReference
from skyverse.numerics.kernel import PLAIN_NUMBA
boxes = np.zeros((1, 6))
put_box(boxes, 0, np.zeros(3), np.ones(3))
print(PLAIN_NUMBA, type(put_box).__name__, boxes.sum())
"""
    environment = {**os.environ, "SKYVERSE_PLAIN_NUMBA": "1", "NUMBA_CACHE_DIR": str(tmp_path)}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["True", "CPUDispatcher", "3.0"]
