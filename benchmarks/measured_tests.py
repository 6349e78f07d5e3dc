"""What each test costs and which lines of the source it runs: ``python benchmarks/measured_tests.py``.

`first_tier.py` chooses the first tier by it, and `mutants.py` the tests that may notice an edit. Every test runs once,
under coverage.py with a context of its own: ``pip install pytest-cov``. A compiled kernel runs no line of Python; a
test that calls one counts as running all lines of it, and of the kernels that it calls in turn.
"""

import argparse
import inspect
import json
import os
import pickle
import sqlite3
import subprocess
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "src" / "skyverse"
FOLDER = ROOT / "out" / "measured-tests"
"""Where the processes in which tests run keep their notes: a coverage data file, and a line for each test."""
MEASURED = FOLDER / "measured.pickle"
PROPERTY_SHARE = 5
"""How many times more examples a property draws here than in the first tier."""

sys.path.insert(0, str(ROOT / "tests" / "support"))


@dataclass(frozen=True)
class MeasuredTests:
    """All tests: what each costs, and what it runs."""

    names: list[str]
    seconds: np.ndarray
    """(tests,) Seconds of processor time of each in the first tier, where properties draw fewer examples."""
    lines: list[tuple[str, int]]
    """Every line that any test runs, as a file's path below the source and a number."""
    runs: csr_array
    """(tests, lines) 1 where a test runs a line."""

    @cached_property
    def number(self) -> dict[tuple[str, int], int]:
        """The number of each line."""
        return {line: k for k, line in enumerate(self.lines)}


class Recorder:
    """Notes for each test what it cost and which kernels Python has called in it: a plugin of pytest."""

    def __init__(self) -> None:
        self.called: set[str] = set()
        self.file = FOLDER / f"tests-{os.getpid()}.jsonl"

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        """Take notes while a test runs."""
        from skyverse.numerics.compiling.numba_internals import Kernel

        def call(kernel, *arguments):
            self.called.add(f"{kernel.py_func.__module__}:{kernel.py_func.__qualname__}")
            return super(Kernel, kernel).__call__(*arguments)

        type.__setattr__(Kernel, "__call__", call)  # anew, since tests in plain Python take it away
        self.called.clear()
        began = sum(os.times()[:4])
        outcome = yield
        seconds = sum(os.times()[:4]) - began
        is_property = item.get_closest_marker("hypothesis") is not None
        with self.file.open("a", encoding="utf-8") as file:
            told = {"test": item.nodeid, "seconds": seconds / (PROPERTY_SHARE if is_property else 1)}
            file.write(json.dumps(told | {"kernels": sorted(self.called)}) + "\n")
        return outcome


def pytest_configure(config):
    """Let the processes in which tests run, not the one that only hands them out, take notes."""
    if hasattr(config, "workerinput"):
        config.pluginmanager.register(Recorder())


def measure(words: list[str]) -> int:
    """Run the tests that pytest finds by these words, all of them without any, and keep what was measured."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for old in FOLDER.iterdir():
        old.unlink()
    settings = FOLDER / "coveragerc"
    settings.write_text(f"[run]\nsource_pkgs = skyverse\ndata_file = {FOLDER / 'coverage'}\n", encoding="utf-8")
    options = ("-p", "measured_tests", "--all", "-n", "auto", "--dist", "worksteal")
    cover = ("--cov", "--cov-context=test", f"--cov-config={settings}", "--cov-report=")
    paths = os.pathsep.join((str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")))
    command = [sys.executable, "-m", "pytest", *options, *cover, *words]
    code = subprocess.run(command, cwd=ROOT, env=os.environ | {"PYTHONPATH": paths}, check=False).returncode
    MEASURED.write_bytes(pickle.dumps(_gathered()))
    return code


def load() -> MeasuredTests:
    """Read the last measurement."""
    if not MEASURED.exists():
        raise SystemExit("there is no measurement of the tests: python benchmarks/measured_tests.py")
    with MEASURED.open("rb") as file:
        return MeasuredTests(**pickle.load(file))


def _gathered() -> dict[str, Any]:
    """Return the fields of `MeasuredTests`, from what the processes have noted."""
    notes = [
        json.loads(line) for file in sorted(FOLDER.glob("tests-*.jsonl")) for line in file.read_text().splitlines()
    ]
    number = {note["test"]: k for k, note in enumerate(notes)}
    run: dict[tuple[str, int], set[int]] = {}
    for test, file, line in _covered():
        if test in number:
            run.setdefault((file, line), set()).add(number[test])
    reached = _reached()
    for k, note in enumerate(notes):
        for kernel in {one for called in note["kernels"] for one in reached.get(called, ())}:
            for line in _lines_of(kernel):
                run.setdefault(line, set()).add(k)
    lines = sorted(run)
    columns = np.repeat(np.arange(len(lines)), [len(run[line]) for line in lines])
    rows = np.fromiter((k for line in lines for k in run[line]), dtype=int)
    runs = csr_array((np.ones(len(rows), dtype=np.int32), (rows, columns)), shape=(len(notes), len(lines)))
    seconds = np.array([note["seconds"] for note in notes])
    return {"names": list(number), "seconds": seconds, "lines": lines, "runs": runs}


def _covered():
    """Yield each test, file and line of the coverage data; the schema is documented by coverage.py."""
    from coverage.numbits import numbits_to_nums

    database = sqlite3.connect(FOLDER / "coverage")
    query = """select context.context, file.path, line_bits.numbits from line_bits
        join context on context.id = line_bits.context_id join file on file.id = line_bits.file_id"""
    for context, path, bits in database.execute(query):
        file = path.rpartition("/src/skyverse/")[2]
        for line in numbits_to_nums(bits):
            yield context.rpartition("|")[0], file, line


def _reached() -> dict[str, list[Any]]:
    """Return by name every kernel, with the plain functions of it and of all kernels that it calls."""
    from kernel_calls import all_kernels
    from skyverse.numerics.compiling.digest import callees_of

    return {name: [one.py_func for one in callees_of(kernel).values()] for name, kernel in all_kernels().items()}


def _lines_of(function):
    """Return the lines of a function that hold code."""
    file = inspect.getsourcefile(function).rpartition("/src/skyverse/")[2]
    return {(file, line) for _, _, line in function.__code__.co_lines() if line}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("words", nargs="*", help="files or names of tests, all of them by default")
    raise SystemExit(measure(parser.parse_args().words))
