"""Machine code kept by content: named by the kernel's digest, its arguments' types, the versions and the processor."""

import ast
import hashlib
import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core import config
from numba.core.event import trigger_event
from numba.core.runtime.nrt import rtsys

from skyverse.numerics.compiling import to_prepare
from skyverse.numerics.compiling.digest import digest_now, digest_of, name_of
from skyverse.numerics.compiling.numba_target import processor
from skyverse.numerics.compiling.signatures import text_of
from skyverse.numerics.compiling.store import KernelStore, user_folder

CODE_FILES = ("numba_internals.py", "numba_target.py", "references.py", "signatures.py")
SETTINGS = ("BOUNDSCHECK", "OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "DEBUGINFO_DEFAULT", "LLVM_REFPRUNE_FLAGS")
SHIPPED = Path(__file__).with_name("shipped")  # kernels that came with a wheel: a folder for each level of processors
LEVELS = {
    "x86-64-v3": {"+avx", "+avx2", "+bmi", "+bmi2", "+f16c", "+fma", "+lzcnt", "+movbe", "+xsave", "+popcnt", "+cx16"},
    "x86-64": {"+64bit"},
    "apple-m1": {"+neon", "+lse"},
    "generic": {"+neon"},
}


class KeptCode:
    """The machine code of one kernel, for each signature, in the stores: what numba calls a cache.

    Parameters
    ----------
    kernel
        The kernel.
    pack, unpack
        Turn what numba has compiled into bytes, and back.
    """

    def __init__(self, kernel: Any, pack: Callable[[Any], bytes | None], unpack: Callable[[Any, bytes], Any]) -> None:
        self._kernel, self._pack, self._unpack = kernel, pack, unpack
        self._enabled = True

    @property
    def cache_path(self) -> str:
        """The folder that machine code is kept in."""
        return str(stores()[-1][0].folder) if stores() else ""

    def enable(self) -> None:
        """Use the stores."""
        self._enabled = True

    def disable(self) -> None:
        """Do not use the stores."""
        self._enabled = False

    def flush(self) -> None:
        """Do nothing: what is kept never becomes stale."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the kernel for arguments of these types as it was compiled before; None if it was not."""
        if not self._enabled:
            return None
        rtsys.initialize(target_context)  # all that kept code needs: numba refreshes the rest before it compiles
        if to_prepare and not is_kept(self._kernel, sig):
            with trigger_event("numba:compile", data={"dispatcher": self._kernel}):  # for those who measure time
                to_prepare.pop()()
        for store, name in self.places(sig):
            body = store.load(name)
            if body is None:
                continue
            try:
                return self._unpack(self._kernel, body)
            except Exception:  # nothing that can be wrong with a file may keep a kernel from being compiled
                store.drop(name)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled for arguments of these types."""
        if not self._enabled or digest_now(self._kernel) != digest_of(self._kernel):  # a global was set since
            return
        for store, name in self.places(sig):
            if store.writable and (body := self._pack(data)) is not None:
                store.keep(name, body)

    def places(self, sig: Any) -> list[tuple[KernelStore, str]]:
        """Return where the code for a signature may be, and under which names; none if its types have no text."""
        try:
            kinds = ", ".join(text_of(kind) for kind in (sig.args if hasattr(sig, "args") else sig))
        except TypeError:
            return []
        module, _, name = name_of(self._kernel).partition(":")
        readable = f"{module.removeprefix('skyverse.')}.{name}"
        content = (digest_of(self._kernel), kinds, _environment())
        return [
            (store, f"{readable}-{hashlib.sha256(repr((content, cpu)).encode()).hexdigest()[:40]}")
            for store, cpu in stores()
        ]


def is_kept(kernel: Any, arguments: Any) -> bool:
    """Tell whether a kernel's machine code for arguments of these types is in a store."""
    return any(store.holds(name) for store, name in kernel._cache.places(arguments))


@cache
def stores() -> tuple[tuple[KernelStore, tuple[str, ...]], ...]:
    """Return where machine code is looked for, in this order, and for which processor it is there."""
    system, cpu, features = processor()
    found = [
        (KernelStore(SHIPPED / level, read_only=True), (system, level, ""))
        for level, wanted in LEVELS.items()
        if (SHIPPED / level).is_dir() and wanted <= {*features.split(",")} and not os.environ.get("SKYVERSE_CPU")
    ]
    folder = user_folder()
    return (*found, (KernelStore(folder), (system, cpu, features))) if folder else tuple(found)


@cache
def _environment() -> str:
    """Return what else machine code depends on: versions, settings, and how this package compiles."""
    versions = (numba.__version__, llvmlite.__version__, np.__version__, sys.implementation.cache_tag)
    settings = [getattr(config, name, None) for name in SETTINGS]
    here = Path(__file__).parent
    code = [ast.dump(_undocumented(here / name)) for name in CODE_FILES]
    return repr((versions, settings, hashlib.sha256("".join(code).encode()).hexdigest()))


def _undocumented(file: Path) -> ast.Module:
    """Return a module's syntax tree without docstrings."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node) is not None:
            node.body = node.body[1:]
    return tree
