"""No two files of the package import each other, directly or through others, and no two classes have one name."""

import ast
from collections import Counter
from pathlib import Path

import skyverse

ROOT = Path(skyverse.__file__).parent


def test_no_files_import_each_other_in_a_circle():
    files = {name_of(path): path for path in ROOT.rglob("*.py")}
    imports = {name: imported(name, path, set(files)) for name, path in files.items()}
    assert circles(imports) == []


def test_a_circle_is_found_wherever_its_imports_stand():
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}, "e": set()}) == [["a", "b", "c"]]
    source = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from p.a import X\ndef f():\n    import p.b.c\n"
    assert names_in("p.d", False, source) >= {"p.a", "p.a.X", "p.b.c"}
    assert names_in("p.q", True, "from . import r\nfrom .s import t") >= {"p.q.r", "p.q.s"}
    assert names_in("p.q", False, "from . import r") >= {"p.r"}
    assert names_in("p.q", False, "def f(): return importlib.import_module('p.s')") >= {"p.s"}


def test_no_class_name_stands_for_two_things():
    trees = [ast.parse(path.read_text(encoding="utf-8")) for path in ROOT.rglob("*.py")]
    names = Counter(node.name for tree in trees for node in ast.walk(tree) if isinstance(node, ast.ClassDef))
    assert [name for name, count in names.items() if count > 1] == []


def name_of(path):
    """Return a file's name as a module: ``skyverse.maps`` for the ``__init__.py`` of a folder."""
    parts = path.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported(name, path, known):
    """Return the files that a file imports, anywhere in it; a folder's name stands for its ``__init__.py``."""
    return (names_in(name, path.name == "__init__.py", path.read_text(encoding="utf-8")) & known) - {name}


def names_in(name, is_folder, source):
    """Return all dotted names that the import statements of a source, and modules loaded by name, may stand for."""
    here = name.split(".") if is_folder else name.split(".")[:-1]
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = here[: len(here) - node.level + 1] if node.level else []
            module = ".".join([*base, *([node.module] if node.module else [])])
            found |= {module} | {f"{module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module"):
            found |= {node.args[0].value} if isinstance(node.args[0], ast.Constant) else set()
    return found


def circles(imports):
    """Return the sets of files each of which reaches all the others (Tarjan's strongly connected components)."""
    number, low, stack, found = {}, {}, [], []

    def visit(file):
        number[file] = low[file] = len(number)
        stack.append(file)
        for other in sorted(imports[file]):
            if other not in number:
                visit(other)
                low[file] = min(low[file], low[other])
            elif other in stack:
                low[file] = min(low[file], number[other])
        if low[file] == number[file]:
            part = [stack.pop()]
            while part[-1] != file:
                part.append(stack.pop())
            if len(part) > 1:
                found.append(sorted(part))

    for file in sorted(imports):
        if file not in number:
            visit(file)
    return found
