# mypy: disable-error-code="misc, no-untyped-call, attr-defined, arg-type, no-any-return"
"""A compilation target of skyverse's own in numba: how machine code is made, linked, serialised and named.

* a large kernel is called by its symbol, not linked into each of its callers and optimised there again;
* reference counts read one field of an array, not all;
* random generators come from Python through numpy's capsule, 20 us sooner than through ctypes;
* compiler settings have a hash that tells them apart.

Since the target has contexts of its own, other people's functions are compiled and run as ever.
"""

import os
import secrets
from functools import cache, cached_property, partial
from typing import Any

import llvmlite
import llvmlite.binding
from llvmlite import ir
from numba.core import cgutils, compiler, types
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.cpu import CPUContext
from numba.core.decorators import jit
from numba.core.pythonapi import NativeValue, PythonAPI
from numba.core.registry import CPUDispatcher, CPUTarget
from numba.core.runtime.context import NRTContext
from numba.core.target_extension import CPU, dispatcher_registry, jit_registry, target_registry

TARGET = "skyverse"
MAX_LINKED_IR_LINES = 200  # at 60, A* and Taut lose a tenth of their speed; see docs/performance.md
PROCESS = secrets.randbits(40) << 24


class Flags(compiler.Flags):
    """Settings of a compilation that differ in their hashes where they differ in their values."""

    def __hash__(self) -> int:
        """Hash what differs from the defaults."""
        return hash(tuple(sorted((k, str(v)) for k, v in self._values.items() if v != self.options[k].default)))

    def __eq__(self, other: object) -> bool:
        """Compare all settings, those that are set first."""
        return (isinstance(other, Flags) and self._values == other._values) or bool(super().__eq__(other))


class Runtime(NRTContext):
    """Reference counting of arrays."""

    def get_meminfos(self, builder: Any, ty: Any, value: Any) -> Any:
        """Return what counts the references to a value: of an array, its first field."""
        if isinstance(ty, types.Array):
            return [(ty, builder.extract_value(value, 0))]
        if not self._context.data_model_manager[ty].contains_nrt_meminfo():
            return []
        return super().get_meminfos(builder, ty, value)


class ArgumentsFromPython(PythonAPI):
    """How the arguments of a kernel come from Python."""

    def to_native_value(self, typ: Any, obj: Any) -> Any:
        """Take the addresses of a random generator from numpy's capsule; take all else as numba does.

        A kernel counts no references to a generator: its caller holds it.
        """
        if not isinstance(typ, types.NumPyRandomGeneratorType):
            return super().to_native_value(typ, obj)
        builder = self.builder
        source = self.object_getattr_string(obj, "bit_generator")
        capsule = self.object_getattr_string(source, "capsule")
        signature = ir.FunctionType(self.voidptr, [self.pyobj, self.cstring])
        name = self.context.insert_const_string(self.module, "BitGenerator")
        address = builder.call(self._get_function(signature, "PyCapsule_GetPointer"), [capsule, name])
        for held in (capsule, source):
            self.decref(held)
        generator = cgutils.create_struct_proxy(typ)(self.context, builder)
        generator.parent = obj
        generator.meminfo = cgutils.get_null_value(generator.meminfo.type)
        is_error = cgutils.is_null(builder, address)
        with builder.if_then(builder.not_(is_error), likely=True):
            words = builder.bitcast(address, self.context.get_value_type(types.uintp).as_pointer())
            bits = cgutils.create_struct_proxy(types.NumPyRandomBitGeneratorType("bit_generator"))(
                self.context, builder
            )
            for i, field in enumerate(("state", "fnptr_next_uint64", "fnptr_next_uint32", "fnptr_next_double")):
                setattr(bits, field, builder.load(cgutils.gep(builder, words, i)))
            generator.bit_generator = bits._getvalue()
        return NativeValue(generator._getvalue(), is_error=is_error)


class Library(JITCodeLibrary):
    """The machine code of one kernel, or of a function of numba that kernels call."""

    def __init__(self, codegen: Any, name: str) -> None:
        super().__init__(codegen, name)
        self.kernel: tuple[str, Any] | None = None  # name and types of arguments
        self.ir_lines = 0
        self.called: dict[tuple[str, Any], Any] = {}  # libraries of kernels that are called by their symbols
        self.callees: list[tuple[str, Any]] = []  # all kernels that the code was compiled with
        self._bitcode: bytes | None = None

    @property
    def is_linked(self) -> bool:
        """Whether callers hold a copy of the code, which may be inlined."""
        return self.kernel is None or self.ir_lines <= MAX_LINKED_IR_LINES

    def finalize(self) -> None:
        """Link what is small, optimise and make machine code, as numba does."""
        self._codegen._check_llvm_bugs()
        self._raise_if_finalized()
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self.called.update(getattr(library, "called", {}))
            self.callees += [library.kernel] if getattr(library, "kernel", None) else getattr(library, "callees", [])
            if getattr(library, "is_linked", True):
                self._final_module.link_in(library._get_module_for_linking(), preserve=True)
            else:
                self.called[library.kernel] = library
        self._optimize_final_module()
        self._final_module.verify()
        self._finalize_final_module()

    def _get_module_for_linking(self) -> Any:
        if self._bitcode is not None:  # kept code that no caller has asked for yet
            self._shared_module, self._bitcode = llvmlite.binding.parse_bitcode(self._bitcode), None
        return super()._get_module_for_linking()

    def serialize_using_object_code(self) -> Any:
        """Return all that a process needs to run the kernel, and to link it if it is small."""
        self._ensure_finalized()
        module = self._final_module
        symbols = [f.name for f in module.functions if not f.is_declaration]
        symbols += [g.name for g in module.global_variables if not g.is_declaration]
        bitcode = self._get_module_for_linking().as_bitcode() if self.is_linked else None
        return (
            self.name,
            "object",
            (self._get_compiled_object(), bitcode, symbols, self.kernel, self.callees, self.ir_lines),
        )

    @classmethod
    def _unserialize(cls, codegen: Any, state: Any) -> "Library":
        name, _, (code, bitcode, symbols, kernel, callees, ir_lines) = state
        self: Library = codegen.create_library(name)
        self.enable_object_caching()
        self._set_compiled_object(code)
        self.kernel, self.callees, self.ir_lines, self._bitcode = kernel, callees, ir_lines, bitcode
        self._finalize_final_module()
        codegen._engine._defined_symbols.update(symbols)
        return self


class Codegen(JITCPUCodegen):
    """What makes machine code."""

    _library_class = Library

    def _get_host_cpu_name(self) -> Any:
        return os.environ.get("SKYVERSE_CPU") or super()._get_host_cpu_name()

    def _get_host_cpu_features(self) -> Any:
        return "" if os.environ.get("SKYVERSE_CPU") else super()._get_host_cpu_features()


class Context(CPUContext):
    """What kernels are compiled for."""

    def init(self) -> None:
        """Take a code generator of this target's own."""
        super().init()
        self._internal_codegen = Codegen("skyverse.exec")

    @cached_property
    def nrt(self) -> Runtime:
        """Reference counting."""
        return Runtime(self, self.enable_nrt)

    def get_python_api(self, builder: Any) -> ArgumentsFromPython:
        """Return what takes arguments from Python."""
        return ArgumentsFromPython(self, builder)

    def mangler(self, name: str, types: Any, *, abi_tags: Any = (), uid: int | None = None) -> Any:
        """Return the symbol of a function: of numba's own functions, one that no other process uses.

        Numba counts in each process from one; the code of two processes may be loaded by a third.
        """
        if uid is not None and uid < PROCESS:
            uid += PROCESS
        return super().mangler(name, types, abi_tags=abi_tags, uid=uid)


class KernelTarget(CPU):
    """The CPU, as kernels are compiled for it."""


class Descriptor(CPUTarget):
    """The contexts of the target."""

    @cached_property
    def _toplevel_target_context(self) -> Context:
        return Context(self.typing_context, self._target_name)


target_registry[TARGET] = KernelTarget


class Compiled(CPUDispatcher):
    """What calls a function that was compiled for this target: a kernel, or a function of numba that kernels call."""

    targetdescr = Descriptor(TARGET)


dispatcher_registry[KernelTarget] = Compiled
jit_registry[KernelTarget] = partial(jit, _target=TARGET)


@cache
def processor() -> tuple[str, str, str]:
    """Return what machine code is made for: system, name of the processor, its features."""
    system, cpu, features = Compiled.targetdescr.target_context.codegen().magic_tuple()
    return str(system), str(cpu), str(features)
