"""All that skyverse uses of numba beyond its public interface.

If numba is another than those that this was tried with, and lacks what is used here, kernels are compiled by plain
numba: more slowly, and each time anew. Other people's compiled functions are compiled and run as ever.
"""

import contextlib
import hashlib
import pickle
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core import config
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.registry import CPUDispatcher
from numba.core.serialize import dumps
from numba.core.types import unliteral

from skyverse.numerics.compiling.digest import digest_now, digest_of, name_of
from skyverse.numerics.compiling.signatures import text_of
from skyverse.numerics.compiling.store import KernelStore, user_folder

SETTINGS = ("BOUNDSCHECK", "OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "DEBUGINFO_DEFAULT", "LLVM_REFPRUNE_FLAGS")


class Kernel(CPUDispatcher):
    """What calls a compiled function: once compiled, it takes all integers.

    Numba would compile a function that kernels call again for each constant that one of them hands to it.
    """

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return how other kernels call this one, by arguments of these types."""
        return super().get_call_template([unliteral(kind) for kind in args], kws)

    @property
    def compiled(self) -> "Kernel":
        """What calls the compiled function: this."""
        return self

    def enable_caching(self) -> None:
        """Keep machine code in the stores from now on."""
        self._cache = KeptCode(self)


class Inner(Kernel):
    """What calls a function that is compiled for other kernels only, without a way into it from Python."""

    def __call__(self, *arguments: Any) -> Any:
        """Return what the plain function returns."""
        return self.py_func(*arguments)

    @property
    def compiled(self) -> Kernel:
        """The same function compiled with a way into it from Python, for tests."""
        if "_compiled" not in vars(self):
            options = {name: value for name, value in self.targetoptions.items() if name != "no_cpython_wrapper"}
            self._compiled = Kernel(self.py_func, targetoptions=options)
            self._compiled.enable_caching()
        return self._compiled


class KeptCode(_Cache):
    """The machine code of one kernel, for each signature, in the stores."""

    def __init__(self, kernel: Kernel) -> None:
        self._kernel = kernel
        self._enabled = True

    @property
    def cache_path(self) -> str:
        """The folder that machine code is kept in."""
        return str(stores()[-1].folder) if stores() else ""

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
        if not self._enabled or not stores():
            return None
        target_context.refresh()
        name = self._name(sig, target_context)
        for store in stores() if name else ():
            body = store.load(name)
            if body is None:
                continue
            try:
                return CompileResult._rebuild(target_context, *pickle.loads(body))
            except Exception:  # nothing that can be wrong with a file may keep a kernel from being compiled
                store.drop(name)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled for arguments of these types."""
        if not self._enabled or data.lifted or data.library.has_dynamic_globals:
            return
        name = self._name(sig, data.target_context)
        if not name or digest_now(self._kernel) != digest_of(self._kernel):  # somebody has set a global since
            return
        for store in stores():
            if store.writable:
                store.keep(name, dumps(data._reduce()))
                return

    def _name(self, sig: Any, target_context: Any) -> str:
        """Return the name of the file for a signature; nothing if its types cannot be written down."""
        with contextlib.suppress(TypeError):
            types = ", ".join(text_of(kind) for kind in (sig.args if hasattr(sig, "args") else sig))
            key = (digest_of(self._kernel), types, _environment(), target_context.codegen().magic_tuple())
            module, _, name = name_of(self._kernel).partition(":")
            return f"{module.partition('.')[2]}.{name}-{hashlib.sha256(repr(key).encode()).hexdigest()[:40]}"
        return ""


@cache
def stores() -> tuple[KernelStore, ...]:
    """Return where machine code is looked for, in this order."""
    folder = user_folder()
    return (KernelStore(folder),) if folder else ()


@cache
def _environment() -> str:
    """Return what machine code depends on beside the kernels: versions, settings, and how this package compiles."""
    import sys

    versions = (numba.__version__, llvmlite.__version__, np.__version__, sys.implementation.cache_tag)
    settings = [getattr(config, name, None) for name in SETTINGS]
    here = Path(__file__)
    code = [(here.parent / name).read_bytes() for name in (here.name, "digest.py", "signatures.py")]
    return repr((versions, settings, hashlib.sha256(b"".join(code)).hexdigest()))
