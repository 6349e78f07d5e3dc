"""Types of kernels' arguments as text and back: for the names of kept machine code, and for the list of kernels."""

import ast
import importlib
import re
from typing import Any

from numba.core import types

from skyverse.numerics.compiling.digest import name_of
from skyverse.numerics.compiling.references import StructReference

GENERATOR = "Generator"
_TOKEN = re.compile(
    r"readonly |array\((\w+), (\d)d, ([CFA])\)|default\(([^()]*)\)|Tuple\(|(&?[\w.]+:[\w.]+)\(|(\w+)|(\))|, "
)


def text_of(kind: Any) -> str:
    """Return a type as text: ``float64``, ``array(float64, 2d, C)``, ``package.module:NamedTuple(int64, float64)``.

    An ampersand before a NamedTuple means that it is taken by reference.

    Raises
    ------
    TypeError
        If kernels take no arguments of this type.
    """
    if isinstance(kind, types.Array) and isinstance(kind.dtype, (types.Number, types.Boolean)) and kind.aligned:
        readonly = "" if kind.mutable else "readonly "
        return f"{readonly}array({text_of(kind.dtype)}, {kind.ndim}d, {kind.layout})"
    if isinstance(kind, (types.NamedTuple, types.NamedUniTuple, StructReference)):
        sign = "&" if isinstance(kind, StructReference) else ""
        return f"{sign}{name_of(kind.instance_class)}({', '.join(map(text_of, kind.types))})"
    if isinstance(kind, (types.Tuple, types.UniTuple)):
        return f"Tuple({', '.join(map(text_of, kind.types))})"
    if isinstance(kind, types.NumPyRandomGeneratorType):
        return GENERATOR
    if isinstance(kind, types.Omitted):
        return f"default({kind.value!r})"
    if isinstance(kind, (types.Number, types.Boolean, types.NoneType)) and not isinstance(kind, types.Literal):
        return str(kind)
    raise TypeError(f"kernels take numbers, arrays, NamedTuples of them and generators, not {kind}")


def type_of(text: str) -> Any:
    """Return the type that a text stands for; see `text_of`.

    Raises
    ------
    ValueError
        If it stands for none.
    """
    tokens = list(_TOKEN.finditer(text))
    if "".join(token[0] for token in tokens) != text:
        raise ValueError(f"expected a type such as array(float64, 2d, C), found {text!r}")
    return _parse(tokens[::-1])


def _parse(tokens: list[re.Match[str]]) -> Any:
    """Take a type off the end of the tokens, which stand in reverse order."""
    token = tokens.pop()
    if token[0] == "readonly ":
        return _parse(tokens).copy(readonly=True)
    if token[1]:
        return types.Array(_scalar(token[1]), int(token[2]), token[3])  # type: ignore[arg-type]
    if token[4]:
        return types.Omitted(ast.literal_eval(token[4]))
    if token[6]:
        return _scalar(token[6])
    items = []
    while tokens[-1][0] != ")":
        items.append(_parse(tokens))
        if tokens[-1][0] == ", ":
            tokens.pop()
    tokens.pop()
    if not token[5]:
        return types.Tuple(items)
    module, _, name = token[5].partition(":")
    cls = getattr(importlib.import_module(module.removeprefix("&")), name)
    return StructReference(cls, tuple(items)) if module.startswith("&") else tuple_type(items, cls)


def tuple_type(items: list[Any], cls: Any) -> Any:
    """Return the type of a NamedTuple whose fields have these types."""
    if items and all(item == items[0] for item in items):
        return types.NamedUniTuple(items[0], len(items), cls)
    return types.NamedTuple(items, cls)


def _scalar(name: str) -> Any:
    if name == GENERATOR:
        return types.npy_rng
    return getattr(types, {"bool": "boolean"}.get(name, name))
