"""Types of arguments as text, and back."""

import numba
import numpy as np
import pytest
from numba.core import types

from skyverse.numerics.compiling.references import StructReference
from skyverse.numerics.compiling.signatures import text_of, type_of
from skyverse.space.tree import Tree


def read_only(array):
    array.flags.writeable = False
    return array


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1, "int64"),
        (1.0, "float64"),
        (True, "bool"),
        (np.zeros((2, 3)), "array(float64, 2d, C)"),
        (np.zeros((2, 3))[:, ::2], "array(float64, 2d, A)"),
        (np.zeros((2, 3), np.int64).T, "array(int64, 2d, F)"),
        (read_only(np.zeros(3, bool)), "readonly array(bool, 1d, C)"),
        (np.random.default_rng(1), "Generator"),
        ((1, 2.0), "Tuple(int64, float64)"),
        (
            Tree(np.zeros((1, 6)), np.zeros((1, 3), np.int64)),
            "&skyverse.space.tree:Tree(array(float64, 2d, C), array(int64, 2d, C))",
        ),
    ],
)
def test_a_type_is_read_back_from_its_text(value, text):
    kind = numba.typeof(value)
    assert text_of(kind) == text
    assert type_of(text) == kind


def test_defaults_and_named_tuples_by_value_are_read_back():
    by_value = types.NamedTuple([types.float64[:, ::1], types.int64[:, ::1]], Tree)
    for kind in (types.Omitted(0.5), types.Omitted(400), by_value, StructReference(Tree, (by_value, types.float64))):
        assert type_of(text_of(kind)) == kind


@pytest.mark.parametrize("value", ["text", np.array([("a", 1.0)], dtype="U1, f8"), [1.0]])
def test_what_kernels_do_not_take_has_no_text(value):
    with pytest.raises(TypeError, match="kernels take"):
        text_of(numba.typeof(value))


def test_a_text_that_is_no_type_is_refused(refuses):
    with refuses(ValueError):
        type_of("array(float64; 2d)")
