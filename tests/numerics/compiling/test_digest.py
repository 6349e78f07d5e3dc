"""What makes a kernel be compiled again, and what does not."""

import importlib
import subprocess
import sys
import types

import numpy as np
import pytest

from kernel_calls import all_kernels
from skyverse.numerics.compiling.digest import digest_now, digest_of

OURS = """
import importlib, pkgutil, skyverse
from skyverse.numerics.compiling.digest import digest_of
kernels = {}
for module in pkgutil.walk_packages(skyverse.__path__, "skyverse."):
    if not module.name.endswith("__main__"):
        for value in vars(importlib.import_module(module.name)).values():
            if hasattr(value, "py_func") and value.__module__ == module.name:
                kernels[f"{value.__module__}:{value.__qualname__}"] = digest_of(value)
print(kernels)
"""

SOURCE = '''
"""A module."""
from typing import NamedTuple
import math
import numpy as np



FACTOR = 2.0
TABLE = np.arange(3.0)

class Pair(NamedTuple):
    a: float
    b: float

def callee(x):
    """Doc."""
    return FACTOR * x + TABLE[0]

def caller(x):
    """Doc."""
    pair = Pair(callee(x), math.sqrt(x))
    return pair.a + pair.b + 1.5
'''


class Stub:
    """What the digest sees of a kernel."""

    def __init__(self, function, **options):
        self.py_func, self.targetoptions = function, options
        self.__module__, self.__qualname__ = function.__module__, function.__qualname__


def digests(source, **options):
    module = types.ModuleType("skyverse.made_up")
    exec(compile(source, "made_up.py", "exec"), vars(module))
    module.callee = Stub(module.callee, **options)
    module.caller = Stub(module.caller)
    return digest_of(module.callee), digest_of(module.caller)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"""Doc."""', '"""Another text,\nof two lines."""'),
        ("FACTOR = 2.0", "# a comment\n\nFACTOR = 4.0 / 2.0  # the same"),
        ("def caller(x):", "def unrelated(x):\n    return x\n\ndef caller(x):"),
    ],
)
def test_comments_docstrings_and_moved_lines_change_no_digest(old, new):
    assert digests(SOURCE.replace(old, new)) == digests(SOURCE)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("FACTOR = 2.0", "FACTOR = 2"),
        ("FACTOR = 2.0", "FACTOR = 2.0000000000000004"),
        ("np.arange(3.0)", "np.arange(1.0, 4.0)"),
        ("FACTOR * x", "FACTOR - x"),
    ],
)
def test_a_changed_callee_changes_its_caller_s_digest(old, new):
    assert not {*digests(SOURCE.replace(old, new))} & {*digests(SOURCE)}


@pytest.mark.parametrize(("old", "new"), [("    b: float", "    c: float"), ("1.5", "1.25"), ("math.sqrt", "math.sin")])
def test_a_changed_caller_leaves_its_callee_s_digest_alone(old, new):
    callee, caller = digests(SOURCE.replace(old, new).replace("pair.b", "pair[1]"))
    before = digests(SOURCE.replace("pair.b", "pair[1]"))
    assert callee == before[0]
    assert caller != before[1]


def test_the_decorator_s_options_change_the_digest():
    assert not {*digests(SOURCE, nogil=True)} & {*digests(SOURCE)}


def test_kernels_that_call_each_other_have_digests():
    recursive = SOURCE.replace("TABLE[0]", "caller(x)")
    assert digests(recursive) == digests(recursive)
    assert not {*digests(recursive)} & {*digests(recursive.replace("1.5", "1.25"))}


def test_a_constant_that_is_set_later_is_noticed():
    module = types.ModuleType("skyverse.made_up")
    exec(SOURCE, vars(module))
    kernel = Stub(module.callee)
    before = digest_of(kernel)
    assert digest_now(kernel) == before
    module.FACTOR = 3.0
    assert digest_of(kernel) == before
    assert digest_now(kernel) != before


def test_what_a_kernel_takes_from_the_function_around_it_changes_its_digest():
    def of(number, values):
        def callee(x):
            return values[0] * x

        stub = Stub(callee)

        def caller(x):
            return stub(x) + number

        return digest_of(stub), digest_of(Stub(caller))

    one, other = of(1.0, np.arange(3.0)), of(1.0, np.arange(1.0, 4.0))
    assert of(1.0, np.arange(3.0)) == one
    assert not {*other} & {*one}
    assert of(2.0, np.arange(3.0))[0] == one[0]
    assert of(2.0, np.arange(3.0))[1] != one[1]


def test_what_has_no_content_that_can_be_told_is_refused():
    module = types.ModuleType("skyverse.made_up")
    exec(SOURCE, vars(module))
    module.TABLE = [0.0]
    with pytest.raises(TypeError, match="TABLE is a list"):
        digest_of(Stub(module.callee))


@pytest.mark.skipif(not hasattr(importlib.import_module("skyverse.cost").fuel, "py_func"), reason="nothing is compiled")
def test_every_kernel_has_a_digest_of_its_own_that_is_the_same_in_each_process():
    kernels = {name: digest_of(kernel) for name, kernel in all_kernels().items()}
    run = subprocess.run([sys.executable, "-c", OURS], capture_output=True, text=True, check=True)
    assert eval(run.stdout) == kernels
    assert len({*kernels.values()}) == len(kernels) > 300
