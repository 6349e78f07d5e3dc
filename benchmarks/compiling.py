"""What it costs to compile the kernels.

``python benchmarks/compiling.py dearest`` prints the kernels with most lines of LLVM IR and the seconds that they take;
``cold`` compiles everything from nothing, as ``skyverse cache --compile`` does, and prints seconds; ``list`` runs the
golden missions and some verbs, and writes the list of kernels that are compiled side by side
(``numerics/compiling/kernels.json``);
``check`` runs them and says what they need that is not listed, or is listed and not needed.
"""

import argparse
import importlib
import io
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import chdir, contextmanager, redirect_stdout, suppress
from pathlib import Path
from typing import Any

import llvmlite
import numba

MISSION = "fleet table-4.8, MVO"
LIST = Path(__file__).parents[1] / "src" / "skyverse" / "numerics" / "compiling" / "kernels.json"


@contextmanager
def calls_from_python(report: Callable[[Any, tuple[Any, ...]], None]) -> Iterator[None]:
    """Report each call of a compiled kernel from Python, with the types of its arguments."""
    from numba.core import types

    from skyverse.numerics.compiling.numba_internals import Kernel
    from skyverse.numerics.compiling.numba_target import Compiled

    def call(kernel: Any, *arguments: Any) -> Any:
        defaults = kernel.__defaults__ or ()
        missing = defaults[len(arguments) - kernel.__code__.co_argcount :] if defaults else ()
        answer = Compiled.__call__(kernel, *arguments)
        report(kernel, (*map(kernel.typeof_pyval, arguments), *map(types.Omitted, missing)))
        return answer

    type.__setattr__(Kernel, "__call__", call)
    try:
        yield
    finally:
        type.__delattr__(Kernel, "__call__")


def workload_of(case: str) -> str:
    """Return which workload a golden mission stands for: a planner by its class, or a kind of mission."""
    if case == MISSION:
        return "mission"
    first = case.split()[0].rstrip(",")
    if case.startswith("export as"):
        return "fleets"
    if first == "fleet":
        return case.rpartition(", ")[2] if case.endswith(("minimum-jerk", "stop-and-go")) else "fleets"
    return first


def verbs() -> dict[str, Callable[[], Any]]:
    """Return what verbs do with a mission that is there, by their names."""
    import golden
    import skyverse as sky
    from skyverse.cli import main

    mission, folder = golden.over_jacksboro(), tempfile.mkdtemp()
    at = mission.trajectory(0).at([2.0]).position[0] + 3.0
    seen = sky.Sighting(name="ball", shape=sky.Sphere(centre=(0, 0, 0), radius=1.0), position=at, top_speed=2.0)
    sky.write(mission, f"{folder}/m.json")

    def run(*words: str) -> None:
        with suppress(SystemExit), redirect_stdout(io.StringIO()), chdir(folder):
            main(words)

    return {
        "export": lambda: run("export", "m.json", "m.plan", "--altitude", "home"),
        "check": lambda: run("check", "m-uav-1.plan"),
        "repair": lambda: run("repair", "m-uav-1.plan", "-o", "fixed.plan"),
        "fly": lambda: run("fly", "m.json", "--runs", "2"),
        "live": lambda: sky.Replanner(mission).observe(1.0, movers=[seen]),
    }


def record(cases: dict[str, Callable[[], Any]]) -> dict[str, set[tuple[str, Any]]]:
    """Run golden missions and verbs, and return the kernels that each workload calls, and those that they call."""
    from skyverse.numerics.compiling.digest import callees_of, name_of

    needed: dict[str, set[tuple[str, Any]]] = defaultdict(set)
    kernels: dict[str, Any] = {}

    def add(workload: str, name: str, types: Any) -> None:
        if (name, types) not in needed[workload]:
            needed[workload].add((name, types))
            kernels[name].compile(types)
            for callee in kernels[name].overloads[types].library.callees:
                add(workload, *callee)

    for case, work in cases.items():
        called: set[tuple[str, Any]] = set()

        def report(kernel: Any, types: Any, called: set[tuple[str, Any]] = called) -> None:
            kernels.update(callees_of(kernel))
            called.update(
                (name_of(kernel), known) for known in ([types] if types in kernel.overloads else kernel.overloads)
            )

        with calls_from_python(report):
            work()
        for name, types in called:
            add(workload_of(case), name, types)
        print(f"{case}: {len(called)} kernels called", flush=True)
    return needed


def listing() -> Any:
    """Return the list of kernels that golden missions and verbs need."""
    import golden
    from skyverse.numerics.compiling.listing import ListedKernel, Listing
    from skyverse.numerics.compiling.signatures import text_of

    needed = record(golden.cases() | verbs())
    order: dict[tuple[str, Any], int] = {}
    rows: list[ListedKernel] = []

    def visit(name: str, types: Any) -> int:
        if (name, types) not in order:
            module, _, function = name.partition(":")
            library = getattr(importlib.import_module(module), function).overloads[types].library
            calls = sorted({visit(*callee) for callee in library.callees})
            order[name, types] = len(rows)
            rows.append(ListedKernel(name, tuple(map(text_of, types)), tuple(calls), library.ir_lines))
        return order[name, types]

    everything = {key for keys in needed.values() for key in keys}
    for key in sorted(everything, key=lambda key: (key[0], str(key[1]))):
        visit(*key)
    workloads = {name: tuple(sorted(order[key] for key in needed[name])) for name in sorted(needed)}
    return Listing(tuple(rows), workloads)


def write_listing(listing: Any, file: Path = LIST) -> None:
    """Write a list, one kernel a line."""
    types = sorted({text for kernel in listing.kernels for text in kernel.types}, key=lambda text: (len(text), text))
    at = {text: i for i, text in enumerate(types)}
    rows = [
        {"kernel": k.name, "types": [at[t] for t in k.types], "calls": list(k.calls), "ir_lines": k.ir_lines}
        for k in listing.kernels
    ]
    parts = [
        f' "{name}": {opening}\n  ' + ",\n  ".join(lines) + f"\n {closing}"
        for name, lines, opening, closing in (
            ("types", [json.dumps(text) for text in types], "[", "]"),
            ("kernels", [json.dumps(row) for row in rows], "[", "]"),
            ("workloads", [f"{json.dumps(k)}: {json.dumps(list(v))}" for k, v in listing.workloads.items()], "{", "}"),
        )
    ]
    file.write_text("{\n" + ",\n".join(parts) + "\n}\n", encoding="utf-8")


def check() -> int:
    """Return 1 if the list is not that of the golden missions."""
    from skyverse.numerics.compiling.listing import read_listing

    needed, listed = (
        {workload: {kernels[i][:2] for i in positions} for workload, positions in workloads.items()}
        for kernels, workloads in (listing(), read_listing())
    )
    different = [
        f"{workload} needs {name}({', '.join(types)})"
        if (name, types) in needed.get(workload, ())
        else f"{workload} does not need {name}({', '.join(types)})"
        for workload in sorted({*needed, *listed})
        for name, types in sorted(needed.get(workload, set()) ^ listed.get(workload, set()))
    ]
    for line in different:
        print(line, file=sys.stderr)
    if different:
        print("the list of kernels is old; renew it: python benchmarks/compiling.py list", file=sys.stderr)
    return 1 if different else 0


def cold(workloads: list[str]) -> None:
    """Compile from nothing, in as many processes as there are cores, and print what that takes."""
    from skyverse.numerics.cores import cores

    with tempfile.TemporaryDirectory() as folder:
        code = "from skyverse.numerics.compiling.together import *; "
        code += f"missing = missing_kernels({workloads}); compile_together(missing); print(len(missing))"
        began = time.perf_counter()
        environment = {**os.environ, "SKYVERSE_CACHE": folder}
        done = subprocess.run([sys.executable, "-c", code], env=environment, check=True, capture_output=True, text=True)
        wall = time.perf_counter() - began
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = used.ru_utime + used.ru_stime
    print(
        f"{done.stdout.strip()} kernels ({', '.join(workloads)}): {wall:.1f} s, {cpu:.1f} s of CPU, {cores()} processes"
    )


def dearest(count: int) -> None:
    """Compile all listed kernels in this process, and print those with most lines of IR."""
    from skyverse.numerics.compiling.listing import read_listing

    rows = []
    with tempfile.TemporaryDirectory() as folder:
        os.environ["SKYVERSE_CACHE"] = folder
        for listed in read_listing().kernels:
            kernel, types = listed.load()
            began = time.process_time()
            kernel.compile(types)
            spent = time.process_time() - began
            rows.append((kernel.overloads[types].library.ir_lines, spent, listed.name))
    print(f"numba {numba.__version__}, llvmlite {llvmlite.__version__}, Python {sys.version.split()[0]}")
    print("| IR lines | CPU s | kernel |\n|---|---|---|")
    for lines, seconds, name in sorted(rows, reverse=True)[:count]:
        print(f"| {lines} | {seconds:.2f} | `{name}` |")
    print(f"| {sum(row[0] for row in rows)} | {sum(row[1] for row in rows):.1f} | all {len(rows)} |")


def main() -> int:
    """Run one of the verbs."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("verb", choices=["dearest", "cold", "list", "check"])
    parser.add_argument("workloads", nargs="*", default=["all"], help="for cold: as in mission MVO; all by default")
    parser.add_argument("-n", type=int, default=30, help="how many of the dearest")
    options = parser.parse_args()
    if options.verb == "dearest":
        dearest(options.n)
    elif options.verb == "cold":
        cold(options.workloads)
    elif options.verb == "check":
        return check()
    else:
        write_listing(listing())
    return 0


if __name__ == "__main__":
    sys.exit(main())
