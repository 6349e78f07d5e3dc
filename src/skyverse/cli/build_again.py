"""The options that a scenario was built with, kept in it, so that a change of one needs no others to be typed again."""

import inspect
from collections.abc import Mapping
from typing import Annotated, Any, get_args, get_origin

from pydantic import TypeAdapter, ValidationError

from skyverse.errors import InputError
from skyverse.model.built_with import Words


def kept_words(given: Mapping[str, Any]) -> Words:
    """Return options as words."""
    return tuple(
        (name, *map(str, value if isinstance(value, list | tuple) else [value])) for name, value in given.items()
    )


def given_again(source: str, words: Words, options: Mapping[str, inspect.Parameter]) -> dict[str, Any]:
    """Return the options that a scenario's file keeps, as the command line gives them."""
    given: dict[str, Any] = {}
    for name, *told in words:
        if name not in options or not told:
            raise InputError(f"{source}: built_with: expected options of scenario build, found {name!r:.60}")
        kind = options[name].annotation
        kind = get_args(kind)[0] if get_origin(kind) is Annotated else kind
        several = any(get_origin(one) is list for one in (kind, *get_args(kind)))
        try:
            given[name] = TypeAdapter(kind).validate_python(told if several else told[0])
        except ValidationError:
            raise InputError(f"{source}: built_with: {name}: found {told!r:.100}, which it does not take") from None
    return given
