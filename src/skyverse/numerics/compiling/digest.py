"""What a kernel's machine code depends on, as one digest, so that kept machine code can never be stale."""

import enum
import hashlib
from collections.abc import Iterator
from functools import cache
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

Content = tuple[str, dict[str, Any]]


def digest_of(kernel: Any) -> str:
    """Return the digest of a kernel's content and of all kernels that it calls, directly or not: 64 hex digits.

    The content is the bytecode, the options of the decorator and the values of the names of the module and of the
    function around it: other kernels, numbers, arrays, NamedTuples and their classes. Comments, docstrings and line
    numbers do not count.

    Raises
    ------
    TypeError
        If the kernel uses a value whose content cannot be told.
    """
    return _digest(kernel, _content)


def digest_now(kernel: Any) -> str:
    """Return the digest as `digest_of` does, from the values that the global names have now.

    `digest_of` remembers what it has seen. The two differ if somebody has set a global of a kernel's module since.
    """
    return _digest(kernel, _content.__wrapped__)


def callees_of(kernel: Any) -> dict[str, Any]:
    """Return the kernel and all kernels that it calls, directly or not, by module and name."""
    found, waiting = {name_of(kernel): kernel}, [kernel]
    while waiting:
        _, callees = _content(waiting.pop())
        waiting += [callee for name, callee in callees.items() if name not in found]
        found |= callees
    return found


def name_of(thing: Any) -> str:
    """Return what a kernel or a class is called: ``package.module:name``."""
    return f"{thing.__module__}:{thing.__qualname__}"


def _digest(kernel: Any, content: Any) -> str:
    found, waiting = {name_of(kernel): kernel}, [kernel]
    texts = []
    while waiting:
        text, callees = content(waiting.pop())
        texts.append(text)
        waiting += [callee for name, callee in callees.items() if name not in found]
        found |= callees
    return hashlib.sha256("\n".join((name_of(kernel), *sorted(texts))).encode()).hexdigest()


@cache
def _content(kernel: Any) -> Content:
    """Return the digest of a kernel's own content, and the kernels that it names."""
    function: FunctionType = kernel.py_func
    parts = [name_of(kernel), repr(sorted(kernel.targetoptions.items())), *_code(function.__code__, function.__doc__)]
    parts += _value("defaults", function.__defaults__)
    callees: dict[str, Any] = {}
    for where, value in (*_around(function), *_named(function)):
        if hasattr(value, "py_func"):
            callees[name_of(value)] = value
            parts.append(f"{where} calls {name_of(value)}")
        else:
            parts += _value(where, value)
    return hashlib.sha256("\n".join(parts).encode()).hexdigest(), callees


def _around(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Yield the variables of the function around a function that it uses."""
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        yield name, cell.cell_contents


def _named(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Yield what the names in a function's code may stand for: globals, or what modules of ours hold."""
    scope, names = function.__globals__, function.__code__.co_names
    for name in names:
        if name in scope:
            yield name, scope[name]
        for other in names:
            module = scope.get(other)
            if isinstance(module, ModuleType) and _is_ours(module, function) and hasattr(module, name):
                yield f"{other}.{name}", getattr(module, name)


def _is_ours(module: ModuleType, function: FunctionType) -> bool:
    return module.__name__.partition(".")[0] == function.__module__.partition(".")[0]


def _code(code: CodeType, doc: str | None) -> list[str]:
    """Return a function's bytecode and what it refers to, without its docstring, file and line numbers."""
    constants = [None if i == 0 and doc is not None and c == doc else c for i, c in enumerate(code.co_consts)]
    parts = [code.co_code.hex(), repr((code.co_argcount, code.co_kwonlyargcount, code.co_flags & 0xFFFF))]
    parts += [repr((code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars))]
    for constant in constants:
        parts += _code(constant, None) if isinstance(constant, CodeType) else _value("constant", constant)
    return parts


def _value(name: str, value: Any) -> list[str]:
    """Return the content of a constant."""
    if isinstance(value, np.ndarray):
        return [f"{name} = {value.dtype} {value.shape} {value.tobytes().hex()}"]
    if isinstance(value, frozenset):
        return [f"{name} of {sorted(map(repr, value))}"]
    if isinstance(value, tuple):
        return [f"{name} of {len(value)}"] + [part for item in value for part in _value(name, item)]
    if isinstance(value, (bool, int, float, complex, str, bytes, enum.Enum, np.generic, type(None))):
        return [f"{name} = {type(value).__name__} {value!r}"]
    if isinstance(value, type):
        return [f"{name} = {name_of(value)} {getattr(value, '_fields', ())}"]
    if isinstance(value, ModuleType):
        return [f"{name} = {value.__name__}"]
    if isinstance(value, (FunctionType, BuiltinFunctionType, np.ufunc)):  # of numpy, math or Python: versions tell
        return [f"{name} = {getattr(value, '__module__', '')} {value.__name__}"]
    raise TypeError(f"kernels use constants, arrays, NamedTuples and kernels; {name} is a {type(value).__name__}")
