"""The tests are judged: ``python benchmarks/mutants.py 300`` edits the source at random, and runs the tests.

Each mutant is one edit of a file of ``src/skyverse``: a comparison turned, a sign changed, a minimum in place of a
maximum, `and` in place of `or`, another constant. It is noticed if a test fails, or takes too long. A mutant is given
only tests that run the edited statement, as `measured_tests.py` has noted, the quickest first: those of the first tier,
with as few examples as it draws, and if these do not notice it, all, with all examples. Edits are made in a copy of the
source, and each mutant runs in a process of its own, forked from one that has imported what skyverse needs.

The answers are kept in a file, line by line, so that a run that was stopped goes on where it ended, and an edit of a
file that has not changed is not judged again. ``--share 0/2`` and ``--share 1/2`` are two halves, for two processes.
"""

import argparse
import ast
import hashlib
import importlib
import json
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import Phase, settings
from measured_tests import ROOT, SOURCE, MeasuredTests, load

from tiers import second_tier

TIME_LIMIT, TIMES_LONGER = 5, 5
"""Seconds of computing time, beyond so many times what the test takes without any edit: a test that takes longer counts
as failed, since a mutant may loop for ever."""
PATIENCE_S = 300
"""Seconds that all tests of one mutant may take beyond that, to compile kernels."""
MAX_SECONDS = 120
"""Seconds of computing time, without any edit, of the tests that a mutant is given in each tier, the quickest first."""
MEMORY_LIMIT = 6 * 2**30
"""Bytes that a process may allocate, since a mutant may fill the memory."""
OPTIONS = ("-x", "-q", "-p", "no:cacheprovider", "-n0", "-W", "ignore::pytest.PytestAssertRewriteWarning")
"""Options of pytest; the warning is that hypothesis is imported already."""
WITHOUT_EFFECT = ("_AT_ONCE", "INTERVALS", "SAMPLES", "MAX_", "CHILDREN", "SHORT_")
"""Parts of the names of constants that bound memory and effort, or say how finely is searched: no answer depends on
them."""

TURNED = {
    ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.GtE, ast.GtE: ast.LtE, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.And: ast.Or, ast.Or: ast.And, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
}  # fmt: skip
"""What each operator is exchanged for."""
EXCHANGED = {
    "min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum", "argmin": "argmax", "argmax": "argmin",
    "any": "all", "all": "any", "floor": "ceil", "ceil": "floor", "cos": "sin", "sin": "cos",
}  # fmt: skip
"""What each name is exchanged for, where it is called."""


def edits(tree: ast.Module) -> Iterator[tuple[ast.AST, str, object]]:
    """Yield all single edits of a module, each as a node, the field that changes, and its new value."""
    for node in _judging(tree):
        if isinstance(node, ast.Compare):
            for k, op in enumerate(node.ops):
                yield node, "ops", [*node.ops[:k], TURNED[type(op)](), *node.ops[k + 1 :]]
        elif isinstance(node, ast.BinOp | ast.BoolOp | ast.AugAssign) and type(node.op) in TURNED:
            yield node, "op", TURNED[type(node.op)]()
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            yield node, "op", ast.UAdd()
        elif isinstance(node, ast.Attribute) and node.attr in EXCHANGED:
            yield node, "attr", EXCHANGED[node.attr]
        elif isinstance(node, ast.Name) and node.id in EXCHANGED:
            yield node, "id", EXCHANGED[node.id]
        elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
            yield node, "value", not node.value
        elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
            yield node, "value", node.value + 1 if isinstance(node.value, int) else node.value * 10 + (not node.value)


def _judging(node: ast.AST) -> Iterator[ast.AST]:
    """Yield all nodes but those of annotations, messages, imports, and constants that change no verdict."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "type_params"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST) or isinstance(child, ast.JoinedStr | ast.Import | ast.ImportFrom):
                continue
            if isinstance(child, ast.Assign) and any(part in ast.unparse(child.targets[0]) for part in WITHOUT_EFFECT):
                continue
            if isinstance(child, ast.Subscript) and ast.unparse(child.value) in ("tuple", "list", "dict", "Callable"):
                continue
            if isinstance(child, ast.keyword) and child.arg == "strict" and ast.unparse(node).startswith("zip("):
                continue  # it only guards against mistakes
            yield child
            yield from _judging(child)


class _Watch:
    """Has pytest run some tests only, the quickest first, and notes the first that fails."""

    def __init__(self, seconds: dict[str, float]) -> None:
        self.seconds, self.noticed_by = seconds, ""

    @pytest.hookimpl(trylast=True)
    def pytest_configure(self):
        # a failing example need not be made simpler
        settings.register_profile("mutants", settings(), phases=(Phase.explicit, Phase.generate))
        settings.load_profile("mutants")

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items):
        items[:] = sorted(
            (item for item in items if item.nodeid in self.seconds), key=lambda item: self.seconds[item.nodeid]
        )

    def pytest_runtest_logstart(self, nodeid):
        signal.setitimer(signal.ITIMER_PROF, TIME_LIMIT + TIMES_LONGER * self.seconds.get(nodeid, 0.0))

    def pytest_runtest_logreport(self, report):
        if report.failed:
            self.noticed_by = self.noticed_by or report.nodeid

    def pytest_collectreport(self, report):
        if report.failed:
            self.noticed_by = self.noticed_by or report.nodeid


def _too_long(number, frame):
    raise TimeoutError("the time limit of a test")


def noticed_by(seconds: dict[str, float], source: Path, *, whole: bool) -> str:
    """Run tests over a copy of the source, in a forked process; return which noticed something, nothing if none did."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.setpgrp()
        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY_LIMIT, MEMORY_LIMIT))
        signal.signal(signal.SIGPROF, _too_long)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        sys.path.insert(0, str(source))
        os.environ["PYTHONPATH"] = str(source)
        watch, said = _Watch(seconds), "the process ended"
        try:
            files = sorted({str(ROOT / name.partition("::")[0]) for name in seconds})
            code = int(pytest.main([*OPTIONS, *(["--all"] if whole else []), *files], plugins=[watch]))
            said = watch.noticed_by or ("" if code in (0, pytest.ExitCode.NO_TESTS_COLLECTED) else f"exit code {code}")
        finally:
            os.write(writing, f"{said}\n".encode())
            os._exit(0)
    os.close(writing)
    end = time.monotonic() + PATIENCE_S + TIMES_LONGER * sum(seconds.values())
    while os.waitpid(child, os.WNOHANG)[0] == 0:
        if time.monotonic() > end:
            os.killpg(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return "it took too long"
        time.sleep(0.02)
    with os.fdopen(reading) as pipe:
        return (pipe.read() or "the process ended").strip()


def _preload() -> None:
    """Import what skyverse and its tests need, so that forked processes need not."""
    for name in ("hypothesis.extra.numpy", "matplotlib.pyplot", "numba", "plotly.graph_objects", "pydantic", "shapely"):
        importlib.import_module(name)
    assert not [name for name in sys.modules if name.startswith("skyverse")]


def edited(text: str, k: int) -> tuple[str, range, str]:
    """Return a module's text with its k-th edit, the lines of its statement, and the edit as a person reads it."""
    tree = ast.parse(text)
    node, field, value = next(edit for j, edit in enumerate(edits(tree)) if j == k)
    lines, before = _lines_of_statement(tree, node), ast.unparse(node)
    setattr(node, field, value)
    after = ast.unparse(node)
    rows = text.encode().splitlines(keepends=True)
    begin = sum(map(len, rows[: node.lineno - 1])) + node.col_offset
    end = sum(map(len, rows[: node.end_lineno - 1])) + node.end_col_offset
    inserted = after if isinstance(node, ast.stmt) else f"({after})"
    changed = text.encode()[:begin] + inserted.encode() + text.encode()[end:]
    return changed.decode(), lines, f"{node.lineno}: {before}  ->  {after}"


def _lines_of_statement(tree: ast.Module, node: ast.AST) -> range:
    """Return the lines of the smallest statement that holds a node; of one that holds others, only its head."""
    statement = [
        one for one in ast.walk(tree) if isinstance(one, ast.stmt) and any(part is node for part in ast.walk(one))
    ][-1]
    last = statement.body[0].lineno - 1 if hasattr(statement, "body") else statement.end_lineno
    return range(statement.lineno, max(statement.lineno, last) + 1)


def judged(tests: MeasuredTests, file: str, k: int, source: Path) -> dict[str, str]:
    """Return which tests notice one edit: of the first tier, and of all."""
    place = source / "skyverse" / file
    text = place.read_text(encoding="utf-8")
    changed, lines, diff = edited(text, k)
    columns = [tests.number[file, line] for line in lines if (file, line) in tests.number]
    if not columns:  # it is run by imports alone: whoever runs anything of the file depends on it
        columns = [column for (name, _), column in tests.number.items() if name == file]
    wanted = np.flatnonzero(np.asarray(tests.runs[:, columns].sum(axis=1)).ravel())
    wanted = wanted[np.argsort(tests.seconds[wanted], kind="stable")]
    second = set(second_tier())
    answer = {"diff": f"{file}:{diff}", "first": "", "all": ""}
    place.write_text(changed, encoding="utf-8")
    try:
        for tier, whole in (("first", False), ("all", True)):
            given = [t for t in wanted if whole or tests.names[t] not in second]
            given = [t for t, spent in zip(given, np.cumsum(tests.seconds[given]), strict=True) if spent <= MAX_SECONDS]
            seconds = {tests.names[t]: float(tests.seconds[t]) for t in given}
            answer[tier] = answer["first"] or (noticed_by(seconds, source, whole=whole) if seconds else "")
    finally:
        place.write_text(text, encoding="utf-8")
    return answer


def main() -> None:
    """Judge as many mutants as are asked for, and print those that no test noticed."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("count", type=int, nargs="?", default=300, help="mutants, 300 by default")
    parser.add_argument("--room", default="", help="only edits of this room, such as referee")
    parser.add_argument("--seed", type=int, default=0, help="of the choice of edits")
    parser.add_argument("--share", default="0/1", help="which of how many shares of the mutants")
    parser.add_argument("--log", type=Path, default=ROOT / "out" / "mutants.jsonl", help="where answers are kept")
    given = parser.parse_args()
    tests = load()
    os.chdir(ROOT)
    _preload()
    texts = {
        str(file.relative_to(SOURCE)): file.read_text(encoding="utf-8")
        for file in sorted((SOURCE / given.room).rglob("*.py"))
    }
    sites = [(file, k) for file, text in texts.items() for k, _ in enumerate(edits(ast.parse(text)))]
    # an edit is chosen or not whatever other files hold, so that answers can be used again when one file has changed
    chosen = sorted(sites, key=lambda site: _digest(f"{given.seed} {site[0]} {site[1]}"))[: given.count]
    share, shares = map(int, given.share.split("/"))
    print(f"{len(chosen)} of {len(sites)} single edits of {len(texts)} files", flush=True)
    given.log.parent.mkdir(parents=True, exist_ok=True)
    keys = [_digest(f"{file}{k}{texts[file]}") for file, k in chosen]
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "src", folder, dirs_exist_ok=True)
        for key, (file, k) in list(zip(keys, chosen, strict=True))[share::shares]:
            if key not in _known(given.log):
                answer = judged(tests, file, k, Path(folder)) | {"key": key}
                with given.log.open("a", encoding="utf-8") as log:
                    log.write(json.dumps(answer) + "\n")
                print(f"first: {answer['first'] or '-'}; all: {answer['all'] or '-'}; {answer['diff']}", flush=True)
    answers = [answer for key, answer in _known(given.log).items() if key in set(keys)]
    for answer in answers:
        if not answer["first"]:
            print(f"not noticed by {'the first tier' if answer['all'] else 'any test'}: {answer['diff']}")
    noticed, first = (sum(bool(answer[tier]) for answer in answers) for tier in ("all", "first"))
    print(f"{noticed} of {len(answers)} noticed; by the first tier {first}, {first / max(noticed, 1):.1%} of these")


def _known(log: Path) -> dict[str, dict[str, str]]:
    """Return the answers in a file."""
    lines = log.read_text(encoding="utf-8").splitlines() if log.exists() else []
    return {answer["key"]: answer for answer in map(json.loads, lines)}


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:24]


if __name__ == "__main__":
    main()
