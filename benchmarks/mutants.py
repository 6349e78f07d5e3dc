"""The judge's tests are judged: ``python benchmarks/mutants.py 300`` edits the referee at random and runs its tests.

Each mutant is one edit of a file of ``src/skyverse/referee``: a comparison turned, a sign changed, a minimum in place
of a maximum, `and` in place of `or`, another constant. It is noticed if a test of ``tests/referee`` fails, or takes too
long. Every mutant runs in a process of its own, forked from one that has imported everything but the referee; no file
is changed. Those that are not noticed are printed with the line before and after.

At first the tests run without any edit, and must pass; how long each of them takes, and which lines of the referee it
runs, is noted then. A mutant is given only tests that run the edited statement: the quick ones of its own file first,
then all other quick ones. When all mutants have had these, those that were not noticed are given the slow tests too.

The answers are kept in a file, line by line, so that a run that was stopped goes on where it ended. An edit that a test
has noticed counts as noticed as long as neither the edited file nor that test changes; one that was not noticed is
tried again as soon as any test has changed.
"""

import argparse
import ast
import hashlib
import importlib.abc
import importlib.util
import json
import os
import resource
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import Phase, settings

ROOT = Path(__file__).resolve().parent.parent
REFEREE, TESTS = ROOT / "src" / "skyverse" / "referee", ROOT / "tests" / "referee"
FOLDER = str(REFEREE)
MAX_QUICK_SECONDS = 0.3
"""Seconds of computing time: tests that take longer without any edit are slow."""
TIME_LIMIT, TIMES_LONGER = 5, 5
"""Seconds of computing time, beyond so many times what the test takes without any edit: a test that takes longer counts
as failed, since a mutant may loop for ever."""
MEMORY_LIMIT = 3 * 2**30
"""Bytes that a process may allocate, for the same reason."""
MAX_EVENTS = 200
"""Calls and lines of one function in one test: after these, all of its lines count as run by the test."""
IMPORTED = ""
"""Stands for a test, among those that run a line: it is run when tests are collected, so that all depend on it."""
OPTIONS = ("-x", "-q", "-p", "no:cacheprovider", "-n0", "-W", "ignore::pytest.PytestAssertRewriteWarning")
"""Options of pytest; the warning is that hypothesis is imported already."""
WITHOUT_EFFECT = ("_AT_ONCE", "INTERVALS", "SAMPLES", "MAX_", "CHILDREN", "SHORT_")
"""Parts of the names of constants that bound memory and effort, or say how finely is searched: no verdict depends on
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


class _Mutated(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Imports one module from a syntax tree."""

    def __init__(self, module: str, file: Path, tree: ast.Module) -> None:
        self.module, self.file, self.tree = module, file, tree

    def find_spec(self, name, path, target=None):
        if name == self.module:
            return importlib.util.spec_from_loader(name, self, origin=str(self.file))
        return None

    def exec_module(self, module):
        module.__file__ = str(self.file)
        exec(compile(self.tree, str(self.file), "exec"), module.__dict__)


class _Watch:
    """Has pytest run some tests only, the quickest first, and notes what they say and how long they take.

    If nothing is known yet of how long they take, it also notes which lines of the referee each of them runs.
    """

    def __init__(self, wanted: Callable[[str], bool], known: dict[str, float]) -> None:
        self.wanted, self.known, self.seconds = wanted, known, {}
        self.noticed_by = ""
        self.lines: dict[str, set[tuple[str, int]]] = {IMPORTED: set()}
        self.running = self.lines[IMPORTED]
        self.events: dict[tuple[str, int], int] = {}
        if not known:
            sys.settrace(self._called)

    def _called(self, frame, event, argument):
        return self._ran(frame, event, argument) if frame.f_code.co_filename.startswith(FOLDER) else None

    def _ran(self, frame, event, argument):
        file, function = frame.f_code.co_filename, frame.f_code.co_firstlineno
        self.running.add((file, frame.f_lineno))
        events = self.events[file, function] = self.events.get((file, function), 0) + 1
        if events < MAX_EVENTS:
            return self._ran
        if events == MAX_EVENTS:  # it takes too long to watch it further
            self.running.update((file, line) for _, _, line in frame.f_code.co_lines() if line)
        frame.f_trace_lines = False
        return None

    @pytest.hookimpl(trylast=True)
    def pytest_configure(self):
        # a failing example need not be made simpler
        settings.register_profile("mutants", settings(), phases=(Phase.explicit, Phase.generate))
        settings.load_profile("mutants")

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items):
        items[:] = sorted(
            (item for item in items if self.wanted(item.nodeid)), key=lambda item: self.known.get(item.nodeid, 0.0)
        )

    def pytest_runtest_logstart(self, nodeid):
        self.running = self.lines.setdefault(nodeid, set())
        self.events.clear()
        self.seconds[nodeid] = -time.process_time()
        if self.known:
            signal.setitimer(signal.ITIMER_PROF, TIME_LIMIT + TIMES_LONGER * self.known.get(nodeid, 0.0))

    def pytest_runtest_logfinish(self, nodeid):
        self.seconds[nodeid] = round(self.seconds[nodeid] + time.process_time(), 3)
        self.running = self.lines[IMPORTED]

    def pytest_runtest_logreport(self, report):
        if report.failed:
            self.noticed_by = self.noticed_by or report.nodeid

    def pytest_collectreport(self, report):
        if report.failed:
            self.noticed_by = self.noticed_by or report.nodeid


def _by_file(lines: set[tuple[str, int]]) -> dict[str, list[int]]:
    """Return the numbers of lines of each file, which is called by its stem."""
    found: dict[str, list[int]] = {}
    for file, number in lines:
        found.setdefault(Path(file).stem, []).append(number)
    return found


def _too_long(number, frame):
    raise TimeoutError("the time limit of a test")


def run_tests(
    tests: list[Path],
    wanted: Callable[[str], bool] = bool,
    known: dict[str, float] | None = None,
    edited: tuple[Path, ast.Module] | None = None,
) -> dict[str, object]:
    """Run tests with one file of the referee replaced, if one is.

    Parameters
    ----------
    tests
        The files of the tests.
    wanted
        Which of the tests in them run, by their names; by default all.
    known
        How long each test takes, as far as that is known.
    edited
        Which file is replaced by what.

    Returns
    -------
    dict
        Whether all tests ``passed``; ``noticed_by``, the first test that failed; how many ``seconds`` each took; and
        which ``lines`` of which file of the referee each has run, if nothing was known.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY_LIMIT, MEMORY_LIMIT))
        signal.signal(signal.SIGPROF, _too_long)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        if edited is not None:
            sys.meta_path.insert(0, _Mutated(f"skyverse.referee.{edited[0].stem}", *edited))
        watch = _Watch(wanted, known or {})
        said: dict[str, object] = {"passed": False}
        try:
            code = int(pytest.main([*OPTIONS, *map(str, tests)], plugins=[watch]))
            none_left = pytest.ExitCode.NO_TESTS_COLLECTED
            said = {"passed": code in (0, none_left), "noticed_by": watch.noticed_by, "seconds": watch.seconds}
            said["lines"] = {name: _by_file(lines) for name, lines in watch.lines.items()}
        finally:
            with os.fdopen(writing, "w") as pipe:
                pipe.write(json.dumps(said))
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as pipe:
        text = pipe.read()
    os.waitpid(child, 0)
    return {"passed": False, "noticed_by": "", "seconds": {}, "lines": {}} | (json.loads(text) if text else {})


def _preload() -> None:
    """Import what the tests need, except the referee, so that forked processes need not."""
    import hypothesis.extra.numpy  # noqa: F401
    import scipy.integrate
    import scipy.optimize  # noqa: F401

    import skyverse.model.mission
    import skyverse.planners.astar
    import skyverse.planners.taut
    import skyverse.trajectory  # noqa: F401

    assert not [name for name in sys.modules if name.startswith("skyverse.referee")]


def main() -> None:
    """Judge as many mutants as are asked for, and print those that no test noticed."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("count", type=int, nargs="?", default=300, help="mutants, 300 by default")
    parser.add_argument("--seed", type=int, default=0, help="of the choice of edits")
    parser.add_argument("--log", type=Path, default=ROOT / "out" / "mutants.jsonl", help="where answers are kept")
    given = parser.parse_args()
    os.environ.setdefault("SKYVERSE_EXAMPLES", "5")
    os.chdir(ROOT)
    sys.path.insert(0, str(ROOT / "src"))
    _preload()
    texts = {file: file.read_text(encoding="utf-8") for file in sorted(REFEREE.glob("*.py"))}
    sites = [(file, k) for file, text in texts.items() for k, _ in enumerate(edits(ast.parse(text)))]
    # an edit is chosen or not whatever other files hold, so that answers can be used again when one file has changed
    chosen = sorted(sites, key=lambda site: _digest(f"{given.seed} {site[0].stem} {site[1]}"))[: given.count]
    print(f"{len(chosen)} of {len(sites)} single edits of {len(texts)} files", flush=True)
    given.log.parent.mkdir(parents=True, exist_ok=True)
    tests = sorted(TESTS.glob("test_*.py"))
    plain = _without_edits(given.log.with_suffix(".plain"), tests)
    assert plain["passed"], f"without any edit a test fails: {plain['noticed_by']}"
    seconds, quick = plain["seconds"], {name for name, taken in plain["seconds"].items() if taken <= MAX_QUICK_SECONDS}
    print(
        f"{len(seconds)} tests pass without any edit, in {sum(seconds.values()):.0f} s; {len(quick)} are quick",
        flush=True,
    )
    answers = _known(given.log)
    for slow in (False, True):
        for number, (file, k) in enumerate(chosen, 1):
            key = _digest(f"{file.stem}{k}{texts[file]}")
            before = answers.get(key, {"passed": True, "slow": None})
            if not before["passed"] or (before["slow"] is not None and before["slow"] >= slow):
                continue
            answers[key] = _judged(file, texts[file], k, plain, slow) | {"key": key}
            with given.log.open("a", encoding="utf-8") as log:
                log.write(json.dumps(answers[key]) + "\n")
            if answers[key]["passed"]:
                print(
                    f"not noticed by {'any test' if slow else 'quick tests'} ({number}): {answers[key]['diff']}",
                    flush=True,
                )
    missed = [one for file, k in chosen if (one := answers[_digest(f"{file.stem}{k}{texts[file]}")])["passed"]]
    for one in missed:
        print(f"not noticed: {one['diff']}")
    print(f"{len(chosen) - len(missed)} of {len(chosen)} noticed, {1 - len(missed) / len(chosen):.1%}")


def _without_edits(kept: Path, tests: list[Path]) -> dict[str, object]:
    """Return what the tests say without any edit, as it is kept in a file for this version of the library, if it is."""
    files = [*tests, *sorted((ROOT / "src").rglob("*.py"))]
    version = _digest("".join(file.read_text(encoding="utf-8") for file in files))
    plain = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    if plain.get("version") != version:
        plain = run_tests(tests) | {"version": version}
        kept.write_text(json.dumps(plain), encoding="utf-8")
    return plain


def _known(log: Path) -> dict[str, dict[str, object]]:
    """Return the answers in a file that still count."""
    lines = log.read_text(encoding="utf-8").splitlines() if log.exists() else []
    answers = [json.loads(line) for line in lines]
    return {answer["key"]: answer for answer in answers if answer["tests"] == _tests(answer["noticed_by"])}


def _tests(noticed_by: str) -> str:
    """Return a digest of one test, or of all tests if none is named or it is no more there."""
    name = noticed_by.partition("::")[2].partition("[")[0]
    file = ROOT / noticed_by.partition("::")[0]
    text = file.read_text(encoding="utf-8") if name and file.is_file() else ""
    source = [ast.unparse(node) for node in ast.parse(text).body if getattr(node, "name", "") == name]
    return _digest("".join(source or [one.read_text(encoding="utf-8") for one in sorted(TESTS.glob("*.py"))]))


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def _judged(file: Path, text: str, k: int, plain: dict[str, object], slow: bool) -> dict[str, object]:
    """Return what the quick tests say of one edit, or the slow ones."""
    tree = ast.parse(text)
    node, field, value = next(edit for j, edit in enumerate(edits(tree)) if j == k)
    run = set(_lines_of_statement(tree, node))
    before = ast.unparse(node)
    setattr(node, field, value)
    ast.fix_missing_locations(tree)
    diff = f"{file.relative_to(ROOT)}:{node.lineno}: {before}  ->  {ast.unparse(node)}"
    seconds = plain["seconds"]
    wanted = {name for name, files in plain["lines"].items() if not run.isdisjoint(files.get(file.stem, ()))}
    wanted = seconds.keys() if IMPORTED in wanted else wanted
    wanted = {name for name in wanted if (seconds[name] > MAX_QUICK_SECONDS) == slow}
    own = {name for name in wanted if f"/test_{file.stem}.py" in name}
    began, said = time.perf_counter(), {"passed": True, "noticed_by": ""}
    for stage in (own, wanted - own):
        if stage and said["passed"]:
            tests = [ROOT / name for name in sorted({name.partition("::")[0] for name in stage})]
            said = run_tests(tests, stage.__contains__, seconds, (file, tree))
    answer = {name: said[name] for name in ("passed", "noticed_by")}
    taken = round(time.perf_counter() - began, 1)
    return {"diff": diff, "seconds": taken, "slow": slow, "tests": _tests(said["noticed_by"])} | answer


def _lines_of_statement(tree: ast.Module, node: ast.AST) -> range:
    """Return the lines of the smallest statement that holds a node; of one that holds others, only its head."""
    statement = [
        one for one in ast.walk(tree) if isinstance(one, ast.stmt) and any(part is node for part in ast.walk(one))
    ][-1]
    last = statement.body[0].lineno - 1 if hasattr(statement, "body") else statement.end_lineno
    return range(statement.lineno, max(statement.lineno, last) + 1)


if __name__ == "__main__":
    main()
