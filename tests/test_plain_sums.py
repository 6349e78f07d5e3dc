"""Nothing that decides an answer is added up by BLAS or LAPACK, which round otherwise on each kind of processor.

Scalar products, norms and small systems are plain sums instead, which give the same bits everywhere. Nor do numpy's own
elementary functions decide one, which round otherwise with AVX-512: `skyverse.model.arrays` has such functions.
"""

import ast
from pathlib import Path

import pytest

import skyverse

ROOT = Path(skyverse.__file__).parent
DECIDE_NO_MISSION = {"draw", "flight", "lab", "reproduction"}  # pictures, simulators, and statistics of answers
ROUND_OTHERWISE = """
    numpy.dot numpy.vdot numpy.inner numpy.matmul numpy.tensordot numpy.matvec numpy.vecmat numpy.vecdot
    numpy.convolve numpy.correlate numpy.cov numpy.corrcoef numpy.roots numpy.poly numpy.polyfit numpy.polymul
    numpy.polynomial numpy.einsum_path operator.matmul operator.imatmul
    numpy.arctan2 numpy.arctan numpy.arcsin numpy.arccos numpy.tan numpy.sinh numpy.cosh numpy.tanh numpy.cbrt
    numpy.power numpy.float_power numpy.exp2 numpy.expm1 numpy.log1p numpy.log10
"""
METHODS = ("dot", "__matmul__", "__rmatmul__", "__imatmul__")
PLAIN_PARTS_OF_SCIPY = {
    "scipy.interpolate.BSpline",
    "scipy.ndimage",
    "scipy.optimize.linear_sum_assignment",
    "scipy.sparse.coo_array",
    "scipy.sparse.csr_array",
    "scipy.sparse.csgraph.connected_components",
    "scipy.sparse.csgraph.floyd_warshall",
    "scipy.sparse.csgraph.maximum_bipartite_matching",
    "scipy.spatial.cKDTree",
    "scipy.spatial.distance.cdist",
}


def test_what_decides_an_answer_is_added_up_plainly():
    files = [path for path in ROOT.rglob("*.py") if path.relative_to(ROOT).parts[0] not in DECIDE_NO_MISSION]
    found = {
        path.relative_to(ROOT).as_posix(): calls_that_round_otherwise(path.read_text(encoding="utf-8"))
        for path in files
    }
    assert {name: calls for name, calls in found.items() if calls} == {}


@pytest.mark.parametrize(
    "source",
    [
        "a @ b",
        "a @= b",
        "import numpy as np\nnp.dot(a, b)",
        "import numpy as np\nnp.arctan2(a, b)",
        "import numpy\nnumpy.inner(a, b)",
        "from numpy import vdot as product\nproduct(a, b)",
        "import numpy as np\nproduct = np.matmul",
        "a.dot(b)",
        "import operator\nfunctools.reduce(operator.matmul, rows)",
        "a.__matmul__(b)",
        "import numpy as np\nnp.linalg.norm(a)",
        "import numpy as np\nnp.linalg.norm(a, axis=None)",
        "import numpy as np\nnp.linalg.norm(a, axis=which)",
        "import numpy as np\nnp.linalg.norm(a, ord=2, axis=(1, 2))",
        "import numpy as np\nlength = np.linalg.norm",
        "import numpy as np\nla = np.linalg\nla.norm(a)",
        "import numpy.linalg as la\nla.solve(a, b)",
        "from numpy.linalg import svd\nsvd(a)",
        "from numpy import linalg\nlinalg.det(a)",
        "import numpy.linalg\nnumpy.linalg.inv(a)",
        "def f():\n    import numpy as n\n    return n.roots(a)",
        "import numpy as np\nnp.einsum('ij,jk->ik', a, b, optimize=True)",
        "import numpy as np\nnp.einsum('ij,jk->ik', a, b, **settings)",
        "from scipy.linalg import solve",
        "import scipy\nscipy.linalg.solve(a, b)",
        "from scipy import linalg",
        "import scipy.linalg",
        "from scipy.interpolate import make_interp_spline",
        "from numpy.polynomial import Polynomial",
    ],
)
def test_a_call_of_blas_is_found_whatever_it_is_called(source):
    assert calls_that_round_otherwise(source)


@pytest.mark.parametrize(
    "source",
    [
        "import numpy as np\nnp.linalg.norm(a, axis=1)",
        "import numpy as np\nnp.linalg.norm(a - b, axis=-1, keepdims=True)",
        "import numpy as np\nnp.einsum('ij,jk->ik', a, b)",
        "import numpy as np\nnp.sum(a * b, axis=1)",
        "import math\nmath.hypot(*a)",
        "from scipy.spatial import cKDTree\ncKDTree(points)",
        "from scipy import ndimage\nndimage.label(a)",
        "from skyverse.live.steered_motion import dot\ndot(a, b)",
        "@property\ndef f(): pass",
    ],
)
def test_a_plain_sum_is_none(source):
    assert calls_that_round_otherwise(source) == []


def calls_that_round_otherwise(source):
    """Return the lines and expressions of a source that may round otherwise on some processors, in order."""
    tree = ast.parse(source)
    whole, names = outermost_names(tree), imported_names(tree)
    calls = {id(node.func): node for node in ast.walk(tree) if isinstance(node, ast.Call)}
    found = {(node.lineno, name) for node, name in imports(tree) if rounds_otherwise(name)}
    for node in ast.walk(tree):
        product = isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.MatMult)
        if product or (isinstance(node, ast.Attribute) and node.attr in METHODS):
            found.add((node.lineno, ast.unparse(node)))
        elif id(node) in whole and rounds_otherwise(name := full_name(node, names), calls.get(id(node))):
            found.add((node.lineno, name))
    return sorted(found)


def rounds_otherwise(name, call=None):
    """Tell whether a dotted name stands for what does; `call` is the call of it, if it is called there."""
    if name.startswith("numpy.linalg"):
        return not (name == "numpy.linalg.norm" and call is not None and is_norm_of_rows(call))
    if name == "numpy.einsum":
        return call is None or bool(call.keywords)
    if name.startswith("scipy"):
        return not any(f"{name}.".startswith(f"{part}.") for part in PLAIN_PARTS_OF_SCIPY)
    return any(f"{name}.".startswith(f"{part}.") for part in ROUND_OTHERWISE.split())


def is_norm_of_rows(call):
    """Tell whether a call of `numpy.linalg.norm` says along which single axis, and nothing else that matters."""
    options = {option.arg: ast.unparse(option.value) for option in call.keywords}
    along = options.get("axis") in ("-1", "0", "1", "2")
    return along and len(call.args) == 1 and options.keys() <= {"axis", "keepdims"}


def outermost_names(tree):
    """Return the ids of all names, such as ``np.linalg.norm``, that are not parts of longer ones."""
    dotted = [node for node in ast.walk(tree) if isinstance(node, ast.Name | ast.Attribute)]
    return {id(node) for node in dotted} - {id(node.value) for node in dotted if isinstance(node, ast.Attribute)}


def full_name(node, names):
    """Return the dotted name of an expression, by what was imported; empty for what has none."""
    if isinstance(node, ast.Name):
        return names.get(node.id, "")
    if isinstance(node, ast.Attribute) and (base := full_name(node.value, names)):
        return f"{base}.{node.attr}"
    return ""


def imports(tree):
    """Yield each import statement of a source with each dotted name that it imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node, alias.name) for alias in node.names if alias.name not in ("numpy.linalg", "scipy"))
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            yield from ((node, name) for name in names if name != "numpy.linalg")


def imported_names(tree):
    """Return what each name of a source stands for."""
    found = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                found[alias.asname or alias.name.split(".")[0]] = (
                    alias.name if alias.asname else alias.name.split(".")[0]
                )
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found |= {alias.asname or alias.name: f"{node.module}.{alias.name}" for alias in node.names}
    return found
