"""Kernels are compiled once a user: by content, whatever the folder, and never stale."""

import os
import subprocess
import sys

import numba
import numpy as np
import pytest

from plain_python import in_plain_python
from skyverse.numerics.arrays import put, put_box
from skyverse.planners.path_changes import rank_wheel

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")

CALLEE = '''
from skyverse.numerics.kernel import inner

FACTOR = 2.0

@inner
def callee(x):
    """Return twice x."""
    return FACTOR * x
'''
CALLER = """
import sys
from numba.core import event
from made_up.below import callee
from skyverse.numerics.kernel import kernel

@kernel
def caller(x):
    return callee(x) + 1.0

if __name__ == "__main__":
    from made_up.above import caller
    with event.install_recorder("numba:compile") as compiled:
        found = caller(3.0)
    kernels = {event.data["dispatcher"] for _, event in compiled.buffer}
    print(found, sum(kernel.__module__.startswith("made_up") for kernel in kernels))
"""


def answer(folder, cache, callee=CALLEE, **more):
    """Write the two modules into a folder, call the kernel in a new process, return its answer and compilations."""
    package = folder / "made_up"
    package.mkdir(parents=True, exist_ok=True)
    (package / "__init__.py").write_text("")
    (package / "below.py").write_text(callee)
    (package / "above.py").write_text(CALLER)
    environment = {**os.environ, "SKYVERSE_CACHE": str(cache), **more}
    environment["PYTHONPATH"] = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
    environment["PYTHONDONTWRITEBYTECODE"] = "1"  # an edit within a second would not be noticed
    run = subprocess.run(
        [sys.executable, "-m", "made_up.above"], capture_output=True, text=True, env=environment, check=True
    )
    number, compiled = run.stdout.split()
    return float(number), int(compiled)


def test_kernels_are_compiled_once_a_user_and_never_stale(tmp_path):
    cache = tmp_path / "cache"
    commented = CALLEE.replace('"""Return', '# A comment.\n    """Still return')
    assert answer(tmp_path / "a", cache) == (7.0, 2)
    assert answer(tmp_path / "a clone", cache, commented) == (7.0, 0)
    assert answer(tmp_path / "a", cache, CALLEE.replace("2.0", "3.0")) == (10.0, 2)
    assert answer(tmp_path / "a", cache, NUMBA_BOUNDSCHECK="1") == (7.0, 2)
    assert answer(tmp_path / "a", cache) == (7.0, 0)
    for file in (cache / "kernels").iterdir():
        file.write_bytes(file.read_bytes()[:-1])
    assert answer(tmp_path / "a", cache) == (7.0, 2)
    assert answer(tmp_path / "a", cache) == (7.0, 0)


def test_without_a_folder_kernels_are_compiled_all_the_same(tmp_path):
    (tmp_path / "file").write_text("")
    assert answer(tmp_path / "a", tmp_path / "file" / "below") == (7.0, 2)


def test_inner_kernels_can_be_called_compiled():
    expected, found = np.zeros((2, 3)), np.zeros((2, 3))
    put.py_func(expected, 1, np.arange(3.0))
    assert put.compiled(found, 1, np.arange(3.0)) is None
    np.testing.assert_array_equal(found, expected)
    assert put.compiled.signatures
    assert rank_wheel.compiled is rank_wheel


def test_kernels_run_as_plain_python_and_are_reported():
    calls = []
    boxes = np.zeros((1, 6))
    with in_plain_python(lambda kernel, arguments: calls.append((kernel, arguments))):
        put_box(boxes, 0, np.zeros(3), np.ones(3))
        rank_wheel(3, np.random.default_rng(1))
    assert [kernel for kernel, _ in calls] == [put_box, rank_wheel]
    assert "__call__" not in vars(type(rank_wheel))
    np.testing.assert_array_equal(boxes, [[0, 0, 0, 1, 1, 1]])


def test_what_is_not_chosen_runs_compiled_and_is_not_reported():
    calls = []
    with in_plain_python(lambda kernel, _: calls.append(kernel), lambda kernel: kernel is not rank_wheel):
        put_box(np.zeros((1, 6)), 0, np.zeros(3), np.ones(3))
        drawn = rank_wheel(3, np.random.default_rng(1))
    assert calls == [put_box]
    assert drawn == rank_wheel.py_func(3, np.random.default_rng(1))


AROUND = """
import sys
import numpy as np
from skyverse.numerics.kernel import inner, kernel

def made(values):
    @inner
    def callee(x):
        return values[0] * x

    @kernel
    def caller(x):
        return callee(x) + values[1]

    return caller

print(*(made(np.array([float(number), 1.0]))(3.0) for number in sys.argv[1:]))
"""


def test_kernels_that_use_other_variables_of_the_function_around_them_are_other_kernels(tmp_path):
    file = tmp_path / "around.py"
    file.write_text(AROUND)
    environment = {**os.environ, "SKYVERSE_CACHE": str(tmp_path / "cache")}
    for numbers, answers in ((["2", "5"], "7.0 16.0"), (["5", "3", "2"], "16.0 10.0 7.0")):
        command = [sys.executable, str(file), *numbers]
        run = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
        assert run.stdout.split() == answers.split()
