# mypy: disable-error-code="misc, no-untyped-call, attr-defined, arg-type, no-any-return, override, untyped-decorator"
"""NamedTuples of arrays that kernels take by reference: one pointer, instead of up to 289 scalars for each call.

A kernel reads the fields of such an argument. It cannot unpack or return the argument, but it can return another
NamedTuple that holds its fields. A NamedTuple that a kernel makes is handed on by reference to kernels that it calls;
what they return of its fields must not be returned further, since it ends with the kernel that made it.
"""

import hashlib
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.imputils import impl_ret_borrowed
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AttributeTemplate
from numba.core.typing.typeof import typeof_impl
from numba.extending import NativeValue, box, infer_getattr, lower_cast, lower_getattr_generic, register_model, unbox

from skyverse.numerics.compiling.digest import name_of

_CLASSES: set[type] = set()


def add_class(cls: type) -> None:
    """Let kernels take arguments of this NamedTuple by reference."""
    _CLASSES.add(cls)

    @typeof_impl.register(cls)
    def _(value: Any, context: Any) -> Any:
        kinds = tuple(typeof_impl(item, context) for item in value)
        return None if None in kinds else StructReference(cls, kinds)


def referenced(kind: Any) -> Any:
    """Return the type by which a kernel takes an argument of this type."""
    if isinstance(kind, (types.NamedTuple, types.NamedUniTuple)) and kind.instance_class in _CLASSES:
        return StructReference(kind.instance_class, tuple(map(referenced, kind.types)))
    return kind


class StructReference(types.Type):
    """The type of a pointer to the fields of a NamedTuple."""

    def __init__(self, cls: Any, kinds: tuple[Any, ...]) -> None:
        self.instance_class, self.types, self.fields = cls, kinds, cls._fields
        super().__init__(f"reference({name_of(cls)}({', '.join(map(str, kinds))}))")

    @property
    def mangling_args(self) -> tuple[str, tuple[()]]:
        """The part of a symbol that stands for the type."""
        return f"{self.instance_class.__name__}{hashlib.sha256(self.name.encode()).hexdigest()[:12]}", ()

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        """Tell whether an argument of another type can be handed on by this one."""
        return Conversion.safe if referenced(other) == self else None


@infer_getattr
class _Fields(AttributeTemplate):
    key = StructReference

    def generic_resolve(self, reference: Any, attribute: str) -> Any:
        return dict(zip(reference.fields, reference.types, strict=False)).get(attribute)  # a list may be of old fields


@register_model(StructReference)
class _ReferenceModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: StructReference) -> None:
        self.struct = ir.LiteralStructType([_stored(manager, field) for field in kind.types])
        super().__init__(manager, kind, self.struct.as_pointer())


def _stored(manager: Any, kind: Any) -> Any:
    """Return how a field lies in memory: a NamedTuple within another one as its fields."""
    model = manager.lookup(kind)
    return model.struct if isinstance(kind, StructReference) else model.get_data_type()


@lower_getattr_generic(StructReference)
def _read_field(context: Any, builder: Any, kind: Any, pointer: Any, attribute: str) -> Any:
    i = kind.fields.index(attribute)
    field = cgutils.gep_inbounds(builder, pointer, 0, i)
    if isinstance(kind.types[i], StructReference):
        return field
    value = context.data_model_manager.lookup(kind.types[i]).load_from_data_pointer(builder, field)
    return impl_ret_borrowed(context, builder, kind.types[i], value)


@lower_cast(types.BaseTuple, StructReference)
def _refer_to(context: Any, builder: Any, kind: Any, to: Any, value: Any) -> Any:
    """Lay down a NamedTuple that a kernel has made; its owner keeps it alive while another kernel reads it."""
    pointer = cgutils.alloca_once(builder, context.data_model_manager.lookup(to).struct)
    _write(context, builder, kind, to, value, pointer)
    return pointer


def _write(context: Any, builder: Any, kind: Any, to: Any, value: Any, pointer: Any) -> None:
    for i, field in enumerate(to.types):
        place = cgutils.gep_inbounds(builder, pointer, 0, i)
        item = builder.extract_value(value, i)
        if not isinstance(field, StructReference):
            builder.store(context.data_model_manager.lookup(field).as_data(builder, item), place)
        elif isinstance(kind.types[i], StructReference):
            builder.store(builder.load(item), place)
        else:
            _write(context, builder, kind.types[i], field, item, place)


@box(StructReference)
def _box(kind: Any, pointer: Any, c: Any) -> Any:
    """Make a NamedTuple for Python, of fields that a kernel was given by reference and has returned within another.

    Numba has released its hold on the arguments by then. So an array is the caller's own object, which the caller still
    holds, and numba's count of who holds the array is not touched.
    """
    items = []
    for i, field in enumerate(kind.types):
        place = cgutils.gep_inbounds(c.builder, pointer, 0, i)
        if not isinstance(field, StructReference):
            place = c.context.data_model_manager.lookup(field).load_from_data_pointer(c.builder, place)
        if isinstance(field, types.Array):
            items.append(c.context.make_array(field)(c.context, c.builder, place).parent)
            c.pyapi.incref(items[-1])
        else:
            items.append(c.box(field, place))
    cls = c.pyapi.unserialize(c.pyapi.serialize_object(kind.instance_class))
    made = c.pyapi.call_function_objargs(cls, items)
    for item in (*items, cls):
        c.pyapi.decref(item)
    return made


@unbox(StructReference)
def _unbox(kind: Any, value: Any, c: Any) -> Any:
    pointer = cgutils.alloca_once(c.builder, c.context.data_model_manager.lookup(kind).struct)
    natives: list[tuple[Any, Any]] = []
    _fill(kind, value, c, pointer, natives)
    is_error = cgutils.false_bit
    for _, native in natives:
        is_error = c.builder.or_(is_error, native.is_error)

    def cleanup() -> None:
        for field, native in reversed(natives):
            if native.cleanup is not None:
                native.cleanup()
            if c.context.enable_nrt:
                c.context.nrt.decref(c.builder, field, native.value)

    return NativeValue(pointer, is_error=is_error, cleanup=cleanup)


def _fill(kind: Any, value: Any, c: Any, pointer: Any, natives: list[tuple[Any, Any]]) -> None:
    """Write the fields of a Python NamedTuple to memory."""
    for i, field in enumerate(kind.types):
        item = c.pyapi.tuple_getitem(value, i)
        place = cgutils.gep_inbounds(c.builder, pointer, 0, i)
        if isinstance(field, StructReference):
            _fill(field, item, c, place, natives)
        else:
            native = c.unbox(field, item)
            c.builder.store(c.context.data_model_manager.lookup(field).as_data(c.builder, native.value), place)
            natives.append((field, native))
