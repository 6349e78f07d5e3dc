"""The judge's tests are judged: ``python benchmarks/mutants.py 300`` edits the referee at random and runs its tests.

Each mutant is one edit of a file of ``src/skyverse/referee``: a comparison turned, a sign changed, a minimum in place
of a maximum, `and` in place of `or`, another constant. It is noticed if a test of ``tests/referee`` fails, or if the
tests take longer than the time limit. Every mutant runs in a process of its own, forked from one that has imported
everything but the referee; no file is changed. Those that are not noticed are printed with the line before and after.

The answers are kept in a file, line by line, so that a run that was stopped goes on where it ended; an answer counts as
long as neither the edited file nor the tests have changed.
"""

import argparse
import ast
import hashlib
import importlib.abc
import importlib.util
import json
import os
import random
import resource
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
REFEREE, TESTS = ROOT / "src" / "skyverse" / "referee", ROOT / "tests" / "referee"
TIME_LIMIT = 300
"""Seconds of computing time: tests that take longer count as failed, since a mutant may loop for ever."""
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


def run_tests(file: Path | None, tree: ast.Module | None) -> str:
    """Run the tests with one file of the referee replaced; return ``passed``, ``failed`` or ``time limit``."""
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (TIME_LIMIT, TIME_LIMIT + 10))
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        tests = sorted(TESTS.glob("test_*.py"))
        if file is not None and tree is not None:
            sys.meta_path.insert(0, _Mutated(f"skyverse.referee.{file.stem}", file, tree))
            tests.sort(key=lambda test: test.stem != f"test_{file.stem}")  # its own tests find most
        import pytest

        try:
            code = int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", "-n0", *map(str, tests)]))
        except BaseException:
            code = 1
        os._exit(min(code, 1))
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return "time limit" if os.WTERMSIG(status) == signal.SIGXCPU else "failed"
    return "failed" if os.WEXITSTATUS(status) else "passed"


def _preload() -> None:
    """Import what the tests need, except the referee, so that forked processes need not."""
    import numpy  # noqa: F401
    import pytest  # noqa: F401
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
    os.environ.setdefault("SKYVERSE_EXAMPLES", "10")
    os.chdir(ROOT)
    sys.path.insert(0, str(ROOT / "src"))
    _preload()
    texts = {file: file.read_text(encoding="utf-8") for file in sorted(REFEREE.glob("*.py"))}
    suite = hashlib.sha256("".join(test.read_text(encoding="utf-8") for test in sorted(TESTS.glob("*.py"))).encode())
    sites = [(file, k) for file, text in texts.items() for k, _ in enumerate(edits(ast.parse(text)))]
    chosen = random.Random(given.seed).sample(sites, min(given.count, len(sites)))
    given.log.parent.mkdir(parents=True, exist_ok=True)
    known = {}
    if given.log.exists():
        for line in given.log.read_text(encoding="utf-8").splitlines():
            answer = json.loads(line)
            known[answer["key"]] = answer
    print(f"{len(chosen)} of {len(sites)} single edits of {len(texts)} files", flush=True)
    if not all(_key(texts[file], k, suite) in known for file, k in chosen):
        assert run_tests(None, None) == "passed", "the tests fail without any edit"
    answers = []
    for number, (file, k) in enumerate(chosen, 1):
        key = _key(texts[file], k, suite)
        if key not in known:
            known[key] = _judged(file, texts[file], k) | {"key": key}
            with given.log.open("a", encoding="utf-8") as log:
                log.write(json.dumps(known[key]) + "\n")
        answers.append(known[key])
        if known[key]["answer"] == "passed":
            print(f"not noticed ({number}): {known[key]['diff']}", flush=True)
    noticed = sum(answer["answer"] != "passed" for answer in answers)
    print(f"{noticed} of {len(answers)} noticed, {noticed / len(answers):.1%}")


def _key(text: str, k: int, suite: "hashlib._Hash") -> str:
    return hashlib.sha256(f"{text}{k}{suite.hexdigest()}".encode()).hexdigest()[:24]


def _judged(file: Path, text: str, k: int) -> dict[str, object]:
    """Return what the tests say of one edit."""
    tree = ast.parse(text)
    node, field, value = next(edit for j, edit in enumerate(edits(tree)) if j == k)
    before = ast.unparse(node)
    setattr(node, field, value)
    ast.fix_missing_locations(tree)
    diff = f"{file.relative_to(ROOT)}:{node.lineno}: {before}  ->  {ast.unparse(node)}"
    began = time.perf_counter()
    answer = run_tests(file, tree)
    return {"diff": diff, "answer": answer, "seconds": round(time.perf_counter() - began, 1)}


if __name__ == "__main__":
    main()
