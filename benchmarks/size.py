"""How large the source is: ``python benchmarks/size.py [--kernels]``.

A line of code is a line with anything on it that is neither a comment nor part of a docstring. With ``--kernels`` the
number of kernels, each for arguments of certain types, that ``skyverse cache --compile`` compiles is printed as well.
"""

import ast
import sys
import tokenize
from collections import Counter, defaultdict
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
SOURCE = ROOT / "src" / "skyverse"
SHORT_FILE = 50
MANY_PARAMETERS = 8
_NO_CODE = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENCODING,
    tokenize.ENDMARKER,
}


@dataclass(frozen=True)
class Size:
    """What is in one file: its lines of code and of all, its classes, and its functions with many parameters."""

    code: int
    lines: int
    classes: list[str]
    many_parameters: list[str]
    inner_names: int
    """How many names it imports from inside rooms, from ``skyverse.room.file`` rather than from ``skyverse.room``."""


def size_of(file: Path) -> Size:
    """Read a source file."""
    tree = ast.parse(file.read_bytes())
    numbers: set[int] = set()
    with tokenize.open(file) as text:
        for token in tokenize.generate_tokens(text.readline):
            if token.type not in _NO_CODE:
                numbers.update(range(token.start[0], token.end[0] + 1))
    classes, many, inner = [], [], 0
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            numbers.difference_update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
        elif isinstance(node, ast.ClassDef):
            classes.append(node.name)
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
            count = len(given) - (bool(given) and given[0].arg in ("self", "cls"))
            if count > MANY_PARAMETERS:
                many.append(f"{file.relative_to(ROOT)}:{node.lineno} {node.name} ({count})")
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("skyverse."):
            inner += len(node.names) if node.module and node.module.count(".") > 1 else 0
    return Size(len(numbers), len(file.read_text(encoding="utf-8").splitlines()), classes, many, inner)


def room_of(file: Path) -> str:
    """Return the package at the top that a file belongs to; files at the root belong to none."""
    parts = file.relative_to(SOURCE).parts
    return parts[0] if len(parts) > 1 else "(root)"


def main() -> None:
    """Print the table of rooms, and the figures of all of them."""
    sizes = {file: size_of(file) for file in sorted(SOURCE.rglob("*.py"))}
    rooms: dict[str, list[Size]] = defaultdict(list)
    for file, size in sizes.items():
        rooms[room_of(file)].append(size)
    print(f"{'room':14}{'code':>7}{'files':>7}{'short':>7}{'classes':>9}")
    for room, found in [
        *sorted(rooms.items(), key=lambda item: -sum(s.code for s in item[1])),
        ("all", sizes.values()),
    ]:
        short = sum(size.lines < SHORT_FILE for size in found)
        classes = sum(len(size.classes) for size in found)
        print(f"{room:14}{sum(size.code for size in found):7,}{len(found):7}{short:7}{classes:9}")
    names = Counter(name for size in sizes.values() for name in size.classes)
    twice = {name: count for name, count in sorted(names.items()) if count > 1}
    print(f"\nclass names that stand for more than one: {len(twice)}")
    for name, count in twice.items():
        where = [str(file.relative_to(SOURCE)) for file, size in sizes.items() if name in size.classes]
        print(f"  {name} ({count}): {', '.join(where)}")
    many = [line for size in sizes.values() for line in size.many_parameters]
    print(f"functions with more than {MANY_PARAMETERS} parameters: {len(many)}", *many, sep="\n  ")
    tests = [size_of(file) for file in (ROOT / "tests").rglob("*.py")]
    print(f"lines of code of tests: {sum(size.code for size in tests):,} in {len(tests)} files")
    print(f"names that tests import from inside rooms: {sum(size.inner_names for size in tests):,}")
    if "--kernels" in sys.argv[1:]:
        from skyverse.numerics.compiling.listing import read_listing

        print(f"kernels, each for arguments of certain types: {len(read_listing().kernels)}")


if __name__ == "__main__":
    main()
