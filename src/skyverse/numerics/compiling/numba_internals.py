# mypy: disable-error-code="misc, no-untyped-call, attr-defined, arg-type, no-any-return"
"""What calls kernels: dispatchers for the target that `numba_target` makes, whose machine code is kept by content.

Numba's own cache does not see that a callee has changed. By versions of numba that this was not tried with, kernels are
compiled in numba's ordinary way (see `kernel`).
"""

import gc
import pickle
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property, partial
from typing import Any

from numba.core import compiler
from numba.core.bytecode import FunctionIdentity
from numba.core.serialize import dumps
from numba.core.target_extension import target_override
from numba.core.types import npy_rng, unliteral
from numba.core.untyped_passes import ExtractByteCode
from numpy.random import Generator

from skyverse.numerics.compiling.digest import callees_of, digest_of, name_of
from skyverse.numerics.compiling.kept_code import KeptCode
from skyverse.numerics.compiling.numba_target import TARGET, Compiled, Flags
from skyverse.numerics.compiling.references import referenced


class Pipeline(compiler.Compiler):
    """Compiles a kernel under a symbol that tells its content, so that it is the same in each process."""

    def __init__(self, kernel: "Kernel", *settings: Any) -> None:
        super().__init__(*settings)
        self._kernel = kernel

    def compile_extra(self, func: Any) -> Any:
        """Compile the plain function."""
        self.state.func_id = FunctionIdentity.from_function(func)
        self.state.func_id.unique_id = self._kernel.symbol
        self.state.func_id.unique_name = f"{self.state.func_id.func_qualname}${self._kernel.symbol}"
        ExtractByteCode().run_pass(self.state)
        self.state.lifted = ()
        self.state.lifted_from = None
        return self._compile_bytecode()


class Kernel(Compiled):
    """What calls a compiled kernel: once compiled, it takes all integers.

    Numba would compile a function that kernels call again for each constant that one of them hands to it.
    """

    def __init__(self, function: Any, **options: Any) -> None:
        options = {"nopython": True, "boundscheck": None, "nogil": True, "no_cfunc_wrapper": True, **options}
        super().__init__(function, targetoptions=options, pipeline_class=partial(Pipeline, self))
        self._compiler._compile_core = self._compile_core
        self._cache = KeptCode(self, _pack, _unpack)

    @cached_property
    def symbol(self) -> int:
        """A number for the symbol: of the content, above those that `Context.mangler` gives."""
        return int(digest_of(self)[:24], 16) | 1 << 96

    @property
    def compiled(self) -> "Kernel":
        """What calls the compiled function: this."""
        return self

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return how other kernels call this one, by arguments of these types."""
        return super().get_call_template([referenced(unliteral(kind)) for kind in args], kws)

    def typeof_pyval(self, value: Any) -> Any:
        """Return the type of an argument that numba's C code does not know: of a generator, without a search."""
        if type(value) is not Generator:
            return super().typeof_pyval(value)
        self._types_active_call.add(npy_rng)
        return npy_rng

    def add_overload(self, cres: Any) -> None:
        """Take a compiled signature, and note what the code is, so that callers may call it by its symbol."""
        library = cres.library
        if library.kernel is None:
            library.ir_lines = str(library.get_function(cres.fndesc.mangled_name)).count("\n")
            library.kernel = name_of(self), tuple(cres.signature.args)
        super().add_overload(cres)

    def _compile_core(self, args: Any, return_type: Any) -> Any:
        flags = Flags()
        self.targetdescr.options.parse_as_flags(flags, self.targetoptions)
        with target_override(TARGET), _without_collector():
            return compiler.compile_extra(
                self.typingctx,
                self.targetctx,
                self.py_func,
                args=args,
                return_type=return_type,
                flags=flags,
                locals={},
                pipeline_class=self._compiler.pipeline_class,
            )


class Inner(Kernel):
    """What calls a function that is compiled for other kernels only, without a way into it from Python."""

    def __init__(self, function: Any, **options: Any) -> None:
        super().__init__(function, no_cpython_wrapper=True, **options)

    def __call__(self, *arguments: Any) -> Any:
        """Return what the plain function returns."""
        return self.py_func(*arguments)

    @cached_property
    def compiled(self) -> Kernel:
        """The same function compiled with a way into it from Python, for tests."""
        return Kernel(self.py_func, **{k: v for k, v in self.targetoptions.items() if k != "no_cpython_wrapper"})


@contextmanager
def _without_collector() -> Iterator[None]:
    """Keep Python from looking for unreachable objects, which takes a sixth of the time in which numba compiles."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def _pack(compiled: Any) -> bytes | None:
    """Return a compiled signature as bytes, None if it cannot be kept."""
    if compiled.lifted or compiled.library.has_dynamic_globals:
        return None
    return bytes(dumps((list(compiled.library.called), compiled._reduce())))


def _unpack(kernel: Kernel, body: bytes) -> Any:
    """Return a compiled signature from bytes; load or compile the kernels that it calls by their symbols before."""
    called, compiled = pickle.loads(body)
    kernels = callees_of(kernel)
    for name, arguments in called:
        kernels[name].compile(arguments)
    result = compiler.CompileResult._rebuild(kernel.targetctx, *compiled)
    result.library.called = {key: kernels[key[0]].overloads[key[1]].library for key in called}
    return result
