"""Kernels compiled side by side, from the list of those that are needed."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from skyverse.numerics.compiling.listing import read_listing
from skyverse.numerics.kernel import PLAIN_PYTHON

BENCHMARK = Path(__file__).parents[3] / "benchmarks" / "compiling.py"
SIDE_BY_SIDE = """
import sys
from skyverse.numerics.compiling import together
from skyverse.numerics.compiling.kept_code import is_kept
from skyverse.numerics.compiling.listing import Listing, read_listing

if __name__ == "__main__":
    kernels = read_listing().kernels
    few = [i for i, kernel in enumerate(kernels) if ".arrays:" in kernel.name or ".bernstein:" in kernel.name]
    wanted = sorted({*few, *(k for i in few for k in kernels[i].calls)})
    together.read_listing = lambda: Listing(kernels, {"few": tuple(wanted)})
    steps = []
    print(together.missing_kernels(["few"]) == wanted)
    together.compile_together(wanted, lambda *step: steps.append(step), workers=2)
    print(all(is_kept(*kernels[i].load()) for i in wanted), together.missing_kernels(["few"]))
    print(steps == [(k + 1, len(wanted)) for k in range(len(wanted))])
"""
needs_compiler = pytest.mark.skipif(PLAIN_PYTHON, reason="nothing is compiled")


def test_those_that_are_called_stand_before_those_that_call_them():
    listing = read_listing()
    assert len(listing.kernels) > 200
    assert all(k < i for i, kernel in enumerate(listing.kernels) for k in kernel.calls)
    assert {"mission", "MVO", "AStar", "Taut", "ThetaStar", "HybridMVO"} <= {*listing.workloads}
    for positions in listing.workloads.values():
        assert {k for i in positions for k in listing.kernels[i].calls} <= {*positions}


@needs_compiler
def test_every_kernel_of_the_list_exists():
    for listed in read_listing().kernels:
        kernel, types = listed.load()
        assert len(types) == len(kernel.py_func.__code__.co_varnames[: kernel.py_func.__code__.co_argcount])
        assert all(map(is_whole, types)), f"{listed.name}: renew the list: python benchmarks/compiling.py list"


def is_whole(kind):
    """Whether the NamedTuples of a type have a type for each of their fields."""
    inner = getattr(kind, "types", ())
    cls = getattr(kind, "instance_class", None)
    return (cls is None or len(inner) == len(cls._fields)) and all(map(is_whole, inner))


def test_a_list_is_read_back_as_it_was_written(tmp_path, monkeypatch):
    import skyverse.numerics.compiling.listing as module

    spec = importlib.util.spec_from_file_location("compiling_benchmark", BENCHMARK)
    benchmark = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(benchmark)
    listing = read_listing()
    benchmark.write_listing(listing, tmp_path / "kernels.json")
    monkeypatch.setattr(module, "FILE", tmp_path / "kernels.json")
    assert read_listing.__wrapped__() == listing


@needs_compiler
def test_two_processes_share_the_work_and_tell_how_far_it_is(tmp_path):
    (tmp_path / "work.py").write_text(SIDE_BY_SIDE)
    environment = {**os.environ, "SKYVERSE_CACHE": str(tmp_path)}
    run = subprocess.run(
        [sys.executable, tmp_path / "work.py"], env=environment, capture_output=True, text=True, check=True
    )
    assert run.stdout.split() == ["True", "True", "[]", "True"]


@needs_compiler
def test_all_that_the_golden_missions_need_is_listed():
    run = subprocess.run([sys.executable, BENCHMARK, "check"], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr


@needs_compiler
def test_no_kernel_is_called_while_modules_are_imported():
    """What is compiled before the first kernel imports modules itself, which must not be half imported by then."""
    code = "import pkgutil, importlib, skyverse\nfrom skyverse.numerics.compiling import kept_code\n"
    code += "kept_code.KeptCode.load_overload = lambda kernel, *_: print(kernel._kernel)\n"
    code += "for module in pkgutil.walk_packages(skyverse.__path__, 'skyverse.'):\n"
    code += "    module.name.endswith('__main__') or importlib.import_module(module.name)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == ""
